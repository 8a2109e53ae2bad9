#include "core/channels.hpp"

#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

namespace gudgeon {

namespace {

struct Column {
    std::string_view name, unit;
};

// Numbers of the components in Channels::Source follow these lists.
constexpr std::array<Column, 19> body_columns{{{"x", "m"},
                                               {"y", "m"},
                                               {"z", "m"},
                                               {"e0", "1"},
                                               {"e1", "1"},
                                               {"e2", "1"},
                                               {"e3", "1"},
                                               {"vx", "m/s"},
                                               {"vy", "m/s"},
                                               {"vz", "m/s"},
                                               {"wx", "rad/s"},
                                               {"wy", "rad/s"},
                                               {"wz", "rad/s"},
                                               {"ax", "m/s2"},
                                               {"ay", "m/s2"},
                                               {"az", "m/s2"},
                                               {"alx", "rad/s2"},
                                               {"aly", "rad/s2"},
                                               {"alz", "rad/s2"}}};
constexpr std::array<Column, 12> wrench_columns{{{"fx", "N"},
                                                 {"fy", "N"},
                                                 {"fz", "N"},
                                                 {"mx", "N m"},
                                                 {"my", "N m"},
                                                 {"mz", "N m"},
                                                 {"fjx", "N"},
                                                 {"fjy", "N"},
                                                 {"fjz", "N"},
                                                 {"mjx", "N m"},
                                                 {"mjy", "N m"},
                                                 {"mjz", "N m"}}};
constexpr std::array<Column, 5> contact_columns{{{"penetration", "m"},
                                                 {"normal_force", "N"},
                                                 {"friction_force", "N"},
                                                 {"strips", "1"},
                                                 {"dissipated", "J"}}};
constexpr std::array<Column, 6> marker_columns{
    {{"x", "m"}, {"y", "m"}, {"z", "m"}, {"vx", "m/s"}, {"vy", "m/s"}, {"vz", "m/s"}}};
constexpr std::array<Column, 6> energy_columns{{{"kinetic", "J"},
                                                {"potential", "J"},
                                                {"elastic", "J"},
                                                {"dissipated", "J"},
                                                {"input", "J"},
                                                {"balance", "J"}}};

using Kind = JointCoordinate::Kind;

const char* unit_of(Kind kind) { return kind == Kind::displacement || kind == Kind::point ? "m" : "rad"; }

/// * any characters (none too), ? exactly one.
bool matches(std::string_view glob, std::string_view text) {
    std::size_t g = 0, i = 0, star = std::string_view::npos, resume = 0;
    while (i < text.size()) {
        if (g < glob.size() && glob[g] == '*') {
            star = g++;
            resume = i;
        } else if (g < glob.size() && (glob[g] == '?' || glob[g] == text[i])) {
            ++g;
            ++i;
        } else if (star != std::string_view::npos) {
            g = star + 1;
            i = ++resume;
        } else {
            return false;
        }
    }
    return glob.find_first_not_of('*', g) == std::string_view::npos;
}

double body_value(const Sample& s, int body, int k) {
    const BodyMotion& m = s.motion[body];
    if (k < 3)
        return m.r[k];
    if (k < 7)
        return m.p[k - 3];
    if (k < 10)
        return m.v[k - 7];
    if (k < 13)
        return m.w[k - 10];
    return s.acceleration[6 * static_cast<Eigen::Index>(body) + k - 13];
}

Vec4 euler_parameters(const Mat3& axes) {
    const Eigen::Quaterniond q(axes);
    return {q.w(), q.x(), q.y(), q.z()};
}

double coordinate_value(const System& system, const Sample& s, const JointRecord& joint,
                        const JointCoordinate& c) {
    const BodyMotion &a = s.motion[joint.a.body], &b = s.motion[joint.b.body];
    switch (c.kind) {
    case Kind::angle: {
        const AngleMemory& memory = s.state.angles;
        const double reference = memory.value[c.index] + (s.state.t - memory.t) * memory.rate[c.index];
        return angle::value(a, b, system.angles[c.index].frames, reference);
    }
    case Kind::rotation:
        return rotation_vector::value(a, b, euler_parameters(joint.a.axes),
                                      euler_parameters(joint.b.axes))[c.index];
    case Kind::swing:
        return swing::value(a, b, joint.a.axes.col(2), joint.b.axes.col(2));
    case Kind::displacement:
    case Kind::point:
        break;
    }
    return displacement::value(a, b, joint.a.point, joint.b.point, joint.a.axes.col(c.index));
}

double wrench_value(const Sample& s, const JointRecord& joint, const Wrench& w, int k) {
    const Vec3& v = k % 6 < 3 ? w.force : w.moment;
    if (k < 6)
        return v[k % 3];
    return (s.motion[joint.a.body].A * joint.a.axes.col(k % 3)).dot(v);
}

double contact_value(const Sample& s, int contact, int k) {
    const JointContact& c = s.contacts[contact];
    const std::array<double, 5> all{c.penetration, c.normal_force, c.friction_force, double(c.touching),
                                    s.state.work[2 + contact]};
    return all[k];
}

double marker_value(const Sample& s, const MarkerRecord& marker, int k) {
    const BodyMotion& m = s.motion[marker.body];
    return k < 3 ? point_position(m, marker.point)[k] : point_velocity(m, marker.point)[k - 3];
}

double energy_value(const Sample& s, int k) {
    const std::array<double, 6> all{s.energies.kinetic,   s.energies.potential, s.energies.elastic,
                                    s.state.dissipated(), s.state.input(),      s.balance};
    return all[k];
}

/// What to try instead of a glob that matches nothing.
std::string advice(const System& system, const std::string& glob) {
    std::vector<std::string> objects{"energy"};
    for (int i = 0; i < system.moving; ++i)
        objects.push_back(system.body_names[i]);
    for (const JointRecord& j : system.joints)
        objects.push_back(j.name);
    for (const MarkerRecord& m : system.markers)
        objects.push_back(m.name);

    const std::string object = glob.substr(0, glob.find('.'));
    if (const int body = system.body_index(object); body >= system.moving)
        return fmt::format("'{}' does not move and has no columns", object);
    const auto fits = [&](const std::string& name) { return matches(object, name); };
    const auto found = std::ranges::find_if(objects, fits);
    if (found == objects.end())
        return suggestion(object, objects) + "columns begin with " + listed(objects);
    const std::vector<std::string> columns = Channels(system, {*found + ".*"}).names();
    return suggestion(glob, columns) + fmt::format("columns of '{}': {}", *found, listed(columns));
}

} // namespace

std::size_t Channels::count_all(const System& system) {
    std::size_t count = body_columns.size() * system.moving + energy_columns.size() +
                        marker_columns.size() * system.markers.size();
    for (const JointRecord& j : system.joints)
        count += j.coordinates.size() + wrench_columns.size() + (j.contact >= 0 ? contact_columns.size() : 0);
    return count;
}

Channels::Channels(const System& system, const std::vector<std::string>& globs) : system_(&system) {
    std::vector<bool> used(globs.size(), false);
    const auto add_all = [&](const auto& columns, const std::string& object, Source::Kind kind, int index) {
        for (std::size_t k = 0; k < columns.size(); ++k)
            add(globs, used, fmt::format("{}.{}", object, columns[k].name), std::string(columns[k].unit),
                {kind, index, static_cast<int>(k)});
    };
    for (int i = 0; i < system.moving; ++i)
        add_all(body_columns, system.body_names[i], Source::Kind::body, i);
    for (int j = 0; j < static_cast<int>(system.joints.size()); ++j) {
        const JointRecord& joint = system.joints[j];
        for (std::size_t k = 0; k < joint.coordinates.size(); ++k)
            add(globs, used, fmt::format("{}.{}", joint.name, joint.coordinates[k].name),
                unit_of(joint.coordinates[k].kind), {Source::Kind::joint_coordinate, j, static_cast<int>(k)});
        add_all(wrench_columns, joint.name, Source::Kind::joint_wrench, j);
        if (joint.contact >= 0)
            add_all(contact_columns, joint.name, Source::Kind::contact, joint.contact);
    }
    for (int m = 0; m < static_cast<int>(system.markers.size()); ++m)
        add_all(marker_columns, system.markers[m].name, Source::Kind::marker, m);
    add_all(energy_columns, "energy", Source::Kind::energy, 0);

    for (std::size_t i = 0; i < globs.size(); ++i)
        if (!used[i])
            throw std::invalid_argument(
                fmt::format("no column matches '{}'; {}", globs[i], advice(system, globs[i])));
}

void Channels::add(const std::vector<std::string>& globs, std::vector<bool>& used, std::string name,
                   std::string unit, Source source) {
    bool wanted = globs.empty();
    for (std::size_t i = 0; i < globs.size(); ++i)
        if (matches(globs[i], name))
            used[i] = wanted = true;
    if (!wanted)
        return;
    names_.push_back(std::move(name));
    units_.push_back(std::move(unit));
    sources_.push_back(source);
}

void Channels::read(const Sample& sample, std::span<double> values) const {
    if (values.size() != sources_.size())
        throw std::invalid_argument("one value per column is needed");
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const auto [kind, index, component] = sources_[i];
        switch (kind) {
        case Source::Kind::body:
            values[i] = body_value(sample, index, component);
            break;
        case Source::Kind::joint_coordinate: {
            const JointRecord& joint = system_->joints[index];
            values[i] = coordinate_value(*system_, sample, joint, joint.coordinates[component]);
            break;
        }
        case Source::Kind::joint_wrench:
            values[i] = wrench_value(sample, system_->joints[index], sample.joint[index], component);
            break;
        case Source::Kind::contact:
            values[i] = contact_value(sample, index, component);
            break;
        case Source::Kind::marker:
            values[i] = marker_value(sample, system_->markers[index], component);
            break;
        case Source::Kind::energy:
            values[i] = energy_value(sample, component);
            break;
        }
    }
}

} // namespace gudgeon

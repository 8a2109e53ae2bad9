// Model -> System: numbering, joint frames, batches, block layout.

#include "core/beam.hpp"
#include "core/joint_kinds.hpp"
#include "core/joint_rows.hpp"
#include "core/system.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

namespace gudgeon {

namespace {

template <class Records, class Name>
int index_of(const Records& records, std::string_view name, Name name_of) {
    const auto found =
        std::find_if(records.begin(), records.end(), [&](const auto& r) { return name_of(r) == name; });
    return found == records.end() ? -1 : static_cast<int>(found - records.begin());
}

unsigned hold_bits(const std::vector<std::string>& names) {
    static constexpr std::array<std::string_view, 12> known{"x",  "y",  "z",  "rx", "ry", "rz",
                                                            "vx", "vy", "vz", "wx", "wy", "wz"};
    unsigned bits = 0;
    for (const std::string& name : names)
        for (std::size_t k = 0; k < known.size(); ++k)
            if (name == known[k])
                bits |= 1u << k;
    return bits;
}

BodyMotion start_motion(const Body& body) {
    BodyMotion m;
    m.p = body.orientation.normalized();
    if (m.p[0] < 0)
        m.p = -m.p; // sign-continuous from a start with e0 >= 0
    m.A = rotation(m.p);
    m.r = body.position;
    m.v = body.fixed ? Vec3::Zero() : body.velocity;
    m.w = body.fixed ? Vec3::Zero() : body.angular_velocity;
    return m;
}

void add_bodies(System& s) {
    for (const bool fixed : {false, true})
        for (const Body& body : s.model.bodies) {
            if (body.fixed != fixed)
                continue;
            s.body_names.push_back(body.name);
            s.start.push_back(start_motion(body));
            if (fixed)
                continue;
            s.mass.push_back(body.mass);
            s.inertia.push_back(0.5 * (body.inertia + body.inertia.transpose()));
            s.inverse_inertia.push_back(s.inertia.back().inverse());
            s.hold.push_back(hold_bits(body.hold));
        }
    s.moving = static_cast<int>(s.mass.size());
    s.body_names.push_back("ground");
    s.start.emplace_back();
}

// Joint frames of both sides in body coordinates; triads parallel in the pose as given wherever the
// model does not say otherwise.
std::pair<Mat3, Mat3> global_triads(const Joint& j, const Mat3& to_global_a, const Mat3& to_global_b) {
    if (!j.axes)
        return {Mat3::Identity(), Mat3::Identity()};
    const Vec3 axis_a = to_global_a * (*j.axes)[0], axis_b = to_global_b * (*j.axes)[1];
    if (j.kind == JointKind::universal)
        return {joint_triad(axis_a, axis_b), joint_triad(axis_b, axis_a)};
    const Mat3 triad_a =
        j.references ? joint_triad(axis_a, to_global_a * (*j.references)[0]) : joint_triad(axis_a);
    const Vec3 reference_b = j.references ? Vec3(to_global_b * (*j.references)[1]) : Vec3(triad_a.col(0));
    return {triad_a, joint_triad(axis_b, reference_b)};
}

void add_joint_record(System& s, const Joint& joint, int a, int b) {
    const BodyMotion &ma = s.start[a], &mb = s.start[b];
    JointRecord record{joint.name, joint.kind, {}, {}, 0, 0, {}};
    const Mat3 identity = Mat3::Identity();
    const auto [triad_a, triad_b] =
        joint.body_frame ? global_triads(joint, ma.A, mb.A) : global_triads(joint, identity, identity);
    const auto local = [&](const BodyMotion& m, const Vec3& p) -> Vec3 {
        return joint.body_frame ? p : Vec3(m.A.transpose() * (p - m.r));
    };
    record.a = {a, local(ma, joint.points[0]), ma.A.transpose() * triad_a};
    record.b = {b, local(mb, joint.points[1]), mb.A.transpose() * triad_b};
    s.joints.push_back(std::move(record));
    add_joint_coordinates(joint, s.joints.back(), s);
}

// Friction fed by the reaction of the joint puts forces on all coordinates of its bodies.
void widen_pressing_rows(System& s, const Joint& joint) {
    const bool pressed =
        std::ranges::any_of(joint.friction, [](const Friction& f) { return !f.normal_force; });
    const JointRecord& record = s.joints.back();
    for (int row = record.first_row; pressed && row < record.first_row + record.rows; ++row)
        s.rows[row].mask = 0xfff;
    s.reaction_friction = s.reaction_friction || pressed;
}

template <class Batch> void keep(std::vector<std::unique_ptr<ConstraintBatch>>& out, Batch& batch) {
    if (batch.size() > 0)
        out.push_back(std::make_unique<Batch>(std::move(batch)));
}

int angle_number(const System& s, int joint, std::string_view coordinate) {
    for (const JointCoordinate& c : s.joints[joint].coordinates)
        if (c.name == coordinate && c.kind == JointCoordinate::Kind::angle)
            return c.index;
    return -1;
}

// The geometry is that of the pose as given; the motion begins where the bodies start.
void move_to_start(System& s) {
    int i = 0;
    for (const Body& body : s.model.bodies) {
        if (body.fixed)
            continue;
        BodyMotion& m = s.start[i++];
        m.r = body.start_position.value_or(m.r);
        if (!body.start_orientation)
            continue;
        m.p = body.start_orientation->normalized();
        if (m.p[0] < 0)
            m.p = -m.p;
        m.A = rotation(m.p);
    }
}

// Lists that grew one by one have up to twice the room they need.
void give_room_back(System& s) {
    const auto fit = [](auto&... lists) { (lists.shrink_to_fit(), ...); };
    fit(s.model.bodies, s.model.joints, s.model.forces, s.model.markers);
    fit(s.body_names, s.start, s.mass, s.inertia, s.inverse_inertia, s.hold);
    fit(s.joints, s.rows, s.angles, s.markers, s.contacts, s.contact_joints, s.state_scales);
    for (JointRecord& joint : s.joints)
        fit(joint.coordinates);
}

// Numbers of contact channels, friction states and scratch of the force batches.
void add_contacts(System& s) {
    for (std::size_t i = 0; i < s.forces.size(); ++i) {
        ForceBatch& batch = *s.forces[i];
        batch.declare_contacts(static_cast<int>(i), s.contacts);
        batch.declare_states(s.state_scales);
        batch.place_scratch(s.scratch);
        s.scratch += batch.scratch_size();
        batch.list_elements(s.contact_elements);
    }
    s.contact_elements.push_back(s.channels());
    for (const ContactChannel& channel : s.contacts)
        s.joints[channel.joint].contact = 0;
    for (std::size_t j = 0; j < s.joints.size(); ++j)
        if (s.joints[j].contact == 0) {
            s.joints[j].contact = static_cast<int>(s.contact_joints.size());
            s.contact_joints.push_back(static_cast<int>(j));
        }
}

} // namespace

void share_equal_parts(Model& model) {
    constexpr std::size_t remembered = 8; // different ones; a model has few kinds of rubber
    const auto share = [&](auto Joint::*part) {
        std::array<std::remove_reference_t<decltype(std::declval<Joint>().*part)>, remembered> known;
        std::size_t next = 0;
        for (Joint& joint : model.joints) {
            if (!(joint.*part) ||
                std::ranges::any_of(known, [&](const auto& k) { return (joint.*part).share_if_equal(k); }))
                continue;
            known[next++ % remembered] = joint.*part;
        }
    };
    share(&Joint::bushing);
    share(&Joint::clearance);
}

int System::body_index(std::string_view name) const {
    return index_of(body_names, name, [](const std::string& n) -> const std::string& { return n; });
}

int System::joint_index(std::string_view name) const {
    return index_of(joints, name, [](const JointRecord& j) -> const std::string& { return j.name; });
}

Vec3 CompileContext::in_body(int body, const Vec3& global) const {
    const BodyMotion& m = system.start[body];
    return m.A.transpose() * (global - m.r);
}

System compile(Model model, const std::vector<ForceBatchBuilder>& builders) {
    validate(model);
    System s;
    s.model = std::move(model);
    expand_beams(s.model);
    share_equal_parts(s.model);
    s.gravity = s.model.gravity;
    add_bodies(s);
    std::unordered_map<std::string_view, int> bodies, joints;
    for (std::size_t i = 0; i < s.body_names.size(); ++i)
        bodies.emplace(s.body_names[i], static_cast<int>(i));

    s.joints.reserve(s.model.joints.size());
    ConstraintBatches batches;
    for (const Joint& joint : s.model.joints) {
        add_joint_record(s, joint, bodies.at(joint.bodies[0]), bodies.at(joint.bodies[1]));
        joints.emplace(joint.name, static_cast<int>(s.joints.size()) - 1);
        add_joint_rows(joint, static_cast<int>(s.joints.size()) - 1, s, batches);
        widen_pressing_rows(s, joint);
    }
    const CompileContext context{s.model, s, [&](std::string_view n) { return bodies.at(n); },
                                 [&](std::string_view n) { return joints.at(n); },
                                 [&](int joint, std::string_view c) { return angle_number(s, joint, c); }};
    for (const Marker& m : s.model.markers) {
        const int body = bodies.at(m.body);
        s.markers.push_back({m.name, body, m.body_frame ? m.point : context.in_body(body, m.point)});
    }
    keep(s.constraints, batches.coincident);
    keep(s.constraints, batches.displacement);
    keep(s.constraints, batches.driven_displacement);
    keep(s.constraints, batches.alignment);
    keep(s.constraints, batches.distance);
    keep(s.constraints, batches.driven_angle);
    for (const ForceBatchBuilder& build : builders)
        if (auto batch = build(context); batch && batch->size() > 0)
            s.forces.push_back(std::move(batch));

    BlockLayoutBuilder layout(s.moving);
    for (auto& batch : s.constraints)
        batch->finish(layout);
    for (auto& batch : s.forces)
        batch->finish(layout);
    s.layout = std::move(layout).finish();
    add_contacts(s);
    move_to_start(s);
    give_room_back(s);
    return s;
}

} // namespace gudgeon

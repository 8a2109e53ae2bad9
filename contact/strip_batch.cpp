#include "contact/strip_batch.hpp"

#include "contact/clearance.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr std::size_t parallel_strips = 256; // below, one thread is quicker
constexpr int most_points = 2;               // of a strip

double angle_between(double x, double y) { return std::abs(std::remainder(x - y, 2 * pi)); }

} // namespace

struct StripBatch::Pose {
    CylinderPose pose;
    StripFrame frame;
    Pose(const Evaluation& e, const StripJoint& x)
        : pose(cylinder_pose(e.body[x.a], e.body[x.b], x.cylinders)), frame(strip_frame(pose)) {}
};

struct StripBatch::Found {
    int count = 0;
    std::array<StripPoint, most_points> point;
    std::array<int, most_points> memory{0, 1}; // which of the strip's memories the point owns
};

struct StripBatch::Touch {
    const StripPoint& point;
    double rate; // m/s
    Coverage cover;
    double share;  // of the joint's law
    NormalForce f; // with the share
    int place;     // strip and memory: contact number of the joint
};

void StripBatch::add(StripJoint x, const std::vector<double>& offsets, const std::vector<double>& radii) {
    x.first_strip = static_cast<int>(offset_.size());
    x.strips = static_cast<int>(offsets.size());
    x.share = 1.0 / x.strips;
    x.half_span = 0;
    for (const double offset : offsets)
        x.half_span = std::max(x.half_span, std::abs(offset));
    x.least_radius = *std::ranges::min_element(radii);
    offset_.insert(offset_.end(), offsets.begin(), offsets.end());
    radius_.insert(radius_.end(), radii.begin(), radii.end());
    joints_.items().push_back(std::move(x));
}

void StripBatch::finish(BlockLayoutBuilder& layout) {
    joints_.colour(layout.moving());
    joint_of_strip_.resize(offset_.size());
    for (int j = 0; j < size(); ++j) {
        StripJoint& x = joints_.items()[j];
        x.pair = layout.pair(x.a, x.b, couple_all);
        std::fill_n(joint_of_strip_.begin() + x.first_strip, x.strips, j);
    }
}

bool StripBatch::in_reach(const Evaluation& e, const StripJoint& x) const {
    const CylinderPose pose = cylinder_pose(e.body[x.a], e.body[x.b], x.cylinders);
    return bearing_depth_bound(pose, x.cylinders.journal_radius, x.half_span, x.least_radius) > 0;
}

std::size_t StripBatch::strips_in_reach(const Evaluation& e) const {
    std::size_t sum = 0;
    for (const StripJoint& x : joints_.items())
        sum += in_reach(e, x) ? x.strips : 0;
    return sum;
}

// The points of a strip; a point takes the memory of the contact nearest to it around the bearing.
StripBatch::Found StripBatch::find(const Evaluation& e, const StripJoint& x, const Pose& pose,
                                   int strip) const {
    Found out;
    out.count = strip_points(pose.pose, pose.frame, x.cylinders.journal_radius, offset_[strip],
                             radius_[strip], out.point.data());
    const int stride = x.law.slots();
    const int first = x.channel + (strip - x.first_strip) * most_points * stride, second = first + stride;
    const bool lives[2] = {e.start_speed[first] >= 0, e.start_speed[second] >= 0};
    if (!lives[1] && (out.count == 1 || !lives[0]))
        return out;
    const Mat3& A = e.body[x.a].A;
    const auto distance = [&](int point, int memory) {
        const Vec3& radial = out.point[point].radial;
        const double place = std::atan2(radial.dot(A * x.across), radial.dot(A * x.reference));
        return lives[memory] ? angle_between(place, e.place[memory == 0 ? first : second]) : pi / 2;
    };
    const bool crossed = out.count == 1 ? distance(0, 1) < distance(0, 0)
                                        : distance(0, 1) + distance(1, 0) < distance(0, 0) + distance(1, 1);
    if (crossed)
        std::swap(out.memory[0], out.memory[1]);
    return out;
}

template <class F>
void StripBatch::for_touches(const Evaluation& e, const StripJoint& x, const Pose& pose, int strip,
                             F&& f) const {
    if (strip_depth_bound(pose.pose, x.cylinders.journal_radius, offset_[strip], radius_[strip]) <= 0)
        return;
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Found found = find(e, x, pose, strip);
    for (int i = 0; i < found.count; ++i) {
        const StripPoint& p = found.point[i];
        if (!(p.depth > 0))
            continue;
        const Coverage cover = strip_coverage(p.x, x.width, x.journal_length);
        if (!(cover.fraction > 0))
            continue;
        const double rate = p.n.dot(point_velocity_at(b, p.p) - point_velocity_at(a, p.p));
        const double share = cover.fraction * x.share;
        const int place = (strip - x.first_strip) * most_points + found.memory[i];
        const int channel = x.channel + place * x.law.slots();
        f(Touch{p, rate, cover, share, contact_force(e, x.law, channel, share, p.depth, rate), place});
    }
}

PointFriction StripBatch::friction_of(const Evaluation& e, const StripJoint& x, const Touch& touch) const {
    return point_friction(*x.friction, x.states(e, touch.place), e.body[x.a], e.body[x.b], touch.point,
                          touch.f.force);
}

// Force on a and its moment about the bearing's middle, global.
Vec6 StripBatch::strip_wrench(const Evaluation& e, const StripJoint& x, const Pose& pose, int strip) const {
    Vec6 sum = Vec6::Zero();
    for_touches(e, x, pose, strip, [&](const Touch& touch) {
        Vec3 force = touch.f.force * touch.point.n;
        if (x.friction)
            force -= friction_of(e, x, touch).force;
        sum.head<3>() += force;
        sum.tail<3>() += (touch.point.p - pose.pose.centre_a).cross(force);
        if (touch.cover.by_x != 0)
            sum += edge_wrench(e, x, pose, touch);
    });
    return sum;
}

// The edge of the journal on a partly covered strip: stored energy times cover is a potential, so the edge
// pushes along the journal by energy per length, -(d energy / dx) (dx/dq)^T.
Vec6 StripBatch::edge_wrench(const Evaluation& e, const StripJoint& x, const Pose& pose,
                             const Touch& touch) const {
    const BodyMotion& a = e.body[x.a];
    Gradient<1> position;
    strip_rates(a, e.body[x.b], pose.pose, touch.point, &position);
    const double push = touch.f.energy * touch.cover.by_x / touch.cover.fraction;
    const Vec3 force = -push * position.ra.transpose();
    Vec6 out;
    out << force, a.A * Vec3(-push * position.ta.transpose()) - (pose.pose.centre_a - a.r).cross(force);
    return out;
}

Vec6 StripBatch::joint_wrench(const Evaluation& e, const StripJoint& x) const {
    Vec6 sum = Vec6::Zero();
    if (!in_reach(e, x))
        return sum;
    const Pose pose(e, x);
    for (int k = 0; k < x.strips; ++k)
        sum += strip_wrench(e, x, pose, x.first_strip + k);
    return sum;
}

PairWrench StripBatch::on_bodies(const Evaluation& e, const StripJoint& x, const Vec6& wrench) const {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Vec3 middle = point_position(a, x.cylinders.point_a), force = wrench.head<3>();
    const Vec3 moment = wrench.tail<3>();
    return {force, a.A.transpose() * ((middle - a.r).cross(force) + moment), -force,
            -(b.A.transpose() * ((middle - b.r).cross(force) + moment))};
}

void StripBatch::add_forces(const Evaluation& e, ForceSink f) const {
    if (e.threads > 1 && strips() >= parallel_strips) {
        add_forces_in_parallel(e, f);
        return;
    }
    for (const StripJoint& x : joints_.items()) {
        const PairWrench w = on_bodies(e, x, joint_wrench(e, x));
        f.add(x.a, w.force_a, w.moment_a);
        f.add(x.b, w.force_b, w.moment_b);
    }
}

// Reach of the joints, wrenches of the strips, sums of the joints: each in parallel.
void StripBatch::add_forces_in_parallel(const Evaluation& e, ForceSink f) const {
    double* reach = e.scratch + scratch_;
    double* wrench = reach + size();
    const std::vector<StripJoint>& joints = joints_.items();
    const int joint_count = size(), strip_count = static_cast<int>(strips());
#pragma omp parallel for schedule(static) num_threads(e.threads)
    for (int j = 0; j < joint_count; ++j)
        reach[j] = in_reach(e, joints[j]);
#pragma omp parallel num_threads(e.threads)
    {
        std::optional<Pose> pose; // of the joint whose strips are at hand
        int joint = -1;
#pragma omp for schedule(static)
        for (int k = 0; k < strip_count; ++k) {
            const int j = joint_of_strip_[k];
            if (reach[j] == 0)
                continue;
            if (j != joint)
                pose.emplace(e, joints[j]);
            joint = j;
            Eigen::Map<Vec6>(wrench + 6 * std::ptrdiff_t(k)) = strip_wrench(e, joints[j], *pose, k);
        }
    }
    joints_.for_each(e.threads, [&](const StripJoint& x) {
        const int j = static_cast<int>(&x - joints.data());
        Vec6 sum = Vec6::Zero();
        for (int k = 0; reach[j] != 0 && k < x.strips; ++k)
            sum += Eigen::Map<const Vec6>(wrench + 6 * std::ptrdiff_t(x.first_strip + k));
        const PairWrench w = on_bodies(e, x, sum);
        f.add(x.a, w.force_a, w.moment_a);
        f.add(x.b, w.force_b, w.moment_b);
    });
}

void StripBatch::add_linearisation(const Evaluation& e, Linearisation& lin) const {
    joints_.for_each(e.threads, [&](const StripJoint& x) {
        if (!in_reach(e, x))
            return;
        const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
        const Pose pose(e, x);
        BlockMatrix c, s;
        c.set_zero();
        s.set_zero();
        for (int k = x.first_strip; k < x.first_strip + x.strips; ++k)
            for_touches(e, x, pose, k, [&](const Touch& touch) {
                Gradient<1> position;
                const bool edge = touch.cover.by_x != 0;
                const ContactPointRates rates =
                    strip_rates(a, b, pose.pose, touch.point, edge ? &position : nullptr);
                const Gradient<1> g = depth_gradient(a, b, touch.point);
                Gradient<1> change = combined(touch.f.by_depth, g, touch.f.by_rate,
                                              depth_rate_gradient(a, b, touch.point, rates, g));
                if (edge) { // the small curvature of x over the pose is left out
                    const double per_length = touch.cover.by_x / touch.cover.fraction;
                    change = combined(1.0, change, touch.f.force * per_length, position);
                    add_product(position, combined(touch.f.elastic * per_length, g, 0.0, g), s);
                }
                add_contact_linearisation(a, b, touch.point, rates, g, touch.f.force, change, touch.f.by_rate,
                                          c, s);
                if (x.friction)
                    add_friction_linearisation(friction_of(e, x, touch), a, b, touch.point, rates, g, change,
                                               touch.f.by_rate, c, s);
            });
        lin.add(lin.C, x.pair, couple_all, c);
        lin.add(lin.S, x.pair, couple_all, s);
    });
    add_state_couplings(e, lin);
}

void StripBatch::declare_states(std::vector<double>& scales) {
    for (StripJoint& x : joints_.items()) {
        if (!x.friction || !x.friction->has_state())
            continue;
        x.state = static_cast<int>(scales.size());
        scales.insert(scales.end(), 3 * std::size_t(x.strips * most_points), x.friction->state_scale());
    }
}

void StripBatch::state_terms(const Evaluation& e, double* source, double* decay) const {
    for (const StripJoint& x : joints_.items()) {
        if (x.state < 0)
            continue;
        for (int place = 0; place < x.strips * most_points; ++place)
            free_state_terms(*x.friction, source + x.state + 3 * place, decay + x.state + 3 * place);
        if (!in_reach(e, x))
            continue;
        const Pose pose(e, x);
        for (int k = x.first_strip; k < x.first_strip + x.strips; ++k)
            for_touches(e, x, pose, k, [&](const Touch& touch) {
                const int state = x.state + 3 * touch.place;
                point_state_terms(friction_of(e, x, touch), e.body[x.a], source + state, decay + state);
            });
    }
}

void StripBatch::add_state_couplings(const Evaluation& e, Linearisation& lin) const {
    for (const StripJoint& x : joints_.items()) {
        if (x.state < 0)
            continue;
        const std::size_t first = lin.states.size();
        for (int place = 0; place < x.strips * most_points; ++place)
            add_couplings(free_state_couplings(*x.friction), x.state + 3 * place, x, lin);
        if (!in_reach(e, x))
            continue;
        const Pose pose(e, x);
        for (int k = x.first_strip; k < x.first_strip + x.strips; ++k)
            for_touches(e, x, pose, k, [&](const Touch& touch) {
                const auto found =
                    point_state_couplings(friction_of(e, x, touch), e.body[x.a], e.body[x.b], touch.point);
                for (int i = 0; i < 3; ++i) {
                    Linearisation::StateCoupling& out = lin.states[first + 3 * std::size_t(touch.place) + i];
                    out.decay = found[i].decay;
                    out.force = found[i].force;
                    out.rate = found[i].rate;
                }
            });
    }
}

EnergyRates StripBatch::energies(const Evaluation& e) const {
    EnergyRates sum;
    for (const StripJoint& x : joints_.items()) {
        if (!in_reach(e, x))
            continue;
        const Pose pose(e, x);
        for (int k = x.first_strip; k < x.first_strip + x.strips; ++k)
            for_touches(e, x, pose, k, [&](const Touch& touch) {
                sum.elastic += touch.f.energy;
                sum.dissipated_power += (touch.f.force - touch.f.elastic) * touch.rate;
                if (x.friction)
                    sum.dissipated_power += friction_of(e, x, touch).power();
            });
    }
    return sum;
}

void StripBatch::add_joint_wrenches(const Evaluation& e, std::span<Wrench> wrenches) const {
    for (const StripJoint& x : joints_.items()) {
        const PairWrench w = on_bodies(e, x, joint_wrench(e, x));
        wrenches[x.joint].force += x.swapped ? w.force_a : w.force_b;
        wrenches[x.joint].moment += x.swapped ? w.moment_a : w.moment_b;
    }
}

void StripBatch::declare_contacts(int batch, std::vector<ContactChannel>& channels) {
    first_channel_ = static_cast<int>(channels.size());
    for (int j = 0; j < size(); ++j) {
        StripJoint& x = joints_.items()[j];
        x.channel = static_cast<int>(channels.size());
        for (int k = 0; k < x.strips; ++k)
            for (int i = 0; i < most_points * x.law.slots(); ++i) {
                channels.push_back({batch, x.joint, x.a, x.b, "strip", k + 1});
                joint_of_channel_.push_back(j);
            }
    }
}

// All channels of a strip: most_points times slots; where it is not in reach only a bound, unless `exactly`.
void StripBatch::strip_samples(const Evaluation& e, const StripJoint& x, const Pose& pose, int strip,
                               bool exactly, ContactSample* out) const {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const int slots = x.law.slots();
    const double bound =
        strip_depth_bound(pose.pose, x.cylinders.journal_radius, offset_[strip], radius_[strip]);
    for (int i = 0; i < most_points * slots; ++i) {
        out[i] = {};
        out[i].depth = -x.cylinders.journal_radius; // no such point
    }
    if (bound <= 0 && !exactly) {
        out[0].depth = std::min(bound, -1e-300);
        return;
    }
    const Found found = find(e, x, pose, strip);
    for (int i = 0; i < found.count; ++i) {
        const StripPoint& p = found.point[i];
        const Coverage cover = strip_coverage(p.x, x.width, x.journal_length);
        const double rate = p.n.dot(point_velocity_at(b, p.p) - point_velocity_at(a, p.p));
        const double share = cover.fraction * x.share;
        const int channel = (strip - x.first_strip) * most_points * slots + found.memory[i] * slots;
        const NormalForce f = contact_force(e, x.law, x.channel + channel, share, p.depth, rate);
        // wanted of new contacts only
        const bool fresh = exactly || (p.depth > 0 && e.start_speed[x.channel + channel] < 0);
        const double inverse = fresh ? inverse_mass(e, x.a, x.b, depth_gradient(a, b, p)) : 0;
        // and the place only where both sides may touch
        const bool two_sided = radius_[strip] * std::abs(pose.pose.cosine) < x.cylinders.journal_radius;
        const Mat3& A = a.A;
        for (int slot = 0; slot < slots; ++slot) {
            ContactSample& sample = out[found.memory[i] * slots + slot];
            sample = contact_sample(x.law, f, slot, p.depth, rate, share, inverse);
            if (two_sided)
                sample.place = std::atan2(p.radial.dot(A * x.across), p.radial.dot(A * x.reference));
            sample.normal_force = (x.swapped ? sample.force : -sample.force) * p.n;
            if (x.friction && slot == 0 && sample.force > 0) {
                const Touch touch{p, rate, cover, share, f, channel / slots};
                const PointFriction friction = friction_of(e, x, touch);
                sample.friction_force = x.swapped ? Vec3(-friction.force) : friction.force;
                sample.friction = friction.force.norm();
                sample.dissipated_power += friction.power();
            }
            if (!(cover.fraction > 0))
                sample.depth = std::min(sample.depth, -1e-300);
        }
    }
}

void StripBatch::sample_contacts(const Evaluation& e, std::span<ContactSample> samples) const {
    for (const StripJoint& x : joints_.items()) {
        ContactSample* out = samples.data() + x.channel;
        const int per_strip = most_points * x.law.slots();
        if (!in_reach(e, x)) {
            std::fill_n(out, x.strips * per_strip, ContactSample{});
            continue;
        }
        const Pose pose(e, x);
        for (int k = 0; k < x.strips; ++k)
            strip_samples(e, x, pose, x.first_strip + k, false, out + k * per_strip);
    }
}

ContactSample StripBatch::sample_contact(const Evaluation& e, int channel) const {
    const StripJoint& x = joints_.items()[joint_of_channel_[channel - first_channel_]];
    const int per_strip = most_points * x.law.slots(), local = channel - x.channel;
    std::array<ContactSample, 2 * most_points> samples;
    strip_samples(e, x, Pose(e, x), x.first_strip + local / per_strip, true, samples.data());
    return samples[local % per_strip];
}

double StripBatch::depth_of_energy(int channel, double energy) const {
    const StripJoint& x = joints_.items()[joint_of_channel_[channel - first_channel_]];
    return slot_depth_of_energy(x.law, (channel - x.channel) % x.law.slots(), energy);
}
double StripBatch::depth_of_force(int channel, double force) const {
    const StripJoint& x = joints_.items()[joint_of_channel_[channel - first_channel_]];
    return slot_depth_of_force(x.law, (channel - x.channel) % x.law.slots(), force);
}

std::size_t StripBatch::scratch_size() const { return static_cast<std::size_t>(size()) + 6 * strips(); }

namespace {

StripJoint strip_joint(const CompileContext& context, int j) {
    const JointSide side = bearing_side(context, j);
    const Clearance& clearance = *context.model.joints[j].clearance;
    StripJoint x;
    place(side, x);
    x.law = radial_law(context, j);
    x.friction = contact_friction(context, j);
    x.cylinders = {side.a.point, side.a.axes.col(2), side.b.point, side.b.axes.col(2),
                   contact_geometry(clearance).journal_radius};
    x.reference = side.a.axes.col(0);
    x.across = side.a.axes.col(1);
    if (clearance.journal_length)
        x.journal_length = *clearance.journal_length;
    return x;
}

std::unique_ptr<ForceBatch> build(const CompileContext& context) {
    auto batch = std::make_unique<StripBatch>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        if (!uses_model(joint, "strips"))
            continue;
        const Clearance& clearance = *joint.clearance;
        const int n =
            clearance.profile.empty() ? clearance.strips : static_cast<int>(clearance.profile.size());
        StripJoint x = strip_joint(context, j);
        x.width = clearance.length.value_or(0) / n;
        std::vector<double> offsets, radii;
        for (int k = 1; k <= n; ++k) { // b_k = (N - 2 k + 1)/2 l/N
            offsets.push_back(0.5 * (n - 2 * k + 1) * x.width);
            radii.push_back(clearance.profile.empty() ? *clearance.radius : clearance.profile[k - 1]);
        }
        batch->add(std::move(x), offsets, radii);
    }
    return batch;
}

} // namespace

ForceBatchBuilder strip_builder() { return build; }

} // namespace gudgeon

#include "contact/strip_touches.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr int block_strips = StripRow::most; // at most, the work of a thread at a time

double angle_between(double x, double y) { return std::abs(std::remainder(x - y, 2 * pi)); }

} // namespace

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
    for (int j = 0; j < size(); ++j) {
        StripJoint& x = joints_.items()[j];
        x.pair = layout.pair(x.a, x.b, couple_all);
        x.first_block = static_cast<int>(blocks_.size());
        const int end = x.first_strip + x.strips;
        for (int first = x.first_strip; first < end; first += block_strips)
            blocks_.push_back({j, first, std::min(first + block_strips, end)});
        x.blocks = static_cast<int>(blocks_.size()) - x.first_block;
    }
}

std::optional<CylinderPose> StripBatch::near_pose(const Evaluation& e, const StripJoint& x) const {
    const CylinderPose pose = cylinder_pose(e.body[x.a], e.body[x.b], x.cylinders);
    if (bearing_depth_bound(pose, x.cylinders.journal_radius, x.half_span, x.least_radius) <= 0)
        return std::nullopt;
    return pose;
}

std::optional<StripBatch::Pose> StripBatch::in_reach(const Evaluation& e, const StripJoint& x) const {
    if (const std::optional<CylinderPose> pose = near_pose(e, x))
        return Pose(e, x, *pose);
    return std::nullopt;
}

std::size_t StripBatch::strips_in_reach(const Evaluation& e) const {
    std::size_t sum = 0;
    for (const StripJoint& x : joints_.items())
        sum += in_reach(e, x) ? x.strips : 0;
    return sum;
}

// The points of a strip deeper than `above`; a point takes the memory of the contact nearest to it around
// the bearing. Where one side at most can touch there is nothing to choose.
void StripBatch::find(const Evaluation& e, const StripJoint& x, const Pose& pose, const StripRow& row, int i,
                      double above, Found& out) const {
    const double journal = x.cylinders.journal_radius;
    const int stride = x.law.slots();
    const int first = x.channel + (row.strip[i] - x.first_strip) * most_points * stride;
    const int second = first + stride;
    const bool lives[2] = {e.start_speed[first] >= 0, e.start_speed[second] >= 0};
    out.memory = {0, 1};
    if (!lives[1] && !may_touch_twice(pose.frame, journal, row.radius[i])) {
        out.count = row.depth(i, journal) > above;
        if (out.count > 0)
            row.fill(pose.pose, pose.frame, journal, i, out.point[0]);
        return;
    }
    out.count = strip_points(pose.pose, pose.frame, journal, row.offset[i], row.radius[i], out.point.data());
    if (!lives[1] && (out.count == 1 || !lives[0]))
        return;
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
}

// Force on a and its moment about the bearing's middle, global. The edge of the journal on a partly covered
// strip pushes with (d energy / dx) dx/d(pose).
Vec6 StripBatch::block_wrench(const Evaluation& e, const Block& block) const {
    const StripJoint& x = joints_.items()[block.joint];
    Vec6 sum = Vec6::Zero();
    const std::optional<Pose> pose = in_reach(e, x);
    if (!pose)
        return sum;
    for_touches(e, x, *pose, block.first, block.last, [&](const Touch& touch) {
        Vec3 force = touch.f.force * touch.point.n;
        if (x.friction)
            force -= friction_of(e, x, touch).force;
        sum.head<3>() += force;
        sum.tail<3>() += touch.point.arm.cross(force);
        if (touch.cover.by_x != 0)
            sum += touch.f.energy * touch.cover.by_x / touch.cover.fraction *
                   StripSlopes(pose->pose, touch.point).position(pose->pose, touch.point);
    });
    return sum;
}

Vec6 StripBatch::joint_wrench(const Evaluation& e, const StripJoint& x) const {
    Vec6 sum = Vec6::Zero();
    for (int k = 0; k < x.blocks; ++k)
        sum += block_wrench(e, blocks_[x.first_block + k]);
    return sum;
}

void StripBatch::add_wrench(const Evaluation& e, const StripJoint& x, const Vec6& wrench, ForceSink f) const {
    if (wrench.isZero(0))
        return;
    const PairWrench w =
        on_bodies(e.body[x.a], e.body[x.b], point_position(e.body[x.a], x.cylinders.point_a), wrench);
    f.add(x.a, w.force_a, w.moment_a);
    f.add(x.b, w.force_b, w.moment_b);
}

void StripBatch::add_forces(const Evaluation& e, ForceSink f) const {
    if (e.threads == 1) {
        for (const StripJoint& x : joints_.items())
            add_wrench(e, x, joint_wrench(e, x), f);
        return;
    }
    double* wrench = e.scratch + scratch_;
    const auto of_block = [wrench](int k) { return Eigen::Map<Vec6>(wrench + 6 * std::ptrdiff_t(k)); };
    in_parallel(e, static_cast<int>(blocks_.size()),
                [&](int k) { of_block(k) = block_wrench(e, blocks_[k]); });
    joints_.for_each(e.threads, [&](const StripJoint& x) {
        Vec6 sum = Vec6::Zero();
        for (int k = 0; k < x.blocks; ++k)
            sum += of_block(x.first_block + k);
        add_wrench(e, x, sum, f);
    });
}

// With energy times cover as potential: f G + push X, f and push the slopes of the potential in depth and
// place, G and X their gradients.
void StripBatch::add_touch(const Evaluation& e, const StripJoint& x, const Pose& pose, const Touch& touch,
                           RelativeWrench& sum) const {
    const StripPoint& p = touch.point;
    const StripSlopes slopes(pose.pose, p);
    const double f = touch.f.force;
    Vec6 change = touch.f.by_depth * slopes.depth; // df
    if (touch.f.by_rate != 0) {
        change += touch.f.by_rate * slopes.rate(p, touch.velocity, pose.turning());
        sum.by_twist += (touch.f.by_rate * slopes.depth).lazyProduct(slopes.depth.transpose());
        sum.damps = true;
    }
    if (touch.cover.by_x != 0) {
        const double per_length = touch.cover.by_x / touch.cover.fraction;
        const double push = touch.f.energy * per_length;
        const Vec6 place = slopes.position(pose.pose, p);
        change += f * per_length * place;
        sum.value += push * place;
        sum.by_pose += place * (touch.f.elastic * per_length * slopes.depth).transpose() +
                       push * slopes.position_slope(pose.pose, p);
    }
    const Vec3 force = f * p.n;
    sum.value.head<3>() += force;
    sum.value.tail<3>() += p.arm.cross(force);
    const Vec6 by_angle = f * p.radius * slopes.g * slopes.per_distance * slopes.angle;
    const Vec6 by_tangent = f * slopes.per_distance * slopes.tangent;
    for (int j = 0; j < 6; ++j)
        sum.by_pose.col(j) +=
            change[j] * slopes.depth + by_angle[j] * slopes.angle - by_tangent[j] * slopes.tangent;
    sum.by_pose.topRightCorner<3, 3>() -= skew(force);
    sum.by_pose.bottomRightCorner<3, 3>() -= force * p.arm.transpose();
    sum.by_pose.diagonal().tail<3>().array() += p.arm.dot(force);
    if (x.friction)
        add_relative_friction(friction_of(e, x, touch), p.n, p.arm, touch.velocity, pose.turning(),
                              slopes.normal(p), slopes.point(p), slopes.depth, change, touch.f.by_rate, sum);
}

void StripBatch::add_linearisation(const Evaluation& e, Linearisation& lin) const {
    joints_.for_each(e.threads, [&](const StripJoint& x) {
        const std::optional<Pose> pose = in_reach(e, x);
        if (!pose)
            return;
        RelativeWrench sum;
        bool touches = false;
        for_touches(e, x, *pose, [&](const Touch& touch) {
            touches = true;
            add_touch(e, x, *pose, touch, sum);
        });
        if (!touches)
            return;
        BlockMatrix c, s;
        c.set_zero();
        s.set_zero();
        add_relative_linearisation(e.body[x.a], e.body[x.b], pose->pose.centre_a, sum, c, s);
        if (sum.damps)
            lin.add_damping(x.pair, couple_all, c);
        lin.add_stiffness(x.pair, couple_all, s);
    });
    add_state_couplings(e, lin);
}

EnergyRates StripBatch::joint_energies(const Evaluation& e, const StripJoint& x) const {
    EnergyRates sum;
    if (const std::optional<Pose> pose = in_reach(e, x))
        for_touches(e, x, *pose, [&](const Touch& touch) {
            sum.elastic += touch.f.energy;
            sum.dissipated_power += (touch.f.force - touch.f.elastic) * touch.rate;
            if (x.friction)
                sum.dissipated_power += friction_of(e, x, touch).power();
        });
    return sum;
}

EnergyRates StripBatch::energies(const Evaluation& e) const {
    double* found = e.scratch + scratch_;
    in_parallel(e, size(), [&](int j) {
        const EnergyRates rates = joint_energies(e, joints_.items()[j]);
        found[2 * std::ptrdiff_t(j)] = rates.elastic;
        found[2 * std::ptrdiff_t(j) + 1] = rates.dissipated_power;
    });
    EnergyRates sum;
    for (int j = 0; j < size(); ++j)
        sum += {found[2 * std::ptrdiff_t(j)], found[2 * std::ptrdiff_t(j) + 1], 0};
    return sum;
}

void StripBatch::add_joint_wrenches(const Evaluation& e, std::span<Wrench> wrenches) const {
    for (const StripJoint& x : joints_.items()) {
        const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
        const PairWrench w = on_bodies(a, b, point_position(a, x.cylinders.point_a), joint_wrench(e, x));
        wrenches[x.joint].force += x.swapped ? w.force_a : w.force_b;
        wrenches[x.joint].moment += x.swapped ? w.moment_a : w.moment_b;
    }
}

std::optional<ElementName> StripBatch::find_bad(const Evaluation& e) const {
    for (const StripJoint& x : joints_.items()) {
        const Vec6 w = joint_wrench(e, x);
        const PairWrench pair =
            on_bodies(e.body[x.a], e.body[x.b], point_position(e.body[x.a], x.cylinders.point_a), w);
        const EnergyRates r = joint_energies(e, x);
        if (!pair.force_a.allFinite() || !pair.moment_a.allFinite() || !pair.moment_b.allFinite() ||
            !std::isfinite(r.elastic) || !std::isfinite(r.dissipated_power))
            return ElementName{"", x.joint, x.a, x.b};
    }
    return {};
}

std::size_t StripBatch::scratch_size() const { return 6 * blocks_.size(); }

} // namespace gudgeon

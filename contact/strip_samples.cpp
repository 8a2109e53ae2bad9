#include "contact/strip_touches.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gudgeon {

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

void StripBatch::blank_samples(const StripJoint& x, ContactSample* out) const {
    ContactSample none;
    none.depth = -x.cylinders.journal_radius; // no such point
    std::fill_n(out, most_points * x.law.slots(), none);
}

// All channels of a strip: most_points times slots.
void StripBatch::strip_samples(const Evaluation& e, const StripJoint& x, const Pose& pose,
                               const StripRow& row, int i_row, bool exactly, Found& found,
                               ContactSample* out) const {
    const int slots = x.law.slots(), strip = row.strip[i_row];
    find(e, x, pose, row, i_row, -std::numeric_limits<double>::infinity(), found);
    blank_samples(x, out);
    const int first = (strip - x.first_strip) * most_points; // contact of the joint
    // the place counts only where both sides may touch, or did
    const bool placed = may_touch_twice(pose.frame, x.cylinders.journal_radius, radius_[strip]) ||
                        e.start_speed[x.channel + (first + 1) * slots] >= 0;
    for (int i = 0; i < found.count; ++i) {
        const StripPoint& p = found.point[i];
        const Coverage cover = strip_coverage(p.x, x.width, x.journal_length);
        const Vec3 velocity = pose.velocity(p.arm);
        const double rate = p.n.dot(velocity), share = cover.fraction * x.share;
        const int place = first + found.memory[i], channel = x.channel + place * slots;
        const NormalForce f = contact_force(e, x.law, channel, share, p.depth, rate);
        // wanted of new contacts only
        const bool fresh = exactly || (p.depth > 0 && e.start_speed[channel] < 0);
        const double inverse =
            fresh ? inverse_mass(e, x.a, x.b, depth_gradient(e.body[x.a], e.body[x.b], p)) : 0;
        const Mat3& A = e.body[x.a].A;
        for (int slot = 0; slot < slots; ++slot) {
            ContactSample& sample = out[found.memory[i] * slots + slot];
            sample = contact_sample(x.law, f, slot, p.depth, rate, share, inverse);
            if (placed)
                sample.place = std::atan2(p.radial.dot(A * x.across), p.radial.dot(A * x.reference));
            sample.normal_force = (x.swapped ? sample.force : -sample.force) * p.n;
            if (x.friction && slot == 0 && sample.force > 0) {
                const PointFriction friction = friction_of(e, x, {p, velocity, rate, cover, share, f, place});
                sample.friction_force = x.swapped ? Vec3(-friction.force) : friction.force;
                sample.friction = friction.force.norm();
                sample.dissipated_power += friction.power();
            }
            if (!(cover.fraction > 0))
                sample.depth = std::min(sample.depth, -1e-300);
        }
    }
}

// Of a strip that is apart the bound alone.
void StripBatch::sample_joint(const Evaluation& e, const StripJoint& x,
                              std::span<ContactSample> samples) const {
    ContactSample* out = samples.data() + x.channel;
    const int per_strip = most_points * x.law.slots(), last = x.first_strip + x.strips;
    const std::optional<Pose> pose = in_reach(e, x);
    if (!pose) {
        if (!e.apart || !e.apart[x.channel]) // else they are blank already
            std::fill_n(out, x.strips * per_strip, ContactSample{});
        if (e.apart)
            e.apart[x.channel] = 1;
        return;
    }
    if (e.apart)
        e.apart[x.channel] = 0;
    StripRow row;
    Found found;
    for (int begin = x.first_strip; begin < last; begin += StripRow::most) {
        const int end = std::min(begin + StripRow::most, last);
        row.find(pose->frame, x.cylinders.journal_radius, begin, end, offset_.data(), radius_.data());
        for (int k = begin, i = 0; k < end; ++k, out += per_strip) {
            if (i < row.count && row.strip[i] == k) {
                strip_samples(e, x, *pose, row, i++, false, found, out);
                continue;
            }
            blank_samples(x, out);
            out[0].depth = std::min(
                strip_depth_bound(pose->frame, x.cylinders.journal_radius, offset_[k], radius_[k]), -1e-300);
        }
    }
}

void StripBatch::sample_contacts(const Evaluation& e, std::span<ContactSample> samples) const {
    in_parallel(e, size(), [&](int j) { sample_joint(e, joints_.items()[j], samples); });
}

void StripBatch::sample_element(const Evaluation& e, int first, std::span<ContactSample> samples) const {
    sample_joint(e, joint_of(first), samples);
}

void StripBatch::list_elements(std::vector<int>& first_channels) const {
    for (const StripJoint& x : joints_.items())
        first_channels.push_back(x.channel);
}

// By the nearest points alone; a strip that may touch twice counts where a memory of it is free.
bool StripBatch::may_be_fresh(const Evaluation& e, const StripJoint& x) const {
    const std::optional<CylinderPose> near = near_pose(e, x);
    if (!near)
        return false;
    const StripFrame frame = strip_frame(*near);
    const double journal = x.cylinders.journal_radius;
    const int stride = x.law.slots(), last = x.first_strip + x.strips;
    const auto is_free = [&](int memory) {
        for (int slot = 0; slot < stride; ++slot)
            if (e.start_speed[memory + slot] < 0)
                return true;
        return false;
    };
    StripRow row;
    for (int begin = x.first_strip; begin < last; begin += StripRow::most) {
        row.find(frame, journal, begin, std::min(begin + StripRow::most, last), offset_.data(),
                 radius_.data());
        for (int i = 0; i < row.count; ++i) {
            if (!(row.depth(i, journal) > 0))
                continue;
            const int first = x.channel + (row.strip[i] - x.first_strip) * most_points * stride;
            const bool twice =
                e.start_speed[first + stride] >= 0 || may_touch_twice(frame, journal, row.radius[i]);
            if (is_free(first) || (twice && is_free(first + stride)))
                return true;
        }
    }
    return false;
}

void StripBatch::find_fresh(const Evaluation& e, unsigned char* marks) const {
    in_parallel(e, size(), [&](int j) {
        const StripJoint& x = joints_.items()[j];
        marks[x.channel] = may_be_fresh(e, x);
    });
}

const StripJoint& StripBatch::joint_of(int channel) const {
    return joints_.items()[joint_of_channel_[channel - first_channel_]];
}

ContactSample StripBatch::sample_contact(const Evaluation& e, int channel) const {
    const StripJoint& x = joint_of(channel);
    const int per_strip = most_points * x.law.slots(), local = channel - x.channel;
    std::array<ContactSample, 2 * most_points> samples;
    const Pose pose(e, x, cylinder_pose(e.body[x.a], e.body[x.b], x.cylinders));
    StripRow row;
    Found found;
    const int strip = x.first_strip + local / per_strip;
    row.find(pose.frame, offset_[strip], radius_[strip]);
    row.strip[0] = strip;
    strip_samples(e, x, pose, row, 0, true, found, samples.data());
    return samples[local % per_strip];
}

ContactSample StripBatch::approach(const Evaluation& e, int channel) const {
    const StripJoint& x = joint_of(channel);
    const int slots = x.law.slots(), local = channel - x.channel;
    const Pose pose(e, x, cylinder_pose(e.body[x.a], e.body[x.b], x.cylinders));
    StripRow row;
    Found found;
    const int strip = x.first_strip + local / (most_points * slots);
    row.find(pose.frame, offset_[strip], radius_[strip]);
    row.strip[0] = strip;
    find(e, x, pose, row, 0, -std::numeric_limits<double>::infinity(), found);
    ContactSample out;
    out.depth = -x.cylinders.journal_radius;
    for (int i = 0; i < found.count; ++i) {
        if (found.memory[i] != local / slots % most_points)
            continue;
        const StripPoint& p = found.point[i];
        const Coverage cover = strip_coverage(p.x, x.width, x.journal_length);
        const double depth = local % slots == 0 ? p.depth : p.depth - x.law.inner_offset();
        out.depth = cover.fraction > 0 ? depth : std::min(depth, -1e-300);
        out.rate = p.n.dot(pose.velocity(p.arm));
        out.share = cover.fraction * x.share;
    }
    return out;
}

double StripBatch::depth_of_energy(int channel, double energy) const {
    const StripJoint& x = joint_of(channel);
    return slot_depth_of_energy(x.law, (channel - x.channel) % x.law.slots(), energy);
}
double StripBatch::depth_of_force(int channel, double force) const {
    const StripJoint& x = joint_of(channel);
    return slot_depth_of_force(x.law, (channel - x.channel) % x.law.slots(), force);
}

} // namespace gudgeon

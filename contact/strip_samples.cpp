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

// All channels of a strip: most_points times slots; where it is not in reach only a bound, unless `exactly`.
void StripBatch::strip_samples(const Evaluation& e, const StripJoint& x, const Pose& pose, int strip,
                               bool exactly, ContactSample* out) const {
    const double journal = x.cylinders.journal_radius;
    const int slots = x.law.slots();
    for (int i = 0; i < most_points * slots; ++i) {
        out[i] = {};
        out[i].depth = -journal; // no such point
    }
    if (!exactly && strip_is_apart(pose.frame, journal, offset_[strip], radius_[strip])) {
        out[0].depth =
            std::min(strip_depth_bound(pose.frame, journal, offset_[strip], radius_[strip]), -1e-300);
        return;
    }
    Found found;
    find(e, x, pose, strip, -std::numeric_limits<double>::infinity(), found);
    const int first = (strip - x.first_strip) * most_points; // contact of the joint
    // the place counts only where both sides may touch, or did
    const bool placed = may_touch_twice(pose.frame, journal, radius_[strip]) ||
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

void StripBatch::sample_contacts(const Evaluation& e, std::span<ContactSample> samples) const {
    in_parallel(e, size(), [&](int j) {
        const StripJoint& x = joints_.items()[j];
        ContactSample* out = samples.data() + x.channel;
        const int per_strip = most_points * x.law.slots();
        const std::optional<Pose> pose = in_reach(e, x);
        if (!pose) {
            std::fill_n(out, x.strips * per_strip, ContactSample{});
            return;
        }
        for (int k = 0; k < x.strips; ++k)
            strip_samples(e, x, *pose, x.first_strip + k, false, out + k * per_strip);
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
    strip_samples(e, x, pose, x.first_strip + local / per_strip, true, samples.data());
    return samples[local % per_strip];
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

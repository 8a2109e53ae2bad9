// Inner part of StripBatch (strip_batch.hpp): which strips of a joint touch, where, and how hard.
#pragma once

#include "contact/strip_batch.hpp"

#include <optional>

namespace gudgeon {

inline constexpr int most_points = 2; // of a strip

/// What all strips of a joint share at an instant.
struct StripBatch::Pose {
    CylinderPose pose;
    StripFrame frame;
    Vec6 twist; // m/s, rad/s, of the journal off the bearing at its middle

    Pose(const Evaluation& e, const StripJoint& x, const CylinderPose& cylinders)
        : pose(cylinders), frame(strip_frame(pose)),
          twist(relative_twist(e.body[x.a], e.body[x.b], pose.centre_a)) {}
    /// Of the journal's material at P_a + arm off the bearing's.
    Vec3 velocity(const Vec3& arm) const { return twist.head<3>() + turning().cross(arm); }
    Vec3 turning() const { return twist.tail<3>(); }
};

struct StripBatch::Found {
    int count = 0;
    std::array<StripPoint, most_points> point;
    std::array<int, most_points> memory{0, 1}; // which of the strip's memories the point owns
};

struct StripBatch::Touch {
    const StripPoint& point;
    Vec3 velocity; // m/s, of the journal's material at the point off the bearing's
    double rate;   // m/s
    Coverage cover;
    double share;  // of the joint's law
    NormalForce f; // with the share
    int place;     // strip and memory: contact number of the joint
};

/// f(Touch) for every point that touches of the strips [first, last).
template <class F>
void StripBatch::for_touches(const Evaluation& e, const StripJoint& x, const Pose& pose, int first, int last,
                             F&& f) const {
    StripRow row;
    Found found;
    for (int begin = first; begin < last; begin += StripRow::most) {
        row.find(pose.frame, x.cylinders.journal_radius, begin, std::min(begin + StripRow::most, last),
                 offset_.data(), radius_.data());
        for (int i = 0; i < row.count; ++i) {
            find(e, x, pose, row, i, 0, found);
            for (int k = 0; k < found.count; ++k)
                if (found.point[k].depth > 0)
                    touch(e, x, pose, row.strip[i], found.point[k], found.memory[k], f);
        }
    }
}

template <class F>
void StripBatch::touch(const Evaluation& e, const StripJoint& x, const Pose& pose, int strip,
                       const StripPoint& point, int memory, F&& f) const {
    const Coverage cover = strip_coverage(point.x, x.width, x.journal_length);
    if (!(cover.fraction > 0))
        return;
    const Vec3 velocity = pose.velocity(point.arm);
    const double rate = point.n.dot(velocity), share = cover.fraction * x.share;
    const int place = (strip - x.first_strip) * most_points + memory;
    f(Touch{point, velocity, rate, cover, share,
            contact_force(e, x.law, x.channel + place * x.law.slots(), share, point.depth, rate), place});
}

/// f(number) of [0, count) in parallel where the batch is large enough; each writes its own results.
template <class F> void StripBatch::in_parallel(const Evaluation& e, int count, F&& f) const {
    constexpr std::size_t parallel_strips = 1024; // below, one thread is quicker
    if (e.threads == 1 || strips() < parallel_strips) {
        for (int i = 0; i < count; ++i)
            f(i);
        return;
    }
#pragma omp parallel for schedule(static) num_threads(e.threads)
    for (int i = 0; i < count; ++i)
        f(i);
}

} // namespace gudgeon

#include "contact/gap_slot.hpp"

namespace gudgeon {

std::array<ContactPoint, slot_channels> slot_points(const BodyMotion& a, const BodyMotion& b,
                                                    const SlotGap& gap) {
    const BodyMotion &edged = gap.corners_on_b ? b : a, &faced = gap.corners_on_b ? a : b;
    const Mat3 edges = edged.A * (gap.corners_on_b ? gap.axes_b : gap.axes_a);
    const Mat3 faces = faced.A * (gap.corners_on_b ? gap.axes_a : gap.axes_b);
    const Vec3 edged_middle = point_position(edged, gap.corners_on_b ? gap.point_b : gap.point_a);
    const Vec3 faced_middle = point_position(faced, gap.corners_on_b ? gap.point_a : gap.point_b);
    const double less = gap.corners_on_b ? gap.clearance : 0; // corners are those of guide or block

    std::array<ContactPoint, slot_channels> out;
    for (int k = 0; k < slot_channels; ++k) {
        const int direction = k / 8, across = 1 - direction;
        const double end = k & 4 ? 1 : -1, side = k & 2 ? 1 : -1, other = k & 1 ? 1 : -1;
        ContactPoint& c = out[k];
        c.p = edged_middle + side * (gap.half_width[direction] - less) * edges.col(direction) +
              other * (gap.half_width[across] - less) * edges.col(across) +
              0.5 * end * gap.length * edges.col(2);
        c.n = side * faces.col(direction);
        const double height = c.n.dot(c.p - faced_middle);
        c.depth = gap.corners_on_b ? height - gap.half_width[direction]
                                   : gap.half_width[direction] - gap.clearance - height;
    }
    return out;
}

ContactPointRates slot_rates(const BodyMotion& a, const BodyMotion& b, const SlotGap& gap,
                             const ContactPoint& c) {
    ContactPointRates rates;
    if (gap.corners_on_b) {
        rates.p.rb = Mat3::Identity();
        rates.p.tb = skew(b.r - c.p).lazyProduct(b.A);
        rates.n.ta = skew(-c.n).lazyProduct(a.A);
    } else {
        rates.p.ra = Mat3::Identity();
        rates.p.ta = skew(a.r - c.p).lazyProduct(a.A);
        rates.n.tb = skew(-c.n).lazyProduct(b.A);
    }
    return rates;
}

} // namespace gudgeon

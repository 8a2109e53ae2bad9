#include "contact/gap_sphere.hpp"

namespace gudgeon {

ContactPoint sphere_point(const BodyMotion& a, const BodyMotion& b, const SphereGap& gap) {
    const Vec3 centre = point_position(a, gap.point_a), e = point_position(b, gap.point_b) - centre;
    const double distance = e.norm();
    ContactPoint c;
    c.depth = distance - gap.clearance;
    if (distance > 0)
        c.n = e / distance;
    c.p = centre + gap.radius * c.n;
    return c;
}

ContactPointRates sphere_rates(const BodyMotion& a, const BodyMotion& b, const SphereGap& gap,
                               const ContactPoint& c) {
    ContactPointRates rates;
    const double distance = c.depth + gap.clearance;
    if (c.n.squaredNorm() > 0 && distance > 0) {
        const Mat3 turn = (Mat3::Identity() - c.n * c.n.transpose()) / distance;
        rates.n.ra = -turn;
        rates.n.rb = turn;
        rates.n.ta = turn.lazyProduct(a.A.lazyProduct(skew(gap.point_a)));
        rates.n.tb = -turn.lazyProduct(b.A.lazyProduct(skew(gap.point_b)));
    }
    rates.p.ra = Mat3::Identity() + gap.radius * rates.n.ra;
    rates.p.ta = gap.radius * rates.n.ta - a.A.lazyProduct(skew(gap.point_a));
    rates.p.rb = gap.radius * rates.n.rb;
    rates.p.tb = gap.radius * rates.n.tb;
    return rates;
}

} // namespace gudgeon

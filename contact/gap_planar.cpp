#include "contact/gap_planar.hpp"

namespace gudgeon {

namespace {

// Rates of the unit vector n from an axis (through x, direction z, fixed in `line`) to a point Q of `other`
// at the distance d: n is fixed in `line` but for its turning about z, dn = t (t . (dQ - dL)) / d + turn x n
// with L the material point of `line` at Q, t = z x n.
struct LineRates {
    Mat3 n_line_r, n_line_t, n_other_r, n_other_t;
};

LineRates line_rates(const BodyMotion& line, const BodyMotion& other, const Vec3& z, const Vec3& q,
                     const Vec3& n, double d) {
    const Vec3 t = z.cross(n);
    const Mat3 project = t * (t / d).transpose();
    LineRates out;
    out.n_other_r = project;
    out.n_other_t = project.lazyProduct(skew(other.r - q).lazyProduct(other.A));
    out.n_line_r = -project;
    out.n_line_t = -project.lazyProduct(skew(line.r - q).lazyProduct(line.A)) - skew(n).lazyProduct(line.A);
    return out;
}

} // namespace

ContactPoint planar_point(const BodyMotion& a, const BodyMotion& b, const PlanarGap& gap) {
    const Vec3 z = a.A * gap.axis_a, q = point_position(b, gap.point_b);
    const Vec3 d = q - point_position(a, gap.point_a), e = d - z.dot(d) * z;
    const double distance = e.norm();
    ContactPoint c;
    c.depth = distance - gap.clearance;
    if (distance > 0)
        c.n = e / distance;
    c.p = q + (gap.radius - distance) * c.n;
    return c;
}

// p = Q + (R - d) n, with the rate n . (dQ - dL) of d.
ContactPointRates planar_rates(const BodyMotion& a, const BodyMotion& b, const PlanarGap& gap,
                               const ContactPoint& c) {
    ContactPointRates rates;
    const Vec3 z = a.A * gap.axis_a, q = point_position(b, gap.point_b);
    const Mat3 q_by_turn = skew(b.r - q).lazyProduct(b.A);
    rates.p.rb = Mat3::Identity();
    rates.p.tb = q_by_turn;
    const double distance = c.depth + gap.clearance;
    if (c.n.squaredNorm() == 0 || distance <= 0)
        return rates;

    const LineRates line = line_rates(a, b, z, q, c.n, distance);
    rates.n = {line.n_line_r, line.n_line_t, line.n_other_r, line.n_other_t};
    const Gradient<1> depth = depth_gradient(a, b, c);
    for (auto part : {&Gradient<3>::ra, &Gradient<3>::ta, &Gradient<3>::rb, &Gradient<3>::tb})
        rates.p.*part += (gap.radius - distance) * (rates.n.*part);
    rates.p.ra -= c.n * depth.ra;
    rates.p.ta -= c.n * depth.ta;
    rates.p.rb -= c.n * depth.rb;
    rates.p.tb -= c.n * depth.tb;
    return rates;
}

namespace {

Vec3 bearing_end(const BodyMotion& a, const TwoEndGap& gap, int end) {
    return point_position(a, gap.point_a + (end == 0 ? -0.5 : 0.5) * gap.length * gap.axis_a);
}

} // namespace

std::array<ContactPoint, 2> two_end_points(const BodyMotion& a, const BodyMotion& b, const TwoEndGap& gap) {
    const Vec3 s = b.A * gap.axis_b, journal = point_position(b, gap.point_b);
    std::array<ContactPoint, 2> out;
    for (int end = 0; end < 2; ++end) {
        ContactPoint& c = out[end];
        const Vec3 q = bearing_end(a, gap, end), d = q - journal, w = d - s.dot(d) * s;
        const double distance = w.norm();
        c.depth = distance - gap.clearance;
        if (distance > 0)
            c.n = -w / distance;
        c.p = q + gap.radius * c.n;
    }
    return out;
}

ContactPointRates two_end_rates(const BodyMotion& a, const BodyMotion& b, const TwoEndGap& gap, int end,
                                const ContactPoint& c) {
    ContactPointRates rates;
    const Vec3 s = b.A * gap.axis_b, q = bearing_end(a, gap, end);
    const double distance = c.depth + gap.clearance;
    if (c.n.squaredNorm() > 0 && distance > 0) {
        const LineRates line = line_rates(b, a, s, q, -c.n, distance);
        rates.n = {-line.n_other_r, -line.n_other_t, -line.n_line_r, -line.n_line_t};
    }
    rates.p.ra = Mat3::Identity() + gap.radius * rates.n.ra;
    rates.p.ta = skew(a.r - q).lazyProduct(a.A) + gap.radius * rates.n.ta;
    rates.p.rb = gap.radius * rates.n.rb;
    rates.p.tb = gap.radius * rates.n.tb;
    return rates;
}

} // namespace gudgeon

#include "contact/gap_strip.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

// Below this fraction of the radius a length counts as zero.
constexpr double vanishing = 1e-30;

// Cosine and sine, in the quadrant of the journal's axis, of a stationary point of the distance.
struct Angle {
    double c = 1, s = 0;
    bool found = true;
};

Angle unit(double c, double s) {
    const double n = std::sqrt(c * c + s * s);
    return {c / n, s / n};
}

// The root mu > 0 of |(A/(mu + D), B/mu)| = 1. 1/|.| - 1 is concave and rises with mu, nearly straight:
// Newton from the left of the root stays left of it and converges in a few steps from anywhere.
Angle nearest_angle(double A, double B, double D, double R) {
    if (B <= vanishing * R) {
        if (A >= D)
            return {1, 0};
        const double c = A / D;
        return {c, std::sqrt((1 - c) * (1 + c))};
    }
    double mu = std::max({B, A - D, std::sqrt(A * A + B * B) - D});
    for (int k = 0; k < 50; ++k) {
        const double c = A / (mu + D), s = B / mu, n2 = c * c + s * s, n = std::sqrt(n2);
        if (n - 1 < 1e-15)
            break;
        mu += (n - 1) * n2 / (c * c / (mu + D) + s * s / mu);
        if (n - 1 < 1e-8) // this step was the last that counts
            break;
    }
    return unit(A / (mu + D), B / mu);
}

// The second local minimum, at mu = -nu on the other side of the long axis: the smaller root nu in (0, D) of
// (A/(D - nu))^2 + (B/nu)^2 = 1. The left side is convex; Newton from the left of the root rises to it, or
// passes the minimum where there is no root.
Angle opposite_angle(double A, double B, double D, double R) {
    constexpr Angle none{1, 0, false};
    if (A + B >= D || std::cbrt(A * A) + std::cbrt(B * B) >= std::cbrt(D * D))
        return none;
    if (B <= vanishing * R) {
        const double c = A / D;
        return {c, -std::sqrt((1 - c) * (1 + c))};
    }
    double nu = B;
    for (int k = 0; k < 100; ++k) {
        const double c = A / (D - nu), s = B / nu, over = c * c + s * s - 1;
        if (over < 1e-15)
            break;
        const double slope = 2 * (c * c / (D - nu) - s * s / nu);
        if (slope >= 0)
            return none;
        nu -= over / slope;
        if (nu >= D)
            return none;
    }
    const Angle angle = unit(A / (D - nu), B / nu);
    return {angle.c, -angle.s};
}

} // namespace

CylinderPose cylinder_pose(const BodyMotion& a, const BodyMotion& b, const CylinderPair& pair) {
    CylinderPose pose;
    pose.z = a.A * pair.axis_a;
    pose.s = b.A * pair.axis_b;
    pose.centre_a = point_position(a, pair.point_a);
    pose.centre_b = point_position(b, pair.point_b);
    const Vec3 d = pose.centre_a - pose.centre_b;
    pose.cosine = pose.z.dot(pose.s);
    pose.offset = d - pose.s.dot(d) * pose.s;
    pose.offset_slope = pose.z - pose.cosine * pose.s;
    return pose;
}

// Along the bearing the offset is straight, so that its length is largest at an end.
double bearing_depth_bound(const CylinderPose& pose, double journal_radius, double half_span,
                           double least_radius) {
    const Vec3 reach = half_span * pose.offset_slope;
    const double largest = std::max((pose.offset + reach).squaredNorm(), (pose.offset - reach).squaredNorm());
    return journal_radius - least_radius * std::abs(pose.cosine) + std::sqrt(largest);
}

double strip_depth_bound(const CylinderPose& pose, double journal_radius, double offset, double radius) {
    return journal_radius - radius * std::abs(pose.cosine) +
           (pose.offset + offset * pose.offset_slope).norm();
}

StripFrame strip_frame(const CylinderPose& pose) {
    StripFrame frame;
    // s - cosine z lies across z up to rounding; made exactly so, or any direction where the axes are
    // parallel.
    Vec3 m = pose.s - pose.cosine * pose.z;
    m -= m.dot(pose.z) * pose.z;
    frame.sine = m.norm();
    if (frame.sine < 1e-15) {
        frame.sine = 0;
        m = pose.z.unitOrthogonal();
    } else {
        m /= frame.sine;
    }
    frame.m = m;
    frame.e = m.cross(pose.z);
    frame.f = pose.cosine * m - frame.sine * pose.z;
    frame.q_e = -pose.offset.dot(frame.e);
    frame.q_f = -pose.offset.dot(frame.f);
    frame.x = pose.s.dot(pose.centre_a - pose.centre_b);
    return frame;
}

int strip_points(const CylinderPose& pose, const StripFrame& frame, double journal_radius, double offset,
                 double radius, StripPoint out[2]) {
    const double R = radius, cosine = pose.cosine, short_axis = std::abs(cosine);
    const double q_e = frame.q_e, q_f = frame.q_f + offset * frame.sine;
    const double A = std::abs(q_e), B = short_axis * std::abs(q_f), D = R * frame.sine * frame.sine;
    const double side_e = q_e < 0 ? -1 : 1, side_f = (q_f < 0) != (cosine < 0) ? -1 : 1;

    const auto fill = [&](const Angle& angle, StripPoint& c) {
        const double ce = side_e * angle.c, sf = side_f * angle.s;
        const double w_e = R * ce - q_e, w_f = R * cosine * sf - q_f;
        c.radius = R;
        c.radial = ce * frame.e + sf * frame.m;
        c.p = pose.centre_a + offset * pose.z + R * c.radial;
        c.x = frame.x + offset * cosine + R * frame.sine * sf;
        c.distance = std::sqrt(w_e * w_e + w_f * w_f);
        c.depth = journal_radius - c.distance;
        if (c.distance > 1e-12 * R) {
            c.n = (w_e / c.distance) * frame.e + (w_f / c.distance) * frame.f;
        } else { // the circle crosses the axis: the normal of the ellipse, outwards
            const Angle normal = unit(short_axis * ce, cosine < 0 ? -sf : sf);
            c.n = normal.c * frame.e + normal.s * frame.f;
        }
    };

    fill(nearest_angle(A, B, D, R), out[0]);
    const Angle second = opposite_angle(A, B, D, R);
    if (!second.found)
        return 1;
    fill(second, out[1]);
    return 2;
}

// With the shift V = dp_a - dp_b of the two materials at p, the turns ta, tb, tau = z x rho, t = s x n, k = t
// . tau:
//   angle    d(phi) = -(k t . V + (tau x w) . (ta - tb)) / g,  g = R (1 - (s . tau)^2) - w . rho
//   point    dp = dp_a + R tau d(phi)
//   normal   dn = t (t . V + R k d(phi)) / d + tb x n
//   along    dx = s . (V + R tau d(phi))
ContactPointRates strip_rates(const BodyMotion& a, const BodyMotion& b, const CylinderPose& pose,
                              const StripPoint& c, Gradient<1>* position) {
    const Vec3 tau = pose.z.cross(c.radial), t = pose.s.cross(c.n);
    const double along = pose.s.dot(tau), k = t.dot(tau);
    const double g = c.radius * (1 - along * along) - c.distance * c.n.dot(c.radial);
    const double per_g = std::abs(g) > 1e-13 * c.radius ? 1 / g : 0;
    const double per_d = c.distance > 1e-12 * c.radius ? 1 / c.distance : 0;

    // d(phi) = phi_shift . (dr_a - dr_b) + phi_a . turn_a - phi_b . turn_b, turns global; t . V likewise.
    const Vec3 arm_a = c.p - a.r, arm_b = c.p - b.r;
    const Vec3 phi_shift = -k * per_g * t, phi_turn = -c.distance * per_g * tau.cross(c.n);
    const Mat3 At = a.A.transpose(), Bt = b.A.transpose();
    Gradient<1> phi, shift;
    const auto rows = [&](const Vec3& x, const Vec3& turn, Gradient<1>& out) {
        out.ra = x.transpose();
        out.ta = (At * (arm_a.cross(x) + turn)).transpose();
        out.rb = -x.transpose();
        out.tb = -(Bt * (arm_b.cross(x) + turn)).transpose();
    };
    rows(phi_shift, phi_turn, phi);
    rows(t, Vec3::Zero(), shift);

    const Vec3 slide = c.radius * tau, t_d = per_d * t;
    const double slide_t = c.radius * k;
    ContactPointRates rates;
    rates.p.ra = Mat3::Identity() + slide * phi.ra;
    rates.p.ta = skew(-arm_a).lazyProduct(a.A) + slide * phi.ta;
    rates.p.rb = slide * phi.rb;
    rates.p.tb = slide * phi.tb;
    rates.n.ra = t_d * (shift.ra + slide_t * phi.ra);
    rates.n.ta = t_d * (shift.ta + slide_t * phi.ta);
    rates.n.rb = t_d * (shift.rb + slide_t * phi.rb);
    rates.n.tb = t_d * (shift.tb + slide_t * phi.tb) + skew(-c.n).lazyProduct(b.A);

    if (position != nullptr) {
        rows(pose.s, Vec3::Zero(), *position);
        *position = combined(1.0, *position, c.radius * along, phi);
    }
    return rates;
}

Coverage strip_coverage(double x, double width, double journal_length) {
    const bool cut_low = x - width / 2 < -journal_length / 2, cut_high = x + width / 2 > journal_length / 2;
    const double low = cut_low ? -journal_length / 2 : x - width / 2;
    const double high = cut_high ? journal_length / 2 : x + width / 2;
    if (high <= low)
        return {0, 0};
    if (!cut_low && !cut_high)
        return {1, 0};
    return {(high - low) / width, (cut_low - cut_high) / width};
}

} // namespace gudgeon

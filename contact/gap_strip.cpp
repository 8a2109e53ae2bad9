#include "contact/gap_strip.hpp"

#include <algorithm>
#include <limits>

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

// The root m of x/(m + eps)^2 + (1 - x)/m^2 = 1 by its series in eps: the journal's axis is far off the
// centre against D, and the tilt bends the nearest point's place only a little. The ratio of (A m, B (m +
// eps)) is exact to eps^8, which is rounding up to small_bend.
constexpr double small_bend = 0.01;
Angle slightly_bent_angle(double A, double B, double x, double eps) {
    const double w = x * (1 - x), u = 2 * x - 1;
    const double a6 = 0.4375 * (8 - w * (132 - 429 * w)), a5 = 3 * u * (1 - 8 * w);
    const double a4 = 0.625 * (4 - 21 * w), a3 = 2 * u, a2 = 1.5;
    const double m = 1 - eps * x + eps * eps * w * (a2 + eps * (a3 + eps * (a4 + eps * (a5 + eps * a6))));
    return unit(A * m, B * (m + eps));
}

// The root mu > 0 of |(A/(mu + D), B/mu)| = 1. 1/|.| - 1 is concave and rises with mu, nearly straight:
// Newton from the left of the root stays left of it and converges in a few steps from anywhere.
Angle nearest_angle(double A, double B, double D, double R) {
    const double far2 = A * A + B * B;
    if (D * D <= small_bend * small_bend * far2 && far2 > vanishing * R * R) {
        const double per_far = 1 / std::sqrt(far2);
        return slightly_bent_angle(A, B, A * A * per_far * per_far, D * per_far);
    }
    if (B <= vanishing * R) {
        if (A >= D)
            return {1, 0};
        const double c = A / D;
        return {c, std::sqrt((1 - c) * (1 + c))};
    }
    double mu = std::max({B, A - D, std::sqrt(far2) - D});
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
    frame.cosine = pose.cosine;
    return frame;
}

double strip_depth_bound(const StripFrame& frame, double journal_radius, double offset, double radius) {
    const double f = frame.journal_f(offset);
    return journal_radius - radius * std::abs(frame.cosine) + std::sqrt(frame.q_e * frame.q_e + f * f);
}

bool strip_is_apart(const StripFrame& frame, double journal_radius, double offset, double radius) {
    const double play = radius * std::abs(frame.cosine) - journal_radius, f = frame.journal_f(offset);
    return play >= 0 && frame.q_e * frame.q_e + f * f <= play * play;
}

bool may_touch_twice(const StripFrame& frame, double journal_radius, double radius) {
    return radius * frame.cosine * frame.cosine < journal_radius;
}

namespace {

// A circle and the journal's axis in the quadrant of its ellipse where the axis passes.
struct Quadrant {
    double A, B, D;
    double side_e, side_f;
    double q_e, q_f;

    Quadrant(const StripFrame& frame, double offset, double radius)
        : q_e(frame.q_e), q_f(frame.journal_f(offset)) {
        A = std::abs(q_e);
        B = std::abs(frame.cosine * q_f);
        D = radius * frame.sine * frame.sine;
        side_e = q_e < 0 ? -1 : 1;
        side_f = (q_f < 0) != (frame.cosine < 0) ? -1 : 1;
    }
};

bool fill_point(const CylinderPose& pose, const StripFrame& frame, double journal_radius, double offset,
                double radius, const Quadrant& quadrant, const Angle& angle, double above, StripPoint& c) {
    const double R = radius, cosine = frame.cosine;
    const double ce = quadrant.side_e * angle.c, sf = quadrant.side_f * angle.s;
    const double w_e = R * ce - quadrant.q_e, w_f = R * cosine * sf - quadrant.q_f;
    c.distance = std::sqrt(w_e * w_e + w_f * w_f);
    c.depth = journal_radius - c.distance;
    if (!(c.depth > above))
        return false;
    c.radius = R;
    c.radial = ce * frame.e + sf * frame.m;
    c.arm = offset * pose.z + R * c.radial;
    c.p = pose.centre_a + c.arm;
    c.x = frame.x + offset * cosine + R * frame.sine * sf;
    if (c.distance > 1e-12 * R) {
        const double per_distance = 1 / c.distance;
        c.n = (w_e * per_distance) * frame.e + (w_f * per_distance) * frame.f;
    } else { // the circle crosses the axis: the normal of the ellipse, outwards
        const Angle normal = unit(std::abs(cosine) * ce, cosine < 0 ? -sf : sf);
        c.n = normal.c * frame.e + normal.s * frame.f;
    }
    return true;
}

constexpr double any_depth = -std::numeric_limits<double>::infinity();

} // namespace

bool nearest_strip_point(const CylinderPose& pose, const StripFrame& frame, double journal_radius,
                         double offset, double radius, double above, StripPoint& out) {
    const Quadrant q(frame, offset, radius);
    return fill_point(pose, frame, journal_radius, offset, radius, q, nearest_angle(q.A, q.B, q.D, radius),
                      above, out);
}

int strip_points(const CylinderPose& pose, const StripFrame& frame, double journal_radius, double offset,
                 double radius, StripPoint out[2]) {
    nearest_strip_point(pose, frame, journal_radius, offset, radius, any_depth, out[0]);
    const Quadrant q(frame, offset, radius);
    const Angle second = opposite_angle(q.A, q.B, q.D, radius);
    if (!second.found)
        return 1;
    fill_point(pose, frame, journal_radius, offset, radius, q, second, any_depth, out[1]);
    return 2;
}

StripSlopes::StripSlopes(const CylinderPose& pose, const StripPoint& c)
    : tau(pose.z.cross(c.radial)), t(pose.s.cross(c.n)) {
    k = t.dot(tau);
    along = pose.s.dot(tau);
    g = c.radius * (1 - along * along) - c.distance * c.n.dot(c.radial);
    per_g = std::abs(g) > 1e-13 * c.radius ? 1 / g : 0;
    per_distance = c.distance > 1e-12 * c.radius ? 1 / c.distance : 0;
    depth << c.n, c.arm.cross(c.n);
    tangent << t, c.arm.cross(t);
    angle = k * tangent;
    angle.tail<3>() += c.distance * tau.cross(c.n);
    angle *= per_g;
}

Mat36 StripSlopes::normal(const StripPoint& c) const {
    Mat36 out = t * slide(c.radius).transpose();
    out.rightCols<3>() -= skew(c.n);
    return out;
}

Vec6 StripSlopes::rate(const StripPoint& c, const Vec3& velocity, const Vec3& turning) const {
    Vec6 out = t.dot(velocity) * slide(c.radius) + c.radius * c.n.dot(turning.cross(tau)) * angle;
    out.tail<3>() += c.n.cross(velocity);
    return out;
}

Vec6 StripSlopes::position(const CylinderPose& pose, const StripPoint& c) const {
    Vec6 out = c.radius * along * angle;
    out.head<3>() -= pose.s;
    out.tail<3>() -= c.arm.cross(pose.s);
    return out;
}

// Seen from the bearing z and the circle's centre are fixed: each factor of position() in turn.
Mat6 StripSlopes::position_slope(const CylinderPose& pose, const StripPoint& c) const {
    const auto below = [](const Mat36& upper, const Mat36& lower) {
        Mat6 out;
        out << upper, lower;
        return out;
    };
    Mat36 ds = Mat36::Zero();
    ds.rightCols<3>() = -skew(pose.s);
    const Mat36 dn = normal(c), dr = point(c), dtau = -c.radial * angle.transpose();
    const Mat36 dt = skew(pose.s) * dn - skew(c.n) * ds;
    const Mat6 dT = below(dt, skew(c.arm) * dt - skew(t) * dr);
    const Vec3 w = c.distance * c.n;
    const Mat36 dw = c.distance * dn - c.n * depth.transpose();
    const Vec6 dk = dt.transpose() * tau + dtau.transpose() * t;
    const Vec6 dalong = ds.transpose() * tau + dtau.transpose() * pose.s;
    const Vec6 dg = -2 * c.radius * along * dalong - dw.transpose() * c.radial - w.dot(tau) * angle;
    const Mat6 turned = below(Mat36::Zero(), skew(tau) * dw - skew(w) * dtau);
    const Mat6 dphi = per_g * (tangent * dk.transpose() + k * dT + turned - angle * dg.transpose());
    return c.radius * (angle * dalong.transpose() + along * dphi) -
           below(ds, skew(c.arm) * ds - skew(pose.s) * dr);
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

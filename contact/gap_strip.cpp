#include "contact/gap_strip.hpp"

#include <algorithm>
#include <cmath>

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

// Row i from its angle.
void set_point(const StripFrame& frame, const Quadrant& quadrant, const Angle& angle, int i, StripRow& row) {
    row.c[i] = quadrant.side_e * angle.c;
    row.s[i] = quadrant.side_f * angle.s;
    row.w_e[i] = row.radius[i] * row.c[i] - quadrant.q_e;
    row.w_f[i] = row.radius[i] * frame.cosine * row.s[i] - quadrant.q_f;
    row.distance[i] = std::sqrt(row.w_e[i] * row.w_e[i] + row.w_f[i] * row.w_f[i]);
}

} // namespace

void StripRow::find(const StripFrame& frame, double journal_radius, int first, int last,
                    const double* offsets, const double* radii) {
    count = 0;
    for (int k = first; k < last; ++k) {
        strip[count] = k;
        offset[count] = offsets[k];
        radius[count] = radii[k];
        count += !strip_is_apart(frame, journal_radius, offsets[k], radii[k]);
    }
    solve(frame);
}

void StripRow::find(const StripFrame& frame, double offset_, double radius_) {
    count = 1;
    strip[0] = 0;
    offset[0] = offset_;
    radius[0] = radius_;
    solve(frame);
}

// Where the journal's axis is far off the centre against D, as with nearly parallel axes, the root of
// nearest_angle() by its series: with m = mu / |(A, B)|, eps = D / |(A, B)|, x the square of A / |(A, B)|,
//   x/(m + eps)^2 + (1 - x)/m^2 = 1,   m = 1 - eps x + w (3/2 eps^2 + ...),   w = x (1 - x)
// up to eps^6; the direction (A m, B (m + eps)) is then exact to eps^8, which is rounding up to small_bend.
void StripRow::solve(const StripFrame& frame) {
    constexpr double small_bend = 0.01;
    const double q_e = frame.q_e, q_f0 = frame.q_f, sine = frame.sine, cosine = frame.cosine;
    const double A = std::abs(q_e), A2 = A * A, side_e = q_e < 0 ? -1 : 1, sine2 = sine * sine;
    std::array<double, most> bend;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const double R = radius[i], q_f = q_f0 + offset[i] * sine, b = cosine * q_f;
        const double per_far = 1 / std::sqrt(A2 + b * b);
        const double eps = R * sine2 * per_far, x = A2 * per_far * per_far, w = x * (1 - x), u = 2 * x - 1;
        const double a6 = 0.4375 * (8 - w * (132 - 429 * w)), a5 = 3 * u * (1 - 8 * w);
        const double a4 = 0.625 * (4 - 21 * w), a3 = 2 * u, a2 = 1.5;
        const double m = 1 - eps * x + eps * eps * w * (a2 + eps * (a3 + eps * (a4 + eps * (a5 + eps * a6))));
        const double e = A * m, f = b * (m + eps), per_length = 1 / std::sqrt(e * e + f * f);
        bend[i] = std::max(eps, small_bend * vanishing * R * per_far); // nor so near that squares vanish
        c[i] = side_e * (e * per_length);
        s[i] = f * per_length;
        w_e[i] = R * c[i] - q_e;
        w_f[i] = R * cosine * s[i] - q_f;
        distance[i] = std::sqrt(w_e[i] * w_e[i] + w_f[i] * w_f[i]);
    }
    for (int i = 0; i < count; ++i)
        if (!(bend[i] <= small_bend) || !std::isfinite(distance[i])) {
            const Quadrant q(frame, offset[i], radius[i]);
            set_point(frame, q, nearest_angle(q.A, q.B, q.D, radius[i]), i, *this);
        }
}

void StripRow::fill(const CylinderPose& pose, const StripFrame& frame, double journal_radius, int i,
                    StripPoint& out) const {
    const double R = radius[i];
    out.distance = distance[i];
    out.depth = depth(i, journal_radius);
    out.radius = R;
    out.radial = c[i] * frame.e + s[i] * frame.m;
    out.arm = offset[i] * pose.z + R * out.radial;
    out.p = pose.centre_a + out.arm;
    out.x = frame.x + offset[i] * frame.cosine + R * frame.sine * s[i];
    if (distance[i] > 1e-12 * R) {
        const double per_distance = 1 / distance[i];
        out.n = (w_e[i] * per_distance) * frame.e + (w_f[i] * per_distance) * frame.f;
    } else { // the circle crosses the axis: the normal of the ellipse, outwards
        const Angle normal = unit(std::abs(frame.cosine) * c[i], frame.cosine < 0 ? -s[i] : s[i]);
        out.n = normal.c * frame.e + normal.s * frame.f;
    }
}

int strip_points(const CylinderPose& pose, const StripFrame& frame, double journal_radius, double offset,
                 double radius, StripPoint out[2]) {
    StripRow row;
    row.find(frame, offset, radius);
    row.fill(pose, frame, journal_radius, 0, out[0]);
    const Quadrant q(frame, offset, radius);
    const Angle second = opposite_angle(q.A, q.B, q.D, radius);
    if (!second.found)
        return 1;
    set_point(frame, q, second, 0, row);
    row.fill(pose, frame, journal_radius, 0, out[1]);
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

#include "core/relative_motion.hpp"

#include <cmath>

namespace gudgeon {

namespace {

// Rows x^T skew(s) = (x cross s)^T, used throughout.
Eigen::RowVector3d row(const Vec3& x) { return x.transpose(); }

// out += B_i^T N B_j for all parts.
template <int R>
void add_quadratic(const Gradient<R>& left, const Eigen::Matrix<double, R, R>& n, const Gradient<R>& right,
                   BlockMatrix& out) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            out.block[i][j] += left.part(i).transpose() * n * right.part(j);
}

} // namespace

void BlockMatrix::set_zero() {
    for (auto& blocks : block)
        for (Mat3& m : blocks)
            m.setZero();
}

Mat3 joint_triad(const Vec3& axis) {
    int largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    return joint_triad(axis, Vec3::Unit((largest + 1) % 3));
}

Mat3 joint_triad(const Vec3& axis, const Vec3& reference) {
    const Vec3 b = axis.normalized();
    const Vec3 h = (reference - reference.dot(b) * b).normalized();
    Mat3 triad;
    triad << h, b.cross(h), b;
    return triad;
}

namespace point_difference {

Gradient<3> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    Gradient<3> g;
    g.ra = -Mat3::Identity();
    g.ta = a.A * skew(sa);
    g.rb = Mat3::Identity();
    g.tb = -b.A * skew(sb);
    return g;
}

Vec3 drift(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    return b.A * b.w.cross(b.w.cross(sb)) - a.A * a.w.cross(a.w.cross(sa));
}

Gradient<3> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    Gradient<3> g;
    g.ta = a.A * skew(a.w.cross(sa));
    g.tb = -b.A * skew(b.w.cross(sb));
    return g;
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& g,
                   BlockMatrix& out) {
    out.block[1][1] -= skew(sa) * skew(a.A.transpose() * g);
    out.block[3][3] += skew(sb) * skew(b.A.transpose() * g);
}

} // namespace point_difference

namespace displacement {

double value(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& x) {
    return (a.A * x).dot(point_difference::value(a, b, sa, sb));
}

Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb,
                     const Vec3& x) {
    const Vec3 lever = a.A.transpose() * (point_position(b, sb) - a.r); // a's mass centre to P_b
    const Vec3 x_global = a.A * x;
    Gradient<1> g;
    g.ra = -row(x_global);
    g.ta = row(x.cross(lever));
    g.rb = row(x_global);
    g.tb = row(sb.cross(b.A.transpose() * x_global));
    (void)sa; // the value needs it, the gradient does not
    return g;
}

Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3&, const Vec3& sb,
                          const Vec3& x) {
    const Vec3 lever = a.A.transpose() * (point_position(b, sb) - a.r);
    const Vec3 relative = a.A.transpose() * (point_velocity(b, sb) - a.v);
    const Vec3 turning = x.cross(a.w);
    const Mat3 b_from_a = b.A.transpose() * a.A;
    Gradient<1> g;
    g.ra = row(a.A * turning);
    g.ta = row(x.cross(relative) - turning.cross(lever));
    g.rb = -g.ra;
    g.tb = row((b_from_a * turning).cross(sb) - (b_from_a * x).cross(b.w.cross(sb)));
    return g;
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3&, const Vec3& sb, const Vec3& gx,
                   BlockMatrix& out) {
    const Vec3 lever = a.A.transpose() * (point_position(b, sb) - a.r);
    const Mat3 a_from_b = a.A.transpose() * b.A;
    const Mat3 turn = a.A * skew(gx);
    const Mat3 gx_skew = skew(gx);
    out.block[0][1] += turn;
    out.block[2][1] -= turn;
    out.block[1][0] -= gx_skew * a.A.transpose();
    out.block[1][1] += gx_skew * skew(lever);
    out.block[1][2] += gx_skew * a.A.transpose();
    out.block[1][3] -= gx_skew * a_from_b * skew(sb);
    out.block[3][1] -= skew(sb) * a_from_b.transpose() * gx_skew;
    out.block[3][3] += skew(sb) * skew(a_from_b.transpose() * gx);
}

} // namespace displacement

namespace alignment {

Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    const Mat3 a_from_b = a.A.transpose() * b.A;
    const Vec3 x_rate = a.w.cross(x), y_rate = b.w.cross(y);
    Gradient<1> g;
    g.ta = row(x_rate.cross(a_from_b * y) - (a_from_b * y_rate).cross(x));
    g.tb = row(y_rate.cross(a_from_b.transpose() * x) - (a_from_b.transpose() * x_rate).cross(y));
    return g;
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y, double g,
                   BlockMatrix& out) {
    const Mat3 a_from_b = a.A.transpose() * b.A;
    const Mat3 gx = g * skew(x), gy = g * skew(y);
    out.block[1][1] += gx * skew(a_from_b * y);
    out.block[1][3] -= gx * a_from_b * skew(y);
    out.block[3][1] -= gy * a_from_b.transpose() * skew(x);
    out.block[3][3] += gy * skew(a_from_b.transpose() * x);
}

} // namespace alignment

namespace swing {

namespace {

// 1/sin of the angle; 0 where the axes are one line and the angle has no gradient.
double inverse_sine(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    constexpr double least = 1e-12;
    const double sine = (a.A * x).cross(b.A * y).norm();
    return sine > least ? 1 / sine : 0;
}

} // namespace

double value(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    const Vec3 in_a = a.A * x, in_b = b.A * y;
    return std::atan2(in_a.cross(in_b).norm(), in_a.dot(in_b));
}

// With c = x . y and theta' = -c'/sin
Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    const double k = -inverse_sine(a, b, x, y);
    Gradient<1> g = alignment::gradient(a, b, x, y);
    g.ta *= k;
    g.tb *= k;
    return g;
}

// d(-c'/sin) = -(d(c') + theta' cos d(theta))/sin
Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y) {
    const double k = -inverse_sine(a, b, x, y);
    const Gradient<1> own = gradient(a, b, x, y);
    const double turning = own.times(a, b)[0] * alignment::value(a, b, x, y);
    Gradient<1> g = alignment::rate_gradient(a, b, x, y);
    g.ta = k * (g.ta + turning * own.ta);
    g.tb = k * (g.tb + turning * own.tb);
    return g;
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& x, const Vec3& y, double g,
                   BlockMatrix& out) {
    const double k = -g * inverse_sine(a, b, x, y);
    alignment::add_geometric(a, b, x, y, k, out);
    const Gradient<1> own = gradient(a, b, x, y);
    add_quadratic<1>(own, Eigen::Matrix<double, 1, 1>(k * alignment::value(a, b, x, y)), own, out);
}

} // namespace swing

namespace distance {

double value(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    return point_difference::value(a, b, sa, sb).norm();
}

namespace {
Gradient<1> along(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, const Vec3& n) {
    Gradient<1> g;
    g.ra = -row(n);
    g.ta = row((a.A.transpose() * n).cross(sa));
    g.rb = row(n);
    g.tb = -row((b.A.transpose() * n).cross(sb));
    return g;
}
} // namespace

Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    return along(a, b, sa, sb, point_difference::value(a, b, sa, sb).normalized());
}

Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb) {
    const Vec3 d = point_difference::value(a, b, sa, sb);
    const double length = d.norm();
    const Vec3 n = d / length;
    const Vec3 d_rate = point_velocity(b, sb) - point_velocity(a, sa);
    const Vec3 swing = (d_rate - n.dot(d_rate) * n) / length;
    Gradient<1> g = along(a, b, sa, sb, swing);
    g.ta += row((a.A.transpose() * n).cross(a.w.cross(sa)));
    g.tb -= row((b.A.transpose() * n).cross(b.w.cross(sb)));
    return g;
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const Vec3& sa, const Vec3& sb, double g,
                   BlockMatrix& out) {
    const Vec3 d = point_difference::value(a, b, sa, sb);
    const double length = d.norm();
    const Vec3 n = d / length;
    point_difference::add_geometric(a, b, sa, sb, g * n, out);
    const Gradient<3> grad = point_difference::gradient(a, b, sa, sb);
    add_quadratic<3>(grad, Mat3(g / length * (Mat3::Identity() - n * n.transpose())), grad, out);
}

} // namespace distance

namespace rotation_vector {

namespace {

// c(x) = (1 - (t/2) cot(t/2)) / t^2 and c'(t) / t with x = t^2, by series where the closed form cancels.
constexpr double largest_for_series = 0.25;
double series(double x) {
    return 1.0 / 12 +
           x * (1.0 / 720 +
                x * (1.0 / 30240 + x * (1.0 / 1209600 + x * (1.0 / 47900160 + x * (691.0 / 1307674368000.0 +
                                                                                   x / 74724249600.0)))));
}
struct Coefficients {
    double c, slope;
};
Coefficients coefficients(double x) {
    if (x < largest_for_series) {
        const double c = series(x);
        const double slope =
            2 * (1.0 / 720 + x * (2.0 / 30240 + x * (3.0 / 1209600 +
                                                     x * (4.0 / 47900160 + x * (5 * 691.0 / 1307674368000.0 +
                                                                                x * 6 / 74724249600.0)))));
        return {c, slope};
    }
    const double t = std::sqrt(x), s = std::sin(0.5 * t), cot = std::cos(0.5 * t) / s;
    const double c = 1 / x - cot / (2 * t);
    return {c, (-2 / (x * t) + cot / (2 * x) + 1 / (4 * t * s * s)) / t};
}

// d/dtheta of c theta x (theta x g)
Mat3 quadratic_derivative(const Vec3& theta, const Vec3& g) {
    const Coefficients k = coefficients(theta.squaredNorm());
    const Vec3 tg = theta.cross(g);
    return k.slope * theta.cross(tg) * theta.transpose() - k.c * (skew(tg) + skew(theta) * skew(g));
}

} // namespace

Vec3 value(const BodyMotion& a, const BodyMotion& b, const Vec4& qa, const Vec4& qb) {
    const Eigen::Quaterniond fa =
        Eigen::Quaterniond(a.p[0], a.p[1], a.p[2], a.p[3]) * Eigen::Quaterniond(qa[0], qa[1], qa[2], qa[3]);
    const Eigen::Quaterniond fb =
        Eigen::Quaterniond(b.p[0], b.p[1], b.p[2], b.p[3]) * Eigen::Quaterniond(qb[0], qb[1], qb[2], qb[3]);
    const Eigen::Quaterniond rel = fa.conjugate() * fb;
    const double sign = rel.w() < 0 ? -1 : 1;
    const double s = rel.vec().norm();
    const double factor = s < 1e-9 ? 2.0 : 2 * std::atan2(s, sign * rel.w()) / s;
    return sign * factor * rel.vec();
}

double curvature(const Vec3& theta) {
    const double x = theta.squaredNorm();
    return x < largest_for_series ? series(x) : coefficients(x).c;
}

Gradient<3> gradient(const Vec3& theta, const Mat3& axes_a, const Mat3& axes_b) {
    const Mat3 t = skew(theta);
    const Mat3 even = Mat3::Identity() + coefficients(theta.squaredNorm()).c * t * t;
    Gradient<3> g;
    g.ta = -(even - 0.5 * t) * axes_a.transpose();
    g.tb = (even + 0.5 * t) * axes_b.transpose();
    return g;
}

Gradient<3> rate_gradient(const BodyMotion& a, const BodyMotion& b, const Vec3& theta, const Mat3& axes_a,
                          const Mat3& axes_b, const Gradient<3>& gradient) {
    const Vec3 wa = axes_a.transpose() * a.w, wb = axes_b.transpose() * b.w;
    const Mat3 d = -0.5 * skew(wa + wb) + quadratic_derivative(theta, wb - wa);
    Gradient<3> g;
    g.ta = d * gradient.ta;
    g.tb = d * gradient.tb;
    return g;
}

void add_geometric(const Vec3& theta, const Mat3& axes_a, const Mat3& axes_b, const Gradient<3>& gradient,
                   const Vec3& g, BlockMatrix& out) {
    const Mat3 q = quadratic_derivative(theta, g), half = 0.5 * skew(g);
    const Mat3 da = -axes_a * (q - half), db = axes_b * (q + half);
    out.block[1][1] += da * gradient.ta;
    out.block[1][3] += da * gradient.tb;
    out.block[3][1] += db * gradient.ta;
    out.block[3][3] += db * gradient.tb;
}

} // namespace rotation_vector

namespace angle {

namespace {

// Sine and cosine like parts with their gradients.
struct Parts {
    double s, c, n;
    Gradient<1> gs, gc;
};
Parts parts(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f) {
    Parts p{alignment::value(a, b, f.x1, f.y1), alignment::value(a, b, f.x2, f.y2), 0,
            alignment::gradient(a, b, f.x1, f.y1), alignment::gradient(a, b, f.x2, f.y2)};
    p.n = p.s * p.s + p.c * p.c;
    return p;
}
Gradient<1> combine(double x, const Gradient<1>& g, double y, const Gradient<1>& h) {
    Gradient<1> out;
    out.ta = x * g.ta + y * h.ta;
    out.tb = x * g.tb + y * h.tb;
    return out;
}

} // namespace

double value(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f, double reference) {
    const double folded = std::atan2(alignment::value(a, b, f.x1, f.y1), alignment::value(a, b, f.x2, f.y2));
    return reference + std::remainder(folded - reference, 2 * pi);
}

Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f) {
    const Parts p = parts(a, b, f);
    return combine(p.c / p.n, p.gs, -p.s / p.n, p.gc);
}

Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f) {
    const Parts p = parts(a, b, f);
    const double s_rate = p.gs.times(a, b)[0], c_rate = p.gc.times(a, b)[0];
    const double rate = (p.c * s_rate - p.s * c_rate) / p.n;
    const Gradient<1> ds = alignment::rate_gradient(a, b, f.x1, f.y1);
    const Gradient<1> dc = alignment::rate_gradient(a, b, f.x2, f.y2);
    const Gradient<1> explicit_part = combine(p.c / p.n, ds, -p.s / p.n, dc);
    const Gradient<1> implicit_part =
        combine((-c_rate - 2 * rate * p.s) / p.n, p.gs, (s_rate - 2 * rate * p.c) / p.n, p.gc);
    return combine(1, explicit_part, 1, implicit_part);
}

void add_geometric(const BodyMotion& a, const BodyMotion& b, const AngleFrames& f, double g,
                   BlockMatrix& out) {
    const Parts p = parts(a, b, f);
    alignment::add_geometric(a, b, f.x1, f.y1, g * p.c / p.n, out);
    alignment::add_geometric(a, b, f.x2, f.y2, -g * p.s / p.n, out);
    // d of the factors c/n, -s/n
    const Gradient<1> angle_gradient = combine(p.c / p.n, p.gs, -p.s / p.n, p.gc);
    const Gradient<1> dn = combine(2 * p.s, p.gs, 2 * p.c, p.gc);
    const Eigen::Matrix<double, 1, 1> k(g / p.n);
    add_quadratic<1>(p.gs, k, p.gc, out);
    add_quadratic<1>(p.gc, -k, p.gs, out);
    add_quadratic<1>(angle_gradient, -k, dn, out);
}

} // namespace angle

} // namespace gudgeon

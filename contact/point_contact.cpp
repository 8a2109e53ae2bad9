#include "contact/point_contact.hpp"

namespace gudgeon {

namespace {

// skew(x) m, column by column.
inline Mat3 cross_columns(const Vec3& x, const Mat3& m) {
    Mat3 out;
    for (int k = 0; k < 3; ++k)
        out.col(k) = x.cross(m.col(k));
    return out;
}

} // namespace

Gradient<1> depth_gradient(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c) {
    Gradient<1> g;
    g.ra = -c.n.transpose();
    g.ta = -(a.A.transpose() * (c.p - a.r).cross(c.n)).transpose();
    g.rb = c.n.transpose();
    g.tb = (b.A.transpose() * (c.p - b.r).cross(c.n)).transpose();
    return g;
}

// B u = -n . V with V the velocity of a's material at p off that of b's. Fixed in B u are v, w in the bodies.
Gradient<1> depth_rate_gradient(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c,
                                const ContactPointRates& rates, const Gradient<1>& gradient) {
    const Vec3 wa = a.A * a.w, wb = b.A * b.w;
    const Vec3 relative = a.v - b.v + wa.cross(c.p - a.r) - wb.cross(c.p - b.r);
    const Eigen::RowVector3d by_n = -relative.transpose(), by_p = -c.n.cross(wa - wb).transpose();
    const auto part = [&](int k) -> Eigen::RowVector3d {
        return by_n.lazyProduct(rates.n.part(k)) + by_p.lazyProduct(rates.p.part(k));
    };
    Gradient<1> d;
    d.ra = part(0) + c.n.cross(wa).transpose();
    d.ta = part(1) + a.w.cross(gradient.ta.transpose()).transpose();
    d.rb = part(2) - c.n.cross(wb).transpose();
    d.tb = part(3) + b.w.cross(gradient.tb.transpose()).transpose();
    return d;
}

PairWrench point_wrench(const BodyMotion& a, const BodyMotion& b, const Vec3& p, const Vec3& force) {
    return {force, a.A.transpose() * (p - a.r).cross(force), -force,
            -(b.A.transpose() * (p - b.r).cross(force))};
}

// The wrench is (f n, f A_a^T (l_a x n), -f n, -f A_b^T (l_b x n)) with arms l to p. With X = d(f n)/dq its
// rows are -X, A_a^T (-l_a x X + f n x d(l_a)), ... and the turning of the frames in which moments are
// written.
void add_contact_linearisation(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c,
                               const ContactPointRates& rates, const Gradient<1>& gradient, double f,
                               const Gradient<1>& force_change, double f_rate, BlockMatrix& C,
                               BlockMatrix& S) {
    const Vec3 arm_a = c.p - a.r, arm_b = c.p - b.r, force = f * c.n;
    for (int j = 0; j < 4; ++j) {
        const Mat3 x = c.n * force_change.part(j) + f * rates.n.part(j);
        Mat3 moment_a = cross_columns(force, rates.p.part(j));
        Mat3 moment_b = moment_a;
        if (j == 0)
            moment_a -= skew(force);
        if (j == 2)
            moment_b -= skew(force);
        moment_a -= cross_columns(arm_a, x);
        moment_b -= cross_columns(arm_b, x);
        S.block[0][j] -= x;
        S.block[2][j] += x;
        S.block[1][j] += a.A.transpose().lazyProduct(moment_a);
        S.block[3][j] -= b.A.transpose().lazyProduct(moment_b);
    }
    S.block[1][1] += skew(f * gradient.ta.transpose());
    S.block[3][3] += skew(f * gradient.tb.transpose());

    if (f_rate == 0)
        return;
    for (int i = 0; i < 4; ++i) {
        const Vec3 left = f_rate * gradient.part(i).transpose();
        for (int j = 0; j < 4; ++j)
            C.block[i][j] += left * gradient.part(j);
    }
}

void add_normal_linearisation(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c,
                              const ContactPointRates& rates, double f, double f_depth, double f_rate,
                              BlockMatrix& C, BlockMatrix& S) {
    const Gradient<1> gradient = depth_gradient(a, b, c);
    const Gradient<1> change =
        f_rate == 0 ? combined(f_depth, gradient, 0.0, gradient)
                    : combined(f_depth, gradient, f_rate, depth_rate_gradient(a, b, c, rates, gradient));
    add_contact_linearisation(a, b, c, rates, gradient, f, change, f_rate, C, S);
}

} // namespace gudgeon

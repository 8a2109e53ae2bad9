#include "solvers/articulated_body.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace gudgeon {

namespace {

template <class S> Vec3 times(const S& m, const Vec3& x) {
    return {m.xx * x[0] + m.xy * x[1] + m.xz * x[2], m.xy * x[0] + m.yy * x[1] + m.yz * x[2],
            m.xz * x[0] + m.yz * x[1] + m.zz * x[2]};
}

// m -= sum over columns of v u^T, which is symmetric.
template <class S, class V, class U> void subtract(S& m, const V& v, const U& u) {
    for (int k = 0; k < v.cols(); ++k) {
        m.xx -= v(0, k) * u(0, k);
        m.yy -= v(1, k) * u(1, k);
        m.zz -= v(2, k) * u(2, k);
        m.xy -= v(0, k) * u(1, k);
        m.xz -= v(0, k) * u(2, k);
        m.yz -= v(1, k) * u(2, k);
    }
}

template <class S> Mat3 full(const S& m) {
    Mat3 out;
    out << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
    return out;
}

// Calls f(R, T) with the joint's numbers of rotations and displacements as constants.
template <class F> void by_freedoms(TreeKind kind, F&& f) {
    using std::integral_constant;
    switch (kind) {
    case TreeKind::revolute:
        return f(integral_constant<int, 1>{}, integral_constant<int, 0>{});
    case TreeKind::translation:
        return f(integral_constant<int, 0>{}, integral_constant<int, 1>{});
    case TreeKind::cylindrical:
        return f(integral_constant<int, 1>{}, integral_constant<int, 1>{});
    case TreeKind::universal:
        return f(integral_constant<int, 2>{}, integral_constant<int, 0>{});
    case TreeKind::spherical:
        return f(integral_constant<int, 3>{}, integral_constant<int, 0>{});
    case TreeKind::planar:
        return f(integral_constant<int, 1>{}, integral_constant<int, 2>{});
    case TreeKind::rigid:
    case TreeKind::free:
        return f(integral_constant<int, 0>{}, integral_constant<int, 0>{});
    }
}

} // namespace

ArticulatedBody::ArticulatedBody(const System& system, const SpanningTree& tree)
    : system_(system), bodies_(tree.links.size()) {
    int size = 0;
    for (const TreeLink& link : tree.links) {
        joints_.push_back({link.kind, link.parent_link, link.speed, link.body, link.kind == TreeKind::free});
        if (link.parent_link >= 0)
            joints_[link.parent_link].alone = false;
        place_.push_back(size);
        size += link.kind == TreeKind::free ? 0 : 6 * speed_count(link.kind);
    }
    factors_.assign(size, 0.0);
}

void ArticulatedBody::solve(std::span<const LinkMotion> links, std::span<const BodyMotion> motion,
                            const VecX& f, VecX& speeds) {
    set_inertia(links, motion, f);
    for (std::size_t i = joints_.size(); i-- > 0;) {
        const Joint& joint = joints_[i];
        if (joint.kind == TreeKind::free)
            continue;
        by_freedoms(joint.kind,
                    [&](auto R, auto T) { reduce<R, T>(i, links[i], speeds.data() + joint.speed); });
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        const Joint& joint = joints_[i];
        if (joint.alone) {
            solve_alone(joint, f, speeds.data() + joint.speed);
            continue;
        }
        if (joint.kind == TreeKind::free) {
            solve_free(i, motion[joint.body].A, speeds.data() + joint.speed);
            continue;
        }
        by_freedoms(joint.kind,
                    [&](auto R, auto T) { expand<R, T>(i, links[i], speeds.data() + joint.speed); });
    }
}

// Of the bodies alone: c from P to the mass centre, A J A^T there.
void ArticulatedBody::set_inertia(std::span<const LinkMotion> links, std::span<const BodyMotion> motion,
                                  const VecX& f) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        if (joints_[i].alone)
            continue;
        const int body = joints_[i].body;
        const LinkMotion& x = links[i];
        const Mat3& A = motion[body].A;
        const double mass = system_.mass[body];
        const Vec3& c = x.centre;
        const Mat3 AJ = A.lazyProduct(system_.inertia[body]);
        const auto turned = [&](int r, int s) { return AJ.row(r).dot(A.row(s)); };
        const Vec3 mc = mass * c;
        Body& b = bodies_[i];
        const Symmetric J{turned(0, 0), turned(1, 1), turned(2, 2), turned(0, 1), turned(0, 2), turned(1, 2)};
        b.J = {J.xx + mc[1] * c[1] + mc[2] * c[2],
               J.yy + mc[0] * c[0] + mc[2] * c[2],
               J.zz + mc[0] * c[0] + mc[1] * c[1],
               J.xy - mc[0] * c[1],
               J.xz - mc[0] * c[2],
               J.yz - mc[1] * c[2]};
        b.M = {mass, mass, mass, 0, 0, 0};
        b.H = skew(mc);
        const Vec3 a = x.a + x.alpha.cross(c) + x.omega.cross(x.omega.cross(c));
        b.force = mass * a - f.segment<3>(6 * body);
        b.moment = times(J, x.alpha) - A * f.segment<3>(6 * body + 3) + c.cross(b.force);
    }
}

template <int R, int T> void ArticulatedBody::reduce(std::size_t i, const LinkMotion& x, double* speeds) {
    constexpr int F = R + T;
    Body& b = bodies_[i];
    if constexpr (F > 0) {
        Eigen::Matrix<double, 3, F> turn, point; // U
        for (int k = 0; k < R; ++k) {
            const Vec3 e = x.axes.col(k);
            turn.col(k) = times(b.J, e);
            point.col(k) = b.H.transpose() * e;
        }
        for (int k = R; k < F; ++k) {
            const Vec3 e = x.axes.col(k);
            turn.col(k) = b.H * e;
            point.col(k) = times(b.M, e);
        }
        Eigen::Matrix<double, F, F> D;
        Eigen::Matrix<double, F, 1> y;
        for (int k = 0; k < F; ++k) {
            const auto& row = k < R ? turn : point;
            for (int l = 0; l < F; ++l)
                D(k, l) = x.axes.col(k).dot(row.col(l));
            y[k] = x.axes.col(k).dot(k < R ? b.moment : b.force);
        }
        const Eigen::Matrix<double, F, F> inverse = D.inverse();
        double* factors = factors_.data() + place_[i];
        Eigen::Map<Eigen::Matrix<double, 3, F>> v_turn(factors), v_point(factors + 3 * F);
        v_turn = turn * inverse;
        v_point = point * inverse;
        Eigen::Map<Eigen::Matrix<double, F, 1>> start(speeds);
        start = -(inverse * y);
        if (joints_[i].parent < 0)
            return;
        b.moment += turn * start;
        b.force += point * start;
        subtract(b.J, v_turn, turn);
        subtract(b.M, v_point, point);
        b.H -= v_turn * point.transpose();
    } else if (joints_[i].parent < 0) {
        return;
    }
    add_to_parent(i, x.from_parent);
}

// About the parent's P, d before this one: H + [d] M, J - H [d] + [d] (H + [d] M)^T.
void ArticulatedBody::add_to_parent(std::size_t i, const Vec3& d) {
    const Body& b = bodies_[i];
    Body& up = bodies_[joints_[i].parent];
    const double x = d[0], y = d[1], z = d[2];
    const Symmetric& m = b.M;
    Mat3 h = b.H;
    h(0, 0) += y * m.xz - z * m.xy;
    h(1, 0) += z * m.xx - x * m.xz;
    h(2, 0) += x * m.xy - y * m.xx;
    h(0, 1) += y * m.yz - z * m.yy;
    h(1, 1) += z * m.xy - x * m.yz;
    h(2, 1) += x * m.yy - y * m.xy;
    h(0, 2) += y * m.zz - z * m.yz;
    h(1, 2) += z * m.xz - x * m.zz;
    h(2, 2) += x * m.yz - y * m.xz;
    // -(H [d])_rs = ([d] H^T)_sr
    const Mat3 &g = b.H, &k = h;
    up.J.xx += b.J.xx + (y * g(0, 2) - z * g(0, 1)) + (y * k(0, 2) - z * k(0, 1));
    up.J.yy += b.J.yy + (z * g(1, 0) - x * g(1, 2)) + (z * k(1, 0) - x * k(1, 2));
    up.J.zz += b.J.zz + (x * g(2, 1) - y * g(2, 0)) + (x * k(2, 1) - y * k(2, 0));
    up.J.xy += b.J.xy + (z * g(0, 0) - x * g(0, 2)) + (y * k(1, 2) - z * k(1, 1));
    up.J.xz += b.J.xz + (x * g(0, 1) - y * g(0, 0)) + (y * k(2, 2) - z * k(2, 1));
    up.J.yz += b.J.yz + (x * g(1, 1) - y * g(1, 0)) + (z * k(2, 0) - x * k(2, 2));
    up.M.xx += m.xx;
    up.M.yy += m.yy;
    up.M.zz += m.zz;
    up.M.xy += m.xy;
    up.M.xz += m.xz;
    up.M.yz += m.yz;
    up.H += h;
    up.moment += b.moment + d.cross(b.force);
    up.force += b.force;
}

// alpha and a of P take the place of the wrench, which is used up.
template <int R, int T> void ArticulatedBody::expand(std::size_t i, const LinkMotion& x, double* speeds) {
    constexpr int F = R + T;
    Body& b = bodies_[i];
    Vec3 alpha = Vec3::Zero(), a = Vec3::Zero();
    const int parent = joints_[i].parent;
    if (parent >= 0) {
        alpha = bodies_[parent].moment;
        a = bodies_[parent].force + alpha.cross(x.from_parent);
    }
    if constexpr (F > 0) {
        const double* factors = factors_.data() + place_[i];
        if (parent >= 0)
            for (int k = 0; k < F; ++k) {
                const Eigen::Map<const Vec3> turn(factors + 3 * k), point(factors + 3 * (F + k));
                speeds[k] -= turn.dot(alpha) + point.dot(a);
            }
        for (int k = 0; k < R; ++k)
            alpha += speeds[k] * x.axes.col(k);
        for (int k = R; k < F; ++k)
            a += speeds[k] * x.axes.col(k);
    }
    b.moment = alpha;
    b.force = a;
}

// M u' = f
void ArticulatedBody::solve_alone(const Joint& joint, const VecX& f, double* speeds) const {
    Eigen::Map<Vec3> v(speeds), w(speeds + 3);
    v = f.segment<3>(6 * joint.body) / system_.mass[joint.body];
    w = system_.inverse_inertia[joint.body] * f.segment<3>(6 * joint.body + 3);
}

// All six speeds, a eliminated first: v of the mass centre and omega' of the body frame.
void ArticulatedBody::solve_free(std::size_t i, const Mat3& A, double* speeds) {
    Body& b = bodies_[i];
    const Eigen::LLT<Mat3> M(full(b.M));
    const Mat3 X = M.solve(b.H.transpose()); // M^-1 H^T
    const Vec3 free_fall = M.solve(b.force);
    const Eigen::LLT<Mat3> about_centre(full(b.J) - b.H * X);
    b.moment = about_centre.solve(b.H * free_fall - b.moment).eval();
    b.force = -(free_fall + X * b.moment);
    Eigen::Map<Vec3> v(speeds), w(speeds + 3);
    v = b.force;
    w = A.transpose() * b.moment;
}

} // namespace gudgeon

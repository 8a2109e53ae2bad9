#include "contact/bushing.hpp"

#include "core/joint_motions.hpp"

#include <type_traits>

namespace gudgeon {

void TabulatedElasticity::evaluate(const Vec6& c, Vec6& force, Vec6* slope) const {
    linear.evaluate(c, force, slope);
    for (int i = 0; i < 6; ++i) {
        if ((*tables)[i].empty())
            continue;
        const CurveValue v = (*tables)[i](c[i]);
        force[i] += v.value;
        if (slope)
            (*slope)[i] += v.slope;
    }
}

double TabulatedElasticity::energy(const Vec6& c) const {
    double sum = linear.energy(c);
    for (int i = 0; i < 6; ++i)
        if (!(*tables)[i].empty())
            sum += (*tables)[i](c[i]).integral;
    return sum;
}

namespace {

// Measures and rates of an element, in a's joint frame unless said otherwise.
struct Measures {
    Vec6 c, rate;
    Mat3 axes;        // a's joint frame in the global frame
    Vec3 lever;       // from a's mass centre to P_b
    double curvature; // of the rotation vector

    Vec3 theta() const { return c.tail<3>(); }
    /// E x of rotation_vector::curvature().
    Vec3 even(const Vec3& x) const { return x + curvature * theta().cross(theta().cross(x)); }
};

template <class Element> Measures measure(const Evaluation& e, const Element& x) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Vec3 wa = x.axes_a.transpose() * a.w, wb = x.axes_b.transpose() * b.w;
    Measures m;
    m.axes = a.A.lazyProduct(x.axes_a);
    m.lever = m.axes.transpose() * (point_position(b, x.sb) - a.r);
    m.c << m.lever - x.axes_a.transpose() * x.sa, rotation_vector::value(a, b, x.qa, x.qb);
    m.curvature = rotation_vector::curvature(m.theta());
    m.rate << m.axes.transpose() * (point_velocity(b, x.sb) - a.v) - wa.cross(m.lever),
        m.even(wb - wa) + 0.5 * m.theta().cross(wa + wb);
    return m;
}

template <class Element> Vec6 force_of(const Element& x, const Measures& m, Vec6* slope) {
    Vec6 g;
    x.elasticity.evaluate(m.c, g, slope);
    return g + x.damping.cwiseProduct(m.rate);
}

Gradient<3> weighted(const Vec3& weight, const Gradient<3>& g) {
    Gradient<3> out;
    out.ra = weight.asDiagonal() * g.ra;
    out.ta = weight.asDiagonal() * g.ta;
    out.rb = weight.asDiagonal() * g.rb;
    out.tb = weight.asDiagonal() * g.tb;
    return out;
}

// stiffness B + damping D
Gradient<3> restoring(const Vec3& stiffness, const Gradient<3>& b, const Vec3& damping,
                      const Gradient<3>& d) {
    Gradient<3> out = weighted(stiffness, b);
    const Gradient<3> rate = weighted(damping, d);
    out.ra += rate.ra;
    out.ta += rate.ta;
    out.rb += rate.rb;
    out.tb += rate.tb;
    return out;
}

// The three displacements (displacement:: in relative_motion.hpp, rows for the axes of the joint frame).
struct Shift {
    Gradient<3> gradient, rate_gradient;
};

template <class Element> Shift shift(const Evaluation& e, const Element& x, const Measures& m) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Mat3 axes_a = x.axes_a.transpose(), to_joint = m.axes.transpose();
    const Mat3 b_to_joint = to_joint.lazyProduct(b.A);
    Shift s;
    s.gradient.ra = -to_joint;
    s.gradient.ta = skew(m.lever) * axes_a;
    s.gradient.rb = to_joint;
    s.gradient.tb = -b_to_joint * skew(x.sb);

    const Mat3 turning = skew(axes_a * a.w);
    const Vec3 relative = to_joint * (point_velocity(b, x.sb) - a.v);
    s.rate_gradient.ra = turning * to_joint;
    s.rate_gradient.ta = skew(relative) * axes_a - turning * s.gradient.ta;
    s.rate_gradient.rb = -s.rate_gradient.ra;
    s.rate_gradient.tb = -turning * s.gradient.tb - b_to_joint * skew(b.w.cross(x.sb));
    return s;
}

// out += B^T diag(weight) B, symmetric, with B_ra = -B_rb.
void add_damping(const Vec3& weight, const Gradient<3>& b, BlockMatrix& out) {
    const Mat3 r = weight.asDiagonal() * b.rb, ta = weight.asDiagonal() * b.ta;
    const Mat3 tb = weight.asDiagonal() * b.tb;
    const Mat3 rr = b.rb.transpose().lazyProduct(r), rta = b.rb.transpose().lazyProduct(ta);
    const Mat3 rtb = b.rb.transpose().lazyProduct(tb), tatb = b.ta.transpose().lazyProduct(tb);
    out.block[0][0] += rr;
    out.block[0][1] -= rta;
    out.block[0][2] -= rr;
    out.block[0][3] -= rtb;
    out.block[1][0] -= rta.transpose();
    out.block[1][1] += b.ta.transpose().lazyProduct(ta);
    out.block[1][2] += rta.transpose();
    out.block[1][3] += tatb;
    out.block[2][0] -= rr;
    out.block[2][1] += rta;
    out.block[2][2] += rr;
    out.block[2][3] += rtb;
    out.block[3][0] -= rtb.transpose();
    out.block[3][1] += tatb.transpose();
    out.block[3][2] += rtb.transpose();
    out.block[3][3] += b.tb.transpose().lazyProduct(tb);
}

// displacement::add_geometric() for the three axes together: with X the axes in a, row a's rotation takes
// X skew(push) B, its column the transpose, and b's rotation the turning of its own lever.
void add_push_stiffness(const Mat3& axes_a, const Vec3& push, const Gradient<3>& b, const Vec3& sb,
                        const Vec3& force_in_b, BlockMatrix& out) {
    const Mat3 turn = axes_a.lazyProduct(skew(push));
    const Mat3 r = turn.lazyProduct(b.rb), tb = turn.lazyProduct(b.tb);
    out.block[1][0] -= r;
    out.block[1][1] += turn.lazyProduct(b.ta);
    out.block[1][2] += r;
    out.block[1][3] += tb;
    out.block[0][1] -= r.transpose();
    out.block[2][1] += r.transpose();
    out.block[3][1] += tb.transpose();
    out.block[3][3] += skew(sb).lazyProduct(skew(force_in_b));
}

// out += left^T right where only rotations take part.
void add_rotation_product(const Gradient<3>& left, const Gradient<3>& right, BlockMatrix& out) {
    out.block[1][1] += left.ta.transpose().lazyProduct(right.ta);
    out.block[1][3] += left.ta.transpose().lazyProduct(right.tb);
    out.block[3][1] += left.tb.transpose().lazyProduct(right.ta);
    out.block[3][3] += left.tb.transpose().lazyProduct(right.tb);
}

} // namespace

template <class Elasticity>
PairWrench BushingKernel<Elasticity>::wrench(const Evaluation& e, const Element& x) {
    const Measures m = measure(e, x);
    const Vec6 g = force_of(x, m, nullptr);
    const Vec3 push = g.head<3>(), twist = g.tail<3>();
    const Vec3 even = m.even(twist), odd = 0.5 * m.theta().cross(twist);
    PairWrench w;
    w.force_a = m.axes * push;
    w.force_b = -w.force_a;
    w.moment_a = x.axes_a * (m.lever.cross(push) + even + odd);
    w.moment_b = (e.body[x.b].A.transpose() * w.force_a).cross(x.sb) - x.axes_b * (even - odd);
    return w;
}

// C = B^T damping B, S = B^T (slope B + damping D) + geometric stiffness, for the displacements and for
// the rotation vector.
template <class Elasticity>
void BushingKernel<Elasticity>::linearise(const Evaluation& e, const Element& x, BlockMatrix& c,
                                          BlockMatrix& s) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Measures m = measure(e, x);
    Vec6 slope;
    const Vec6 g = force_of(x, m, &slope);

    const Shift d = shift(e, x, m);
    const Vec3 d_damping = x.damping.template head<3>(), d_slope = slope.head<3>();
    add_damping(d_damping, d.gradient, c);
    add_difference_product(d.gradient, restoring(d_slope, d.gradient, d_damping, d.rate_gradient), s);
    const Vec3 force = m.axes * g.head<3>();
    add_push_stiffness(x.axes_a, g.head<3>(), d.gradient, x.sb, b.A.transpose() * force, s);

    const Vec3 theta = m.c.tail<3>(), damping = x.damping.template tail<3>(), t_slope = slope.tail<3>();
    const Gradient<3> turn = rotation_vector::gradient(theta, x.axes_a, x.axes_b);
    const Gradient<3> turn_rate = rotation_vector::rate_gradient(a, b, theta, x.axes_a, x.axes_b, turn);
    add_rotation_product(turn, weighted(damping, turn), c);
    add_rotation_product(turn, restoring(t_slope, turn, damping, turn_rate), s);
    rotation_vector::add_geometric(theta, x.axes_a, x.axes_b, turn, g.tail<3>(), s);
}

template <class Elasticity>
EnergyRates BushingKernel<Elasticity>::energies(const Evaluation& e, const Element& x) {
    const Measures m = measure(e, x);
    return {x.elasticity.energy(m.c), x.damping.dot(m.rate.cwiseAbs2()), 0};
}

template struct BushingKernel<LinearElasticity>;
template struct BushingKernel<TabulatedElasticity>;

namespace {

bool has_table(const Bushing& bushing) {
    for (const Table& table : bushing.tables)
        if (!table.empty())
            return true;
    return false;
}

// In a mixed joint the components of the motions that something else holds are left out.
Bushing rubber_part(const Joint& joint) {
    Bushing out = *joint.bushing;
    const bool ball = joint.kind == JointKind::spherical;
    const auto drop = [&](std::initializer_list<std::size_t> components) {
        for (const std::size_t i : components) {
            out.stiffness[i] = out.damping[i] = out.preload[i] = 0;
            out.tables[i] = {};
        }
    };
    const auto other = [&](Motion motion) {
        return holds_motion(joint.kind, motion) && joint.holds(motion) != Fidelity::bushing;
    };
    if (other(Motion::radial))
        ball ? drop({0, 1, 2}) : drop({0, 1});
    if (other(Motion::axial))
        drop({2});
    if (other(Motion::misalignment))
        drop({3, 4});
    if (other(Motion::rotation))
        drop({5});
    return out;
}

LinearElasticity linear_part(const Bushing& bushing) {
    LinearElasticity out;
    for (int i = 0; i < 6; ++i) {
        out.preload[i] = bushing.preload[i];
        out.stiffness[i] = bushing.tables[i].empty() ? bushing.stiffness[i] : 0;
    }
    return out;
}

Vec4 euler_parameters(const Mat3& axes) {
    const Eigen::Quaterniond q(axes);
    return {q.w(), q.x(), q.y(), q.z()};
}

template <class Element> void place(const CompileContext& context, int joint, bool global_axes, Element& x) {
    const JointRecord& record = context.system.joints[joint];
    x.joint = joint;
    x.a = record.a.body;
    x.b = record.b.body;
    x.sa = record.a.point;
    x.sb = record.b.point;
    x.axes_a = global_axes ? Mat3(context.system.start[x.a].A.transpose()) : record.a.axes;
    x.axes_b = global_axes ? Mat3(context.system.start[x.b].A.transpose()) : record.b.axes;
    x.qa = euler_parameters(x.axes_a);
    x.qb = euler_parameters(x.axes_b);
}

template <class Elasticity> std::unique_ptr<ForceBatch> build(const CompileContext& context) {
    constexpr bool tabulated = std::is_same_v<Elasticity, TabulatedElasticity>;
    auto batch = std::make_unique<ForceBatchOf<BushingKernel<Elasticity>>>();
    for (std::size_t j = 0; j < context.model.joints.size(); ++j) {
        const Joint& joint = context.model.joints[j];
        if (!holds_any(joint, Fidelity::bushing) || has_table(*joint.bushing) != tabulated)
            continue;
        const Bushing bushing = rubber_part(joint);
        typename BushingKernel<Elasticity>::Element x;
        place(context, context.joint(joint.name), bushing.global_axes, x);
        x.damping = Vec6(bushing.damping.data());
        if constexpr (tabulated) {
            std::array<Spline, 6> tables;
            for (int i = 0; i < 6; ++i)
                if (!bushing.tables[i].empty())
                    tables[i] = Spline(bushing.tables[i], Spline::Ends::linear);
            x.elasticity = {linear_part(bushing),
                            std::make_shared<const std::array<Spline, 6>>(std::move(tables))};
        } else {
            x.elasticity = linear_part(bushing);
        }
        batch->add(std::move(x));
    }
    if (batch->size() == 0)
        return nullptr;
    return batch;
}

} // namespace

ForceBatchBuilder bushing_builder() { return build<LinearElasticity>; }
ForceBatchBuilder tabulated_bushing_builder() { return build<TabulatedElasticity>; }

} // namespace gudgeon

#include "contact/point_batches.hpp"

#include "contact/clearance.hpp"

namespace gudgeon {

namespace {

double rate_of(const BodyMotion& a, const BodyMotion& b, const ContactPoint& c) {
    return c.n.dot(point_velocity_at(b, c.p) - point_velocity_at(a, c.p));
}

template <class Element>
NormalForce force_of(const Evaluation& e, const Element& x, int contact, const ContactPoint& c, double rate) {
    return contact_force(e, x.law, x.channel + contact * x.law.slots(), x.share, c.depth, rate);
}

template <class Element>
PointFriction friction_of(const Evaluation& e, const Element& x, int contact, const ContactPoint& c,
                          double normal_force) {
    return point_friction(*x.friction, x.states(e, contact), e.body[x.a], e.body[x.b], c, normal_force);
}

} // namespace

template <class Shape> PairWrench PointKernel<Shape>::wrench(const Evaluation& e, const Element& x) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    PairWrench sum;
    const auto points = x.shape.find(a, b);
    for (int i = 0; i < contacts; ++i) {
        const ContactPoint& c = points[i];
        if (!(c.depth > 0))
            continue;
        const NormalForce f = force_of(e, x, i, c, rate_of(a, b, c));
        Vec3 force = f.force * c.n;
        if (x.friction)
            force -= friction_of(e, x, i, c, f.force).force;
        sum += point_wrench(a, b, c.p, force);
    }
    return sum;
}

template <class Shape>
void PointKernel<Shape>::linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const auto points = x.shape.find(a, b);
    for (int i = 0; i < contacts; ++i) {
        const ContactPoint& point = points[i];
        if (!(point.depth > 0))
            continue;
        const NormalForce f = force_of(e, x, i, point, rate_of(a, b, point));
        const ContactPointRates rates = x.shape.rates(a, b, i, point);
        add_normal_linearisation(a, b, point, rates, f.force, f.by_depth, f.by_rate, c, s);
        if (!x.friction)
            continue;
        const Gradient<1> g = depth_gradient(a, b, point);
        const Gradient<1> change =
            combined(f.by_depth, g, f.by_rate, depth_rate_gradient(a, b, point, rates, g));
        add_friction_linearisation(friction_of(e, x, i, point, f.force), a, b, point, rates, g, change,
                                   f.by_rate, c, s);
    }
}

template <class Shape> EnergyRates PointKernel<Shape>::energies(const Evaluation& e, const Element& x) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    EnergyRates sum;
    const auto points = x.shape.find(a, b);
    for (int i = 0; i < contacts; ++i) {
        const ContactPoint& c = points[i];
        if (!(c.depth > 0))
            continue;
        const double rate = rate_of(a, b, c);
        const NormalForce f = force_of(e, x, i, c, rate);
        sum += {f.energy, (f.force - f.elastic) * rate, 0};
        if (x.friction)
            sum.dissipated_power += friction_of(e, x, i, c, f.force).power();
    }
    return sum;
}

template <class Shape>
ContactSample PointKernel<Shape>::sample(const Evaluation& e, const Element& x, int contact, int slot) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const ContactPoint c = x.shape.find(a, b)[contact];
    const double rate = rate_of(a, b, c);
    const NormalForce f = force_of(e, x, contact, c, rate);
    ContactSample out = contact_sample(x.law, f, slot, c.depth, rate, x.share,
                                       inverse_mass(e, x.a, x.b, depth_gradient(a, b, c)));
    out.normal_force = -out.force * c.n;
    if (x.friction && slot == 0 && c.depth > 0) {
        const PointFriction friction = friction_of(e, x, contact, c, f.force);
        out.friction_force = friction.force;
        out.friction = friction.force.norm();
        out.dissipated_power += friction.power();
    }
    return out;
}

template <class Shape>
void PointKernel<Shape>::state_terms(const Evaluation& e, const Element& x, int contact, double* source,
                                     double* decay) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const ContactPoint c = x.shape.find(a, b)[contact];
    if (c.depth > 0)
        point_state_terms(friction_of(e, x, contact, c, 0), a, source, decay);
    else
        free_state_terms(*x.friction, source, decay);
}

template <class Shape>
std::array<Linearisation::StateCoupling, 3>
PointKernel<Shape>::state_couplings(const Evaluation& e, const Element& x, int contact) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const ContactPoint c = x.shape.find(a, b)[contact];
    if (!(c.depth > 0))
        return free_state_couplings(*x.friction);
    const NormalForce f = force_of(e, x, contact, c, rate_of(a, b, c));
    return point_state_couplings(friction_of(e, x, contact, c, f.force), a, b, c);
}

template struct PointKernel<SphereShape>;
template struct PointKernel<PlanarShape>;
template struct PointKernel<TwoEndShape>;
template struct PointKernel<SlotShape>;

namespace {

template <class Shape> typename PointKernel<Shape>::Element element_of(const CompileContext& context, int j) {
    typename PointKernel<Shape>::Element x;
    place(bearing_side(context, j), x);
    x.law = radial_law(context, j);
    x.friction = contact_friction(context, j);
    return x;
}

template <class Shape, class Wanted, class Fill>
std::unique_ptr<ForceBatch> build(const CompileContext& context, Wanted wanted, Fill fill) {
    auto batch = std::make_unique<ContactBatchOf<PointKernel<Shape>>>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        if (!wanted(joint))
            continue;
        auto x = element_of<Shape>(context, j);
        fill(*joint.clearance, bearing_side(context, j), x);
        batch->add(std::move(x));
    }
    return batch;
}

} // namespace

ForceBatchBuilder sphere_builder() {
    return [](const CompileContext& context) {
        const auto wanted = [](const Joint& j) {
            return (j.kind == JointKind::spherical || j.kind == JointKind::universal) &&
                   held_by_contact(j, Motion::radial);
        };
        return build<SphereShape>(context, wanted, [](const Clearance& c, const JointSide& side, auto& x) {
            x.shape.gap = {side.a.point, side.b.point, c.radial.value_or(0), c.radius.value_or(0)};
        });
    };
}

ForceBatchBuilder planar_builder() {
    return [](const CompileContext& context) {
        const auto wanted = [](const Joint& j) { return uses_model(j, "planar"); };
        return build<PlanarShape>(context, wanted, [](const Clearance& c, const JointSide& side, auto& x) {
            x.shape.gap = {side.a.point, side.a.axes.col(2), side.b.point, c.radial.value_or(0),
                           c.radius.value_or(0)};
        });
    };
}

ForceBatchBuilder two_end_builder() {
    return [](const CompileContext& context) {
        const auto wanted = [](const Joint& j) { return uses_model(j, "two-end"); };
        return build<TwoEndShape>(context, wanted, [](const Clearance& c, const JointSide& side, auto& x) {
            x.share = 0.5;
            x.shape.gap = {side.a.point,        side.a.axes.col(2),   side.b.point,
                           side.b.axes.col(2),  c.length.value_or(0), c.radial.value_or(0),
                           c.radius.value_or(0)};
        });
    };
}

ForceBatchBuilder slot_builder() {
    return [](const CompileContext& context) {
        const auto wanted = [](const Joint& j) { return uses_model(j, "slot"); };
        return build<SlotShape>(context, wanted, [](const Clearance& c, const JointSide& side, auto& x) {
            x.share = 0.25; // a face rests on four corners
            const std::array<double, 2> section = c.section.value_or(std::array<double, 2>{0, 0});
            const double guide = c.length.value_or(0), block = c.journal_length.value_or(guide);
            x.shape.gap = {side.a.point,
                           side.b.point,
                           side.a.axes,
                           side.b.axes,
                           {0.5 * section[0], 0.5 * section[1]},
                           c.radial.value_or(0),
                           std::min(guide, block),
                           block < guide};
        });
    };
}

} // namespace gudgeon

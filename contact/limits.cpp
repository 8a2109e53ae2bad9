#include "contact/limits.hpp"

#include "contact/clearance.hpp"

namespace gudgeon {

namespace {

struct Reach {
    double depth, side; // side: +1 beyond upper, -1 beyond lower
};

template <class Element> Reach reach(const Evaluation& e, const Element& x) {
    const double c = x.measure.value(e, e.body[x.a], e.body[x.b]);
    const double above = c - x.upper, below = x.lower - c;
    return above >= below ? Reach{above, 1} : Reach{below, -1};
}

} // namespace

template <class Measure> PairWrench LimitKernel<Measure>::wrench(const Evaluation& e, const Element& x) {
    const auto [depth, side] = reach(e, x);
    if (!(depth > 0))
        return {};
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Gradient<1> g = x.measure.gradient(a, b);
    const double rate = side * g.times(a, b)[0];
    const NormalForce f = contact_force(e, x.law, x.channel, x.share, depth, rate);
    return conjugate_wrench<1>(g, Eigen::Matrix<double, 1, 1>(side * f.force));
}

template <class Measure>
void LimitKernel<Measure>::linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s) {
    const auto [depth, side] = reach(e, x);
    if (!(depth > 0))
        return;
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Gradient<1> g = x.measure.gradient(a, b);
    const NormalForce f = contact_force(e, x.law, x.channel, x.share, depth, side * g.times(a, b)[0]);
    add_product(g, combined(f.by_rate, g, 0.0, g), c);
    add_product(g, combined(f.by_depth, g, f.by_rate, x.measure.rate_gradient(a, b)), s);
    x.measure.add_geometric(a, b, side * f.force, s);
}

template <class Measure> EnergyRates LimitKernel<Measure>::energies(const Evaluation& e, const Element& x) {
    if (!(reach(e, x).depth > 0))
        return {};
    const ContactSample now = sample(e, x, 0, 0);
    return {now.elastic, now.dissipated_power, 0};
}

template <class Measure>
ContactSample LimitKernel<Measure>::sample(const Evaluation& e, const Element& x, int, int slot) {
    const auto [depth, side] = reach(e, x);
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Gradient<1> g = x.measure.gradient(a, b);
    const double rate = side * g.times(a, b)[0];
    const NormalForce f = contact_force(e, x.law, x.channel, x.share, depth, rate);
    ContactSample out = contact_sample(x.law, f, slot, depth, rate, x.share, inverse_mass(e, x.a, x.b, g));
    out.normal_force = -side * out.force * x.measure.force_direction(a);
    return out;
}

template struct LimitKernel<DisplacementMeasure>;
template struct LimitKernel<AngleMeasure>;
template struct LimitKernel<CosineMeasure>;

namespace {

using Displacements = ContactBatchOf<LimitKernel<DisplacementMeasure>>;
using Angles = ContactBatchOf<LimitKernel<AngleMeasure>>;
using Cosines = ContactBatchOf<LimitKernel<CosineMeasure>>;

template <class Element> Element element_of(const JointSide& side) {
    Element x;
    place(side, x);
    return x;
}

// The same play to both sides.
template <class Element> void set_play(double play, std::string_view where, NormalLaw law, Element& x) {
    x.lower = -play;
    x.upper = play;
    x.place = where;
    x.law = std::move(law);
}

template <class Element>
void set_stop(const CompileContext& context, int joint, const std::string& coordinate, const Stop& stop,
              Element& x) {
    x.lower = stop.lower.value_or(x.lower);
    x.upper = stop.upper.value_or(x.upper);
    x.place = "stop";
    ContactGeometry geometry;
    geometry.rotation = coordinate.starts_with("angle");
    x.law = joint_law(context, joint, stop.law, geometry, "/stops/" + coordinate + "/law");
}

LimitKernel<DisplacementMeasure>::Element displacement_element(const JointSide& side, int axis) {
    auto x = element_of<LimitKernel<DisplacementMeasure>::Element>(side);
    x.measure = {side.a.point, side.b.point, side.a.axes.col(axis)};
    return x;
}

std::unique_ptr<ForceBatch> build_displacements(const CompileContext& context) {
    auto batch = std::make_unique<Displacements>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        for (const auto& [coordinate, stop] : joint.stops) {
            if (coordinate.starts_with("angle"))
                continue;
            const int axis = coordinate == "u" ? 0 : coordinate == "v" ? 1 : 2;
            auto x = displacement_element(plain_side(context, j), axis);
            set_stop(context, j, coordinate, stop, x);
            batch->add(std::move(x));
        }
        if (held_by_contact(joint, Motion::axial)) { // end faces
            auto x = displacement_element(bearing_side(context, j), 2);
            set_play(joint.clearance->axial.value_or(joint.clearance->radial.value_or(0)), "end face",
                     axial_law(context, j), x);
            batch->add(std::move(x));
        }
    }
    return batch;
}

std::unique_ptr<ForceBatch> build_angles(const CompileContext& context) {
    auto batch = std::make_unique<Angles>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        const auto add = [&](const std::string& coordinate) {
            auto x = element_of<LimitKernel<AngleMeasure>::Element>(plain_side(context, j));
            const int angle = context.angle(j, coordinate);
            x.measure = {context.system.angles[angle].frames, angle};
            return x;
        };
        for (const auto& [coordinate, stop] : joint.stops) {
            if (!coordinate.starts_with("angle"))
                continue;
            auto x = add(coordinate);
            set_stop(context, j, coordinate, stop, x);
            batch->add(std::move(x));
        }
        if (held_by_contact(joint, Motion::rotation) && joint.clearance->model != "slot") { // key or spline
            auto x = add("angle");
            set_play(joint.clearance->rotation.value_or(0), "key", rotation_law(context, j), x);
            batch->add(std::move(x));
        }
    }
    return batch;
}

std::unique_ptr<ForceBatch> build_cosines(const CompileContext& context) {
    auto batch = std::make_unique<Cosines>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        if (joint.kind != JointKind::universal || !held_by_contact(joint, Motion::misalignment))
            continue;
        const JointSide side = plain_side(context, j);
        auto x = element_of<LimitKernel<CosineMeasure>::Element>(side);
        x.measure = {side.a.axes.col(2), side.b.axes.col(2)};
        set_play(std::sin(joint.clearance->misalignment.value_or(0)), "right angle", rotation_law(context, j),
                 x);
        batch->add(std::move(x));
    }
    return batch;
}

} // namespace

ForceBatchBuilder displacement_limit_builder() { return build_displacements; }
ForceBatchBuilder angle_limit_builder() { return build_angles; }
ForceBatchBuilder cosine_limit_builder() { return build_cosines; }

} // namespace gudgeon

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

/// The limit as it is pressed now.
struct Press {
    double depth, side, rate;
    Gradient<1> g; // of the coordinate
    NormalForce f;
    template <class Element>
    Press(const Evaluation& e, const Element& x, const Reach& now)
        : depth(now.depth), side(now.side), g(x.measure.gradient(e.body[x.a], e.body[x.b])) {
        rate = side * g.times(e.body[x.a], e.body[x.b])[0];
        f = contact_force(e, x.law, x.channel, x.share, depth, rate);
    }
};

template <class Element> FaceFriction friction_of(const Evaluation& e, const Element& x, double force) {
    return face_friction(*x.friction, x.face, x.states(e, 0), e.body[x.a], e.body[x.b], force);
}

} // namespace

template <class Measure> PairWrench LimitKernel<Measure>::wrench(const Evaluation& e, const Element& x) {
    const Reach now = reach(e, x);
    if (!(now.depth > 0))
        return {};
    const Press press(e, x, now);
    PairWrench w = conjugate_wrench<1>(press.g, Eigen::Matrix<double, 1, 1>(press.side * press.f.force));
    if constexpr (Measure::rubs)
        if (x.friction)
            w += face_wrench(friction_of(e, x, press.f.force));
    return w;
}

template <class Measure>
void LimitKernel<Measure>::linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s) {
    const Reach now = reach(e, x);
    if (!(now.depth > 0))
        return;
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Press press(e, x, now);
    const Gradient<1> by_speed = combined(press.f.by_rate, press.g, 0.0, press.g);
    const Gradient<1> by_pose =
        combined(press.f.by_depth, press.g, press.f.by_rate, x.measure.rate_gradient(a, b));
    add_product(press.g, by_speed, c);
    add_product(press.g, by_pose, s);
    x.measure.add_geometric(a, b, press.side * press.f.force, s);
    if constexpr (Measure::rubs)
        if (x.friction) // the force follows the depth, side times the coordinate
            add_face_linearisation(friction_of(e, x, press.f.force), x.face, a, b,
                                   combined(press.side, by_pose, 0.0, by_pose),
                                   combined(press.side, by_speed, 0.0, by_speed), c, s);
}

template <class Measure> EnergyRates LimitKernel<Measure>::energies(const Evaluation& e, const Element& x) {
    if (!(reach(e, x).depth > 0))
        return {};
    const ContactSample now = sample(e, x, 0, 0);
    return {now.elastic, now.dissipated_power, 0};
}

template <class Measure>
ContactSample LimitKernel<Measure>::sample(const Evaluation& e, const Element& x, int, int slot) {
    const BodyMotion& a = e.body[x.a];
    const Press press(e, x, reach(e, x));
    ContactSample out = contact_sample(x.law, press.f, slot, press.depth, press.rate, x.share,
                                       inverse_mass(e, x.a, x.b, press.g));
    out.normal_force = -press.side * out.force * x.measure.force_direction(a);
    if constexpr (Measure::rubs)
        if (x.friction && slot == 0 && press.depth > 0) {
            const FaceFriction friction = friction_of(e, x, press.f.force);
            out.friction_force = face_force(friction, x.face, a);
            out.friction = friction.force();
            out.dissipated_power += friction.power();
        }
    return out;
}

template <class Measure>
void LimitKernel<Measure>::state_terms(const Evaluation& e, const Element& x, int, double* source,
                                       double* decay) requires Measure::rubs {
    if (reach(e, x).depth > 0)
        face_state_terms(friction_of(e, x, 0), source, decay);
    else
        free_state_terms(*x.friction, source, decay);
}

template <class Measure>
std::array<Linearisation::StateCoupling, 3>
LimitKernel<Measure>::state_couplings(const Evaluation& e, const Element& x, int) requires Measure::rubs {
    const Reach now = reach(e, x);
    if (!(now.depth > 0))
        return free_state_couplings(*x.friction);
    return face_state_couplings(friction_of(e, x, Press(e, x, now).f.force));
}

template struct LimitKernel<DisplacementMeasure>;
template struct LimitKernel<AngleMeasure>;
template struct LimitKernel<KeyMeasure>;
template struct LimitKernel<CosineMeasure>;
template struct LimitKernel<SwingMeasure>;

namespace {

using Displacements = ContactBatchOf<LimitKernel<DisplacementMeasure>>;
using Cosines = ContactBatchOf<LimitKernel<CosineMeasure>>;
using Swings = ContactBatchOf<LimitKernel<SwingMeasure>>;

bool is_rotation(std::string_view coordinate) {
    return coordinate.starts_with("angle") || coordinate == "swing";
}

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
    geometry.rotation = is_rotation(coordinate);
    x.law = joint_law(context, joint, stop.law, geometry, "/stops/" + coordinate + "/law");
    if (stop.friction)
        x.friction = compile_friction(*stop.friction);
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
            if (is_rotation(coordinate))
                continue;
            const JointSide side = plain_side(context, j);
            const int axis = coordinate == "u" ? 0 : coordinate == "v" ? 1 : 2;
            auto x = displacement_element(side, axis);
            set_stop(context, j, coordinate, stop, x);
            if (stop.friction)
                x.face = face_slip(side.a.point, side.b.point, side.a.axes, axis,
                                   stop.friction->radius.value_or(0));
            batch->add(std::move(x));
        }
        if (held_by_contact(joint, Motion::axial)) { // end faces
            const JointSide side = bearing_side(context, j);
            auto x = displacement_element(side, 2);
            x.friction = contact_friction(context, j);
            x.face = face_slip(side.a.point, side.b.point, side.a.axes, 2, rubbing_radius(*joint.clearance));
            set_play(joint.clearance->axial.value_or(joint.clearance->radial.value_or(0)), "end face",
                     axial_law(context, j), x);
            batch->add(std::move(x));
        }
    }
    return batch;
}

// Stops of angles and keys; KeyMeasure takes those with friction, AngleMeasure the others.
template <class Measure> std::unique_ptr<ForceBatch> build_angles(const CompileContext& context) {
    auto batch = std::make_unique<ContactBatchOf<LimitKernel<Measure>>>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        const JointSide side = plain_side(context, j);
        const auto element = [&](const std::string& coordinate, const std::optional<Friction>& friction,
                                 double radius) {
            auto x = element_of<typename LimitKernel<Measure>::Element>(side);
            const int angle = context.angle(j, coordinate);
            static_cast<AngleMeasure&>(x.measure) = {context.system.angles[angle].frames, angle};
            if (friction) {
                x.friction = compile_friction(*friction);
                x.face = key_slip(side.a.point, side.b.point, side.a.axes, radius);
            }
            return x;
        };
        for (const auto& [coordinate, stop] : joint.stops) {
            if (!coordinate.starts_with("angle") || stop.friction.has_value() != Measure::rubs)
                continue;
            auto x =
                element(coordinate, stop.friction, stop.friction ? stop.friction->radius.value_or(1) : 1);
            set_stop(context, j, coordinate, stop, x);
            batch->add(std::move(x));
        }
        if (held_by_contact(joint, Motion::rotation) && joint.clearance->model != "slot" && // key or spline
            joint.clearance->friction.has_value() == Measure::rubs) {
            auto x = element("angle", joint.clearance->friction, rubbing_radius(*joint.clearance));
            set_play(joint.clearance->rotation.value_or(0), "key", rotation_law(context, j), x);
            batch->add(std::move(x));
        }
    }
    return batch;
}

std::unique_ptr<ForceBatch> build_swings(const CompileContext& context) {
    auto batch = std::make_unique<Swings>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j)
        if (const auto& stops = context.model.joints[j].stops; stops.contains("swing")) {
            const JointSide side = plain_side(context, j);
            auto x = element_of<LimitKernel<SwingMeasure>::Element>(side);
            x.measure = {side.a.axes.col(2), side.b.axes.col(2)};
            set_stop(context, j, "swing", stops.at("swing"), x);
            batch->add(std::move(x));
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
ForceBatchBuilder angle_limit_builder() { return build_angles<AngleMeasure>; }
ForceBatchBuilder key_limit_builder() { return build_angles<KeyMeasure>; }
ForceBatchBuilder cosine_limit_builder() { return build_cosines; }
ForceBatchBuilder swing_limit_builder() { return build_swings; }

} // namespace gudgeon

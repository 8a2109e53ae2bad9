#include "contact/friction_batch.hpp"

#include "contact/clearance.hpp"
#include "core/joint_kinds.hpp"

namespace gudgeon {

namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;

// The rows' directions are orthonormal: the reaction is as long as the vector of their multipliers.
template <class Element> double pressed(const Evaluation& e, const Element& x) {
    if (x.rows[0] < 0)
        return x.normal_force;
    double sum = 0;
    for (const int row : x.rows)
        sum += row < 0 ? 0.0 : e.lambda[row] * e.lambda[row];
    return std::sqrt(sum);
}

// Friction at an instant: gradient of c, its value and derivatives over the slip velocity.
template <class Element> struct Slip {
    Gradient<1> g;
    double speed; // m/s
    double normal_force;
    FrictionValue<1> f;
    Slip(const Evaluation& e, const Element& x)
        : g(x.measure.gradient(e.body[x.a], e.body[x.b])),
          speed(x.lever * g.times(e.body[x.a], e.body[x.b])[0]), normal_force(pressed(e, x)),
          f(evaluate_friction<1>(x.law, Scalar(speed), Scalar(x.state < 0 ? 0.0 : e.z[x.state]))) {}
};

} // namespace

template <class Measure> PairWrench FrictionKernel<Measure>::wrench(const Evaluation& e, const Element& x) {
    const Slip slip(e, x);
    return conjugate_wrench<1>(slip.g, x.lever * slip.normal_force * slip.f.mu);
}

template <class Measure>
void FrictionKernel<Measure>::linearise(const Evaluation& e, const Element& x, BlockMatrix& c,
                                        BlockMatrix& s) {
    const Slip slip(e, x);
    const double by_rate = x.lever * x.lever * slip.normal_force * slip.f.by_speed(0);
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    add_product(slip.g, combined(by_rate, slip.g, 0.0, slip.g), c);
    add_product(slip.g, combined(by_rate, x.measure.rate_gradient(a, b), 0.0, slip.g), s);
    x.measure.add_geometric(a, b, x.lever * slip.normal_force * slip.f.mu(0), s);
}

template <class Measure>
EnergyRates FrictionKernel<Measure>::energies(const Evaluation& e, const Element& x) {
    const Slip slip(e, x);
    return {0, slip.normal_force * slip.f.mu(0) * slip.speed, 0};
}

template <class Measure>
Linearisation::StateCoupling FrictionKernel<Measure>::state_coupling(const Evaluation& e, const Element& x) {
    const Slip slip(e, x);
    return {x.state,
            x.pair,
            x.a,
            x.b,
            slip.f.decay,
            combined(-x.lever * slip.normal_force * slip.f.by_state, slip.g, 0.0, slip.g),
            combined(x.lever * slip.f.rate_by_speed(0), slip.g, 0.0, slip.g)};
}

template <class Measure>
Gradient<1> FrictionKernel<Measure>::by_multiplier(const Evaluation& e, const Element& x, int k) {
    const Slip slip(e, x);
    const double share = slip.normal_force > 0 ? e.lambda[x.rows[k]] / slip.normal_force : 0;
    return combined(x.lever * share * slip.f.mu(0), slip.g, 0.0, slip.g);
}

template <class Measure>
void FrictionKernel<Measure>::state_terms(const Evaluation& e, const Element& x, double& source,
                                          double& decay) {
    const Slip slip(e, x);
    source = slip.speed;
    decay = slip.f.decay;
}

template <class Measure> void FrictionBatch<Measure>::declare_states(std::vector<double>& scales) {
    for (auto& x : this->elements_.items())
        if (x.law.has_state()) {
            x.state = static_cast<int>(scales.size());
            scales.push_back(x.law.state_scale());
        }
}

template <class Measure>
void FrictionBatch<Measure>::state_terms(const Evaluation& e, double* source, double* decay) const {
    for (const auto& x : this->elements_.items())
        if (x.state >= 0)
            Kernel::state_terms(e, x, source[x.state], decay[x.state]);
}

template <class Measure>
void FrictionBatch<Measure>::add_linearisation(const Evaluation& e, Linearisation& lin) const {
    ForceBatchOf<Kernel>::add_linearisation(e, lin);
    for (const auto& x : this->elements_.items()) {
        if (x.state >= 0)
            lin.states.push_back(Kernel::state_coupling(e, x));
        for (int k = 0; k < 3 && x.rows[k] >= 0; ++k)
            lin.reactions.push_back({x.rows[k], Kernel::by_multiplier(e, x, k)});
    }
}

template struct FrictionKernel<DisplacementMeasure>;
template struct FrictionKernel<AngleMeasure>;
template class FrictionBatch<DisplacementMeasure>;
template class FrictionBatch<AngleMeasure>;

namespace {

/// Calls f(joint, friction, coordinate) for every friction on a coordinate of a joint.
template <class F> void for_joint_frictions(const CompileContext& context, F&& f) {
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        for (const Friction& friction : joint.friction)
            f(j, friction, friction.coordinate.value_or(free_coordinates(joint.kind)[0]));
    }
}

template <class Element>
Element joint_element(const CompileContext& context, int j, const Friction& friction) {
    const JointSide side = plain_side(context, j);
    Element x;
    x.joint = j;
    x.a = side.a.body;
    x.b = side.b.body;
    x.law = compile_friction(friction);
    x.lever = friction.radius.value_or(1);
    x.normal_force = friction.normal_force.value_or(0);
    if (friction.normal_force)
        return x;
    const JointRecord& record = context.system.joints[j];
    int count = 0;
    for (int row = record.first_row; row < record.first_row + record.rows; ++row)
        if (context.system.rows[row].direction.starts_with("displacement"))
            x.rows[count++] = row;
    return x;
}

std::unique_ptr<ForceBatch> build_displacements(const CompileContext& context) {
    using Batch = FrictionBatch<DisplacementMeasure>;
    auto batch = std::make_unique<Batch>();
    for (const Force& force : context.model.forces) {
        const auto* given = std::get_if<FrictionForce>(&force);
        if (!given)
            continue;
        Batch::Kernel::Element x;
        x.a = context.body(given->bodies[0]);
        x.b = context.body(given->bodies[1]);
        const bool local = given->body_frame;
        const Mat3 to_a = local ? Mat3(Mat3::Identity()) : Mat3(context.system.start[x.a].A.transpose());
        x.measure = {local ? given->points[0] : context.in_body(x.a, given->points[0]),
                     local ? given->points[1] : context.in_body(x.b, given->points[1]),
                     to_a * given->axis.normalized()};
        x.law = compile_friction(given->friction);
        x.normal_force = given->friction.normal_force.value_or(0);
        batch->add(std::move(x), given->name);
    }
    for_joint_frictions(context, [&](int j, const Friction& friction, const std::string& coordinate) {
        if (coordinate.starts_with("angle"))
            return;
        auto x = joint_element<Batch::Kernel::Element>(context, j, friction);
        const JointSide side = plain_side(context, j);
        const int axis = coordinate == "u" ? 0 : coordinate == "v" ? 1 : 2;
        x.measure = {side.a.point, side.b.point, side.a.axes.col(axis)};
        batch->add(std::move(x));
    });
    return batch;
}

std::unique_ptr<ForceBatch> build_angles(const CompileContext& context) {
    using Batch = FrictionBatch<AngleMeasure>;
    auto batch = std::make_unique<Batch>();
    for_joint_frictions(context, [&](int j, const Friction& friction, const std::string& coordinate) {
        if (!coordinate.starts_with("angle"))
            return;
        auto x = joint_element<Batch::Kernel::Element>(context, j, friction);
        const int angle = context.angle(j, coordinate);
        x.measure = {context.system.angles[angle].frames, angle};
        batch->add(std::move(x));
    });
    return batch;
}

} // namespace

ForceBatchBuilder displacement_friction_builder() { return build_displacements; }
ForceBatchBuilder angle_friction_builder() { return build_angles; }

} // namespace gudgeon

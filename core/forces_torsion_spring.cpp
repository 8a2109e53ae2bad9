#include "core/forces_torsion_spring.hpp"

#include "core/elastic_law.hpp"

namespace gudgeon {

namespace {

using Element = TorsionSpringKernel::Element;
using Scalar = Eigen::Matrix<double, 1, 1>;

CurveValue elastic(const Evaluation& e, const Element& x) {
    const double q = angle::value(e.body[x.a], e.body[x.b], x.frames, e.angle_reference(x.angle));
    return elastic_law(x.stiffness, x.table.get(), q - x.free_angle);
}

double rate(const Evaluation& e, const Element& x, const Gradient<1>& g) {
    return g.times(e.body[x.a], e.body[x.b])[0];
}

} // namespace

PairWrench TorsionSpringKernel::wrench(const Evaluation& e, const Element& x) {
    const Gradient<1> g = angle::gradient(e.body[x.a], e.body[x.b], x.frames);
    return conjugate_wrench<1>(g, Scalar(elastic(e, x).value + x.damping * rate(e, x, g)));
}

void TorsionSpringKernel::linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Gradient<1> g = angle::gradient(a, b, x.frames);
    const CurveValue spring = elastic(e, x);
    add_product(g, combined(x.damping, g, 0, g), c);
    add_product(g, combined(spring.slope, g, x.damping, angle::rate_gradient(a, b, x.frames)), s);
    angle::add_geometric(a, b, x.frames, spring.value + x.damping * rate(e, x, g), s);
}

EnergyRates TorsionSpringKernel::energies(const Evaluation& e, const Element& x) {
    const double q_rate = rate(e, x, angle::gradient(e.body[x.a], e.body[x.b], x.frames));
    return {elastic(e, x).integral, x.damping * q_rate * q_rate, 0};
}

std::unique_ptr<ForceBatch> build_torsion_springs(const CompileContext& context) {
    auto batch = std::make_unique<ForceBatchOf<TorsionSpringKernel>>();
    for (const Force& force : context.model.forces) {
        const auto* spring = std::get_if<TorsionSpring>(&force);
        if (!spring)
            continue;
        Element x;
        x.angle = context.angle(context.joint(spring->joint), spring->coordinate);
        if (x.angle < 0)
            throw ModelError(context.model.source, "/forces",
                             "'" + spring->name + "': joint '" + spring->joint + "' has no angle '" +
                                 spring->coordinate + "'",
                             "a rotation coordinate of the joint");
        const AngleRecord& record = context.system.angles[x.angle];
        x.a = record.a;
        x.b = record.b;
        x.frames = record.frames;
        x.stiffness = spring->stiffness;
        x.damping = spring->damping;
        x.free_angle = spring->free_angle;
        if (!spring->table.empty())
            x.table = std::make_shared<const Spline>(spring->table, Spline::Ends::linear);
        batch->add(std::move(x), spring->name);
    }
    if (batch->size() == 0)
        return nullptr;
    return batch;
}

} // namespace gudgeon

#include "core/forces_applied.hpp"

namespace gudgeon {

namespace {

double factor(const Evaluation& e, const AppliedElement& x) {
    return x.time ? evaluate(*x.time, e.t).value : 1.0;
}

} // namespace

template <bool follows>
PairWrench AppliedForceKernel<follows>::wrench(const Evaluation& e, const Element& x) {
    const Mat3& a = e.body[x.b].A;
    const double f = factor(e, x);
    PairWrench w;
    if (follows) {
        w.force_b = f * (a * x.force);
        w.moment_b = f * (x.point.cross(x.force) + x.torque);
    } else {
        w.force_b = f * x.force;
        w.moment_b = f * (x.point.cross(a.transpose() * x.force) + a.transpose() * x.torque);
    }
    return w;
}

template <bool follows>
void AppliedForceKernel<follows>::linearise(const Evaluation& e, const Element& x, BlockMatrix&,
                                            BlockMatrix& s) {
    const Mat3& a = e.body[x.b].A;
    const double f = factor(e, x);
    if (follows)
        s.block[2][3] += f * a * skew(x.force);
    else
        s.block[3][3] -= f * (skew(x.point) * skew(a.transpose() * x.force) + skew(a.transpose() * x.torque));
}

template <bool follows>
EnergyRates AppliedForceKernel<follows>::energies(const Evaluation& e, const Element& x) {
    const BodyMotion& b = e.body[x.b];
    const PairWrench w = wrench(e, x);
    return {0, 0, w.force_b.dot(b.v) + w.moment_b.dot(b.w)};
}

template <bool follows> std::unique_ptr<ForceBatch> build_applied_forces(const CompileContext& context) {
    auto batch = std::make_unique<ForceBatchOf<AppliedForceKernel<follows>>>();
    for (const Force& force : context.model.forces) {
        const auto* applied = std::get_if<AppliedForce>(&force);
        if (!applied || applied->follows != follows)
            continue;
        AppliedElement x;
        x.a = static_cast<int>(context.system.start.size()) - 1;
        x.b = context.body(applied->body);
        if (applied->torque) {
            x.torque = applied->vector;
        } else {
            x.force = applied->vector;
            x.point = applied->body_frame ? applied->point : context.in_body(x.b, applied->point);
        }
        x.time = applied->time;
        batch->add(std::move(x), applied->name);
    }
    if (batch->size() == 0)
        return nullptr;
    return batch;
}

template struct AppliedForceKernel<true>;
template struct AppliedForceKernel<false>;
template std::unique_ptr<ForceBatch> build_applied_forces<true>(const CompileContext&);
template std::unique_ptr<ForceBatch> build_applied_forces<false>(const CompileContext&);

} // namespace gudgeon

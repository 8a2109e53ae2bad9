#include "core/forces_tyre.hpp"

namespace gudgeon {

namespace {

struct Contact {
    double y, y_rate;
    double road_rate;        // of z_road, profile included
    double slope, curvature; // of the profile
    double x_rate;
    double force(const TyreElement& x) const { return x.preload - x.stiffness * y - x.damping * y_rate; }
};

Contact contact(const Evaluation& e, const TyreElement& x) {
    const BodyMotion& b = e.body[x.b];
    const Vec3 position = point_position(b, x.point), velocity = point_velocity(b, x.point);
    Contact k{position.z() - x.reference, velocity.z(), 0, 0, 0, velocity.x()};
    if (x.road) {
        const TimeValue road = evaluate(*x.road, e.t);
        k.y -= road.value;
        k.road_rate += e.frozen ? 0 : road.rate;
    }
    if (x.profile) {
        const CurveValue profile = (*x.profile)(position.x());
        k.y -= profile.value;
        k.slope = profile.slope;
        k.curvature = x.profile->curvature(position.x());
        k.road_rate += profile.slope * velocity.x();
    }
    k.y_rate -= k.road_rate;
    return k;
}

} // namespace

template <bool at_mass_centre>
PairWrench TyreKernel<at_mass_centre>::wrench(const Evaluation& e, const Element& x) {
    PairWrench w;
    w.force_b = Vec3(0, 0, contact(e, x).force(x));
    if (!at_mass_centre)
        w.moment_b = x.point.cross(e.body[x.b].A.transpose() * w.force_b);
    return w;
}

// With J the gradient of the point and D its rate gradient: F_z = F_z(y, y') where
// dy = (e_z - slope e_x)^T J dq and dy' = (e_z - slope e_x)^T (J du + D dq) - curvature x' e_x^T J dq.
template <bool at_mass_centre>
void TyreKernel<at_mass_centre>::linearise(const Evaluation& e, const Element& x, BlockMatrix& c,
                                           BlockMatrix& s) {
    const BodyMotion& b = e.body[x.b];
    const Contact k = contact(e, x);
    const Vec3 across(-k.slope, 0, 1);
    const Vec3 stiff = x.stiffness * across - Vec3(x.damping * k.curvature * k.x_rate, 0, 0);
    const Vec3 up = Vec3::UnitZ();
    c.block[2][2] += up * (x.damping * across).transpose();
    s.block[2][2] += up * stiff.transpose();
    if (at_mass_centre)
        return;

    const Mat3 turn = -b.A * skew(x.point), turn_rate = -b.A * skew(b.w.cross(x.point));
    const Vec3 moment = turn.transpose() * up; // per unit of F_z
    const Eigen::RowVector3d damped = x.damping * across.transpose() * turn;
    const Eigen::RowVector3d sprung = stiff.transpose() * turn + x.damping * across.transpose() * turn_rate;
    c.block[2][3] += up * damped;
    c.block[3][2] += moment * (x.damping * across).transpose();
    c.block[3][3] += moment * damped;
    s.block[2][3] += up * sprung;
    s.block[3][2] += moment * stiff.transpose();
    s.block[3][3] += moment * sprung - skew(x.point) * skew(b.A.transpose() * (k.force(x) * up));
}

template <bool at_mass_centre>
EnergyRates TyreKernel<at_mass_centre>::energies(const Evaluation& e, const Element& x) {
    const Contact k = contact(e, x);
    return {(0.5 * x.stiffness * k.y - x.preload) * k.y, x.damping * k.y_rate * k.y_rate,
            k.force(x) * k.road_rate};
}

template <bool at_mass_centre> std::unique_ptr<ForceBatch> build_tyres(const CompileContext& context) {
    auto batch = std::make_unique<ForceBatchOf<TyreKernel<at_mass_centre>>>();
    for (const Force& force : context.model.forces) {
        const auto* tyre = std::get_if<Tyre>(&force);
        if (!tyre)
            continue;
        TyreElement x;
        x.a = static_cast<int>(context.system.start.size()) - 1;
        x.b = context.body(tyre->body);
        x.point = tyre->body_frame ? tyre->point : context.in_body(x.b, tyre->point);
        const BodyMotion& start = context.system.start[x.b];
        const double round_off = 1e-14 * (1 + start.r.norm());
        if ((x.point.norm() <= round_off) != at_mass_centre)
            continue;
        x.stiffness = tyre->stiffness;
        x.damping = tyre->damping;
        x.preload = tyre->preload;
        x.reference = tyre->reference.value_or(point_position(start, x.point).z());
        x.road = tyre->road;
        if (!tyre->profile.empty())
            x.profile = std::make_shared<const Spline>(tyre->profile, Spline::Ends::constant);
        batch->add(std::move(x), tyre->name);
    }
    if (batch->size() == 0)
        return nullptr;
    return batch;
}

template struct TyreKernel<true>;
template struct TyreKernel<false>;
template std::unique_ptr<ForceBatch> build_tyres<true>(const CompileContext&);
template std::unique_ptr<ForceBatch> build_tyres<false>(const CompileContext&);

} // namespace gudgeon

#include "core/archive_state.hpp"

#include <algorithm>

namespace gudgeon {

namespace {
void visit_gradient(Archive& archive, Gradient<1>& g) { archive(g.ra, g.ta, g.rb, g.tb); }
} // namespace

void visit(Archive& archive, AngleMemory& x) { archive(x.value, x.rate, x.t); }

void visit(Archive& archive, BodyMotion& x) { archive(x.A, x.p, x.r, x.v, x.w); }

void visit(Archive& archive, ContactHistory& x) {
    archive(x.impacts, x.deepest, x.deepest_angle, x.peak_force, x.peak_moment, x.touching);
}

void visit(Archive& archive, ContactMemory& x) { archive(x.start_speed, x.start_time, x.place); }

void visit(Archive& archive, ContactSample& x) {
    archive(x.depth, x.rate, x.force, x.friction, x.dissipated_power, x.elastic, x.place, x.share,
            x.inverse_mass, x.normal_force, x.friction_force);
}

void visit(Archive& archive, Linearisation::ReactionCoupling& x) {
    archive(x.row);
    visit_gradient(archive, x.force);
}

void visit(Archive& archive, Linearisation::StateCoupling& x) {
    archive(x.state, x.pair, x.a, x.b, x.decay);
    visit_gradient(archive, x.force);
    visit_gradient(archive, x.rate);
}

void visit(Archive& archive, State& x) {
    archive(x.t, x.q, x.u, x.lambda, x.angles, x.z, x.contacts, x.history, x.work);
}

void visit(Archive& archive, Workspace& x) {
    archive(x.motion, x.f, x.external, x.phi, x.rate, x.rows, x.rate_rows, x.lin.C, x.lin.S, x.lin.states,
            x.lin.reactions, x.angles, x.z, x.lambda, x.contacts, x.scratch, x.samples);
    if (archive.reading())
        std::ranges::fill(x.apart, 0);
}

} // namespace gudgeon

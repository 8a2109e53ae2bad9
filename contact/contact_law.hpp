// A normal law with what it remembers: the bridge between a contact's channels and its law.
#pragma once

#include "contact/normal_law.hpp"
#include "core/force_batch.hpp"

#include <utility>

namespace gudgeon {

/// Force of the contact at `channel` (a blend uses the next one too), with its share of the law's force.
inline NormalForce contact_force(const Evaluation& e, const NormalLaw& law, int channel, double share,
                                 double depth, double rate) {
    const Indentation outer{depth, rate, e.start_speed[channel]};
    if (law.slots() == 1)
        return share * law.evaluate(outer);
    return share * law.evaluate(outer, {depth - law.inner_offset(), rate, e.start_speed[channel + 1]});
}

/// B M^-1 B^T of a scalar measure of two bodies.
inline double inverse_mass(const Evaluation& e, int a, int b, const Gradient<1>& g) {
    double sum = 0;
    if (a < e.moving)
        sum += g.ra.squaredNorm() / e.mass[a] + (g.ta * e.inverse_inertia[a] * g.ta.transpose())(0);
    if (b < e.moving)
        sum += g.rb.squaredNorm() / e.mass[b] + (g.tb * e.inverse_inertia[b] * g.tb.transpose())(0);
    return sum;
}

/// The sample of a contact's first slot, without vectors; of the second slot where slot is 1.
inline ContactSample contact_sample(const NormalLaw& law, const NormalForce& f, int slot, double depth,
                                    double rate, double share, double inverse) {
    ContactSample out;
    out.depth = slot == 0 ? depth : depth - law.inner_offset();
    out.rate = rate;
    out.share = share;
    out.inverse_mass = inverse;
    if (slot == 0 && depth > 0) {
        out.force = f.force;
        out.elastic = f.energy;
        out.dissipated_power = (f.force - f.elastic) * rate;
    }
    return out;
}

/// Depth of a slot at which the law has stored an energy (J) more than at the slot's beginning.
inline double slot_depth_of_energy(const NormalLaw& law, int slot, double energy) {
    if (slot == 0)
        return law.depth_of_energy(energy);
    const double offset = law.inner_offset();
    return law.depth_of_energy(law.evaluate({offset, 0, 0}).energy + energy) - offset;
}
inline double slot_depth_of_force(const NormalLaw& law, int slot, double force) {
    if (slot == 0)
        return law.depth_of_force(force);
    const double offset = law.inner_offset();
    return std::max(0.0, law.depth_of_force(law.evaluate({offset, 0, 0}).force + force) - offset);
}

} // namespace gudgeon

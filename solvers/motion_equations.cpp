#include "solvers/motion_equations.hpp"

#include "core/assembly.hpp"
#include "solvers/cartesian_motion.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/tree_motion.hpp"

#include <algorithm>

namespace gudgeon {

MotionRates MotionEquations::make_rates() const {
    return {VecX::Zero(coordinates()), VecX::Zero(speeds()), VecX::Zero(system().friction_states()),
            VecX::Zero(work_count(system())), VecX::Zero(system().row_count())};
}

bool MotionEquations::has_drives(const System& system) {
    return std::ranges::any_of(system.model.joints, [](const Joint& joint) { return !joint.drives.empty(); });
}

void MotionEquations::find_powers_and_states(double t, const VecX& z, const double* lambda, Workspace& ws,
                                             MotionRates& out) {
    const PhaseTimer timer(seconds_.evaluate);
    powers(system(), t, lambda, ws, out.powers);
    if (z.size() == 0)
        return;
    source_.resize(z.size());
    decay_.resize(z.size());
    state_terms(system(), t, ws, source_, decay_);
    out.states = source_ - decay_.cwiseProduct(z);
}

bool all_finite(const MotionRates& rates) {
    return rates.coordinates.allFinite() && rates.speeds.allFinite() && rates.lambda.allFinite();
}

std::unique_ptr<MotionEquations> make_motion_equations(const System& system,
                                                       const IntegratorOptions& options) {
    if (options.formulation == Formulation::tree)
        return make_tree_motion(system, options);
    return make_cartesian_motion(system, options);
}

} // namespace gudgeon

#include "solvers/index1_equations.hpp"

#include "solvers/phase_timer.hpp"

#include <fmt/format.h>

namespace gudgeon {

Index1Equations::Index1Equations(const System& system)
    : system_(system), matrix_(system), values_(matrix_.pattern().nonzeros()),
      gamma_(VecX::Zero(system.row_count())),
      unknowns_(VecX::Zero(system.velocities() + system.row_count())) {
    klu_.analyse(matrix_.pattern());
}

FactorStatus Index1Equations::solve(double t, Workspace& ws, const VecX* extra, VecX& acceleration,
                                    VecX& lambda) {
    {
        const PhaseTimer timer(seconds_.evaluate);
        ++evaluations_;
        evaluate_forces(system_, t, ws);
        evaluate_constraints(system_, t, nullptr, true, ws);
        const Evaluation e = evaluation(system_, ws, t);
        for (const auto& batch : system_.constraints)
            batch->acceleration_rhs(e, gamma_.data());
    }
    {
        const PhaseTimer timer(seconds_.assemble);
        matrix_.assemble_mass(system_, ws, 1.0, values_);
        unknowns_.head(system_.velocities()) = ws.f;
        unknowns_.tail(system_.row_count()) = gamma_;
        if (extra)
            unknowns_.tail(system_.row_count()) += *extra;
    }
    FactorStatus status;
    {
        const PhaseTimer timer(seconds_.factor);
        status = klu_.factor(values_);
    }
    if (!status.ok())
        return status;
    const PhaseTimer timer(seconds_.solve);
    klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
    acceleration = unknowns_.head(system_.velocities());
    lambda = unknowns_.tail(system_.row_count());
    if (system_.reaction_friction)
        settle_reactions(t, ws, extra, acceleration, lambda);
    return status;
}

// Friction that reactions press on, by iteration: forces and multipliers in turn.
void Index1Equations::settle_reactions(double t, Workspace& ws, const VecX* extra, VecX& acceleration,
                                       VecX& lambda) {
    constexpr int most_passes = 60;
    for (int pass = 0; pass < most_passes; ++pass) {
        ws.lambda = lambda;
        ++evaluations_;
        evaluate_forces(system_, t, ws);
        unknowns_.head(system_.velocities()) = ws.f;
        unknowns_.tail(system_.row_count()) = gamma_;
        if (extra)
            unknowns_.tail(system_.row_count()) += *extra;
        klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
        acceleration = unknowns_.head(system_.velocities());
        lambda = unknowns_.tail(system_.row_count());
        if ((lambda - ws.lambda).cwiseAbs().maxCoeff() <= 1e-14 * lambda.cwiseAbs().maxCoeff())
            return;
    }
}

void Index1Equations::respond(const VecX& extra, VecX& acceleration) {
    const PhaseTimer timer(seconds_.solve);
    unknowns_.head(system_.velocities()).setZero();
    unknowns_.tail(system_.row_count()) = extra;
    klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
    acceleration = unknowns_.head(system_.velocities());
}

void Index1Equations::report(Statistics& statistics) const {
    statistics.evaluations = evaluations_;
    statistics.factorisations = klu_.counts().factorisations;
    statistics.refactorisations = klu_.counts().refactorisations;
    statistics.nnz_matrix = matrix_.pattern().nonzeros();
    statistics.nnz_factors = klu_.factor_nonzeros();
    statistics.seconds.evaluate = seconds_.evaluate;
    statistics.seconds.assemble = seconds_.assemble;
    statistics.seconds.factor = seconds_.factor;
    statistics.seconds.solve = seconds_.solve;
}

std::string Index1Equations::name_of(int column) const {
    if (column < 0)
        return "unknown";
    if (column < system_.velocities())
        return "body " + system_.body_names[column / 6];
    return row_name(system_, column - system_.velocities());
}

std::string row_name(const System& system, int row) {
    const RowRecord& r = system.rows[row];
    return fmt::format("joint {} ({})", system.joints[r.joint].name, r.direction);
}

} // namespace gudgeon

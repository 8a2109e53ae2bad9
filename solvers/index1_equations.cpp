#include "solvers/index1_equations.hpp"

#include "core/bad_numbers.hpp"
#include "solvers/phase_timer.hpp"

#include <limits>

namespace gudgeon {

Index1Equations::Index1Equations(const System& system, Rows rows)
    : system_(system), rows_(rows), matrix_(system, rows), gamma_(VecX::Zero(system.row_count())),
      unknowns_(VecX::Zero(system.velocities() + system.row_count())), solution_(unknowns_), target_(gamma_),
      residual_(gamma_) {
    use(rows);
}

void Index1Equations::use(Rows rows) {
    rows_ = rows;
    matrix_ = SaddleMatrix(system_, rows);
    values_.assign(matrix_.pattern().nonzeros(), 0.0);
    klu_.analyse(matrix_.pattern());
}

void Index1Equations::visit(Archive& archive) {
    Rows rows = rows_;
    archive(rows);
    if (archive.reading() && rows != rows_)
        use(rows);
    archive(klu_, values_, gamma_, unknowns_, evaluations_, seconds_);
}

FactorStatus Index1Equations::factor(const Workspace& ws) {
    {
        const PhaseTimer timer(seconds_.assemble);
        matrix_.assemble_mass(system_, ws, 1.0, values_);
    }
    const PhaseTimer timer(seconds_.factor);
    return klu_.factor(values_);
}

// Rows that turn out to repeat each other are soft from then on.
FactorStatus Index1Equations::prepare(const Workspace& ws) {
    FactorStatus status = factor(ws);
    if (status.kind == FactorStatus::Kind::singular && rows_ == Rows::independent) {
        use(Rows::soft);
        status = factor(ws);
    }
    return status;
}

// Soft rows: what a solve leaves of G u' = target is solved for again, until round-off.
void Index1Equations::close_rows(const Workspace& ws, const VecX& target) {
    constexpr int most_passes = 40;
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    double last = std::numeric_limits<double>::infinity();
    for (int pass = 0; rows_ == Rows::soft && pass < most_passes; ++pass) {
        solution_ = unknowns_;
        acceleration_ = solution_.head(n);
        rows_times(system_, ws, acceleration_, residual_);
        residual_ = target - residual_;
        const double open = residual_.cwiseAbs().maxCoeff();
        if (open == 0 || open > 0.5 * last)
            return;
        last = open;
        unknowns_.head(n).setZero();
        unknowns_.tail(m) = residual_;
        klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
        unknowns_ += solution_;
    }
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
    target_ = gamma_;
    if (extra)
        target_ += *extra;
    const FactorStatus status = prepare(ws);
    if (!status.ok())
        return status;
    const PhaseTimer timer(seconds_.solve);
    unknowns_.head(system_.velocities()) = ws.f;
    unknowns_.tail(system_.row_count()) = target_;
    klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
    close_rows(ws, target_);
    acceleration = unknowns_.head(system_.velocities());
    lambda = unknowns_.tail(system_.row_count());
    if (system_.reaction_friction)
        settle_reactions(t, ws, acceleration, lambda);
    return status;
}

// Friction that reactions press on, by iteration: forces and multipliers in turn.
void Index1Equations::settle_reactions(double t, Workspace& ws, VecX& acceleration, VecX& lambda) {
    constexpr int most_passes = 60;
    for (int pass = 0; pass < most_passes; ++pass) {
        ws.lambda = lambda;
        ++evaluations_;
        evaluate_forces(system_, t, ws);
        unknowns_.head(system_.velocities()) = ws.f;
        unknowns_.tail(system_.row_count()) = target_;
        klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
        close_rows(ws, target_);
        acceleration = unknowns_.head(system_.velocities());
        lambda = unknowns_.tail(system_.row_count());
        if ((lambda - ws.lambda).cwiseAbs().maxCoeff() <= 1e-14 * lambda.cwiseAbs().maxCoeff())
            return;
    }
}

void Index1Equations::respond(const Workspace& ws, const VecX& extra, VecX& acceleration) {
    const PhaseTimer timer(seconds_.solve);
    unknowns_.head(system_.velocities()).setZero();
    unknowns_.tail(system_.row_count()) = extra;
    klu_.solve({unknowns_.data(), static_cast<std::size_t>(unknowns_.size())});
    close_rows(ws, extra);
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

std::string Index1Equations::name_of(int column) const { return unknown_name(system_, column); }

std::string row_name(const System& system, int row) { return constraint_name(system, row); }

} // namespace gudgeon

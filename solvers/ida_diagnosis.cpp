#include "solvers/ida_diagnosis.hpp"

#include <fmt/format.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>

#include <cmath>

namespace gudgeon {

namespace {

Eigen::Map<const VecX> view(N_Vector v, int n) { return {N_VGetArrayPointer(v), n}; }

/// Estimated errors over their tolerances.
VecX weighted_errors(const IdaTrouble& x, int n, int counted) {
    IDAGetEstLocalErrors(x.ida, x.scratch);
    VecX errors = view(x.scratch, n);
    errors.tail(n - counted).setZero();
    IDAGetErrWeights(x.ida, x.scratch);
    return errors.cwiseProduct(view(x.scratch, n));
}

/// What the equations miss at IDA's last iterate, as errors of the step in coordinates and velocities.
VecX missed(const IdaTrouble& x, const System& system, IdaEquations& equations) {
    double t = x.t, h = 0;
    N_Vector y = x.y, ydot = x.y;
    IDAGetCurrentTime(x.ida, &t);
    IDAGetCurrentStep(x.ida, &h);
    IDAGetCurrentY(x.ida, &y);
    IDAGetCurrentYp(x.ida, &ydot);
    VecX f = VecX::Zero(equations.size());
    try {
        equations.residual(t, N_VGetArrayPointer(y), N_VGetArrayPointer(ydot), f.data());
    } catch (...) {
        return f; // a force law refuses to be asked again
    }
    f.head(equations.lambda0()) *= h;
    VecX momentum = f.segment(equations.u0(), system.velocities());
    inverse_mass_times(system, momentum, momentum);
    f.segment(equations.u0(), system.velocities()) = momentum;
    return f;
}

std::string worst_place(const IdaTrouble& x, const System& system, IdaEquations& equations) {
    const bool by_error = x.flag == IDA_ERR_FAIL || x.flag == IDA_TOO_MUCH_ACC;
    const VecX badness =
        by_error ? weighted_errors(x, equations.size(), equations.lambda0()) : missed(x, system, equations);
    int worst = 0;
    for (int i = 0; i < equations.size(); ++i) {
        if (!std::isfinite(badness[i]))
            return equations.name_of(i);
        if (std::abs(badness[i]) > std::abs(badness[worst]))
            worst = i;
    }
    return equations.name_of(worst);
}

struct Reason {
    StepReason reason;
    const char* words;
};

Reason reason_of(const IdaTrouble& x) {
    if (!x.exception.empty())
        return {StepReason::non_finite, "a force law failed"};
    if (x.singular_column >= 0)
        return {StepReason::singular, "the matrix of the step is singular (constraints repeat each other?)"};
    switch (x.flag) {
    case IDA_RES_FAIL:
    case IDA_REP_RES_ERR:
    case IDA_FIRST_RES_FAIL:
    case IDA_BAD_EWT:
        return {StepReason::non_finite, "forces or constraints are no numbers"};
    case IDA_ERR_FAIL:
        return {StepReason::error_test, "the error test failed at every step tried"};
    case IDA_TOO_MUCH_ACC:
    case IDA_ILL_INPUT:
        return {StepReason::step_too_small, "the step became too small for rounding"};
    default:
        return {StepReason::newton, "Newton's iteration did not converge"};
    }
}

} // namespace

// IDA's own factor varies with the history of steps; it is 1 / (order + 1) for equal ones.
double ida_error_norm(void* ida, N_Vector scratch, int counted) {
    int order = 0;
    IDAGetLastOrder(ida, &order);
    const int n = static_cast<int>(N_VGetLength(scratch));
    const IdaTrouble last{ida, scratch, scratch, 0, 0, -1, {}, {}, {}};
    return std::sqrt(weighted_errors(last, n, counted).squaredNorm() / n) / (order + 1);
}

StepOutcome explain(const IdaTrouble& x, const System& system, IdaEquations& equations) {
    const auto [reason, words] = reason_of(x);
    if (!x.bad_number.empty() && x.exception.empty())
        return {false, StepReason::non_finite, fmt::format("t = {} s: {}", x.t, x.bad_number)};
    const std::string place = reason == StepReason::singular ? equations.name_of(x.singular_column)
                                                             : worst_place(x, system, equations);
    const std::string& detail = x.exception.empty() ? x.message : x.exception;
    return {
        false, reason,
        fmt::format("t = {} s: {}; worst at {}{}{}", x.t, words, place, detail.empty() ? "" : ": ", detail)};
}

} // namespace gudgeon

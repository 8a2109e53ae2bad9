// What IDA knows of a step: its error, why it failed, and where. Internal to the ida integrator.
#pragma once

#include "solvers/ida_equations.hpp"
#include "solvers/integrator.hpp"

#include <string>

struct _generic_N_Vector;

namespace gudgeon {

/// Error over tolerance of the last attempted step, 1 is about the limit; scratch is written over.
/// counted: the first unknowns, which take part in the test.
double ida_error_norm(void* ida, _generic_N_Vector* scratch, int counted);

struct IdaTrouble {
    void* ida;
    _generic_N_Vector* y; // any vector of the solver
    _generic_N_Vector* scratch;
    int flag;                      // what IDASolve returned
    double t;                      // end of the last accepted step
    int singular_column;           // of the last factorisation, -1: none
    const std::string& exception;  // of a force law, empty: none
    const std::string& message;    // IDA's own
    const std::string& bad_number; // of find_bad_number() since the last accepted step, empty: none
};

StepOutcome explain(const IdaTrouble& trouble, const System& system, IdaEquations& equations);

} // namespace gudgeon

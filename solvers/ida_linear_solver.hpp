// SUNDIALS' KLU solver with clocks and counters. Internal to the ida integrator.
#pragma once

struct _generic_SUNLinearSolver;
struct _generic_SUNMatrix;
struct _generic_N_Vector;
struct _SUNContext;

namespace gudgeon {

struct IdaLinearRecord {
    double factor_seconds = 0, solve_seconds = 0;
    long factorisations = 0, refactorisations = 0, nnz_factors = 0;
    int singular_column = -1; // of the last factorisation, -1: none
};

/// To be freed by SUNLinSolFree; the record must outlive it. Null when SUNDIALS refuses.
_generic_SUNLinearSolver* make_ida_linear_solver(_generic_N_Vector* vector, _generic_SUNMatrix* matrix,
                                                 _SUNContext* context, IdaLinearRecord& record);

} // namespace gudgeon

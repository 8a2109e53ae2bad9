#include "solvers/ida_linear_solver.hpp"

#include "solvers/phase_timer.hpp"

#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

namespace gudgeon {

namespace {

constexpr int minimum_degree = 0; // AMD on A + A^T: the pattern is nearly symmetric

struct Content {
    SUNLinearSolver klu;
    IdaLinearRecord* record;
};

Content& content(SUNLinearSolver s) { return *static_cast<Content*>(s->content); }

SUNLinearSolver_Type get_type(SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; }
SUNLinearSolver_ID get_id(SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; }
int initialize(SUNLinearSolver s) { return SUNLinSolInitialize(content(s).klu); }
sunindextype last_flag(SUNLinearSolver s) { return SUNLinSolLastFlag(content(s).klu); }
int space(SUNLinearSolver s, long* reals, long* integers) {
    return SUNLinSolSpace(content(s).klu, reals, integers);
}

int setup(SUNLinearSolver s, SUNMatrix a) {
    Content& c = content(s);
    const PhaseTimer timer(c.record->factor_seconds);
    auto* common = SUNLinSol_KLUGetCommon(c.klu);
    common->noffdiag = -1; // only a factorisation with a new choice of pivots writes it
    const int flag = SUNLinSolSetup(c.klu, a);
    const bool full = common->noffdiag >= 0;
    ++(full ? c.record->factorisations : c.record->refactorisations);
    const bool singular = common->status == KLU_SINGULAR;
    c.record->singular_column = singular ? static_cast<int>(common->singular_col) : -1;
    if (const auto* numeric = SUNLinSol_KLUGetNumeric(c.klu); numeric && full && !singular)
        c.record->nnz_factors = static_cast<long>(numeric->lnz + numeric->unz);
    if (singular)
        SUNLinSol_KLUReInit(c.klu, a, 0, SUNKLU_REINIT_PARTIAL); // the pivots are of no use any more
    return flag;
}

int solve(SUNLinearSolver s, SUNMatrix a, N_Vector x, N_Vector b, realtype tolerance) {
    const PhaseTimer timer(content(s).record->solve_seconds);
    return SUNLinSolSolve(content(s).klu, a, x, b, tolerance);
}

int destroy(SUNLinearSolver s) {
    if (!s)
        return SUNLS_SUCCESS;
    SUNLinSolFree(content(s).klu);
    delete &content(s);
    s->content = nullptr;
    SUNLinSolFreeEmpty(s);
    return SUNLS_SUCCESS;
}

} // namespace

SUNLinearSolver make_ida_linear_solver(N_Vector vector, SUNMatrix matrix, SUNContext context,
                                       IdaLinearRecord& record) {
    SUNLinearSolver klu = SUNLinSol_KLU(vector, matrix, context);
    if (!klu)
        return nullptr;
    SUNLinSol_KLUSetOrdering(klu, minimum_degree);
    SUNLinearSolver s = SUNLinSolNewEmpty(context);
    if (!s) {
        SUNLinSolFree(klu);
        return nullptr;
    }
    s->content = new Content{klu, &record};
    s->ops->gettype = get_type;
    s->ops->getid = get_id;
    s->ops->initialize = initialize;
    s->ops->setup = setup;
    s->ops->solve = solve;
    s->ops->lastflag = last_flag;
    s->ops->space = space;
    s->ops->free = destroy;
    return s;
}

} // namespace gudgeon

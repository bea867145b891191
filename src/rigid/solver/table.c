#include "rigid/solver/solver.h"

const ll_solver *const ll_solvers[LL_SOLVERS] = {
    &ll_solver_impulse,    &ll_solver_pgs,  &ll_solver_pgs_ngs, &ll_solver_soft_step,
    &ll_solver_tgs_sticky, &ll_solver_xpbd, &ll_solver_avbd};
const char *const ll_rigid_solver_names[LL_SOLVERS + 1] = {"impulse",    "pgs",  "pgs_ngs", "soft_step",
                                                           "tgs_sticky", "xpbd", "avbd",    NULL};

const char *ll_rigid_solver_help(ll_rigid_solver_kind kind)
{
    return ll_solvers[kind]->help;
}

double ll_rigid_passes(const ll_rigid_params *p)
{
    const double *passes = ll_solvers[p->solver]->passes;
    return passes[LL_PER_STEP] + passes[LL_PER_SUBSTEP] * (double)p->substeps +
           passes[LL_PER_ITERATION] * (double)p->iterations +
           passes[LL_PER_POSITION_ITERATION] * (double)p->position_iterations;
}

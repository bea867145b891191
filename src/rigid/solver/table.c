#include "rigid/solver/solver.h"

#define ROW(KIND, NAME) [LL_SOLVER_##KIND] = &ll_solver_##NAME,
#define NAMED(KIND, NAME) [LL_SOLVER_##KIND] = #NAME,

const ll_solver *const ll_solvers[LL_SOLVERS] = {LL_RIGID_SOLVERS(ROW)};
const char *const ll_rigid_solver_names[LL_SOLVERS + 1] = {LL_RIGID_SOLVERS(NAMED)};

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

/* Successive over-relaxation: Gauss-Seidel with enlarged corrections. */
#include "fluid/pressure/poisson.h"

static size_t work_size(int32_t nx, int32_t ny)
{
    (void)nx;
    (void)ny;
    return 0;
}

static void solve(ll_poisson *p)
{
    ll_poisson_relax(p, p->relaxation > 0 ? p->relaxation : ll_poisson_best_relaxation(p));
}

const ll_pressure_solver ll_pressure_sor = {
    .name = "sor",
    .help = "Over-relaxed Gauss-Seidel; default relaxation 2 / (1 + sin(pi / N)). A sweep costs 1 pass; "
            "converges in about 8 N sweeps.",
    .source = "Young 1954",
    .passes = 1,
    .work_size = work_size,
    .solve = solve,
};

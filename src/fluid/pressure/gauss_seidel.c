/* Red-black Gauss-Seidel: uses new values at once. */
#include "fluid/pressure/poisson.h"

static size_t work_size(int32_t nx, int32_t ny)
{
    (void)nx;
    (void)ny;
    return 0;
}

static void solve(ll_poisson *p)
{
    ll_poisson_relax(p, 1);
}

const ll_pressure_solver ll_pressure_gauss_seidel = {
    .name = "gauss_seidel",
    .help = "Red-black Gauss-Seidel. A sweep costs 1 pass; converges in about N^2 / 2 sweeps.",
    .source = "Stam 2003",
    .passes = 1,
    .work_size = work_size,
    .solve = solve,
};

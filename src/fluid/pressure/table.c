/* The solvers, and a solution by one of them. */
#include "fluid/pressure/poisson.h"

#include "fluid/core/fft.h"

#define ROW(KIND, NAME) &ll_pressure_##NAME,
#define NAMED(KIND, NAME) #NAME,

const ll_pressure_solver *const ll_pressure_solvers[LL_PRESSURES] = {LL_PRESSURE_SOLVERS(ROW)};
const char *const ll_pressure_names[LL_PRESSURES + 1] = {LL_PRESSURE_SOLVERS(NAMED)};

ll_status ll_pressure_fits(ll_pressure_kind kind, int32_t nx, int32_t ny, bool periodic_x, bool periodic_y,
                           bool empty)
{
    if (!ll_pressure_solvers[kind]->direct)
        return ll_ok();
    if (!empty)
        return ll_error(LL_BAD_INPUT, "direct needs a box without obstacles");
    if (periodic_x != periodic_y)
        return ll_error(LL_BAD_INPUT, "direct needs walls on all sides, or none");
    if (!ll_fft_allowed(nx) || !ll_fft_allowed(ny) || nx % 2 != 0 || ny % 2 != 0)
        return ll_error(LL_BAD_INPUT,
                        "direct needs even numbers of cells with factors 2, 3 and 5; got %d x %d", nx, ny);
    return ll_ok();
}

size_t ll_pressure_work_size(int32_t nx, int32_t ny)
{
    size_t most = 0;
    for (int i = 0; i < LL_PRESSURES; i++) {
        size_t size = ll_pressure_solvers[i]->work_size(nx, ny);
        most = size > most ? size : most;
    }
    return most;
}

void ll_pressure_prepare(ll_pressure_kind kind, const ll_poisson *p)
{
    if (ll_pressure_solvers[kind]->prepare)
        ll_pressure_solvers[kind]->prepare(p);
}

void ll_pressure_solve(ll_pressure_kind kind, ll_poisson *p)
{
    ll_poisson_take_mean_out(p);
    p->sweeps = 0;
    p->residual = 0;
    ll_pressure_solvers[kind]->solve(p);
}

/* Solvers that repeat sweeps over the cells: Jacobi, Gauss-Seidel, over-relaxation. */
#include <string.h>

#include "fluid/pressure/poisson.h"

/* ---- Jacobi: every cell from its neighbours of the last sweep ---- */

static size_t jacobi_work_size(int32_t nx, int32_t ny)
{
    return (size_t)(nx + 3) * (size_t)(ny + 3) * sizeof(double) + (size_t)(ny + 3) * sizeof(double);
}

typedef struct move {
    const ll_poisson *p;
    double weight;
} move;

static void move_rows(void *context, ll_share rows, int part)
{
    const move *m = context;
    const ll_poisson *p = m->p;
    const double *r = p->work;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++)
            p->x[k] += m->weight * p->inverse[k] * r[k];
}

/* With relaxation 1 the checkerboard mode changes sign from sweep to sweep and never decays. */
static void solve_jacobi(ll_poisson *p)
{
    enum { LOOK_EVERY = 10 }; /* a check costs as much as a sweep */
    move m = {p, p->relaxation > 0 ? p->relaxation : 1};
    if (ll_poisson_done(p))
        return;
    do {
        ll_poisson_residual(p, p->work);
        ll_rows_run(p->team, p->ny, p->nx, move_rows, &m);
        p->sweeps++;
    } while ((p->sweeps % LOOK_EVERY != 0 && p->sweeps < p->sweeps_max) || !ll_poisson_done(p));
}

/* Suits graphics cards. A sweep costs 1 pass; converges in about N^2 sweeps, and not at all with
 * relaxation 1. Stam 1999; Harris, GPU Gems 38, 2004. */
const ll_pressure_solver ll_pressure_jacobi = {
    .passes = 1, .work_size = jacobi_work_size, .solve = solve_jacobi};

/* ---- Gauss-Seidel and over-relaxation: new values at once ---- */

static size_t no_work(int32_t nx, int32_t ny)
{
    (void)nx, (void)ny;
    return 0;
}

static void solve_gauss_seidel(ll_poisson *p)
{
    ll_poisson_relax(p, 1);
}

/* Red-black Gauss-Seidel. A sweep costs 1 pass; converges in about N^2 / 2 sweeps. Stam 2003. */
const ll_pressure_solver ll_pressure_gauss_seidel = {
    .passes = 1, .work_size = no_work, .solve = solve_gauss_seidel};

static void solve_sor(ll_poisson *p)
{
    ll_poisson_relax(p, p->relaxation > 0 ? p->relaxation : ll_poisson_best_relaxation(p));
}

/* Over-relaxed Gauss-Seidel; default relaxation 2 / (1 + sin(pi / N)). A sweep costs 1 pass; converges in
 * about 8 N sweeps. Young 1954. */
const ll_pressure_solver ll_pressure_sor = {.passes = 1, .work_size = no_work, .solve = solve_sor};

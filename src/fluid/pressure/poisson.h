/* The pressure equation on the cells of a box, and the table of its solvers.
 *
 * For each fluid cell: sum over its open faces of (x - x beyond the face) = b. With b = -h times the outflow
 * of a cell, subtracting the gradient of x from the velocities leaves each cell with an outflow of (A x - b)
 * / h. Walls and faces of obstacles are closed, so x is determined up to a constant, and b must sum to zero:
 * its mean is subtracted.
 *
 * Fields have a ring of one cell around: cell (i, j) of nx x ny is at (j + 1) * stride + i + 1. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "base/status.h"
#include "fluid/core/rows.h"

typedef struct ll_poisson {
    int32_t nx, ny, stride;
    bool periodic_x, periodic_y;
    bool empty;                    /* no obstacle */
    const double *open_x, *open_y; /* of a cell's left and lower face: 1 open, 0 closed; also of the upper and
                                      right cells of the ring */
    const double *inverse;         /* one over a cell's number of open faces; 0 in obstacles */
    double *x;                     /* initial guess and solution */
    double *b;                     /* 0 in obstacles */
    void *work;                    /* owned by the solver */
    double tolerance;              /* stops at max |b - A x| <= tolerance max |b| */
    double relaxation;             /* 0: the solver's own */
    int64_t sweeps_max;
    ll_pace *pace;   /* may be NULL: asked between sweeps */
    ll_team *team;   /* may be NULL: shares the rows */
    int64_t sweeps;  /* made so far: sweeps, iterations, or V-cycles */
    double residual; /* max |b - A x| at the end */
    double source;   /* max |b| */
} ll_poisson;

typedef struct ll_pressure_solver {
    double passes; /* passes over the cells per sweep; a pass is about 7 operations per cell */
    bool direct;   /* needs an empty box, walls or periodic sides on both axes, lengths of ll_fft_allowed */
    size_t (*work_size)(int32_t nx, int32_t ny);
    void (*prepare)(const ll_poisson *); /* fills `work` for these faces. NULL: nothing to prepare */
    void (*solve)(ll_poisson *);
} ll_pressure_solver;

/* clang-format off */
#define LL_PRESSURE_SOLVERS(ROW) \
    ROW(JACOBI, jacobi) \
    ROW(GAUSS_SEIDEL, gauss_seidel) \
    ROW(SOR, sor) \
    ROW(PCG, pcg) \
    ROW(MULTIGRID, multigrid) \
    ROW(DIRECT, direct)
/* clang-format on */

#define LL_PRESSURE_KIND(KIND, NAME) LL_PRESSURE_##KIND,
typedef enum ll_pressure_kind { LL_PRESSURE_SOLVERS(LL_PRESSURE_KIND) LL_PRESSURES } ll_pressure_kind;
#undef LL_PRESSURE_KIND
#define LL_PRESSURE_DECLARE(KIND, NAME) extern const ll_pressure_solver ll_pressure_##NAME;
LL_PRESSURE_SOLVERS(LL_PRESSURE_DECLARE)
#undef LL_PRESSURE_DECLARE

extern const ll_pressure_solver *const ll_pressure_solvers[LL_PRESSURES];
extern const char *const ll_pressure_names[LL_PRESSURES + 1]; /* NULL-terminated */

/* LL_BAD_INPUT says why the solver cannot handle such a box. */
ll_status ll_pressure_fits(ll_pressure_kind, int32_t nx, int32_t ny, bool periodic_x, bool periodic_y,
                           bool empty);
size_t ll_pressure_work_size(int32_t nx, int32_t ny); /* sufficient for every solver */

/* Computes faces and `inverse` from cells that are fluid (1) or obstacle (0). The ring is included but
 * ignored. */
void ll_poisson_open(ll_poisson *, const uint8_t *fluid, double *open_x, double *open_y, double *inverse);
void ll_pressure_prepare(ll_pressure_kind, const ll_poisson *);
void ll_pressure_solve(ll_pressure_kind, ll_poisson *);

/* ---- for the solvers ---- */

static inline int64_t ll_cell(const ll_poisson *p, int32_t i, int32_t j)
{
    return (int64_t)(j + 1) * p->stride + i + 1;
}

void ll_poisson_wrap(const ll_poisson *, double *field); /* fills the ring of periodic sides, except faces */
/* One red-black Gauss-Seidel sweep with over-relaxation. */
void ll_poisson_sweep(const ll_poisson *, double relaxation);
void ll_poisson_take_mean_out(ll_poisson *); /* of b, over the fluid; and notes the largest that is left */
/* max |b - A x|; stores the differences in `r` unless NULL. */
double ll_poisson_residual(const ll_poisson *, double *r);
bool ll_poisson_done(ll_poisson *);                     /* checks the residual; asks the pace */
void ll_poisson_relax(ll_poisson *, double relaxation); /* sweeps until done */
double ll_poisson_best_relaxation(const ll_poisson *);

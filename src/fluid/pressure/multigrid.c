/* Multigrid: slow variations over the cells are solved on cells twice as large, and so on.
 *
 * V(2,2) cycles with red-black sweeps, 2 x 2 cells per coarse cell, bilinear interpolation. A coarse face is
 * open in proportion to its two fine faces, which for an empty box gives the same stencil on every level.
 * Behind a wall with a gap that proportion is too small and the correction too large: among obstacles the
 * correction is scaled to minimise the energy of the error, so that no cycle can increase it. Cell numbers
 * are halved while both are even; the coarsest level is solved by over-relaxation. */
#include <string.h>

#include "fluid/pressure/poisson.h"

enum { LEVELS_MAX = 16, SMOOTHING = 2, COARSEST = 2 };

typedef struct level {
    ll_poisson p;
    double *r;
    double *e; /* the correction, among obstacles */
} level;

static size_t cells_of(int32_t nx, int32_t ny)
{
    return (size_t)(nx + 4) * (size_t)(ny + 3);
}

static bool can_halve(int32_t nx, int32_t ny)
{
    return nx % 2 == 0 && ny % 2 == 0 && nx > COARSEST && ny > COARSEST;
}

/* The finest level stores only the residual and the correction here; the others x, b, both, faces and
 * inverse. */
static size_t work_size(int32_t nx, int32_t ny)
{
    size_t count = 2 * cells_of(nx, ny);
    while (can_halve(nx, ny)) {
        nx /= 2;
        ny /= 2;
        count += 7 * cells_of(nx, ny);
    }
    return count * sizeof(double);
}

/* Places the fields of each level in `work`. */
static int lay_out(const ll_poisson *p, level levels[LEVELS_MAX])
{
    double *at = p->work;
    int count = 1;
    levels[0] = (level){*p, at, at + cells_of(p->nx, p->ny)};
    at += 2 * cells_of(p->nx, p->ny);
    for (; count < LEVELS_MAX && can_halve(levels[count - 1].p.nx, levels[count - 1].p.ny); count++) {
        level *l = &levels[count];
        *l = (level){.p = levels[count - 1].p};
        l->p.nx /= 2;
        l->p.ny /= 2;
        l->p.stride = l->p.nx + 4;
        size_t n = cells_of(l->p.nx, l->p.ny);
        l->p.x = at;
        l->p.b = at + n;
        l->r = at + 2 * n;
        l->p.open_x = at + 3 * n;
        l->p.open_y = at + 4 * n;
        l->p.inverse = at + 5 * n;
        l->e = at + 6 * n;
        at += 7 * n;
    }
    return count;
}

static void coarsen(const ll_poisson *fine, const ll_poisson *coarse)
{
    double *ox = (double *)coarse->open_x, *oy = (double *)coarse->open_y,
           *inverse = (double *)coarse->inverse;
    int64_t s = fine->stride;
    for (int32_t j = 0; j <= coarse->ny; j++)
        for (int32_t i = 0; i <= coarse->nx; i++) {
            int64_t k = ll_cell(coarse, i, j), f = ll_cell(fine, 2 * i, 2 * j);
            if (j < coarse->ny)
                ox[k] = 0.5 * (fine->open_x[f] + fine->open_x[f + s]);
            if (i < coarse->nx)
                oy[k] = 0.5 * (fine->open_y[f] + fine->open_y[f + 1]);
        }
    for (int32_t j = 0; j < coarse->ny; j++)
        for (int32_t i = 0; i < coarse->nx; i++) {
            int64_t k = ll_cell(coarse, i, j);
            double faces = ox[k] + ox[k + 1] + oy[k] + oy[k + coarse->stride];
            inverse[k] = faces > 0 ? 1 / faces : 0;
        }
}

static void prepare(const ll_poisson *p)
{
    level levels[LEVELS_MAX];
    int count = lay_out(p, levels);
    memset(p->work, 0, work_size(p->nx, p->ny));
    for (int l = 1; l < count; l++)
        coarsen(&levels[l - 1].p, &levels[l].p);
}

typedef struct transfer {
    const level *coarse, *fine;
    double *x; /* of the fine cells */
    double length;
} transfer;

static void restrict_rows(void *context, ll_share rows, int part)
{
    const transfer *t = context;
    const level *fine = t->fine, *coarse = t->coarse;
    int64_t s = fine->p.stride;
    const double *r = fine->r;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < coarse->p.nx; i++) {
            int64_t f = ll_cell(&fine->p, 2 * i, 2 * j);
            coarse->p.b[ll_cell(&coarse->p, i, j)] = (r[f] + r[f + 1]) + (r[f + s] + r[f + s + 1]);
        }
}

/* Sums the residuals of four cells; the initial guess is zero. */
static void restrict_rest(const level *fine, const level *coarse)
{
    memset(coarse->p.x, 0, cells_of(coarse->p.nx, coarse->p.ny) * sizeof(double));
    ll_rows_run(coarse->p.team, coarse->p.ny, 4 * (int64_t)coarse->p.nx, restrict_rows,
                &(transfer){.coarse = coarse, .fine = fine});
}

/* The fine cell in the corner of coarse cell k towards `side` and `across`, a step along x and y. The
 * gradient through a closed face is zero. */
static double corner(const ll_poisson *c, int64_t k, int64_t side, int64_t across, double open_side,
                     double open_across, double open_diagonal)
{
    const double *x = c->x;
    double to_side = open_side * (x[k + side] - x[k]), to_across = open_across * (x[k + across] - x[k]);
    double twist = x[k + side + across] - x[k + side] - x[k + across] + x[k];
    return x[k] + 0.25 * (to_side + to_across) + 0.0625 * open_diagonal * twist;
}

static void interpolate_rows(void *context, ll_share rows, int part)
{
    const transfer *to = context;
    const level *fine = to->fine;
    const ll_poisson *c = &to->coarse->p;
    const double *ox = c->open_x, *oy = c->open_y;
    double *x = to->x;
    int64_t s = c->stride;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < c->nx; i++) {
            int64_t k = ll_cell(c, i, j), f = ll_cell(&fine->p, 2 * i, 2 * j), t = fine->p.stride;
            double left = ox[k], right = ox[k + 1], below = oy[k], above = oy[k + s];
            x[f] += corner(c, k, -1, -s, left, below, left * below * ox[k - s] * oy[k - 1]);
            x[f + 1] += corner(c, k, 1, -s, right, below, right * below * ox[k + 1 - s] * oy[k + 1]);
            x[f + t] += corner(c, k, -1, s, left, above, left * above * ox[k + s] * oy[k - 1 + s]);
            x[f + t + 1] += corner(c, k, 1, s, right, above, right * above * ox[k + 1 + s] * oy[k + 1 + s]);
        }
}

static void interpolate(const level *coarse, const level *fine, double *x)
{
    ll_poisson_wrap(&coarse->p, coarse->p.x);
    ll_rows_run(coarse->p.team, coarse->p.ny, 4 * (int64_t)coarse->p.nx, interpolate_rows,
                &(transfer){.coarse = coarse, .fine = fine, .x = x});
}

/* (r . e) / (e . A e). */
static double best_length(const level *l)
{
    const double *ox = l->p.open_x, *oy = l->p.open_y, *e = l->e;
    int64_t s = l->p.stride;
    double wanted = 0, energy = 0;
    ll_poisson_wrap(&l->p, l->e);
    for (int32_t j = 0; j < l->p.ny; j++)
        for (int64_t k = ll_cell(&l->p, 0, j), end = ll_cell(&l->p, l->p.nx, j); k < end; k++) {
            double across = ox[k] * (e[k] - e[k - 1]) + ox[k + 1] * (e[k] - e[k + 1]);
            double along = oy[k] * (e[k] - e[k - s]) + oy[k + s] * (e[k] - e[k + s]);
            wanted += l->r[k] * e[k];
            energy += e[k] * (across + along);
        }
    return energy > 0 ? wanted / energy : 0;
}

static void add_rows(void *context, ll_share rows, int part)
{
    const transfer *t = context;
    const level *fine = t->fine;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int64_t k = ll_cell(&fine->p, 0, j), end = ll_cell(&fine->p, fine->p.nx, j); k < end; k++)
            fine->p.x[k] += t->length * fine->e[k];
}

static void add_coarse(const level *coarse, const level *fine)
{
    if (fine->p.empty) {
        interpolate(coarse, fine, fine->p.x);
        return;
    }
    memset(fine->e, 0, cells_of(fine->p.nx, fine->p.ny) * sizeof(double));
    interpolate(coarse, fine, fine->e);
    ll_rows_run(fine->p.team, fine->p.ny, fine->p.nx, add_rows,
                &(transfer){.fine = fine, .length = best_length(fine)});
}

static void smooth(const ll_poisson *p, int sweeps, double relaxation)
{
    for (int i = 0; i < sweeps; i++)
        ll_poisson_sweep(p, relaxation);
}

static void cycle(level *levels, int count)
{
    for (int l = 0; l < count - 1; l++) {
        smooth(&levels[l].p, SMOOTHING, 1);
        ll_poisson_residual(&levels[l].p, levels[l].r);
        restrict_rest(&levels[l], &levels[l + 1]);
    }
    const ll_poisson *last = &levels[count - 1].p;
    smooth(last, 4 * (last->nx > last->ny ? last->nx : last->ny), ll_poisson_best_relaxation(last));
    for (int l = count - 2; l >= 0; l--) {
        add_coarse(&levels[l + 1], &levels[l]);
        smooth(&levels[l].p, SMOOTHING, 1);
    }
}

static void solve(ll_poisson *p)
{
    level levels[LEVELS_MAX];
    int count = lay_out(p, levels);
    while (!ll_poisson_done(p)) {
        cycle(levels, count);
        p->sweeps++;
    }
}

/* Multigrid, V(2,2) cycles. A cycle costs about 8 passes; about six converge, for every N. Best if the
 * numbers of cells have many factors 2. Brandt 1977; Trottenberg, Oosterlee and Schueller 2001. */
const ll_pressure_solver ll_pressure_multigrid = {
    .passes = 8,
    .work_size = work_size,
    .prepare = prepare,
    .solve = solve,
};

#include "ode/core/extrapolation.h"

#include "ode/core/method_internal.h"

enum { LANES = 2 * LL_PAIRS, COLUMNS_MIN = 4 };

/* Of an extrapolated rule: evaluations of the column of j substeps beyond the shared ones, substeps of that
 * column per step, and the fraction of a substep at which its first evaluation is. */
typedef struct rule {
    int per_column, less;
    int divisions;
    double first;
} rule;

enum { F0 /* f at the start */, VECTORS };

static size_t extra(int dim)
{
    (void)dim;
    return sizeof(ll_ode_plan) / sizeof(double);
}

static ll_ode_plan *plan_of(ll_ode_run *run, const ll_ode_method *method)
{
    return (ll_ode_plan *)ll_ode_extra(run, method);
}

/* More columns pay off at small tolerances: measured on orbits, springs, pendulums, tops and reactions. */
static int columns_for(double tolerance)
{
    return tolerance > 3e-3 ? COLUMNS_MIN : tolerance > 1e-4 ? 6 : LL_COLUMNS_MAX;
}

/* Lagrange weights at 0, in the square of the substep: of column j among the columns `from` (1 or 2) to k. */
#define FACTOR(i, j, from, k)                                                                                \
    ((i) == (j) || (i) < (from) || (i) > (k) ? 1 : (double)((j) * (j)) / ((j) * (j) - (i) * (i)))
#define WEIGHT(j, from, k)                                                                                   \
    ((j) < (from)                                                                                            \
         ? 0                                                                                                 \
         : FACTOR(1, j, from, k) * FACTOR(2, j, from, k) * FACTOR(3, j, from, k) * FACTOR(4, j, from, k) *   \
               FACTOR(5, j, from, k) * FACTOR(6, j, from, k) * FACTOR(7, j, from, k))
#define OF_COLUMN(j, k)                                                                                      \
    {                                                                                                        \
        WEIGHT(j, 1, k), WEIGHT(j, 1, k) - WEIGHT(j, 2, k)                                                   \
    }
#define OF_COLUMNS(k)                                                                                        \
    {                                                                                                        \
        OF_COLUMN(1, k), OF_COLUMN(2, k), OF_COLUMN(3, k), OF_COLUMN(4, k), OF_COLUMN(5, k),                 \
            OF_COLUMN(6, k), OF_COLUMN(7, k)                                                                 \
    }
static const struct {
    double result, error;
} weights[][LL_COLUMNS_MAX] = {OF_COLUMNS(4), OF_COLUMNS(5), OF_COLUMNS(6), OF_COLUMNS(7)};

/* Puts column j into `lane`, from row `at` on. Returns the next free row. */
static int place(ll_ode_plan *p, const rule *r, int j, int lane, int at)
{
    int k = (int)p->columns, length = r->per_column * j - r->less, pair = lane / 2, part = lane % 2;
    double substep = 1. / (r->divisions * j);
    for (int i = 0; i < length; i++) {
        ll_ode_row *x = &p->row[at + i][pair];
        x->h[part] = substep;
        x->c[part] = (i + r->first) * substep;
        x->active = 1;
        p->evaluations++;
    }
    ll_ode_row *last = &p->row[at + length - 1][pair];
    last->weight[part] = weights[k - COLUMNS_MIN][j - 1].result;
    last->error[part] = weights[k - COLUMNS_MIN][j - 1].error;
    last->ends = 1;
    if (at > 0) {
        ll_ode_row *before = &p->row[at - 1][pair];
        before->keep[part] = 0;
        before->next[part] = substep;
        before->begins = 1;
    }
    return at + length;
}

/* Lane l takes column k - l, and then column l if that is left. */
static void make(ll_ode_plan *p, const rule *r, double tolerance)
{
    int k = columns_for(tolerance);
    p->columns = k;
    p->rows = r->per_column * k - r->less;
    for (int i = 0; i < LL_ROWS_MAX; i++)
        for (int pair = 0; pair < LL_PAIRS; pair++)
            p->row[i][pair].keep = (ll_pair){1, 1};
    for (int lane = 0; lane < LANES && lane < k; lane++) {
        int at = place(p, r, k - lane, lane, 0);
        if (lane >= 1 && lane <= k - LANES)
            place(p, r, lane, lane, at);
    }
}

/* ---- systems without compiled loops: two states, one after the other ---- */

static void lane_of(int n, int lane, const ll_pair *from, double *to)
{
    for (int i = 0; i < n; i++)
        to[i] = from[i][lane];
}

static void into_lane(int n, int lane, const double *from, ll_pair *to)
{
    for (int i = 0; i < n; i++)
        to[i][lane] = from[i];
}

static void rhs_pair(const void *system, const ll_pair *t, const ll_pair *y, ll_pair *dy)
{
    const ll_ode *ode = system;
    double point[LL_ODE_DIM_MAX], slope[LL_ODE_DIM_MAX];
    for (int lane = 0; lane < 2; lane++) {
        lane_of(ode->dim, lane, y, point);
        ll_ode_eval(ode, (*t)[lane], point, slope);
        into_lane(ode->dim, lane, slope, dy);
    }
}

static void acceleration_pair(const void *system, const ll_pair *t, const ll_pair *q, const ll_pair *v,
                              ll_pair *a)
{
    const ll_ode *ode = system;
    int half = ode->dim / 2;
    double point[LL_ODE_DIM_MAX], slope[LL_ODE_DIM_MAX / 2];
    for (int lane = 0; lane < 2; lane++) {
        lane_of(half, lane, q, point);
        lane_of(half, lane, v, point + half);
        ode->acceleration(ode->params, (*t)[lane], point, point + half, slope);
        into_lane(half, lane, slope, a);
    }
}

static void magnetic_pair(const void *system, const ll_pair *t, const ll_pair *q, ll_pair *e, ll_pair *b)
{
    const ll_ode *ode = system;
    int half = ode->dim / 2;
    double point[3] = {0}, electric[3] = {0}, field[3] = {0};
    for (int lane = 0; lane < 2; lane++) {
        lane_of(half, lane, q, point);
        ode->magnetic(ode->params, (*t)[lane], point, electric, field);
        into_lane(half, lane, electric, e);
        into_lane(3, lane, field, b);
    }
}

/* ---- both rules ---- */

/* The midpoint rule needs f at the start; leapfrog does not. */
static bool begins_with_f(const rule *r)
{
    return r->less > 0;
}

static double extrapolate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode,
                          const ll_ode_trial *trial)
{
    const ll_ode_plan *plan = plan_of(run, method);
    const struct ll_ode_kernels *own = ode->kernels;
    if (begins_with_f(method->data)) {
        if (own != NULL && own->midpoint != NULL)
            return own->midpoint(ode->params, plan, trial);
        return ll_ode_midpoint_rows(run->dim, rhs_pair, ode, plan, trial);
    }
    if (own != NULL && own->leapfrog != NULL)
        return own->leapfrog(ode->params, plan, trial);
    if (ode->velocity_dependent)
        return ll_ode_leapfrog_rows(run->dim / 2, NULL, magnetic_pair, ode, plan, trial);
    return ll_ode_leapfrog_rows(run->dim / 2, acceleration_pair, NULL, ode, plan, trial);
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const rule *r = method->data;
    ll_ode_plan *p = plan_of(run, method);
    ll_ode_trial trial = ll_ode_trial_of(run, h, ll_ode_work(run, F0));
    if (p->columns == 0)
        make(p, r, run->control.tolerance);
    if (run->history == 0 && begins_with_f(r))
        ll_ode_f(run, ode, run->t, trial.y, trial.k);
    run->history = 1;
    run->counters.evaluations += (int64_t)p->evaluations;
    return extrapolate(run, method, ode, &trial);
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)ode, (void)h;
    run->history = 0;
}

static double propose(ll_ode_run *run, const ll_ode_method *method, double h, double error)
{
    return ll_ode_propose(run, h, error, 2 * plan_of(run, method)->columns - 1);
}

/* A shorter step from the same start: as accurate as the step itself, at the same cost. */
static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    ll_ode_trial trial = ll_ode_trial_of(run, theta * (run->t - run->t_last), ll_ode_work(run, F0));
    trial.t = run->t_last;
    trial.y = ll_ode_next(run);
    trial.next = y;
    extrapolate(run, method, ode, &trial);
}

static const ll_ode_body body = {.vectors = VECTORS,
                                 .extra = extra,
                                 .attempt = attempt,
                                 .accept = accept,
                                 .propose = propose,
                                 .dense = dense,
                                 .error_order = 9};

const ll_ode_method ll_ode_extrapolated_midpoint = {
    .name = "extrapolated_midpoint",
    .help = "Gragg-Bulirsch-Stoer: midpoint rules of several steps, extrapolated to order 8 to 14.",
    .source = "W. B. Gragg, SIAM J. Numer. Anal. 2, 1965; R. Bulirsch, J. Stoer, Numer. Math. 8, 1966",
    .order = 8,
    .adaptive = true,
    .body = &body,
    .data = &(const rule){.per_column = 2, .less = 1, .divisions = 2, .first = 1}};

const ll_ode_method ll_ode_extrapolated_leapfrog = {
    .name = "extrapolated_leapfrog",
    .help = "Leapfrogs of several steps, extrapolated to order 8 to 14: for forces independent of v, or "
            "magnetic.",
    .source = "E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.14",
    .order = 8,
    .adaptive = true,
    .needs = LL_ODE_NEEDS_MECHANICAL | LL_ODE_NEEDS_POSITIONS,
    .body = &body,
    .data = &(const rule){.per_column = 1, .divisions = 1, .first = 0.5}};

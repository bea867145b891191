#include "ode/extrapolation.h"

#include "ode/internal.h"

enum { LANES = 2 * LL_PAIRS };

/* What is extrapolated: evaluations of the column of j substeps beyond those that all columns share, substeps
 * of that column in a step, and the part of a substep after which its first evaluation comes. */
typedef struct rule {
    int per_column, less;
    int divisions;
    double first;
} rule;

/* Work vectors: f at the start, the estimate, then two of pairs. */
enum { F0, ERROR, SUM, VECTORS = SUM + 4 };

static size_t extra(int dim)
{
    (void)dim;
    return sizeof(ll_ode_plan) / sizeof(double);
}

static ll_ode_plan *plan_of(ll_ode_run *run, const ll_ode_method *method)
{
    return (ll_ode_plan *)ll_ode_extra(run, method);
}

/* More columns pay at small tolerances: measured on orbits, pendulums and reactions. */
static int columns_for(double tolerance)
{
    return tolerance > 3e-3 ? 4 : tolerance > 3e-6 ? 5 : tolerance > 3e-8 ? 6 : 7;
}

/* Of column j among the columns `from` to `to`: Lagrange's weight at 0, in the square of the substep. */
static double weight(int j, int from, int to)
{
    double w = 1;
    for (int i = from; i <= to; i++)
        if (i != j)
            w *= (double)(j * j) / (j * j - i * i);
    return j < from ? 0 : w;
}

/* Puts column j into `lane`, from row `at` on. Returns the row after it. */
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
    last->weight[part] = weight(j, 1, k);
    last->error[part] = weight(j, 1, k) - weight(j, 2, k);
    last->ends = 1;
    if (at > 0) {
        ll_ode_row *before = &p->row[at - 1][pair];
        before->keep[part] = 0;
        before->next[part] = substep;
        before->begins = 1;
    }
    return at + length;
}

/* Lane l takes column k - l, and column l after it where that is left over. */
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

/* ---- systems without loops of their own: two states, one after the other ---- */

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

/* The midpoint rule takes f at the start; leapfrog does not. */
static bool begins_with_f(const rule *r)
{
    return r->less > 0;
}

/* A step of `h` from (t, y) to `out`; the estimate of its error goes to `error`. */
static void extrapolate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t, double h,
                        const double *y, double *out, double *error)
{
    const ll_ode_plan *plan = plan_of(run, method);
    const struct ll_ode_kernels *own = ode->kernels;
    const double *f0 = ll_ode_work(run, F0);
    ll_pair *sum = (ll_pair *)ll_ode_work(run, SUM), *estimate = sum + run->dim;
    memset(sum, 0, 2 * (size_t)run->dim * sizeof *sum);
    if (begins_with_f(method->data)) {
        if (own != NULL && own->midpoint != NULL)
            own->midpoint(ode->params, plan, t, h, y, f0, sum, estimate);
        else
            ll_ode_midpoint_rows(run->dim, rhs_pair, ode, plan, t, h, y, f0, sum, estimate);
    } else if (own != NULL && own->leapfrog != NULL) {
        own->leapfrog(ode->params, plan, t, h, y, f0, sum, estimate);
    } else if (ode->velocity_dependent) {
        ll_ode_leapfrog_rows(run->dim / 2, NULL, magnetic_pair, ode, plan, t, h, y, sum, estimate);
    } else {
        ll_ode_leapfrog_rows(run->dim / 2, acceleration_pair, NULL, ode, plan, t, h, y, sum, estimate);
    }
    run->counters.evaluations += (int64_t)plan->evaluations;
    for (int i = 0; i < run->dim; i++) {
        out[i] = y[i] + (sum[i][0] + sum[i][1]);
        error[i] = estimate[i][0] + estimate[i][1];
    }
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const rule *r = method->data;
    ll_ode_plan *p = plan_of(run, method);
    double *error = ll_ode_work(run, ERROR);
    const double *y = ll_ode_state_y(run);
    if (p->columns == 0)
        make(p, r, run->control.tolerance);
    if (run->history == 0 && begins_with_f(r))
        ll_ode_f(run, ode, run->t, y, ll_ode_work(run, F0));
    run->history = 1;
    extrapolate(run, method, ode, run->t, h, y, ll_ode_next(run), error);
    return ll_ode_norm2(run, error);
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

/* A shorter step from the same start: as good as the step itself, at its cost. */
static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    int64_t evaluations = run->counters.evaluations;
    double h = theta * (run->t - run->t_last);
    extrapolate(run, method, ode, run->t_last, h, ll_ode_next(run), y, ll_ode_work(run, ERROR));
    run->counters.evaluations = evaluations;
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
    .help = "Leapfrogs of several steps, extrapolated to order 8 to 14: for forces free of v, or magnetic.",
    .source = "E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.14",
    .order = 8,
    .adaptive = true,
    .needs = LL_ODE_NEEDS_MECHANICAL | LL_ODE_NEEDS_POSITIONS,
    .body = &body,
    .data = &(const rule){.per_column = 1, .divisions = 1, .first = 0.5}};

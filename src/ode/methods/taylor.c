/* Taylor series of the solution, of an order chosen by the tolerance and with a step chosen by the series: A.
 * Jorba, M. Zou, A Software Package for the Numerical Integration of ODEs by Means of High-Order Taylor
 * Methods, Exp. Math. 14, 2005, section 3. The problem gives the coefficients (ode/core/series.h). No attempt
 * is rejected: the step is known before it is made. */
#include "ode/core/method_internal.h"
#include "ode/core/series.h"

#include <float.h>

enum { ORDER_MIN = 4 };

/* Jorba and Zou have 1 - ln(tolerance) / 2, the optimum if a coefficient costs in proportion to its index.
 * The recurrences of the problems are short: the cost grows less, and higher orders need 2 to 15 % fewer
 * instructions at equal error (orbit, pendulums, predators). */
static int order_for(double tolerance)
{
    int order = (int)(2 - 0.65 * ll_detmath_log(tolerance));
    return order < ORDER_MIN ? ORDER_MIN : order > LL_SERIES_ORDER ? LL_SERIES_ORDER : order;
}

/* Of the series in the work vectors: kept, since dense output asks for it after run->history is cleared. */
static size_t extra(int dim)
{
    (void)dim;
    return 1;
}

static int order_of(ll_ode_run *run, const ll_ode_method *method)
{
    return (int)*ll_ode_extra(run, method);
}

static void expand(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode)
{
    int order = order_of(run, method);
    double *series = ll_ode_work(run, 0);
    if (order == 0) {
        order = order_for(run->control.tolerance);
        *ll_ode_extra(run, method) = order;
    }
    ll_ode_copy(run->stride, ll_ode_state_y(run), series);
    ode->series(ode->params, run->t, order, series);
    run->counters.evaluations += order;
    run->history = 1;
}

/* Two terms decide, since those of odd or of even order may be zero. The last one is to equal the tolerance,
 * by the norm of the other methods, and the one before e^2 times as much: a step of e^-2 of the radius of
 * convergence. */
static double limit(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode)
{
    const double e4 = 54.598150033144236;
    if (run->history == 0)
        expand(run, method, ode);
    int order = order_of(run, method);
    const double *y = ll_ode_work(run, 0), *last = ll_ode_work(run, order),
                 *before = ll_ode_work(run, order - 1);
    ll_pair absolute = {run->control.absolute, run->control.absolute};
    ll_pair sum_last = {0, 0}, sum_before = {0, 0};
    for (int i = 0; i < run->stride; i += 2) {
        ll_pair over = 1 / (absolute + run->control.tolerance * ll_pair_fabs(ll_pair_at(y + i)));
        ll_pair a = ll_pair_at(last + i) * over, b = ll_pair_at(before + i) * over;
        sum_last += a * a;
        sum_before += b * b;
    }
    double size_last = (sum_last[0] + sum_last[1]) / run->dim,
           size_before = (sum_before[0] + sum_before[1]) / (run->dim * e4);
    double by_last = size_last > 0 ? ll_ode_power(size_last, -0.5 / order) : DBL_MAX;
    double by_before = size_before > 0 ? ll_ode_power(size_before, -0.5 / (order - 1)) : DBL_MAX;
    return by_last < by_before ? by_last : by_before;
}

/* The series at `h` after the start of the step. */
static void evaluate(ll_ode_run *run, int order, double h, double *y)
{
    for (int i = 0; i < run->stride; i += 2) {
        ll_pair sum = ll_pair_at(ll_ode_work(run, order) + i);
        for (int k = order - 1; k >= 0; k--)
            sum = sum * h + ll_pair_at(ll_ode_work(run, k) + i);
        ll_pair_put(y + i, sum);
    }
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)ode;
    double *next = ll_ode_next(run), sum = 0;
    evaluate(run, order_of(run, method), h, next);
    for (int i = 0; i < run->dim; i++)
        sum += next[i] * 0; /* NaN where a component is not finite */
    return sum;
}

/* The next step is limited by its own series alone. A sum that is not finite is tried again with less. */
static double propose(ll_ode_run *run, const ll_ode_method *method, double h, double error)
{
    (void)method;
    return error == 0 ? run->control.t_end - run->control.t0 : h / 2;
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)ode, (void)h;
    run->history = 0;
}

static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    double at[LL_ODE_DIM_MAX];
    (void)ode;
    evaluate(run, order_of(run, method), theta * (run->t - run->t_last), at);
    memcpy(y, at, (size_t)run->dim * sizeof *y);
}

static const ll_ode_body body = {.vectors = LL_SERIES_TERMS,
                                 .extra = extra,
                                 .limit = limit,
                                 .attempt = attempt,
                                 .propose = propose,
                                 .accept = accept,
                                 .dense = dense,
                                 .error_order = LL_SERIES_ORDER};

const ll_ode_method ll_ode_taylor = {
    .name = "taylor",
    .help =
        "Taylor series of an order by the tolerance, 4 to 24: for smooth problems; a coefficient counts as "
        "an evaluation.",
    .source = "A. Jorba, M. Zou, Exp. Math. 14, 2005",
    .order = ORDER_MIN,
    .adaptive = true,
    .needs = LL_ODE_NEEDS_TAYLOR,
    .body = &body};

#include "experiment/precision.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ode/scale.h"

enum { SAMPLES = 64, REPEATS = 7, STEPS_MAX = 1 << 20 };

#define LONG_NS 200000000 /* a run of more than so long is not repeated */

/* What one ladder needs: the solution at the sample times, and a run. */
typedef struct bench {
    const ll_precision_order *order;
    ll_ode ode;
    double duration;
    double *solution; /* SAMPLES + 1 states, the first at time 0 */
    ll_ode_run *run;
} bench;

static const ll_ode_method *best_method(const ll_ode_problem *problem)
{
    return ll_ode_method_find(problem->stiff ? "radau13" : "dop853");
}

static double sample_time(const bench *b, int k)
{
    return k == SAMPLES ? b->duration : b->duration * k / SAMPLES;
}

/* By formula, else by the best method at the least tolerance; the published end where it is for this span. */
static ll_status solve(bench *b)
{
    const ll_ode_problem *p = b->order->problem;
    const ll_ode_method *best = best_method(p);
    int dim = b->ode.dim;
    ll_ode_control control = {.t_end = b->duration, .tolerance = 1e-14, .absolute = 1e-18};
    ll_ode_run *run = malloc(ll_ode_run_size(best, &b->ode));
    ll_status status = run ? ll_ok() : ll_error(LL_NO_MEMORY, "no memory for a solution");
    p->start(b->order->params, b->solution);
    if (!ll_failed(&status))
        status = ll_ode_start(run, best, &b->ode, &control, b->solution);
    for (int k = 1; k <= SAMPLES && !ll_failed(&status); k++) {
        double t = sample_time(b, k), *y = b->solution + k * dim;
        if (p->exact && p->exact(b->order->params, t, y))
            continue;
        if (run->t < t && ll_ode_advance(run, best, &b->ode, t) == LL_ODE_DIVERGED)
            status = ll_error(LL_DIVERGED, "the solution of %s could not be computed", p->name);
        else
            ll_ode_sample(run, best, &b->ode, t, y);
    }
    free(run);
    return status;
}

static double distance(const double *a, const double *b, int dim)
{
    double sum = 0;
    for (int i = 0; i < dim; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum);
}

static double energy_at(const bench *b, double t, const double *y)
{
    const ll_ode_problem *p = b->order->problem;
    return p->energy ? p->energy(b->order->params, t, y) : 0;
}

static ll_status start(bench *b, const ll_ode_method *method, double setting)
{
    ll_ode_control control = {
        .t_end = b->duration, .dt = setting, .tolerance = setting, .max_steps = 100 * (int64_t)STEPS_MAX};
    return ll_ode_start(b->run, method, &b->ode, &control, b->solution);
}

static void forget(ll_precision *r)
{
    r->e_final = r->e_max = r->e_l2 = r->drift_final = r->drift_max = r->drift_per_s = NAN;
}

/* Of the whole solution. */
static ll_ode_scale scale_of(const bench *b)
{
    ll_ode_scale scale = {0};
    for (int k = 0; k <= SAMPLES; k++)
        ll_ode_scale_see(&scale, b->order->problem, &b->ode, sample_time(b, k), b->solution + k * b->ode.dim);
    return scale;
}

/* The error at the sample times, and at the end at the method's own time. */
static void measure(bench *b, const ll_ode_method *method, ll_precision *r)
{
    int dim = b->ode.dim;
    ll_ode_scale most = scale_of(b);
    double y[LL_ODE_DIM_MAX], squares = 0, e0 = energy_at(b, 0, b->solution),
                              scale = fabs(e0) > 0 ? fabs(e0) : 1;
    double sum_t = 0, sum_tt = 0, sum_d = 0, sum_td = 0;
    for (int k = 1; k <= SAMPLES; k++) {
        double t = sample_time(b, k);
        if (ll_ode_advance(b->run, method, &b->ode, t) == LL_ODE_DIVERGED)
            break;
        ll_ode_sample(b->run, method, &b->ode, t, y);
        double e = distance(y, b->solution + k * dim, dim), drift = (energy_at(b, t, y) - e0) / scale;
        if (ll_ode_blown_up(&most, e, drift * scale)) {
            ll_ode_blow_up(b->run);
            break;
        }
        r->e_max = fmax(r->e_max, e);
        r->drift_max = fmax(r->drift_max, fabs(drift));
        r->e_final = e;
        r->drift_final = drift;
        squares += e * e;
        sum_t += t;
        sum_tt += t * t;
        sum_d += drift;
        sum_td += t * drift;
    }
    r->status = ll_ode_run_status(b->run);
    r->reason = (ll_ode_reason)b->run->reason;
    r->counters = b->run->counters;
    r->e_l2 = sqrt(squares / SAMPLES);
    r->drift_per_s = (SAMPLES * sum_td - sum_t * sum_d) / (SAMPLES * sum_tt - sum_t * sum_t);
    if (r->status != LL_RUN_OK)
        forget(r);
}

static int by_size(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static ll_status time_it(bench *b, const ll_ode_method *method, double setting, ll_precision *r)
{
    int64_t took[REPEATS];
    int n = 0;
    do {
        int64_t from = b->order->now_ns();
        ll_status status = start(b, method, setting);
        if (ll_failed(&status))
            return status;
        ll_ode_advance(b->run, method, &b->ode, b->duration);
        took[n++] = b->order->now_ns() - from;
    } while (n < REPEATS && took[0] < LONG_NS);
    qsort(took, (size_t)n, sizeof *took, by_size);
    r->cpu_min_s = (double)took[0] * 1e-9;
    r->cpu_median_s = (double)took[n / 2] * 1e-9;
    return ll_ok();
}

static ll_status rung(bench *b, const ll_ode_method *method, double setting, ll_precision *r)
{
    *r = (ll_precision){.setting = setting, .order = NAN};
    ll_status status = time_it(b, method, setting, r);
    if (!ll_failed(&status))
        status = start(b, method, setting);
    if (!ll_failed(&status))
        measure(b, method, r);
    return status;
}

static ll_status open_bench(bench *b, const ll_precision_order *order, const ll_ode_method *method)
{
    *b =
        (bench){.order = order, .duration = order->duration > 0 ? order->duration : order->problem->duration};
    order->problem->system(order->params, &b->ode);
    ll_status status = ll_ode_method_fits(method, &b->ode);
    if (ll_failed(&status))
        return status;
    b->solution = calloc((SAMPLES + 1) * (size_t)b->ode.dim, sizeof *b->solution);
    b->run = malloc(ll_ode_run_size(method, &b->ode));
    return b->solution && b->run ? solve(b) : ll_error(LL_NO_MEMORY, "no memory to measure a method");
}

static void close_bench(bench *b)
{
    free(b->solution);
    free(b->run);
}

ll_status ll_precision_rung(const ll_precision_order *order, const ll_ode_method *method, double setting,
                            ll_precision *out)
{
    bench b;
    ll_status status = open_bench(&b, order, method);
    if (!ll_failed(&status))
        status = rung(&b, method, setting, out);
    close_bench(&b);
    return status;
}

ll_status ll_precision_ladder(const ll_precision_order *order, const ll_ode_method *method,
                              ll_precision *rungs, int *count)
{
    bench b;
    int n = 0;
    ll_status status = open_bench(&b, order, method);
    double setting = method->adaptive ? 1e-2 : b.duration / 16, factor = method->adaptive ? 0.1 : 0.5;
    double least = method->adaptive ? 0.9e-14 : b.duration / STEPS_MAX;
    for (; !ll_failed(&status) && n < LL_PRECISION_RUNGS_MAX && setting >= least; setting *= factor) {
        ll_precision *r = &rungs[n];
        status = rung(&b, method, setting, r);
        if (n > 0 && r->e_max > 0 && r[-1].e_max > 0)
            r->order = log(r->e_max / r[-1].e_max) / log(factor);
        n += !ll_failed(&status);
        if (n > 2 && !method->adaptive && r->e_max > r[-1].e_max && r[-1].e_max < 1e-9)
            break; /* rounding has the say from here on */
    }
    close_bench(&b);
    *count = n;
    return status;
}

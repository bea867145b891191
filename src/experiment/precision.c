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
    double *solution;          /* SAMPLES + 1 states, the first at time 0 */
    double doubt[SAMPLES + 1]; /* by how much two references differ */
    ll_ode_run *run;
} bench;

static double sample_time(const bench *b, int k)
{
    return k == SAMPLES ? b->duration : b->duration * k / SAMPLES;
}

static double distance(const double *a, const double *b, int dim)
{
    double sum = 0;
    for (int i = 0; i < dim; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum);
}

/* One of the references at the sample times, from the second on. */
static ll_status integrate(const bench *b, int which, double *states)
{
    const ll_ode_problem *p = b->order->problem;
    const ll_ode_method *method = ll_ode_reference_method(p, which);
    ll_ode_control control = ll_ode_reference_control(b->duration);
    ll_ode_run *run = malloc(ll_ode_run_size(method, &b->ode));
    ll_status status = run ? ll_ode_start(run, method, &b->ode, &control, b->solution)
                           : ll_error(LL_NO_MEMORY, "no memory for a solution");
    for (int k = 1; k <= SAMPLES && !ll_failed(&status); k++) {
        double t = sample_time(b, k);
        if (run->t < t && ll_ode_advance(run, method, &b->ode, t) == LL_ODE_DIVERGED)
            status = ll_error(LL_DIVERGED, "the solution of %s could not be computed", p->name);
        else
            ll_ode_sample(run, method, &b->ode, t, states + k * b->ode.dim);
    }
    free(run);
    return status;
}

/* By formula, else by two references. */
static ll_status solve(bench *b)
{
    const ll_ode_problem *p = b->order->problem;
    int dim = b->ode.dim;
    bool formula = p->exact != NULL;
    p->start(b->order->params, b->solution);
    for (int k = 1; k <= SAMPLES && formula; k++)
        formula = p->exact(b->order->params, sample_time(b, k), b->solution + k * dim);
    if (formula)
        return ll_ok();
    double *other = calloc((SAMPLES + 1) * (size_t)dim, sizeof *other);
    ll_status status =
        other ? integrate(b, 0, b->solution) : ll_error(LL_NO_MEMORY, "no memory for a solution");
    if (!ll_failed(&status))
        status = integrate(b, 1, other);
    for (int k = 1; k <= SAMPLES && !ll_failed(&status); k++)
        b->doubt[k] = distance(b->solution + k * dim, other + k * dim, dim);
    free(other);
    return status;
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
    r->predictable_s = r->uncertainty = NAN;
}

/* Of the whole solution. */
static ll_ode_scale scale_of(const bench *b)
{
    ll_ode_scale scale = {0};
    for (int k = 0; k <= SAMPLES; k++)
        ll_ode_scale_see(&scale, b->order->problem, &b->ode, sample_time(b, k), b->solution + k * b->ode.dim);
    return scale;
}

/* How many of the sample times the solution is predictable for. */
static int predictable(const bench *b, const ll_ode_scale *scale)
{
    int k = 0;
    while (k < SAMPLES && b->doubt[k + 1] <= LL_ODE_PREDICTABLE * scale->state)
        k++;
    return k;
}

/* The error at the sample times, as far as the solution is predictable, and above what is not known of it. */
static void errors(const bench *b, const double *error, int known, ll_precision *r)
{
    double squares = 0, unknown = 0;
    for (int k = 1; k <= known; k++) {
        r->e_max = fmax(r->e_max, error[k]);
        r->uncertainty = fmax(r->uncertainty, b->doubt[k]);
        squares += error[k] * error[k];
        unknown += b->doubt[k] * b->doubt[k];
    }
    r->e_final = known == SAMPLES ? error[SAMPLES] : NAN;
    r->e_l2 = sqrt(squares / (known > 0 ? known : 1));
    r->predictable_s = known < SAMPLES ? sample_time(b, known) : NAN;
    if (b->doubt[known] > 0 && !(r->e_final > b->doubt[known]))
        r->e_final = NAN;
    if (r->uncertainty > 0 && !(r->e_max > r->uncertainty))
        r->e_max = NAN;
    if (unknown > 0 && !(squares > unknown))
        r->e_l2 = NAN;
}

/* Least squares. */
static double slope(const double *t, const double *value, int n)
{
    double sum_t = 0, sum_tt = 0, sum = 0, sum_tv = 0;
    for (int k = 1; k <= n; k++) {
        sum_t += t[k];
        sum_tt += t[k] * t[k];
        sum += value[k];
        sum_tv += t[k] * value[k];
    }
    return (n * sum_tv - sum_t * sum) / (n * sum_tt - sum_t * sum_t);
}

/* The run, held against the solution. */
static void measure(bench *b, const ll_ode_method *method, ll_precision *r)
{
    int dim = b->ode.dim;
    ll_ode_scale most = scale_of(b);
    r->size = most.state;
    double at[SAMPLES + 1], error[SAMPLES + 1], drift[SAMPLES + 1], y[LL_ODE_DIM_MAX];
    double e0 = energy_at(b, 0, b->solution), scale = fabs(e0) > 0 ? fabs(e0) : 1;
    for (int k = 1; k <= SAMPLES; k++) {
        at[k] = sample_time(b, k);
        if (ll_ode_advance(b->run, method, &b->ode, at[k]) == LL_ODE_DIVERGED)
            break;
        ll_ode_sample(b->run, method, &b->ode, at[k], y);
        error[k] = distance(y, b->solution + k * dim, dim);
        drift[k] = (energy_at(b, at[k], y) - e0) / scale;
        r->drift_max = fmax(r->drift_max, fabs(drift[k]));
        if (ll_ode_blown_up(&most, error[k], drift[k] * scale)) {
            ll_ode_blow_up(b->run);
            break;
        }
    }
    r->status = ll_ode_run_status(b->run);
    r->reason = (ll_ode_reason)b->run->reason;
    r->counters = b->run->counters;
    if (r->status != LL_RUN_OK) {
        forget(r);
        return;
    }
    r->drift_final = drift[SAMPLES];
    r->drift_per_s = slope(at, drift, SAMPLES);
    errors(b, error, predictable(b, &most), r);
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

/* Above what is not known of the solution, and below a tenth of its size: an order can be told. */
static bool is_well_known(const ll_precision *r)
{
    return r->e_max > 4 * r->uncertainty && r->e_max < r->size / 10;
}

/* Shorter steps tell no more: rounding has the say, or the solution is not known better. */
static bool is_over(const ll_precision *r)
{
    bool unknown = r->status == LL_RUN_OK && isnan(r->e_max);
    return unknown ? isnan(r[-1].e_max) && r[-1].status == LL_RUN_OK
                   : r->e_max > r[-1].e_max && r[-1].e_max < 1e-9;
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
        if (n > 0 && is_well_known(r) && is_well_known(r - 1))
            r->order = log(r->e_max / r[-1].e_max) / log(factor);
        n += !ll_failed(&status);
        if (n > 2 && !method->adaptive && is_over(r))
            break;
    }
    close_bench(&b);
    *count = n;
    return status;
}

#include "experiment/advise/work_precision_run.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ode/core/measure.h"

enum { TIMES = 1024, REPEATS = 7, STEPS_MAX = 1 << 20, ROUNDS = 16 };

#define LONG_NS 200000000 /* a longer run is not repeated */
#define SLACK 1e-9        /* a step that ends closer to the end than this part of its length ends there */

/* Working memory of one series: a run, the solution to compare it with, and the uncertainty of that. */
typedef struct series_workspace {
    const ll_work_precision_request *request;
    ll_ode ode;
    double duration;
    double start[LL_ODE_DIM_MAX];
    bool formula;
    ll_ode_run *run, *solution; /* the solution: the first reference run, if there is no formula */
    double *each, *doubt_each;  /* by component: measure.h */
    ll_ode_measure doubt;       /* differences of the two references */
    double predictable_s;       /* until when these are small; the duration: always */
    ll_ode_scale whole;         /* scale of the solution, while it is predictable */
} series_workspace;

static ll_status start_reference(const series_workspace *b, int which, ll_ode_run *run)
{
    ll_ode_control control = ll_ode_reference_control(b->duration);
    return ll_ode_start(run, ll_ode_reference_method(b->request->problem, which), &b->ode, &control,
                        b->start);
}

/* Of a run, or of a pace that was broken off. */
static ll_status interrupted(void)
{
    return ll_error(LL_INTERRUPTED, "interrupted");
}

/* Reference `which` at `t`; t must not decrease. */
static void reference_at(const series_workspace *b, ll_ode_run *run, int which, double t, double *y)
{
    const ll_ode_method *method = ll_ode_reference_method(b->request->problem, which);
    if (run->t < t)
        ll_ode_advance(run, method, &b->ode, t);
    ll_ode_sample(run, method, &b->ode, t, y);
}

static void solution_at(const series_workspace *b, double t, double *y)
{
    if (b->formula)
        b->request->problem->exact(b->request->params, t, y);
    else
        reference_at(b, b->solution, 0, t, y);
}

/* Compares both references over the last step of the first; false when they diverge. */
static bool compare(series_workspace *b, ll_ode_run *second)
{
    const ll_ode_method *method = ll_ode_reference_method(b->request->problem, 0);
    double at[LL_ODE_POINTS], y[LL_ODE_DIM_MAX], other[LL_ODE_DIM_MAX];
    int points = ll_ode_measure_points(b->solution, method, at);
    for (int k = 0; k < points; k++) {
        ll_ode_measure before = b->doubt;
        ll_ode_sample(b->solution, method, &b->ode, at[k], y);
        reference_at(b, second, 1, at[k], other);
        ll_ode_scale_see(&b->doubt.scale, b->request->problem, &b->ode, at[k], y);
        ll_ode_measure_at(&b->doubt, b->doubt_each, &b->ode, at[k],
                          (b->solution->t - b->solution->t_last) / points, other, y, true);
        if (!(b->doubt.error <= LL_ODE_PREDICTABLE * b->doubt.scale.state)) {
            b->doubt = before;
            return false;
        }
        b->predictable_s = at[k];
    }
    return true;
}

/* Sets the solution: by formula, else two references and their difference. */
static ll_status solve(series_workspace *b)
{
    const ll_ode_problem *p = b->request->problem;
    double y[LL_ODE_DIM_MAX];
    b->predictable_s = b->duration;
    b->formula = p->exact != NULL && p->exact(b->request->params, b->duration, y);
    ll_ode_measure_start(&b->doubt, b->doubt_each, p, &b->ode, b->start);
    for (int k = 1; b->formula && k <= TIMES; k++) {
        p->exact(b->request->params, b->duration * k / TIMES, y);
        ll_ode_scale_see(&b->whole, p, &b->ode, b->duration * k / TIMES, y);
    }
    if (b->formula)
        return ll_ok();
    ll_ode_run *second = malloc(ll_ode_run_size(ll_ode_reference_method(p, 1), &b->ode));
    ll_status status =
        second ? start_reference(b, 0, b->solution) : ll_error(LL_NO_MEMORY, "out of memory: solution");
    LL_THEN(status, start_reference(b, 1, second));
    bool together = !ll_failed(&status);
    ll_pace pace = ll_pace_by(b->request->interrupt, ROUNDS);
    for (b->predictable_s = 0; together && b->solution->state == LL_ODE_RUNNING && ll_goes_on(&pace);) {
        ll_ode_state state = ll_ode_step(b->solution, ll_ode_reference_method(p, 0), &b->ode);
        together = compare(b, second);
        if (state == LL_ODE_DIVERGED || second->state == LL_ODE_DIVERGED)
            status = ll_error(LL_DIVERGED, "cannot compute the solution of %s", p->name);
        together = together && !ll_failed(&status);
    }
    b->whole = b->doubt.scale;
    free(second);
    return ll_broken_off(&pace) ? interrupted() : status;
}

static ll_status start(series_workspace *b, const ll_ode_method *method, double setting)
{
    ll_ode_control control = {
        .t_end = b->duration, .dt = setting, .tolerance = setting, .max_steps = 100 * (int64_t)STEPS_MAX};
    return ll_ode_start(b->run, method, &b->ode, &control, b->start);
}

static void forget(ll_work_precision *r)
{
    r->e_final = r->e_max = r->e_l2 = r->drift_final = r->drift_max = r->drift_per_s = NAN;
    r->e_final_weighted = r->e_max_weighted = r->e_l2_weighted = NAN;
    r->predictable_s = r->uncertainty = NAN;
}

/* The error in excess of the solution's uncertainty. */
static double above(double error, double doubt)
{
    return doubt == 0 || error > doubt ? error : NAN;
}

static double weighted(const series_workspace *b, const ll_ode_measure *m, int row)
{
    return above(ll_ode_measure_weighted(m, b->each, &b->ode, row),
                 ll_ode_measure_weighted(&b->doubt, b->doubt_each, &b->ode, row));
}

static void errors(const series_workspace *b, const ll_ode_measure *m, ll_work_precision *r)
{
    bool all = b->predictable_s >= b->duration;
    r->e_final = all ? above(m->error, b->doubt.error) : NAN;
    r->e_final_weighted = all ? weighted(b, m, LL_ODE_LAST) : NAN;
    r->e_max = above(m->error_max, b->doubt.error_max);
    r->e_max_weighted = weighted(b, m, LL_ODE_MOST);
    r->e_l2 = above(ll_ode_measure_rms(m), ll_ode_measure_rms(&b->doubt));
    r->e_l2_weighted = weighted(b, m, LL_ODE_SQUARES);
    r->uncertainty = b->doubt.error_max;
    r->predictable_s = all ? NAN : b->predictable_s;
    r->size = m->scale.state;
    r->drift_final = ll_ode_measure_relative(m, m->drift);
    r->drift_max = ll_ode_measure_relative(m, m->drift_max);
    r->drift_per_s = ll_ode_measure_slope(m);
}

/* Measures the last step of the run, up to the duration. */
static void measure_step(series_workspace *b, const ll_ode_method *method, ll_ode_measure *m)
{
    double at[LL_ODE_POINTS], y[LL_ODE_DIM_MAX], wanted[LL_ODE_DIM_MAX], from = m->t;
    int points = ll_ode_measure_points(b->run, method, at);
    bool within = b->run->t < b->duration;
    double end = within ? b->run->t : b->duration;
    for (int k = 0; k < points; k++) {
        double t = k == points - 1 || at[k] > end ? end : at[k];
        if (t == end && within && b->run->event >= 0)
            return; /* at a discontinuity the run may be on the other side of it */
        ll_ode_sample(b->run, method, &b->ode, t, y);
        solution_at(b, t, wanted);
        ll_ode_scale_see(&m->scale, b->request->problem, &b->ode, t, wanted);
        ll_ode_measure_at(m, b->each, &b->ode, t, (end - from) / points, y, wanted, t <= b->predictable_s);
    }
    ll_ode_measure_energy(m, b->request->problem, &b->ode, end, end - from, y);
    if (ll_ode_measure_blown_up(m))
        ll_ode_give_up(b->run, LL_ODE_BLEW_UP);
}

/* Runs the method and compares every step with the solution. */
static ll_status measure(series_workspace *b, const ll_ode_method *method, ll_work_precision *r)
{
    ll_ode_measure m;
    ll_ode_measure_start(&m, b->each, b->request->problem, &b->ode, b->start);
    ll_ode_scale_join(&m.scale, &b->whole);
    ll_status status = b->formula ? ll_ok() : start_reference(b, 0, b->solution);
    double slack = method->adaptive ? 0 : SLACK * r->setting;
    ll_pace pace = ll_pace_by(b->request->interrupt, ROUNDS);
    while (!ll_failed(&status) && b->run->state == LL_ODE_RUNNING && b->duration - b->run->t > slack &&
           ll_goes_on(&pace))
        if (ll_ode_step(b->run, method, &b->ode) != LL_ODE_DIVERGED)
            measure_step(b, method, &m);
    if (ll_broken_off(&pace))
        return interrupted();
    if (b->run->state != LL_ODE_DIVERGED && b->predictable_s >= b->duration &&
        !ll_ode_measure_resolved(&m, b->each, b->request->problem, &b->ode))
        ll_ode_give_up(b->run, LL_ODE_UNRESOLVED);
    r->status = ll_ode_run_status(b->run);
    r->reason = (ll_ode_reason)b->run->reason;
    r->counters = b->run->counters;
    if (r->status == LL_RUN_OK)
        errors(b, &m, r);
    else
        forget(r);
    return status;
}

static int by_size(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static ll_status measure_time(series_workspace *b, const ll_ode_method *method, double setting,
                              ll_work_precision *r)
{
    const ll_interrupt *interrupt = b->request->interrupt;
    int64_t took[REPEATS];
    int n = 0;
    do {
        if (interrupt && !interrupt->go_on(interrupt->context))
            return interrupted();
        int64_t from = b->request->now_ns();
        LL_TRY(start(b, method, setting));
        ll_ode_advance(b->run, method, &b->ode, b->duration);
        took[n++] = b->request->now_ns() - from;
    } while (n < REPEATS && took[0] < LONG_NS);
    qsort(took, (size_t)n, sizeof *took, by_size);
    r->cpu_min_s = (double)took[0] * 1e-9;
    r->cpu_median_s = (double)took[n / 2] * 1e-9;
    r->runs = n;
    return ll_ok();
}

static ll_status refinement_level(series_workspace *b, const ll_ode_method *method, double setting,
                                  ll_work_precision *r)
{
    *r = (ll_work_precision){.setting = setting, .order = NAN};
    LL_TRY(measure_time(b, method, setting, r));
    LL_TRY(start(b, method, setting));
    return measure(b, method, r);
}

static ll_status open_workspace(series_workspace *b, const ll_work_precision_request *request,
                                const ll_ode_method *method)
{
    *b = (series_workspace){.request = request,
                            .duration =
                                request->duration > 0 ? request->duration : request->problem->duration};
    request->problem->system(request->params, &b->ode);
    LL_TRY(ll_ode_method_fits(method, &b->ode));
    size_t each = LL_ODE_ROWS * (size_t)b->ode.dim;
    request->problem->start(request->params, b->start);
    b->run = malloc(ll_ode_run_size(method, &b->ode));
    b->solution = malloc(ll_ode_run_size(ll_ode_reference_method(request->problem, 0), &b->ode));
    b->each = calloc(each, sizeof *b->each);
    b->doubt_each = calloc(each, sizeof *b->doubt_each);
    return b->run && b->solution && b->each && b->doubt_each
               ? solve(b)
               : ll_error(LL_NO_MEMORY, "out of memory: measuring a method");
}

static void close_workspace(series_workspace *b)
{
    free(b->run);
    free(b->solution);
    free(b->each);
    free(b->doubt_each);
}

ll_status ll_work_precision_level(const ll_work_precision_request *request, const ll_ode_method *method,
                                  double setting, ll_work_precision *out)
{
    series_workspace b;
    ll_status status = open_workspace(&b, request, method);
    LL_THEN(status, refinement_level(&b, method, setting, out));
    close_workspace(&b);
    return status;
}

/* Whether an order can be computed: the error is above the solution's uncertainty and the rounding of these
 * steps, and below a tenth of the solution's size. */
static bool is_well_known(const ll_work_precision *r)
{
    double rounding = 16 * DBL_EPSILON * r->size * sqrt((double)r->counters.steps);
    return r->e_max > 4 * r->uncertainty && r->e_max > rounding && r->e_max < r->size / 10;
}

/* Shorter steps would not help: rounding dominates, or the solution is not known more exactly. */
static bool is_over(const ll_work_precision *before, const ll_work_precision *r)
{
    bool unknown = r->status == LL_RUN_OK && isnan(r->e_max);
    return unknown ? isnan(before->e_max) && before->status == LL_RUN_OK
                   : r->e_max > before->e_max && before->e_max < 1e-9;
}

/* ---- a series, level by level ---- */

/* Settings of a series; of a fixed step as parts of the duration. */
typedef struct series_range {
    double first, factor, least;
} series_range;

static series_range range_of(const ll_ode_method *method, int64_t steps_max)
{
    if (method->adaptive)
        return (series_range){1e-2, 0.1, 0.9e-14};
    return (series_range){1.0 / 16, 0.5, 1.0 / (double)(steps_max > 0 ? steps_max : STEPS_MAX)};
}

int ll_work_precision_levels(const ll_ode_method *method, int64_t steps_max)
{
    series_range range = range_of(method, steps_max);
    int n = 0;
    for (double at = range.first; at >= range.least && n < LL_WORK_PRECISION_LEVELS_MAX; at *= range.factor)
        n++;
    return n;
}

struct ll_work_precision_run {
    series_workspace workspace;
    const ll_ode_method *method;
    double setting, factor;
    int left, count;
    ll_work_precision last;
};

ll_status ll_work_precision_start(const ll_work_precision_request *request, const ll_ode_method *method,
                                  ll_work_precision_run **run)
{
    ll_work_precision_run *r = *run = calloc(1, sizeof *r);
    if (!r)
        return ll_error(LL_NO_MEMORY, "out of memory: measuring a method");
    series_range range = range_of(method, request->steps_max);
    ll_status status = open_workspace(&r->workspace, request, method);
    r->method = method;
    r->setting = range.first * (method->adaptive ? 1 : r->workspace.duration);
    r->factor = range.factor;
    r->left = ll_work_precision_levels(method, request->steps_max);
    if (ll_failed(&status)) {
        ll_work_precision_end(r);
        *run = NULL;
    }
    return status;
}

bool ll_work_precision_next(ll_work_precision_run *r, ll_work_precision *level, ll_status *status)
{
    if (r->left == 0)
        return false;
    *status = refinement_level(&r->workspace, r->method, r->setting, level);
    if (ll_failed(status))
        return false;
    if (r->count > 0 && is_well_known(level) && is_well_known(&r->last))
        level->order = log(level->e_max / r->last.e_max) / log(r->factor);
    r->count++;
    r->left--;
    if (r->count > 2 && !r->method->adaptive && is_over(&r->last, level))
        r->left = 0;
    r->setting *= r->factor;
    r->last = *level;
    return true;
}

void ll_work_precision_end(ll_work_precision_run *r)
{
    if (r)
        close_workspace(&r->workspace);
    free(r);
}

ll_status ll_work_precision_series(const ll_work_precision_request *request, const ll_ode_method *method,
                                   ll_work_precision *refinement_levels, int *count)
{
    ll_work_precision_run *run;
    ll_status status = ll_work_precision_start(request, method, &run);
    *count = 0;
    while (!ll_failed(&status) && ll_work_precision_next(run, &refinement_levels[*count], &status))
        ++*count;
    ll_work_precision_end(run);
    return status;
}

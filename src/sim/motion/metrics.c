/* Metrics of a motion: of the solution, and the errors, drifts and counters of each method. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/run_status.h"
#include "ode/core/single.h"
#include "record/metric.h"
#include "sim/motion/motion.h"

ll_run_status ll_motion_status(const ll_motion *m, int i)
{
    return m->config.methods[i].shown ? ll_ode_run_status(ll_motion_run(m, i)) : LL_RUN_OFF;
}

#define METHODS "methods.*"
#define NOT_OK "The status of the method is not ok."
#define OFF "The method was not run."

/* ---- the problem ---- */

#define PROBLEM(X)                                                                                           \
    X(text, problem, NULL, ll_motion_problem(&m->config)->name, "name of the problem that is integrated",    \
      NULL)                                                                                                  \
    X(text, solution_by, NULL, m->formula ? "formula" : "integration",                                       \
      "source of the solution: `formula`, or `integration` at a tolerance of 1e-14", NULL)                   \
    X(number, solution_uncertainty_max, NULL, m->uncertainty.by.error_max,                                   \
      "largest difference of two reference solutions by different methods; 0 of a formula",                  \
      "The difference is not finite.")                                                                       \
    X(number, predictable_until_s, "s", m->uncertainty.parted ? m->uncertainty.predictable_s : NAN,          \
      "last time before the two reference solutions differ by more than a thousandth of the solution's "     \
      "size",                                                                                                \
      "The reference solutions do not differ by more than that.")

#define NOTICES(X)                                                                                           \
    X(notices, notices, NULL, , "sentences that say why errors of methods with the status ok are null", NULL)

static const ll_metric_table notice_table = {
    .path = "", .help = "Notices about the metrics.", LL_METRICS_FROM(NOTICES)};
static const ll_metric_table problem_table = {
    .path = "", .help = "The problem and its solution.", LL_METRICS_FROM(PROBLEM)};

/* ---- a method ---- */

#define METHOD(X) X(text, method, NULL, method->name, "name of the method", NULL)
#define TOLERANCE(X)                                                                                         \
    X(number, tolerance, NULL, m->config.methods[i].tolerance, "tolerance: wanted local error of a step",    \
      NULL)
#define STEP(X) X(number, dt_s, "s", m->config.methods[i].dt_s, "time step of the method", NULL)
#define STATUS(X)                                                                                            \
    X(text, status, NULL, ll_run_status_names[status],                                                       \
      "ok; diverged: a value is not finite, or the run has blown up; failed: the method gave up (the "       \
      "equations of an implicit step have no solution, or the tolerance needs too small steps), or the "     \
      "steps do not resolve a stiff problem; off: the method was not run",                                   \
      NULL)                                                                                                  \
    X(text, reason, NULL, status == LL_RUN_OK ? NULL : reason, "reason for a status other than ok",          \
      "The status is ok: the reason is left out.")
#define FAILURE(X)                                                                                           \
    X(number, diverged_t_s, "s", run->failed_t, "time at which the method diverged or failed", NULL)
#define AT(X)                                                                                                \
    X(signed_number, t_s, "s", status == LL_RUN_OFF ? NAN : ll_motion_time(m, i),                            \
      "time that the method has reached", OFF)                                                               \
    X(numbers, state, NULL, ll_metric_numbers(status == LL_RUN_OK ? ll_ode_y(run) : NULL, m->dim),           \
      "state of the method at the time t_s, positions first", NOT_OK)                                        \
    X(numbers, solution, NULL, ll_metric_numbers(ll_motion_vector(m, m->at[i].wanted), m->dim),              \
      "solution at the time t_s, positions first", "The solution is not finite.")

static const ll_metric_table method_table = {.path = METHODS, .help = "The method.", LL_METRICS_FROM(METHOD)};
static const ll_metric_table tolerance_table = {.path = METHODS,
                                                .when = "Only of methods with an adaptive step.",
                                                .help = "The tolerance of the method.",
                                                LL_METRICS_FROM(TOLERANCE)};
static const ll_metric_table step_table = {.path = METHODS,
                                           .when = "Only of methods with a fixed step.",
                                           .help = "The step of the method.",
                                           LL_METRICS_FROM(STEP)};
static const ll_metric_table status_table = {
    .path = METHODS, .help = "Result of the method's run.", LL_METRICS_FROM(STATUS)};
static const ll_metric_table failure_table = {.path = METHODS,
                                              .when = "Only of methods that diverged or failed.",
                                              .help = "Time of the failure.",
                                              LL_METRICS_FROM(FAILURE)};
static const ll_metric_table at_table = {
    .path = METHODS, .help = "State of the method, and the solution at the same time.", LL_METRICS_FROM(AT)};

/* ---- errors of a method ---- */

#define NOT_ABOVE NOT_OK " Or the error is not above the uncertainty of the solution."
#define PARTED " Or the problem was no longer predictable at the end."

#define ERRORS(X)                                                                                            \
    X(number, e_final, NULL, last *above(r->error, d->error),                                                \
      "error at the end: Euclidean distance of the state from the solution", NOT_ABOVE PARTED)               \
    X(number, e_max, NULL, known *above(r->error_max, d->error_max),                                         \
      "largest error: Euclidean distance of the state from the solution", NOT_ABOVE)                         \
    X(number, e_l2, NULL, known *above(ll_ode_measure_rms(r), ll_ode_measure_rms(d)),                        \
      "root mean square of the error over time; the error is the Euclidean distance of the state from the "  \
      "solution",                                                                                            \
      NOT_ABOVE)                                                                                             \
    X(number, e_final_weighted, NULL, last *weighted(m, i, LL_ODE_LAST),                                     \
      "error at the end of the worst component, each divided by its scale: its largest magnitude in the "    \
      "solution. All positions share one scale, and so do all velocities; in a problem without them each "   \
      "component has its own",                                                                               \
      NOT_ABOVE PARTED)                                                                                      \
    X(number, e_max_weighted, NULL, known *weighted(m, i, LL_ODE_MOST),                                      \
      "largest error of the worst component, each divided by its scale in the solution", NOT_ABOVE)          \
    X(number, e_l2_weighted, NULL, known *weighted(m, i, LL_ODE_SQUARES),                                    \
      "root mean square error over time of the worst component, each divided by its scale in the solution",  \
      NOT_ABOVE)

#define ENERGY(X)                                                                                            \
    X(signed_number, energy_drift_final, NULL, known *ll_ode_measure_relative(r, r->drift),                  \
      "energy drift at the end: change of the energy, relative to the energy at the start; where that is "   \
      "nearly 0, relative to the largest total, kinetic or potential energy of the solution",                \
      NOT_OK)                                                                                                \
    X(number, energy_drift_max, NULL, known *ll_ode_measure_relative(r, r->drift_max),                       \
      "largest magnitude of the relative energy drift", NOT_OK)                                              \
    X(signed_number, energy_drift_per_s, "1/s", known *ll_ode_measure_slope(r),                              \
      "secular drift: slope of the relative energy drift over time, by least squares", NOT_OK)

static const ll_metric_table error_table = {
    .path = METHODS,
    .help = "Errors of the method, measured at the end of every step, and at three times within it where the "
            "method has dense output.",
    LL_METRICS_FROM(ERRORS)};
static const ll_metric_table energy_table = {
    .path = METHODS,
    .when = "Only of problems that conserve energy.",
    .help = "Energy drift of the method, measured at the end of every step.",
    LL_METRICS_FROM(ENERGY)};

/* An error not above the uncertainty of the solution is unknown. */
static double above(double error, double uncertainty)
{
    return uncertainty == 0 || error > uncertainty ? error : NAN;
}

static double weighted(const ll_motion *m, int i, int row)
{
    const double *each = ll_motion_vector(m, m->at[i].each),
                 *doubts = ll_motion_vector(m, m->uncertainty_each);
    ll_motion_config copy = m->config;
    ll_ode ode = ll_motion_system(&copy);
    return above(ll_ode_measure_weighted(&m->measure[i], each, &ode, row),
                 ll_ode_measure_weighted(&m->uncertainty.by, doubts, &ode, row));
}

/* Null if it has failed or was not run: earlier measures do not describe the whole run. */
static void measures(cJSON *o, const ll_motion *m, int i, ll_run_status status)
{
    const ll_ode_measure *r = &m->measure[i], *d = &m->uncertainty.by;
    double known = status == LL_RUN_OK ? 1 : NAN, last = m->uncertainty.parted ? NAN : known;
    LL_METRICS_PUT(o, &error_table, ERRORS);
    if (ll_motion_problem(&m->config)->energy)
        LL_METRICS_PUT(o, &energy_table, ENERGY);
}

/* ---- time stepping and counters of a method ---- */

#define STEPS_BY(X)                                                                                          \
    X(text, steps_by, NULL, ll_motion_step_names[method->steps],                                             \
      "time stepping of the method: `frame` or `accumulator`", NULL)                                         \
    X(count, frames, NULL, m->drive[i].frames, "frames that have passed", NULL)
#define CLOCK(X)                                                                                             \
    X(signed_number, clock_error_s, "s", ll_motion_clock_error(m, i),                                        \
      "time by the method's clock less the exact time", "The time is not finite.")
#define ORIGIN(X)                                                                                            \
    X(number, ulp_m, "m", ll_single_spacing((float)method->origin_offset_m),                                 \
      "distance of neighbouring single-precision numbers at origin_offset_m", NULL)
#define COUNTERS(X)                                                                                          \
    X(count, evaluations, NULL, ran *(double)(before->evaluations + c->evaluations),                         \
      "evaluations of the derivative", OFF)                                                                  \
    X(count, steps, NULL, ran *(double)(before->steps + c->steps), "accepted steps", OFF)                    \
    X(count, rejected, NULL, ran *(double)(before->rejected + c->rejected),                                  \
      "rejected steps, which were repeated with a shorter step", OFF)                                        \
    X(count, jacobians, NULL, ran *(double)(before->jacobians + c->jacobians),                               \
      "Jacobians that were computed", OFF)                                                                   \
    X(count, factorisations, NULL, ran *(double)(before->factorisations + c->factorisations),                \
      "factorisations of matrices", OFF)                                                                     \
    X(count, events, NULL, ran *(double)(before->events + c->events),                                        \
      "events: jumps of the state, such as the impact of a ball", OFF)

static const ll_metric_table steps_by_table = {.path = METHODS,
                                               .when =
                                                   "Only of methods with steps by frames or an accumulator.",
                                               .help = "Time stepping of the method.",
                                               LL_METRICS_FROM(STEPS_BY)};
static const ll_metric_table clock_table = {.path = METHODS,
                                            .when = "Only of methods whose clock is not exact.",
                                            .help = "Clock of the method.",
                                            LL_METRICS_FROM(CLOCK)};
static const ll_metric_table origin_table = {.path = METHODS,
                                             .when = "Only of methods with an origin_offset_m.",
                                             .help = "Resolution of positions.",
                                             LL_METRICS_FROM(ORIGIN)};
static const ll_metric_table counter_table = {.path = METHODS,
                                              .help =
                                                  "Cost counters of the method: of both directions if the "
                                                  "run is reversed; of a method that failed, until then.",
                                              LL_METRICS_FROM(COUNTERS)};

/* Effects of its time stepping. */
static void drive(cJSON *o, const ll_motion *m, int i)
{
    const ll_motion_method *method = &m->config.methods[i];
    if (method->steps != LL_MOTION_FIXED)
        LL_METRICS_PUT(o, &steps_by_table, STEPS_BY);
    if (method->clock != LL_MOTION_EXACT)
        LL_METRICS_PUT(o, &clock_table, CLOCK);
    if (method->origin_offset_m > 0)
        LL_METRICS_PUT(o, &origin_table, ORIGIN);
}

/* Of both directions; after a failure, the counts until then. */
static void counters(cJSON *o, const ll_motion *m, int i, ll_run_status status)
{
    const ll_ode_counters *c = &ll_motion_run(m, i)->counters, *before = &m->drive[i].before;
    double ran = status == LL_RUN_OFF ? NAN : 1;
    LL_METRICS_PUT(o, &counter_table, COUNTERS);
}

/* ---- metrics of a run ---- */

static cJSON *method_metrics(const ll_motion *m, int i)
{
    const ll_ode_method *method = ll_motion_method_of(&m->config, i);
    const ll_ode_run *run = ll_motion_run(m, i);
    ll_run_status status = ll_motion_status(m, i);
    char reason[160] = "It was not run: shown is off.";
    cJSON *o = cJSON_CreateObject();
    if (status != LL_RUN_OK && status != LL_RUN_OFF)
        ll_ode_reason_text(run, reason, sizeof reason);
    LL_METRICS_PUT(o, &method_table, METHOD);
    if (method->adaptive)
        LL_METRICS_PUT(o, &tolerance_table, TOLERANCE);
    else
        LL_METRICS_PUT(o, &step_table, STEP);
    LL_METRICS_PUT(o, &status_table, STATUS);
    if (status != LL_RUN_OK && status != LL_RUN_OFF)
        LL_METRICS_PUT(o, &failure_table, FAILURE);
    LL_METRICS_PUT(o, &at_table, AT);
    measures(o, m, i, status);
    drive(o, m, i);
    counters(o, m, i, status);
    return o;
}

/* Why errors are null after a run without failure. */
static void add_notices(cJSON *metrics, const ll_motion *m)
{
    cJSON *notices = cJSON_AddArrayToObject(metrics, "notices");
    char text[240];
    if (m->uncertainty.parted) {
        snprintf(text, sizeof text,
                 "The solution is known until predictable_until_s, %.6g s, only: e_final is null, e_max and "
                 "e_l2 are of the time before.",
                 m->uncertainty.predictable_s);
        cJSON_AddItemToArray(notices, cJSON_CreateString(text));
    }
    for (int i = 0; i < m->config.method_count; i++) {
        if (ll_motion_status(m, i) != LL_RUN_OK ||
            !isnan(above(m->measure[i].error_max, m->uncertainty.by.error_max)))
            continue;
        snprintf(text, sizeof text,
                 "methods.%d, %s, is nearer to the solution than its uncertainty, "
                 "solution_uncertainty_max = %.3g: such errors are null.",
                 i, ll_motion_method_of(&m->config, i)->name, m->uncertainty.by.error_max);
        cJSON_AddItemToArray(notices, cJSON_CreateString(text));
    }
}

cJSON *ll_motion_metrics(const void *block)
{
    const ll_motion *m = block;
    cJSON *metrics = cJSON_CreateObject(), *methods;
    LL_METRICS_PUT(metrics, &problem_table, PROBLEM);
    methods = cJSON_AddArrayToObject(metrics, "methods");
    for (int i = 0; i < m->config.method_count; i++)
        cJSON_AddItemToArray(methods, method_metrics(m, i));
    add_notices(metrics, m);
    return metrics;
}

/* ---- processor time, measured after a run ---- */

#define TIMES(X)                                                                                             \
    X(number, ns_per_sim_s, "ns/s", ns,                                                                      \
      "processor time of the method alone, per simulated second; the least of five runs", NOT_OK)

static const ll_metric_table time_table = {.path = METHODS,
                                           .when = "Only in the output of `laglab run`, of methods that were "
                                                   "run: a daemon would have to run the scenario again.",
                                           .help = "Processor time of the method.",
                                           LL_METRICS_FROM(TIMES)};

enum { REPEATS = 5 };

/* The minimum of several runs: the rest is not the method's cost. 0: out of memory. */
static double cost_of(ll_motion_config *c, int i, int64_t (*now_ns)(void))
{
    const ll_ode_method *method = ll_motion_method_of(c, i);
    ll_ode ode = ll_motion_system(c);
    ll_ode_control control = ll_motion_control(c, i);
    ll_ode_run *run = malloc(ll_ode_run_size(method, &ode));
    double y0[LL_ODE_DIM_MAX];
    int64_t least = INT64_MAX;
    ll_motion_problem(c)->start(c->params, y0);
    for (int n = 0; run && n < REPEATS; n++) {
        int64_t from = now_ns();
        ll_ode_start(run, method, &ode, &control, y0);
        ll_ode_advance(run, method, &ode, control.t_end);
        int64_t took = now_ns() - from;
        least = took < least ? took : least;
    }
    free(run);
    return run ? (double)least / control.t_end : 0;
}

void ll_motion_time_parts(const void *config, cJSON *metrics, int64_t (*now_ns)(void))
{
    ll_motion_config c = *(const ll_motion_config *)config;
    cJSON *methods = cJSON_GetObjectItemCaseSensitive(metrics, "methods");
    for (int i = 0; i < c.method_count; i++) {
        cJSON *o = cJSON_GetArrayItem(methods, i);
        const cJSON *status = cJSON_GetObjectItemCaseSensitive(o, "status");
        bool ok = strcmp(status->valuestring, ll_run_status_names[LL_RUN_OK]) == 0;
        double ns = ok ? cost_of(&c, i, now_ns) : NAN;
        if (c.methods[i].shown)
            LL_METRICS_PUT(o, &time_table, TIMES);
    }
}

const ll_metric_table *const ll_motion_metric_tables[] = {
    &problem_table, &method_table, &tolerance_table, &step_table,  &status_table, &failure_table, &at_table,
    &error_table,   &energy_table, &steps_by_table,  &clock_table, &origin_table, &counter_table, &time_table,
    &notice_table,  NULL};

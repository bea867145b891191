/* The metrics of a motion: the solution, and of each method its errors, drifts and counts. */
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
#define NOT_OK "Its status is not ok."
#define OFF "It was not run."

/* ---- the problem ---- */

#define PROBLEM(X)                                                                                           \
    X(text, problem, NULL, ll_motion_problem(&m->config)->name, "what is integrated", NULL)                  \
    X(text, solution_by, NULL, m->formula ? "formula" : "integration",                                       \
      "formula, or integration at a tolerance of 1e-14", NULL)                                               \
    X(number, solution_uncertainty_max, NULL, m->uncertainty.by.error_max,                                   \
      "the most that two references by different methods differed by; 0 of a formula", "It is not finite.")  \
    X(number, predictable_until_s, "s", m->uncertainty.parted ? m->uncertainty.predictable_s : NAN,          \
      "the last time before they differ by more than a thousandth of the solution's size", "They do not.")

#define NOTICES(X) X(notices, notices, NULL, , "why errors of what ended well are null", NULL)

static const ll_metric_table notice_table = {
    .path = "", .help = "What to know of it.", LL_METRICS_FROM(NOTICES)};
static const ll_metric_table problem_table = {
    .path = "", .help = "The problem and its solution.", LL_METRICS_FROM(PROBLEM)};

/* ---- a method ---- */

#define METHOD(X) X(text, method, NULL, method->name, "the integrator", NULL)
#define TOLERANCE(X) X(number, tolerance, NULL, m->config.methods[i].tolerance, "of its steps", NULL)
#define STEP(X) X(number, dt_s, "s", m->config.methods[i].dt_s, "its step", NULL)
#define STATUS(X)                                                                                            \
    X(text, status, NULL, ll_run_status_names[status],                                                       \
      "ok; diverged: a value was not finite, or it blew up; failed: it gave up, as where the equations of "  \
      "an implicit step have no solution or a tolerance asks for steps too small, or its steps do not "      \
      "resolve a stiff problem; off: it was not run",                                                        \
      NULL)                                                                                                  \
    X(text, reason, NULL, status == LL_RUN_OK ? NULL : reason, "why it is not ok", "It is ok: left out.")
#define FAILURE(X) X(number, diverged_t_s, "s", run->failed_t, "when", NULL)
#define AT(X)                                                                                                \
    X(signed_number, t_s, "s", status == LL_RUN_OFF ? NAN : ll_motion_time(m, i), "the method's own time",   \
      OFF)                                                                                                   \
    X(numbers, state, NULL, ll_metric_numbers(status == LL_RUN_OK ? ll_ode_y(run) : NULL, m->dim),           \
      "its state there, positions first", NOT_OK)                                                            \
    X(numbers, solution, NULL, ll_metric_numbers(ll_motion_vector(m, m->at[i].wanted), m->dim),              \
      "the solution there", "It is not finite.")

static const ll_metric_table method_table = {.path = METHODS, .help = "What it is.", LL_METRICS_FROM(METHOD)};
static const ll_metric_table tolerance_table = {.path = METHODS,
                                                .when = "Of an adaptive method.",
                                                .help = "What it is asked for.",
                                                LL_METRICS_FROM(TOLERANCE)};
static const ll_metric_table step_table = {.path = METHODS,
                                           .when = "Of a method with fixed steps.",
                                           .help = "What it is asked for.",
                                           LL_METRICS_FROM(STEP)};
static const ll_metric_table status_table = {
    .path = METHODS, .help = "What has become of it.", LL_METRICS_FROM(STATUS)};
static const ll_metric_table failure_table = {
    .path = METHODS, .when = "It diverged or failed.", .help = "When it did.", LL_METRICS_FROM(FAILURE)};
static const ll_metric_table at_table = {.path = METHODS, .help = "Where it stands.", LL_METRICS_FROM(AT)};

/* ---- its errors ---- */

#define NOT_ABOVE NOT_OK " Or the error is not above what is not known of the solution."
#define PARTED " Or the problem was predictable no longer."

#define ERRORS(X)                                                                                            \
    X(number, e_final, NULL, last *above(r->error, d->error),                                                \
      "Euclidean distance from the solution at the end", NOT_ABOVE PARTED)                                   \
    X(number, e_max, NULL, known *above(r->error_max, d->error_max), "the largest", NOT_ABOVE)               \
    X(number, e_l2, NULL, known *above(ll_ode_measure_rms(r), ll_ode_measure_rms(d)),                        \
      "its root mean square over time", NOT_ABOVE)                                                           \
    X(number, e_final_weighted, NULL, last *weighted(m, i, LL_ODE_LAST),                                     \
      "at the end, of the component that is worst, each over its scale: the largest that it is in the "      \
      "solution. Positions share one, and so do velocities; where there are none each component has its "    \
      "own",                                                                                                 \
      NOT_ABOVE PARTED)                                                                                      \
    X(number, e_max_weighted, NULL, known *weighted(m, i, LL_ODE_MOST), "the largest of these", NOT_ABOVE)   \
    X(number, e_l2_weighted, NULL, known *weighted(m, i, LL_ODE_SQUARES),                                    \
      "their root mean square over time", NOT_ABOVE)

#define ENERGY(X)                                                                                            \
    X(signed_number, energy_drift_final, NULL, known *ll_ode_measure_relative(r, r->drift),                  \
      "change of the energy at the end over that at the start; where there is next to none at the start, "   \
      "over the largest total, kinetic or potential energy of the solution",                                 \
      NOT_OK)                                                                                                \
    X(number, energy_drift_max, NULL, known *ll_ode_measure_relative(r, r->drift_max), "the largest",        \
      NOT_OK)                                                                                                \
    X(signed_number, energy_drift_per_s, "1/s", known *ll_ode_measure_slope(r),                              \
      "its secular slope by least squares", NOT_OK)

static const ll_metric_table error_table = {.path = METHODS,
                                            .help = "Its errors, at the end of every step and three times "
                                                    "within it where the method has dense output.",
                                            LL_METRICS_FROM(ERRORS)};
static const ll_metric_table energy_table = {.path = METHODS,
                                             .when = "Energy is conserved.",
                                             .help = "The drift of its energy, at the end of every step.",
                                             LL_METRICS_FROM(ENERGY)};

/* An error that is not above what is not known of the solution is not known. */
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

/* Null where it has failed or was not run: what was measured before says nothing of the whole. */
static void measures(cJSON *o, const ll_motion *m, int i, ll_run_status status)
{
    const ll_ode_measure *r = &m->measure[i], *d = &m->uncertainty.by;
    double known = status == LL_RUN_OK ? 1 : NAN, last = m->uncertainty.parted ? NAN : known;
    LL_METRICS_PUT(o, &error_table, ERRORS);
    if (ll_motion_problem(&m->config)->energy)
        LL_METRICS_PUT(o, &energy_table, ENERGY);
}

/* ---- how it is driven, and what it took ---- */

#define STEPS_BY(X)                                                                                          \
    X(text, steps_by, NULL, ll_motion_step_names[method->steps], "what its steps come from", NULL)           \
    X(count, frames, NULL, m->drive[i].frames, "frames that have passed", NULL)
#define CLOCK(X)                                                                                             \
    X(signed_number, clock_error_s, "s", ll_motion_clock_error(m, i), "what it shows less what it should",   \
      "It is not finite.")
#define ORIGIN(X)                                                                                            \
    X(number, ulp_m, "m", ll_single_spacing((float)method->origin_offset_m),                                 \
      "how far apart numbers are there", NULL)
#define COUNTERS(X)                                                                                          \
    X(count, evaluations, NULL, ran *(double)(before->evaluations + c->evaluations),                         \
      "of the right-hand side", OFF)                                                                         \
    X(count, steps, NULL, ran *(double)(before->steps + c->steps), "that were made", OFF)                    \
    X(count, rejected, NULL, ran *(double)(before->rejected + c->rejected),                                  \
      "steps that were made again, shorter", OFF)                                                            \
    X(count, jacobians, NULL, ran *(double)(before->jacobians + c->jacobians), "Jacobian matrices", OFF)     \
    X(count, factorisations, NULL, ran *(double)(before->factorisations + c->factorisations), "of matrices", \
      OFF)                                                                                                   \
    X(count, events, NULL, ran *(double)(before->events + c->events),                                        \
      "jumps of the state, as of a ball that bounces", OFF)

static const ll_metric_table steps_by_table = {
    .path = METHODS, .when = "Its steps are not fixed.", .help = "Its frames.", LL_METRICS_FROM(STEPS_BY)};
static const ll_metric_table clock_table = {
    .path = METHODS, .when = "Its clock is not exact.", .help = "Its clock.", LL_METRICS_FROM(CLOCK)};
static const ll_metric_table origin_table = {
    .path = METHODS, .when = "With an origin_offset_m.", .help = "Its numbers.", LL_METRICS_FROM(ORIGIN)};
static const ll_metric_table counter_table = {
    .path = METHODS,
    .help = "What it took: of both ways where it turns; of one that failed, until then.",
    LL_METRICS_FROM(COUNTERS)};

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

static void counters(cJSON *o, const ll_motion *m, int i, ll_run_status status)
{
    const ll_ode_counters *c = &ll_motion_run(m, i)->counters, *before = &m->drive[i].before;
    double ran = status == LL_RUN_OFF ? NAN : 1;
    LL_METRICS_PUT(o, &counter_table, COUNTERS);
}

/* ---- all of it ---- */

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

/* Why errors of what ended well are null. */
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

/* ---- what is timed after a run ---- */

#define TIMES(X)                                                                                             \
    X(number, ns_per_sim_s, "ns/s", ns,                                                                      \
      "processor time of the method alone, per simulated second, the least of five runs", NOT_OK)

static const ll_metric_table time_table = {
    .path = METHODS,
    .when = "Of laglab run, of a method that was run: a daemon would have to run the scenario again for it.",
    .help = "What it costs.",
    LL_METRICS_FROM(TIMES)};

enum { REPEATS = 5 };

/* The least of a few runs: what is above it is not the method's. 0 without memory. */
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

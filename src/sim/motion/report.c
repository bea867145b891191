/* Reports and streamed rows of a motion: state, metrics, layout, trace and sections. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/run_status.h"
#include "ode/core/paper.h"
#include "ode/core/single.h"
#include "sim/motion/motion.h"

/* JSON has no infinity: a value beyond all bounds is null. */
static cJSON *number_json(double value)
{
    return value - value == 0 ? ll_param_number(value) : cJSON_CreateNull();
}

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddItemToObject(object, name, number_json(value));
}

/* NULL gives nulls. */
static cJSON *vector_json(const double *y, int dim)
{
    cJSON *array = cJSON_CreateArray();
    for (int i = 0; i < dim; i++)
        cJSON_AddItemToArray(array, number_json(y != NULL ? y[i] : NAN));
    return array;
}

/* ---- status of a method ---- */

static ll_run_status status_of(const ll_motion *m, int i)
{
    return m->config.methods[i].shown ? ll_ode_run_status(ll_motion_run(m, i)) : LL_RUN_OFF;
}

/* ---- state ---- */

cJSON *ll_motion_state(const void *block)
{
    const ll_motion *m = block;
    cJSON *state = cJSON_CreateObject(), *methods;
    cJSON_AddItemToObject(state, "solution", vector_json(ll_motion_vector(m, m->solution), m->dim));
    methods = cJSON_AddArrayToObject(state, "methods");
    for (int i = 0; i < m->config.method_count; i++) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "method", ll_motion_method_of(&m->config, i)->name);
        cJSON_AddStringToObject(o, "status", ll_run_status_names[status_of(m, i)]);
        number(o, "t_s", ll_motion_time(m, i));
        cJSON_AddItemToObject(o, "state", vector_json(ll_ode_y(ll_motion_run(m, i)), m->dim));
        cJSON_AddItemToArray(methods, o);
    }
    return state;
}

/* ---- metrics ---- */

const char *const ll_motion_signed_metrics[] = {"energy_drift_final", "energy_drift_per_s", "clock_error_s",
                                                "t_s", NULL};

/* An error not above the uncertainty of the solution is unknown. */
static double above(double error, double uncertainty)
{
    return uncertainty == 0 || error > uncertainty ? error : NAN;
}

/* The Euclidean errors and the weighted ones. */
static void errors(cJSON *o, const ll_motion *m, int i, double known)
{
    static const struct {
        const char *name;
        int row;
    } weighted[] = {{"e_final_weighted", LL_ODE_LAST},
                    {"e_max_weighted", LL_ODE_MOST},
                    {"e_l2_weighted", LL_ODE_SQUARES}};
    const ll_ode_measure *r = &m->measure[i], *d = &m->uncertainty.by;
    const double *each = ll_motion_vector(m, m->at[i].each),
                 *doubts = ll_motion_vector(m, m->uncertainty_each);
    double last = m->uncertainty.parted ? NAN : known;
    ll_motion_config copy = m->config;
    ll_ode ode = ll_motion_system(&copy);
    number(o, "e_final", last * above(r->error, d->error));
    number(o, "e_max", known * above(r->error_max, d->error_max));
    number(o, "e_l2", known * above(ll_ode_measure_rms(r), ll_ode_measure_rms(d)));
    for (int k = 0; k < 3; k++)
        number(o, weighted[k].name,
               (weighted[k].row == LL_ODE_LAST ? last : known) *
                   above(ll_ode_measure_weighted(r, each, &ode, weighted[k].row),
                         ll_ode_measure_weighted(d, doubts, &ode, weighted[k].row)));
}

/* Null if it has failed or was not run: earlier measures do not describe the whole run. */
static void measures(cJSON *o, const ll_motion *m, int i, ll_run_status status)
{
    const ll_ode_measure *r = &m->measure[i];
    double known = status == LL_RUN_OK ? 1 : NAN;
    errors(o, m, i, known);
    if (!ll_motion_problem(&m->config)->energy)
        return;
    number(o, "energy_drift_final", known * ll_ode_measure_relative(r, r->drift));
    number(o, "energy_drift_max", known * ll_ode_measure_relative(r, r->drift_max));
    number(o, "energy_drift_per_s", known * ll_ode_measure_slope(r));
}

/* Of both directions; after a failure, the counts until then. */
static void counters(cJSON *o, const ll_motion *m, int i, ll_run_status status)
{
    const ll_ode_counters *c = &ll_motion_run(m, i)->counters, *before = &m->drive[i].before;
    const struct {
        const char *name;
        int64_t count;
    } all[] = {{"evaluations", before->evaluations + c->evaluations},
               {"steps", before->steps + c->steps},
               {"rejected", before->rejected + c->rejected},
               {"jacobians", before->jacobians + c->jacobians},
               {"factorisations", before->factorisations + c->factorisations},
               {"events", before->events + c->events}};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        number(o, all[k].name, status == LL_RUN_OFF ? NAN : (double)all[k].count);
}

/* Effects of its time stepping. */
static void drive(cJSON *o, const ll_motion *m, int i)
{
    const ll_motion_method *method = &m->config.methods[i];
    if (method->steps != LL_MOTION_FIXED) {
        cJSON_AddStringToObject(o, "steps_by", ll_motion_step_names[method->steps]);
        number(o, "frames", (double)m->drive[i].frames);
    }
    if (method->clock != LL_MOTION_EXACT)
        number(o, "clock_error_s", ll_motion_clock_error(m, i));
    if (method->origin_offset_m > 0)
        number(o, "ulp_m", (double)ll_single_spacing((float)method->origin_offset_m));
}

/* Why it is not ok, and when it failed. */
static void failure(cJSON *o, const ll_ode_run *run, ll_run_status status)
{
    char reason[160] = "It was not run: shown is off.";
    if (status == LL_RUN_OK)
        return;
    if (status != LL_RUN_OFF)
        ll_ode_reason_text(run, reason, sizeof reason);
    cJSON_AddStringToObject(o, "reason", reason);
    if (status != LL_RUN_OFF)
        number(o, "diverged_t_s", run->failed_t);
}

static cJSON *method_metrics(const ll_motion *m, int i)
{
    const ll_ode_method *method = ll_motion_method_of(&m->config, i);
    const ll_ode_run *run = ll_motion_run(m, i);
    cJSON *o = cJSON_CreateObject();
    ll_run_status status = status_of(m, i);
    cJSON_AddStringToObject(o, "method", method->name);
    if (method->adaptive)
        number(o, "tolerance", m->config.methods[i].tolerance);
    else
        number(o, "dt_s", m->config.methods[i].dt_s);
    cJSON_AddStringToObject(o, "status", ll_run_status_names[status]);
    failure(o, run, status);
    number(o, "t_s", status == LL_RUN_OFF ? NAN : ll_motion_time(m, i));
    cJSON_AddItemToObject(o, "state", vector_json(status == LL_RUN_OK ? ll_ode_y(run) : NULL, m->dim));
    cJSON_AddItemToObject(o, "solution", vector_json(ll_motion_vector(m, m->at[i].wanted), m->dim));
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
        if (status_of(m, i) != LL_RUN_OK ||
            !isnan(above(m->measure[i].error_max, m->uncertainty.by.error_max)))
            continue;
        snprintf(text, sizeof text,
                 "methods.%d, %s, is nearer to the solution than its uncertainty, solution_uncertainty_max = "
                 "%.3g: such errors are null.",
                 i, ll_motion_method_of(&m->config, i)->name, m->uncertainty.by.error_max);
        cJSON_AddItemToArray(notices, cJSON_CreateString(text));
    }
}

cJSON *ll_motion_metrics(const void *block)
{
    const ll_motion *m = block;
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    cJSON *metrics = cJSON_CreateObject();
    cJSON_AddStringToObject(metrics, "problem", problem->name);
    cJSON_AddStringToObject(metrics, "solution_by", m->formula ? "formula" : "integration");
    number(metrics, "solution_uncertainty_max", m->uncertainty.by.error_max);
    number(metrics, "predictable_until_s", m->uncertainty.parted ? m->uncertainty.predictable_s : NAN);
    cJSON *methods = cJSON_AddArrayToObject(metrics, "methods");
    for (int i = 0; i < m->config.method_count; i++)
        cJSON_AddItemToArray(methods, method_metrics(m, i));
    add_notices(metrics, m);
    return metrics;
}

/* ---- cost ---- */

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
        if (c.methods[i].shown)
            number(o, "ns_per_sim_s",
                   strcmp(status->valuestring, ll_run_status_names[LL_RUN_OK]) == 0 ? cost_of(&c, i, now_ns)
                                                                                    : NAN);
    }
}

/* ---- the paper's text ---- */

static bool is_listing(const ll_motion_config *c, int i)
{
    return strcmp(ll_motion_problem(c)->name, "free_fall") == 0 && c->methods[i].shown &&
           strcmp(ll_motion_method_of(c, i)->name, "semi_implicit_euler") == 0;
}

/* The lines that the paper's program prints for each step of its method, a blank line between. */
ll_status ll_motion_text(const void *config, void (*write)(void *context, const char *text, size_t length),
                         void *context)
{
    ll_motion_config c = *(const ll_motion_config *)config;
    double start[LL_ODE_DIM_MAX], slope[LL_ODE_DIM_MAX];
    char line[160];
    int listings = 0;
    ll_ode ode = ll_motion_system(&c);
    ll_motion_problem(&c)->start(c.params, start);
    ll_ode_eval(&ode, 0, start, slope);
    for (int i = 0; i < c.method_count; i++) {
        if (!is_listing(&c, i))
            continue;
        ll_ode_listing listing = {.dt = (float)c.methods[i].dt_s,
                                  .acceleration = (float)slope[1],
                                  .displacement = (float)start[0],
                                  .velocity = (float)start[1]};
        if (listings++ > 0)
            write(context, "\n", 1);
        while (ll_ode_listing_next(&listing, c.head.duration_s, line, sizeof line))
            write(context, line, strlen(line));
    }
    if (listings == 0)
        return ll_error(LL_BAD_INPUT,
                        "the paper prints lines of free_fall with semi_implicit_euler; this is %s with %s",
                        ll_motion_problem(&c)->name, ll_motion_method_of(&c, 0)->name);
    return ll_ok();
}

/* ---- layout ---- */

cJSON *ll_motion_layout(const void *config)
{
    ll_motion_config c = *(const ll_motion_config *)config;
    const ll_ode_problem *problem = ll_motion_problem(&c);
    ll_ode ode = ll_motion_system(&c);
    cJSON *layout = cJSON_CreateObject();
    cJSON_AddStringToObject(layout, "problem", problem->name);
    cJSON_AddStringToObject(layout, "help", problem->help);
    cJSON_AddBoolToObject(layout, "mechanical", ll_ode_mechanical(&ode));
    cJSON_AddBoolToObject(layout, "energy", problem->energy != NULL);
    cJSON *components = cJSON_AddArrayToObject(layout, "components"),
          *methods = cJSON_AddArrayToObject(layout, "methods");
    for (int i = 0; i < ode.dim; i++)
        cJSON_AddItemToArray(components, cJSON_CreateString(problem->components[i]));
    for (int i = 0; ll_ode_methods[i]; i++) {
        const ll_ode_method *method = ll_ode_methods[i];
        ll_status fits = ll_ode_method_fits(method, &ode);
        if (ll_failed(&fits))
            continue;
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "method", method->name);
        cJSON_AddNumberToObject(o, "order", ll_ode_order(method, &ode));
        cJSON_AddBoolToObject(o, "adaptive", method->adaptive);
        cJSON_AddItemToArray(methods, o);
    }
    return layout;
}

/* ---- trace ---- */

enum { TRACED = 8 /* components */ };

static int traced(int dim)
{
    return dim < TRACED ? dim : TRACED;
}

int ll_motion_trace_columns(const void *config, char (*names)[48], int capacity)
{
    ll_motion_config c = *(const ll_motion_config *)config;
    const ll_ode_problem *problem = ll_motion_problem(&c);
    int dim = ll_motion_system(&c).dim, n = 0;
    if (capacity < traced(dim) + c.method_count * (traced(dim) + 2))
        return 0;
    for (int k = 0; k < traced(dim); k++)
        snprintf(names[n++], 48, "solution_%s", problem->components[k]);
    for (int i = 0; i < c.method_count; i++) {
        for (int k = 0; k < traced(dim); k++)
            snprintf(names[n++], 48, "%d_%s", i, problem->components[k]);
        snprintf(names[n++], 48, "%d_error", i);
        snprintf(names[n++], 48, "%d_energy_drift", i);
    }
    return n;
}

int ll_motion_trace_row(const void *block, double *values, int capacity)
{
    const ll_motion *m = block;
    int n = 0;
    if (capacity < traced(m->dim) + m->config.method_count * (traced(m->dim) + 2))
        return 0;
    for (int k = 0; k < traced(m->dim); k++)
        values[n++] = ll_motion_vector(m, m->solution)[k];
    for (int i = 0; i < m->config.method_count; i++) {
        for (int k = 0; k < traced(m->dim); k++)
            values[n++] = ll_motion_vector(m, m->at[i].shown)[k];
        values[n++] = m->measure[i].error;
        values[n++] = ll_ode_measure_relative(&m->measure[i], m->measure[i].drift);
    }
    return n;
}

/* ---- streamed ---- */

typedef struct motion_row {
    uint8_t status;
    double t_s, error, error_max, energy_drift, error_max_weighted;
    int64_t evaluations, steps, rejected;
} motion_row;

static const ll_record_field motion_fields[] = {
    LL_ENUM(motion_row, status, ll_run_status_names, "off: not run"),
    LL_REAL(motion_row, t_s, 32, "s", "time of the last step"),
    LL_REAL(motion_row, error, 23, NULL, "present distance from the solution"),
    LL_REAL(motion_row, error_max, 23, NULL, "largest error so far"),
    LL_REAL(motion_row, energy_drift, 23, NULL, "energy minus that of the start, relative to it"),
    LL_INT(motion_row, evaluations, NULL, "of the derivative"),
    LL_INT(motion_row, steps, NULL, "accepted steps"),
    LL_INT(motion_row, rejected, NULL, "rejected steps"),
    LL_REAL(motion_row, error_max_weighted, 23, NULL,
            "the largest error, each component relative to its size"),
};

static const ll_record motion_record = {.id = 16,
                                        .name = "motion",
                                        .channel = LL_CHANNEL_MOTION,
                                        .help = "The solution, then each method.",
                                        .form = LL_FORM_BY_INDEX,
                                        LL_ROWS_OF(motion_row, motion_fields)};

typedef struct motion_value {
    uint8_t motion, component;
    double value;
} motion_value;

static const ll_record_field value_fields[] = {
    LL_INT(motion_value, motion, NULL, "0: the solution; 1 + i: method i"),
    LL_INT(motion_value, component, NULL, "index of its name in the hello's layout"),
    LL_REAL(motion_value, value, 24, NULL, "the component of the state"),
};

static const ll_record value_record = {.id = 17,
                                       .name = "motion_state",
                                       .channel = LL_CHANNEL_MOTION,
                                       .help = "The components of their states.",
                                       .form = LL_FORM_BY_INDEX,
                                       LL_ROWS_OF(motion_value, value_fields)};

const ll_record *const ll_motion_records[] = {&motion_record, &value_record, NULL};

static motion_row row_of(const ll_motion *m, int i)
{
    const ll_ode_counters *c = &ll_motion_run(m, i)->counters, *before = &m->drive[i].before;
    const ll_ode_measure *r = &m->measure[i];
    ll_motion_config copy = m->config;
    ll_ode ode = ll_motion_system(&copy);
    return (motion_row){.status = (uint8_t)status_of(m, i),
                        .t_s = ll_motion_time(m, i),
                        .error = r->error,
                        .error_max = r->error_max,
                        .energy_drift = ll_ode_measure_relative(r, r->drift),
                        .error_max_weighted =
                            ll_ode_measure_weighted(r, ll_motion_vector(m, m->at[i].each), &ode, LL_ODE_MOST),
                        .evaluations = before->evaluations + c->evaluations,
                        .steps = before->steps + c->steps,
                        .rejected = before->rejected + c->rejected};
}

static void fill_state(const ll_motion *m, int place, const double *state, ll_row_set *rows)
{
    for (int k = 0; k < m->dim; k++) {
        motion_value value = {(uint8_t)place, (uint8_t)k, state[k]};
        ll_row_set_put(rows, &value_record, &value, 1);
    }
}

void ll_motion_fill(const void *block, ll_row_set *rows)
{
    const ll_motion *m = block;
    motion_row solution = {.t_s = ll_to_s(m->now)};
    if (!ll_row_set_wants(rows, &motion_record))
        return;
    ll_row_set_put(rows, &motion_record, &solution, 1);
    fill_state(m, 0, ll_motion_vector(m, m->solution), rows);
    for (int i = 0; i < m->config.method_count; i++) {
        motion_row row = row_of(m, i);
        ll_row_set_put(rows, &motion_record, &row, 1);
        fill_state(m, i + 1, ll_motion_vector(m, m->at[i].shown), rows);
    }
}

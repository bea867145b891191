/* Reports and streamed rows of a motion: state, layout, trace and sections. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/run_status.h"
#include "ode/core/single.h"
#include "record/integers.h"
#include "sim/motion/motion.h"

/* NULL gives nulls. */
static cJSON *vector_json(const double *y, int dim)
{
    cJSON *array = cJSON_CreateArray();
    for (int i = 0; i < dim; i++)
        cJSON_AddItemToArray(array, ll_param_number(y != NULL ? y[i] : NAN));
    return array;
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
        cJSON_AddStringToObject(o, "status", ll_run_status_names[ll_motion_status(m, i)]);
        cJSON_AddItemToObject(o, "t_s", ll_param_number(ll_motion_time(m, i)));
        cJSON_AddItemToObject(o, "state", vector_json(ll_ode_y(ll_motion_run(m, i)), m->dim));
        cJSON_AddItemToArray(methods, o);
    }
    return state;
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

#define VECTOR(values)                                                                                       \
    ((ll_metric_reading){.number = traced, .numbers = values, .names = problem->components})

#define SOLUTION_COLUMNS(X) X(by_name, component, NULL, VECTOR(solution), "a component of the solution", NULL)

#define METHOD_COLUMNS(X)                                                                                    \
    X(by_name, component, NULL, VECTOR(shown), "a component of the state", NULL)                             \
    X(number, error, NULL, measure->error, "distance of the state from the solution", NULL)                  \
    X(signed_number, energy_drift, NULL, ll_ode_measure_relative(measure, measure->drift),                   \
      "energy minus that of the start, relative to it; 0 if the problem has none", NULL)

static const ll_metric_table solution_columns = {
    .path = "solution_",
    .help = "The solution: a column for each of its first 8 components, by name.",
    LL_METRICS_FROM(SOLUTION_COLUMNS)};
static const ll_metric_table method_columns = {
    .path = "*_",
    .help = "A method: a column for each of the first 8 components, by name, and the others.",
    LL_METRICS_FROM(METHOD_COLUMNS)};

const ll_metric_table *const ll_motion_trace_tables[] = {&solution_columns, &method_columns, NULL};

void ll_motion_trace(const void *block, ll_trace_line *trace)
{
    const ll_motion *m = block;
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    const int traced = m->dim < TRACED ? m->dim : TRACED;
    const double *solution = ll_motion_vector(m, m->solution);
    LL_TRACE_PUT(trace, &solution_columns, 0, SOLUTION_COLUMNS);
    for (int i = 0; i < m->config.method_count; i++) {
        const double *shown = ll_motion_vector(m, m->at[i].shown);
        const ll_ode_measure *measure = &m->measure[i];
        LL_TRACE_PUT(trace, &method_columns, i, METHOD_COLUMNS);
    }
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

LL_INTEGERS(motion_integers, motion_row, motion_fields)

static const ll_record motion_record = {.id = 16,
                                        .name = "motion",
                                        .channel = LL_CHANNEL_MOTION,
                                        .help = "The solution, then each method.",
                                        .form = LL_FORM_BY_INDEX,
                                        LL_ROWS_OF(motion_row, motion_fields),
                                        .integers = motion_integers};

typedef struct motion_value {
    uint8_t motion, component;
    double value;
} motion_value;

static const ll_record_field value_fields[] = {
    LL_INT(motion_value, motion, NULL, "0: the solution; 1 + i: method i"),
    LL_INT(motion_value, component, NULL, "index of its name in the hello's layout"),
    LL_REAL(motion_value, value, 24, NULL, "the component of the state"),
};

LL_INTEGERS(value_integers, motion_value, value_fields)

static const ll_record value_record = {.id = 17,
                                       .name = "motion_state",
                                       .channel = LL_CHANNEL_MOTION,
                                       .help = "The components of their states.",
                                       .form = LL_FORM_BY_INDEX,
                                       LL_ROWS_OF(motion_value, value_fields),
                                       .integers = value_integers};

const ll_record *const ll_motion_records[] = {&motion_record, &value_record, NULL};

static motion_row row_of(const ll_motion *m, int i)
{
    const ll_ode_counters *c = &ll_motion_run(m, i)->counters, *before = &m->drive[i].before;
    const ll_ode_measure *r = &m->measure[i];
    ll_motion_config copy = m->config;
    ll_ode ode = ll_motion_system(&copy);
    return (motion_row){.status = (uint8_t)ll_motion_status(m, i),
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

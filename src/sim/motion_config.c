#include <stdio.h>
#include <string.h>

#include "ode/names.h"
#include "sim/kinds.h"
#include "sim/motion.h"

static const ll_param method_rows[] = {
    {.name = "method",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_motion_method, method),
     .choices = ll_ode_method_names,
     .required = true,
     .live = true,
     .help = "The integrator."},
    {.name = "dt_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_motion_method, dt_s),
     .min = 1e-9,
     .max = LL_DURATION_MAX_S,
     .standard = 0.01,
     .unit = "s",
     .live = true,
     .help = "Step of a method of fixed step."},
    {.name = "tolerance",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_motion_method, tolerance),
     .min = 1e-15,
     .max = 0.1,
     .standard = 1e-6,
     .live = true,
     .help = "Relative and absolute tolerance of an adaptive method."},
    {.name = "shown",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_motion_method, shown),
     .standard = 1,
     .live = true,
     .help = "Off leaves the method out: it costs nothing."},
};

static const ll_param_table method_table = {.name = "motion_method",
                                            .help = "A method and its step.",
                                            .rows = method_rows,
                                            .count = sizeof method_rows / sizeof method_rows[0],
                                            .size = sizeof(ll_motion_method)};

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    {.name = "problem",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_motion_config, problem),
     .choices = ll_ode_problem_names,
     .help = "What moves."},
    {.name = "params",
     .type = LL_PARAM_VARIANT,
     .offset = offsetof(ll_motion_config, params),
     .variants = ll_ode_problem_tables,
     .count_offset = offsetof(ll_motion_config, problem),
     .live = true,
     .help = "The problem's own parameters."},
    {.name = "tick_hz",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_motion_config, tick_hz),
     .min = 1,
     .max = 1000,
     .standard = 60,
     .unit = "Hz",
     .help = "How often errors are sampled and pictures are made; no method steps by it."},
    {.name = "methods",
     .type = LL_PARAM_ARRAY,
     .offset = offsetof(ll_motion_config, methods),
     .min = 1,
     .max = LL_MOTION_METHODS_MAX,
     .child = &method_table,
     .count_offset = offsetof(ll_motion_config, method_count),
     .live = true,
     .required = true,
     .help = "The methods, side by side from the same start."},
};

/* A method's refusal names `dt` or `method`; here that is a row of an element. */
static ll_status in_method(const ll_status *status, int i)
{
    char field[96];
    const char *row = strcmp(status->field, "dt") == 0 ? "dt_s" : status->field;
    snprintf(field, sizeof field, "methods.%d.%s", i, row);
    return ll_field_error(LL_BAD_INPUT, field, "%s: %s", field, status->text);
}

static ll_status check(const void *object, const char *path)
{
    ll_motion_config c = *(const ll_motion_config *)object;
    ll_status status = ll_ok();
    (void)path;
    ll_ode ode = ll_motion_system(&c);
    for (int i = 0; i < c.method_count && !ll_failed(&status); i++) {
        const ll_ode_method *method = ll_motion_method_of(&c, i);
        ll_ode_control control = ll_motion_control(&c, i);
        status = ll_ode_method_fits(method, &ode);
        if (!ll_failed(&status))
            status = ll_ode_check_control(method, &control);
        if (ll_failed(&status))
            return in_method(&status, i);
    }
    return status;
}

const ll_param_table ll_motion_table = {.name = "motion",
                                        .help =
                                            "A problem of motion, solved by several methods side by side.",
                                        .rows = rows,
                                        .count = sizeof rows / sizeof rows[0],
                                        .size = sizeof(ll_motion_config),
                                        .check = check};

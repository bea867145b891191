#include <stdio.h>
#include <string.h>

#include "ode/catalogue/catalogue.h"
#include "sim/core/scenario_rows.h"
#include "sim/motion/motion.h"

static const ll_param method_rows[] = {
    {LL_PARAM_ROW("method", CHOICE, ll_motion_method, method), .choices = ll_ode_method_names,
     .required = true, .live = true, .help = "The integrator."},
    {LL_PARAM_ROW("dt_s", REAL, ll_motion_method, dt_s), .min = 1e-9, .max = LL_DURATION_MAX_S,
     .default_value = 0.01, .unit = "s", .live = true, .help = "Step of a fixed-step method."},
    {LL_PARAM_ROW("tolerance", REAL, ll_motion_method, tolerance), .min = 1e-15, .max = 0.1,
     .default_value = 1e-6, .live = true, .help = "Relative and absolute tolerance of an adaptive method."},
    {LL_PARAM_ROW("steps", CHOICE, ll_motion_method, steps), .choices = ll_motion_step_names, .live = true,
     .help = "Time stepping. fixed: steps of dt_s. frame: one step per frame, as long as the frame. "
             "accumulator: frame time is saved up and spent in steps of dt_s."},
    {LL_PARAM_ROW("clock", CHOICE, ll_motion_method, clock), .choices = ll_motion_clock_names, .live = true,
     .help = "Time that forces see. exact: steps times dt_s. float: dt_s added up in single precision. "
             "compensated: added up in single precision with Kahan's compensation."},
    {LL_PARAM_ROW("precision", CHOICE, ll_motion_method, precision), .choices = ll_motion_precision_names,
     .live = true, .help = "Precision that the state is rounded to after each step."},
    {LL_PARAM_ROW("origin_offset_m", REAL, ll_motion_method, origin_offset_m), .min = 0, .max = 1e9,
     .unit = "m", .live = true,
     .help = "Distance of stored positions from the origin; has an effect in single precision."},
    {LL_PARAM_ROW("shown", BOOL, ll_motion_method, shown), .default_value = 1, .live = true,
     .help = "Off: the method is not run and costs nothing."},
};

static const ll_param_table method_table = {
    .name = "motion_method", .help = "A method and its step.", LL_PARAM_ROWS(method_rows, ll_motion_method)};

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    {LL_PARAM_ROW("problem", CHOICE, ll_motion_config, problem), .choices = ll_ode_problem_names,
     .help = "The problem that is integrated."},
    {LL_PARAM_ROW("params", VARIANT, ll_motion_config, params), .variants = ll_ode_problem_tables,
     .count_offset = offsetof(ll_motion_config, problem), .live = true,
     .help = "The problem's own parameters."},
    {LL_PARAM_ROW("tick_hz", REAL, ll_motion_config, tick_hz), .min = 1, .max = 1000, .default_value = 60,
     .unit = "Hz",
     .help = "Sampling rate for display. No method uses it as its step, and no error depends on it."},
    {LL_PARAM_ROW("frames", CHOICE, ll_motion_config, frames), .choices = ll_motion_frame_names, .live = true,
     .help = "Lengths of a machine's frames, for methods stepped by frames. alternating: short and long in "
             "turn. random: between both, by the seed."},
    {LL_PARAM_ROW("frame_s", REAL, ll_motion_config, frame_s), .min = 0.001, .max = 1,
     .default_value = 1.0 / 60, .unit = "s", .live = true, .help = "Mean length of a frame."},
    {LL_PARAM_ROW("frame_jitter", REAL, ll_motion_config, frame_jitter), .min = 0, .max = 0.9,
     .default_value = 0.5, .live = true, .help = "Relative deviation of frame lengths from the mean."},
    {LL_PARAM_ROW("reverse", BOOL, ll_motion_config, reverse), .live = true,
     .help = "Time reversal: halfway every method turns back with steps of -dt_s; the distance from the "
             "start at the end is the error."},
    {LL_PARAM_ROW("methods", ARRAY, ll_motion_config, methods), .min = 1, .max = LL_MOTION_METHODS_MAX,
     .child = &method_table, .count_offset = offsetof(ll_motion_config, method_count), .live = true,
     .required = true, .help = "The methods, side by side from the same start."},
};

/* A method's error names `dt` or `method`; here that is a row of an element. */
static ll_status in_method(const ll_status *status, int i)
{
    char field[96];
    const char *row = strcmp(status->field, "dt") == 0 ? "dt_s" : status->field;
    snprintf(field, sizeof field, "methods.%d.%s", i, row);
    return ll_field_error(LL_BAD_INPUT, field, "%s: %s", field, status->text);
}

/* Rejects a combination that cannot be stepped, with a sentence that gives the reason. */
static ll_status check_drive(const ll_motion_config *c, const ll_ode *ode, int i)
{
    const ll_motion_method *m = &c->methods[i];
    const char *method = ll_motion_method_of(c, i)->name;
    bool adaptive = ll_motion_method_of(c, i)->adaptive;
    if (adaptive && m->steps != LL_MOTION_FIXED)
        return ll_field_error(LL_BAD_INPUT, "steps",
                              "%s chooses its steps by its tolerance: frames cannot set them (%s).", method,
                              ll_motion_step_names[m->steps]);
    if (m->clock != LL_MOTION_EXACT && (adaptive || m->steps != LL_MOTION_FIXED || c->reverse))
        return ll_field_error(
            LL_BAD_INPUT, "clock",
            "A clock that adds up its step (%s) needs steps of fixed length, and cannot run backwards.",
            ll_motion_clock_names[m->clock]);
    if (c->reverse && m->steps != LL_MOTION_FIXED)
        return ll_field_error(LL_BAD_INPUT, "steps",
                              "Frames (%s) cannot run backwards: reverse needs fixed steps.",
                              ll_motion_step_names[m->steps]);
    if (m->origin_offset_m != 0 && (m->precision != LL_MOTION_SINGLE || !ll_ode_mechanical(ode)))
        return ll_field_error(LL_BAD_INPUT, "origin_offset_m",
                              "origin_offset_m (%.9g) needs single precision (precision: float) and a "
                              "problem with positions and velocities.",
                              m->origin_offset_m);
    return ll_ok();
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
        LL_THEN(status, ll_ode_check_control(method, &control));
        LL_THEN(status, check_drive(&c, &ode, i));
        if (ll_failed(&status))
            return in_method(&status, i);
    }
    return status;
}

const ll_param_table ll_motion_table = {.name = "motion",
                                        .help =
                                            "A problem of motion, solved by several methods side by side.",
                                        LL_PARAM_ROWS(rows, ll_motion_config),
                                        .check = check};

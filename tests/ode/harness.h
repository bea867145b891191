/* Running a method over a system, for tests. */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "ode/core/run.h"
#include "systems.h"

typedef struct setting {
    const ll_ode_method *method;
    const ll_ode *ode;
    ll_ode_run *run;
} setting;

static setting begin(const char *method, const ll_ode *ode, const double *y0, const ll_ode_control *control)
{
    setting s = {ll_ode_method_find(method), ode, NULL};
    assert_non_null(s.method);
    s.run = malloc(ll_ode_run_size(s.method, ode));
    assert_non_null(s.run);
    ll_status status = ll_ode_start(s.run, s.method, ode, control, y0);
    if (ll_failed(&status))
        fail_msg("%s: %s", method, status.text);
    return s;
}

static inline ll_ode_state step(setting *s)
{
    return ll_ode_step(s->run, s->method, s->ode);
}

static inline void end(setting *s)
{
    free(s->run);
}

/* To t = T, by n steps of a fixed or with the tolerance of an adaptive method; the state ends in y. */
static inline ll_ode_counters solve(const char *method, const ll_ode *ode, const double *y0, double T, int n,
                                    double tolerance, double *y)
{
    ll_ode_control control = {.t_end = T, .dt = n > 0 ? T / n : 0, .tolerance = tolerance};
    setting s = begin(method, ode, y0, &control);
    ll_ode_advance(s.run, s.method, ode, T);
    if (s.run->state != LL_ODE_FINISHED) {
        char text[160];
        ll_ode_reason_text(s.run, text, sizeof text);
        fail_msg("%s: %s", method, text);
    }
    for (int i = 0; i < ode->dim; i++)
        y[i] = ll_ode_y(s.run)[i];
    ll_ode_counters counters = s.run->counters;
    end(&s);
    return counters;
}

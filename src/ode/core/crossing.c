/* Locates a crossing with the method itself by varying the length of the step, so that the time is as
 * accurate as the method. Costs about ten attempts. */
#include "ode/core/crossing.h"

#include <float.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "ode/core/method_internal.h"

typedef struct search {
    ll_ode_run *run;
    const ll_ode_method *method;
    const ll_ode *ode;
    const ll_ode_event *event;
    double h; /* of the whole step */
} search;

/* g after the fraction `theta` of the step. */
static double g_at(const search *s, double theta)
{
    s->run->partial = true;
    s->method->body->attempt(s->run, s->method, s->ode, theta * s->h);
    return s->event->g(s->ode->params, s->run->t + theta * s->h, ll_ode_next(s->run));
}

/* Whether g crossed zero in the direction of the event. A step that starts on the surface counts as starting
 * from the side that the event comes from; for an event of both directions it is no crossing. */
static bool crosses(const ll_ode_event *event, double g0, double g1)
{
    int way = event->direction;
    bool falls = (g0 > 0 || (g0 == 0 && way < 0)) && g1 < 0;
    bool rises = (g0 < 0 || (g0 == 0 && way > 0)) && g1 > 0;
    return (falls && way <= 0) || (rises && way >= 0);
}

/* Fraction of the step just after the zero crossing of g: T. R. Chandrupatla's method (Adv. Eng. Softw. 28,
 * 1997), inverse quadratic interpolation where it is safe, else bisection. */
static double crossing(const search *s, double g0, double g1)
{
    double resolution = 2 * DBL_EPSILON * (1 + ll_abs(s->run->t / s->h));
    double x = 1, g = g1, other = 0, g_other = g0, old = 0, g_old = g0, share = 0.5;
    for (int i = 0; i < 100; i++) {
        double at = x + share * (other - x), g_new = g_at(s, at);
        if (crosses(s->event, g0, g_new) == crosses(s->event, g0, g)) {
            old = x, g_old = g;
        } else {
            old = other, g_old = g_other;
            other = x, g_other = g;
        }
        x = at, g = g_new;
        double least = resolution / ll_abs(other - x);
        if (least > 0.5)
            break;
        double xi = (x - other) / (old - other), phi = (g - g_other) / (g_old - g_other);
        share = 0.5;
        /* g = 0 is a start on the surface and cannot be interpolated. */
        if (g * g_other < 0 && phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi) {
            share = g / (g_other - g) * g_old / (g_other - g_old) +
                    (old - x) / (other - x) * g / (g_old - g) * g_other / (g_old - g_other);
            share = share < least ? least : share > 1 - least ? 1 - least : share;
        }
    }
    return crosses(s->event, g0, g) ? x : other;
}

bool ll_ode_event_locate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double *h)
{
    const double *y = ll_ode_y(run), *next = ll_ode_next(run);
    bool partial = run->partial;
    double g0[LL_ODE_EVENTS_MAX], g1[LL_ODE_EVENTS_MAX], first = 1;
    for (int i = 0; i < ode->event_count; i++) {
        g0[i] = ode->events[i].g(ode->params, run->t, y);
        g1[i] = ode->events[i].g(ode->params, run->t + *h, next);
    }
    for (int i = 0; i < ode->event_count; i++) {
        if (!crosses(&ode->events[i], g0[i], g1[i]))
            continue;
        search s = {run, method, ode, &ode->events[i], *h};
        double theta = crossing(&s, g0[i], g1[i]);
        if (run->event < 0 || theta < first) {
            first = theta;
            run->event = i;
        }
    }
    if (run->event < 0)
        return false;
    LL_ASSERT(first >= 0 && first <= 1); /* within the step */
    run->partial = partial || first < 1;
    *h *= first;
    method->body->attempt(run, method, ode, *h);
    run->event_t[run->event] = run->t + *h;
    return true;
}

void ll_ode_event_jump(ll_ode_run *run, const ll_ode *ode)
{
    const ll_ode_event *event = &ode->events[run->event];
    double *y = ll_ode_state_y(run);
    LL_ASSERT(run->event < ode->event_count);
    run->counters.events++;
    run->event_n[run->event]++;
    memcpy(run->data + 2 * run->stride, y, (size_t)run->stride * sizeof *y);
    if (event->jump == NULL)
        return;
    run->at_rest = event->jump(ode->params, run->t, y) == LL_ODE_REST;
    run->history = 0;
}

/* Driver of every method: time, acceptance of steps, step size control, and failures. */
#include "ode/core/run.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "ode/core/crossing.h"
#include "ode/core/method_internal.h"

#define DEFAULT_MAX_STEPS 100000000

/* Steps are proposed shorter than their error requires: with 0.9 every fourth step of a double pendulum is
 * rejected, which costs more than shorter steps, in most problems. */
#define SAFETY 0.85

/* A step that ends within this fraction of itself before a given time ends there: times are rounded. */
#define SLACK 1e-9

static double magnitude(double x)
{
    return __builtin_fabs(x);
}

static bool finite(double x)
{
    return x - x == 0;
}

static bool all_finite(const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += x[i] * 0;
    return sum == 0;
}

static double direction(const ll_ode_run *run)
{
    return run->control.t_end < run->control.t0 ? -1 : 1;
}

double ll_ode_power(double x, double p)
{
    /* The bits of a double, read as an integer, are its logarithm, linear between powers of two; the parabola
     * corrects most of the difference. */
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    double exponent = (double)(bits >> 52) - 1023;
    double part = (double)(bits & 0xfffffffffffff) * 0x1p-52;
    double target = p * (exponent + part + 0.346 * part * (1 - part));
    if (target < -1000)
        return 0;
    if (target > 1000)
        return DBL_MAX;
    double whole = (double)(int64_t)target - (target < 0);
    part = target - whole;
    bits = (int64_t)((whole + 1023 + part - 0.338 * part * (1 - part)) * 0x1p52);
    memcpy(&x, &bits, sizeof x);
    return x;
}

double ll_ode_norm2(const ll_ode_run *run, const double *e)
{
    const double *y = run->data, *next = run->data + run->stride;
    ll_pair relative = {run->control.tolerance, run->control.tolerance}, sum = {0, 0};
    ll_pair absolute = {run->control.absolute, run->control.absolute};
    for (int i = 0; i < run->stride; i += 2) {
        ll_pair a = ll_pair_at(y + i), b = ll_pair_at(next + i);
        ll_pair size = {magnitude(a[0]), magnitude(a[1])}, other = {magnitude(b[0]), magnitude(b[1])};
        size[0] = size[0] > other[0] ? size[0] : other[0];
        size[1] = size[1] > other[1] ? size[1] : other[1];
        ll_pair ratio = ll_pair_at(e + i) / (absolute + relative * size);
        sum += ratio * ratio;
    }
    return (sum[0] + sum[1]) * (1.0 / run->dim);
}

size_t ll_ode_run_size(const ll_ode_method *method, const ll_ode *ode)
{
    size_t stride = (size_t)(ode->dim + 1) / 2 * 2;
    size_t doubles = (3 + (size_t)method->body->vectors) * stride;
    if (method->body->extra != NULL)
        doubles += method->body->extra(ode->dim);
    return sizeof(ll_ode_run) + doubles * sizeof(double);
}

ll_status ll_ode_check_control(const ll_ode_method *method, const ll_ode_control *c)
{
    double span = magnitude(c->t_end - c->t0);
    if (!finite(span) || span == 0)
        return ll_field_error(LL_BAD_INPUT, "t_end", "t_end: must be finite and differ from t0; got %.17g.",
                              c->t_end);
    if (c->max_steps < 0)
        return ll_field_error(LL_BAD_INPUT, "max_steps", "max_steps: must be at least 0; got %lld.",
                              (long long)c->max_steps);
    if (method->adaptive) {
        if (!(c->tolerance >= 1e-15 && c->tolerance <= 0.1))
            return ll_field_error(LL_BAD_INPUT, "tolerance",
                                  "tolerance: must be 1e-15 to 0.1 for %s; got %.17g.", method->name,
                                  c->tolerance);
        if (!(c->absolute >= 0 && finite(c->absolute)))
            return ll_field_error(LL_BAD_INPUT, "absolute",
                                  "absolute: must be finite and at least 0; got %.17g.", c->absolute);
        if (!(c->first_step >= 0 && finite(c->first_step)))
            return ll_field_error(LL_BAD_INPUT, "first_step",
                                  "first_step: must be finite and at least 0 s; got %.17g.", c->first_step);
        if (!(c->largest_step >= 0))
            return ll_field_error(LL_BAD_INPUT, "largest_step",
                                  "largest_step: must be at least 0 s; got %.17g.", c->largest_step);
        return ll_ok();
    }
    if (!(c->dt > 0 && c->dt <= span))
        return ll_field_error(LL_BAD_INPUT, "dt",
                              "dt: must be above 0 and, for %s, at most the duration of %.17g s; got %.17g.",
                              method->name, span, c->dt);
    double limit = (double)(c->max_steps > 0 ? c->max_steps : DEFAULT_MAX_STEPS);
    if (span / c->dt > limit)
        return ll_field_error(LL_BAD_INPUT, "dt",
                              "dt: must be at least %.17g s; got %.17g. The duration of %.17g s would take "
                              "more than the limit of %.0f steps.",
                              span / limit, c->dt, span, limit);
    return ll_ok();
}

/* First step from the magnitude of y and of its first two derivatives (Hairer, Norsett, Wanner: Solving
 * Ordinary Differential Equations I, II.4). */
static double first_step(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode)
{
    const ll_ode_control *c = &run->control;
    double span = magnitude(c->t_end - c->t0), *y = ll_ode_state_y(run), *next = ll_ode_next(run);
    if (c->first_step > 0)
        return c->first_step < span ? c->first_step : span;
    if (method->body->limit != NULL)
        return span;
    double *f0 = ll_ode_work(run, 0), *f1 = ll_ode_work(run, 1);
    ll_ode_f(run, ode, c->t0, y, f0);
    double d0 = ll_sqrt(ll_ode_norm2(run, y)), d1 = ll_sqrt(ll_ode_norm2(run, f0));
    double h = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    h = h < span ? h : span;
    for (int i = 0; i < run->dim; i++)
        next[i] = y[i] + direction(run) * h * f0[i];
    ll_ode_f(run, ode, c->t0 + direction(run) * h, next, f1);
    for (int i = 0; i < run->dim; i++)
        f1[i] -= f0[i];
    memcpy(next, y, (size_t)run->stride * sizeof *y);
    double d2 = ll_sqrt(ll_ode_norm2(run, f1)) / h, most = d1 > d2 ? d1 : d2;
    double better = most <= 1e-15 ? 100 * h : ll_ode_power(0.01 / most, 1.0 / method->body->error_order);
    memset(f0, 0, 2 * (size_t)run->stride * sizeof *f0);
    better = better < 100 * h ? better : 100 * h;
    return better < span ? better : span;
}

ll_status ll_ode_start(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode,
                       const ll_ode_control *control, const double *y0)
{
    LL_TRY(ll_ode_method_fits(method, ode));
    LL_TRY(ll_ode_check_control(method, control));
    LL_ASSERT(ode->dim >= 1 && ode->dim <= LL_ODE_DIM_MAX && ode->event_count <= LL_ODE_EVENTS_MAX);
    memset(run, 0, ll_ode_run_size(method, ode));
    run->dim = ode->dim;
    run->stride = (ode->dim + 1) / 2 * 2;
    run->control = *control;
    if (run->control.max_steps == 0)
        run->control.max_steps = DEFAULT_MAX_STEPS;
    if (run->control.absolute == 0)
        run->control.absolute = control->tolerance;
    run->t = run->t_last = run->origin = control->t0;
    run->event = -1;
    memcpy(ll_ode_state_y(run), y0, (size_t)ode->dim * sizeof *y0);
    memcpy(ll_ode_next(run), y0, (size_t)ode->dim * sizeof *y0);
    if (!all_finite(y0, ode->dim))
        return ll_field_error(LL_BAD_INPUT, "state", "state: the initial state must be finite.");
    if (method->adaptive)
        run->h = direction(run) * first_step(run, method, ode);
    return ll_ok();
}

static ll_ode_state fail(ll_ode_run *run, ll_ode_reason reason, double t)
{
    LL_ASSERT(reason != LL_ODE_NO_REASON); /* it says why */
    run->state = LL_ODE_DIVERGED;
    run->reason = (int32_t)reason;
    run->failed_t = t;
    return LL_ODE_DIVERGED;
}

static bool out_of_steps(const ll_ode_run *run)
{
    return run->counters.steps + run->counters.rejected >= run->control.max_steps;
}

/* Accepts the attempt: makes `next` the state at `t`. */
static ll_ode_state commit(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t,
                           double h)
{
    LL_ASSERT(run->state == LL_ODE_RUNNING && (run->current == 0 || run->current == 1));
    run->t_last = run->t;
    run->t = t;
    run->current = 1 - run->current;
    run->counters.steps++;
    run->dense = 0;
    if (method->body->accept != NULL)
        method->body->accept(run, method, ode, h);
    if (run->event >= 0)
        ll_ode_event_jump(run, ode);
    return LL_ODE_RUNNING;
}

/* Step of `h` to `t`, which is run->t + h except for rounding. */
static ll_ode_state step_fixed(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h,
                               double t)
{
    if (method->body->attempt(run, method, ode, h) != 0)
        return fail(run, LL_ODE_NO_SOLUTION, t);
    if (!all_finite(ll_ode_next(run), run->dim))
        return fail(run, LL_ODE_NOT_FINITE, t);
    if (ode->event_count > 0 && ll_ode_event_locate(run, method, ode, &h))
        t = run->event_t[run->event];
    return commit(run, method, ode, t, h);
}

/* Steps to the next multiple of dt; after an event the rest of that step comes first. */
static ll_ode_state step_to_grid(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode)
{
    if (out_of_steps(run))
        return fail(run, LL_ODE_STEP_LIMIT, run->t);
    double dt = direction(run) * run->control.dt, t = run->origin + (double)(run->n + 1) * dt;
    run->partial = run->event >= 0;
    run->event = -1;
    double h = run->partial ? t - run->t : dt;
    step_fixed(run, method, ode, h, t);
    if (run->event < 0)
        run->n++;
    return (ll_ode_state)run->state;
}

/* Step size by the error of the step and, if the errors of the last two steps indicate that it must shrink,
 * by their trend (K. Gustafsson, ACM Trans. Math. Softw. 20, 1994): this avoids rejected steps on the way
 * into a close encounter. */
double ll_ode_propose(ll_ode_run *run, double h, double error, double order)
{
    enum { LEAST = 5, MOST = 6 };
    if (!finite(error))
        return h / LEAST;
    LL_VALIDATE(error >= 0 && order > 0); /* a norm */
    double growth = ll_ode_power(error > 1e-20 ? error : 1e-20, -0.5 / order), factor = SAFETY * growth;
    if (error <= 1) {
        if (run->growth != 0) {
            double trend = factor * growth * (h / (run->h_last * run->growth));
            factor = trend < factor ? trend : factor;
        }
        run->growth = growth < 2 ? growth : 2;
        run->h_last = h;
    }
    return h * (factor < 1. / LEAST ? 1. / LEAST : factor > MOST ? MOST : factor);
}

static ll_ode_state step_adaptive(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode)
{
    const ll_ode_control *c = &run->control;
    bool rejected = false;
    for (;;) {
        double h = run->h, left = c->t_end - run->t;
        if (method->body->limit != NULL) {
            double most = method->body->limit(run, method, ode);
            h = magnitude(h) > most ? direction(run) * most : h;
        }
        if (c->largest_step > 0 && magnitude(h) > c->largest_step)
            h = direction(run) * c->largest_step;
        /* Makes the last two steps equal, rather than one of them tiny. */
        bool last = magnitude(h) >= magnitude(left) * (1 - SLACK);
        if (last)
            h = left;
        else if (2 * magnitude(h) > magnitude(left))
            h = left / 2;
        if (magnitude(h) <= 4 * DBL_EPSILON * magnitude(run->t) || magnitude(h) < DBL_MIN)
            return fail(run, LL_ODE_STEP_TOO_SMALL, run->t);
        if (out_of_steps(run))
            return fail(run, LL_ODE_STEP_LIMIT, run->t);
        double error = method->body->attempt(run, method, ode, h);
        double next = method->body->propose != NULL
                          ? method->body->propose(run, method, h, error)
                          : ll_ode_propose(run, h, error, method->body->error_order);
        if (!(error <= 1)) {
            run->counters.rejected++;
            run->h = next;
            rejected = true;
            continue;
        }
        double t = last ? c->t_end : run->t + h;
        bool event = ode->event_count > 0 && ll_ode_event_locate(run, method, ode, &h);
        if (event)
            t = run->event_t[run->event];
        run->h = rejected && magnitude(next) > magnitude(h) && !event ? h : next;
        return commit(run, method, ode, t, h);
    }
}

/* At rest: time passes without evaluations. */
static ll_ode_state pass(ll_ode_run *run, double t)
{
    run->t_last = run->t;
    run->t = t;
    run->event = -1;
    return LL_ODE_RUNNING;
}

ll_ode_state ll_ode_step(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode)
{
    if (run->state != LL_ODE_RUNNING)
        return (ll_ode_state)run->state;
    const ll_ode_control *c = &run->control;
    double slack = 0;
    if (method->adaptive) {
        run->event = -1;
        if (run->at_rest)
            pass(run, c->t_end);
        else
            step_adaptive(run, method, ode);
    } else {
        slack = SLACK * c->dt;
        if (run->at_rest)
            pass(run, run->origin + (double)++run->n * direction(run) * c->dt);
        else
            step_to_grid(run, method, ode);
    }
    if (run->state == LL_ODE_RUNNING && direction(run) * (c->t_end - run->t) <= slack)
        run->state = LL_ODE_FINISHED;
    return (ll_ode_state)run->state;
}

ll_ode_state ll_ode_advance(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t)
{
    double slack = method->adaptive ? 0 : SLACK * run->control.dt;
    while (run->state == LL_ODE_RUNNING && direction(run) * (t - run->t) > slack)
        ll_ode_step(run, method, ode);
    return (ll_ode_state)run->state;
}

ll_ode_state ll_ode_step_by(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    LL_ASSERT(!method->adaptive);
    if (run->state != LL_ODE_RUNNING)
        return (ll_ode_state)run->state;
    if (out_of_steps(run))
        return fail(run, LL_ODE_STEP_LIMIT, run->t);
    run->partial = false;
    run->event = -1;
    if (run->at_rest)
        pass(run, run->t + h);
    else
        step_fixed(run, method, ode, h, run->t + h);
    run->origin = run->t;
    run->n = 0;
    return (ll_ode_state)run->state;
}

void ll_ode_set_time(ll_ode_run *run, double t)
{
    run->t = run->origin = t;
    run->n = 0;
}

void ll_ode_round(ll_ode_run *run, int positions, double origin)
{
    double *y = ll_ode_state_y(run);
    for (int i = 0; i < run->dim; i++) {
        double from = i < positions ? origin : 0;
        y[i] = (double)(float)(from + y[i]) - from;
    }
}

/* Cubic Hermite interpolation. */
static void cubic(ll_ode_run *run, const ll_ode *ode, double theta, double *y)
{
    double slope[2][LL_ODE_DIM_MAX], h = run->t - run->t_last;
    const double *y0 = ll_ode_next(run), *y1 = ll_ode_end(run);
    ll_ode_eval(ode, run->t_last, y0, slope[0]);
    ll_ode_eval(ode, run->t, y1, slope[1]);
    double rest = 1 - theta, a = rest * rest * (1 + 2 * theta), b = theta * theta * (3 - 2 * theta);
    double c = h * theta * rest * rest, d = -h * theta * theta * rest;
    for (int i = 0; i < run->dim; i++)
        y[i] = a * y0[i] + b * y1[i] + c * slope[0][i] + d * slope[1][i];
}

void ll_ode_sample(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t, double *y)
{
    double h = run->t - run->t_last, theta = h == 0 ? 1 : (t - run->t_last) / h;
    if (theta == 1 || (run->at_rest && run->event < 0))
        memcpy(y, ll_ode_y(run), (size_t)run->dim * sizeof *y);
    else if (method->body->dense != NULL)
        method->body->dense(run, method, ode, theta, y);
    else
        cubic(run, ode, theta, y);
}

void ll_ode_give_up(ll_ode_run *run, ll_ode_reason reason)
{
    fail(run, reason, run->t);
}

ll_run_status ll_ode_run_status(const ll_ode_run *run)
{
    static const ll_run_status statuses[] = {
        [LL_ODE_NO_REASON] = LL_RUN_OK,          [LL_ODE_NOT_FINITE] = LL_RUN_DIVERGED,
        [LL_ODE_STEP_TOO_SMALL] = LL_RUN_FAILED, [LL_ODE_NO_SOLUTION] = LL_RUN_FAILED,
        [LL_ODE_STEP_LIMIT] = LL_RUN_FAILED,     [LL_ODE_BLEW_UP] = LL_RUN_DIVERGED,
        [LL_ODE_UNRESOLVED] = LL_RUN_FAILED,
    };
    return statuses[run->reason];
}

void ll_ode_reason_text(const ll_ode_run *run, char *text, size_t size)
{
    static const char *const reasons[] = {
        [LL_ODE_NO_REASON] = "The run has not failed",
        [LL_ODE_NOT_FINITE] = "A value of the state was not finite",
        [LL_ODE_STEP_TOO_SMALL] = "The tolerance needs a step below the resolution of time",
        [LL_ODE_NO_SOLUTION] = "The equations of the implicit step could not be solved",
        [LL_ODE_STEP_LIMIT] = "The step limit was reached",
        [LL_ODE_BLEW_UP] = "The error or the energy exceeded ten times the scale of the problem",
        [LL_ODE_UNRESOLVED] =
            "The steps do not resolve the problem: a component is off by over a third of its scale,",
    };
    snprintf(text, size, "%s at t = %.9g s.", reasons[run->reason], run->failed_t);
}

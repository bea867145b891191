/* The solution of a motion, by formula or by integration, and the errors of a method against it: measured
 * over every step, so that they do not depend on a session's ticks. */
#include <string.h>

#include "sim/motion/motion.h"

/* A session's time at the motion's time `t` of a run; a run to 0 has been reversed. */
static double session_time(const ll_motion *m, const ll_ode_run *run, double t)
{
    return run->control.t_end > 0 ? t : m->config.head.duration_s - t;
}

/* ---- references, where there is no formula ---- */

/* Longest time by which a method's last step may pass the end. */
static double overshoot(const ll_motion_config *c)
{
    double most = 0;
    for (int i = 0; i < c->method_count; i++) {
        double step = c->methods[i].steps == LL_MOTION_FRAME ? 2 * c->frame_s : c->methods[i].dt_s;
        if (!ll_motion_method_of(c, i)->adaptive && step > most)
            most = step;
    }
    return most;
}

static void start_reference(ll_motion *m, const ll_ode *ode, int64_t offset, int which, const double *y0)
{
    ll_ode_control control = ll_ode_reference_control(m->config.head.duration_s + overshoot(&m->config));
    control.max_steps = LL_MOTION_STEPS_MAX;
    if (!m->formula)
        ll_ode_start(ll_motion_run_at(m, offset),
                     ll_ode_reference_method(ll_motion_problem(&m->config), which), ode, &control, y0);
}

/* From its present state back to the start. */
static void reverse_reference(ll_motion *m, const ll_ode *ode, ll_ode_run *reference, int which)
{
    double y[LL_ODE_DIM_MAX];
    ll_ode_control back = reference->control;
    memcpy(y, ll_ode_y(reference), (size_t)m->dim * sizeof *y);
    back.t0 = reference->t;
    back.t_end = 0;
    ll_ode_start(reference, ll_ode_reference_method(ll_motion_problem(&m->config), which), ode, &back, y);
}

/* The solution at `t`, which increases, and after the reversal decreases, from reference `which`. */
static void solution_at(ll_motion *m, const ll_ode *ode, int64_t offset, int which, double t, double *y,
                        ll_pace *pace)
{
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    if (t == 0) {
        problem->start(m->config.params, y);
        return;
    }
    if (m->formula && problem->exact(m->config.params, t, y))
        return;
    const ll_ode_method *method = ll_ode_reference_method(problem, which);
    ll_ode_run *reference = ll_motion_run_at(m, offset);
    if (t < reference->t_last && reference->control.t_end > 0)
        reverse_reference(m, ode, reference, which);
    while ((reference->control.t_end > 0 ? reference->t < t : reference->t > t) && ll_goes_on(pace) &&
           ll_ode_step(reference, method, ode) == LL_ODE_RUNNING)
        ;
    ll_ode_sample(reference, method, ode, t, y);
}

/* ---- uncertainty of the solution ---- */

/* One of the times of the first reference's last step. */
static void compare(ll_motion *m, const ll_ode *ode, double t, double span, ll_pace *pace)
{
    double y[LL_ODE_DIM_MAX], other[LL_ODE_DIM_MAX];
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    ll_motion_uncertainty *d = &m->uncertainty;
    ll_ode_run *first = ll_motion_run_at(m, m->first);
    solution_at(m, ode, m->first, 0, t, y, pace);
    solution_at(m, ode, m->second, 1, t, other, pace);
    ll_ode_scale_see(&d->by.scale, problem, ode, t, y);
    double square = 0;
    for (int k = 0; k < m->dim; k++)
        square += (y[k] - other[k]) * (y[k] - other[k]);
    double most = LL_ODE_PREDICTABLE * d->by.scale.state;
    if (!(square <= most * most) || ll_motion_run_at(m, m->second)->state == LL_ODE_DIVERGED) {
        d->parted = 1;
        return;
    }
    ll_ode_measure_at(&d->by, ll_motion_vector(m, m->uncertainty_each), ode, t, span, other, y, true);
    d->predictable_s = session_time(m, first, t);
}

/* Not inlined: it has vectors on the stack, of which a step with a formula needs none. */
__attribute__((noinline)) static void follow_references(ll_motion *m, const ll_ode *ode, double t,
                                                        ll_pace *pace)
{
    ll_motion_uncertainty *d = &m->uncertainty;
    ll_ode_run *first = ll_motion_run_at(m, m->first);
    const ll_ode_method *method = ll_ode_reference_method(ll_motion_problem(&m->config), 0);
    while (!d->parted && first->state != LL_ODE_FINISHED && session_time(m, first, first->t) < t &&
           ll_goes_on(pace)) {
        double at[LL_ODE_POINTS];
        if (m->config.reverse && first->control.t_end > 0 && first->t >= ll_motion_end(&m->config))
            reverse_reference(m, ode, first, 0);
        if (ll_ode_step(first, method, ode) == LL_ODE_DIVERGED) {
            d->parted = 1;
            return;
        }
        int points = ll_ode_measure_points(first, method, at);
        double step = first->t - first->t_last, span = (step < 0 ? -step : step) / points;
        for (int k = 0; k < points && !d->parted; k++)
            compare(m, ode, at[k], span, pace);
    }
}

/* Compares the two references up to the session's time `t`. */
static inline void compare_references(ll_motion *m, const ll_ode *ode, double t, ll_pace *pace)
{
    if (!m->formula)
        follow_references(m, ode, t, pace);
}

/* ---- of a method ---- */

void ll_motion_measure_start(ll_motion *m, const ll_ode *ode, const double *y0)
{
    double y[LL_ODE_DIM_MAX];
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    m->formula = problem->exact && problem->exact(m->config.params, 0, y);
    start_reference(m, ode, m->reference, 0, y0);
    start_reference(m, ode, m->first, 0, y0);
    start_reference(m, ode, m->second, 1, y0);
    start_reference(m, ode, m->ahead, 0, y0);
    ll_ode_measure_start(&m->uncertainty.by, ll_motion_vector(m, m->uncertainty_each), problem, ode, y0);
    for (int i = 0; i < m->config.method_count; i++) {
        start_reference(m, ode, m->at[i].reference, 0, y0);
        ll_ode_measure_start(&m->measure[i], ll_motion_vector(m, m->at[i].each), problem, ode, y0);
    }
}

void ll_motion_solve(ll_motion *m, const ll_ode *ode, double t, ll_pace *pace)
{
    compare_references(m, ode, t, pace);
    solution_at(m, ode, m->reference, 0, ll_motion_moment(&m->config, t), ll_motion_vector(m, m->solution),
                pace);
}

/* The scale of the whole solution, part of which lies in the future. */
static void look_ahead(ll_motion *m, const ll_ode *ode, ll_pace *pace)
{
    enum { TIMES = 1024 };
    double y[LL_ODE_DIM_MAX], end = ll_motion_end(&m->config);
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    const ll_ode_method *method = ll_ode_reference_method(problem, 0);
    ll_ode_run *ahead = ll_motion_run_at(m, m->ahead);
    for (int k = 1; m->formula && k <= TIMES; k++) {
        problem->exact(m->config.params, end * k / TIMES, y);
        ll_ode_scale_see(&m->whole, problem, ode, end * k / TIMES, y);
    }
    while (!m->formula && ahead->t < end && ll_goes_on(pace) &&
           ll_ode_step(ahead, method, ode) == LL_ODE_RUNNING)
        ll_ode_scale_see(&m->whole, problem, ode, ahead->t, ll_ode_y(ahead));
    m->looked = 1;
}

/* A state that is ahead of the solution has not blown up while it is no larger than the solution will be. */
static bool blown_up(ll_motion *m, const ll_ode *ode, ll_ode_measure *r, ll_pace *pace)
{
    if (!ll_ode_measure_blown_up(r))
        return false;
    if (!m->looked)
        look_ahead(m, ode, pace);
    ll_ode_scale_join(&r->scale, &m->whole);
    return ll_ode_measure_blown_up(r);
}

/* Times within a step are measured where the state is that of the method, and its time that of the clock. */
static int points_of(const ll_motion *m, int i, double *at)
{
    const ll_motion_method *method = &m->config.methods[i];
    if (method->clock == LL_MOTION_EXACT && method->precision == LL_MOTION_DOUBLE)
        return ll_ode_measure_points(ll_motion_run(m, i), ll_motion_method_of(&m->config, i), at);
    at[0] = ll_motion_time(m, i);
    return 1;
}

void ll_motion_measure_step(ll_motion *m, int i, const ll_ode *ode, ll_pace *pace)
{
    ll_ode_run *run = ll_motion_run(m, i);
    ll_ode_measure *r = &m->measure[i];
    const ll_ode_problem *problem = ll_motion_problem(&m->config);
    double at[LL_ODE_POINTS], y[LL_ODE_DIM_MAX], *wanted = ll_motion_vector(m, m->at[i].wanted);
    int points = points_of(m, i, at);
    double end = at[points - 1], step = end > r->t ? end - r->t : r->t - end;
    compare_references(m, ode, session_time(m, run, end), pace);
    for (int k = 0; k < points; k++) {
        /* At an event's jump it may be on the other side than the solution */
        if (k == points - 1 && run->event >= 0)
            return;
        solution_at(m, ode, m->at[i].reference, 0, at[k], wanted, pace);
        ll_ode_scale_see(&r->scale, problem, ode, at[k], wanted);
        if (k < points - 1)
            ll_ode_sample(run, ll_motion_method_of(&m->config, i), ode, at[k], y);
        const double *state = k < points - 1 ? y : ll_ode_y(run);
        bool known = m->formula || !m->uncertainty.parted ||
                     session_time(m, run, at[k]) <= m->uncertainty.predictable_s;
        ll_ode_measure_at(r, ll_motion_vector(m, m->at[i].each), ode, at[k], step / points, state, wanted,
                          known);
    }
    ll_ode_measure_energy(r, problem, ode, session_time(m, run, end), step, ll_ode_y(run));
    if (blown_up(m, ode, r, pace))
        ll_ode_give_up(run, LL_ODE_BLEW_UP);
}

void ll_motion_judge(ll_motion *m, int i, const ll_ode *ode)
{
    ll_ode_run *run = ll_motion_run(m, i);
    if (!m->uncertainty.parted && run->state != LL_ODE_DIVERGED &&
        !ll_ode_measure_resolved(&m->measure[i], ll_motion_vector(m, m->at[i].each),
                                 ll_motion_problem(&m->config), ode))
        ll_ode_give_up(run, LL_ODE_UNRESOLVED);
}

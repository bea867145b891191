/* Time stepping of a method: by fixed steps, by a machine's frames, or by fixed steps from an accumulator of
 * frame time; with which clock; in which precision its state is stored; and where time is reversed. */
#include <string.h>

#include "base/rng.h"
#include "ode/core/single.h"
#include "sim/motion/motion.h"

/* A step that ends before a given time by less than this part of itself counts as ending there. */
#define SLACK 1e-9

static ll_time to_ns(double s)
{
    return (ll_time)(s * 1e9 + 0.5);
}

/* The length of frame `n`. */
static ll_time frame_length(const ll_motion_config *c, int64_t n)
{
    double share = n % 2 == 0 ? -1 : 1;
    if (c->frames == LL_MOTION_RANDOM)
        share = 2 * ll_rng_unit((uint64_t)c->head.seed, 0, (uint64_t)n) - 1;
    return to_ns(c->frame_s * (1 + share * c->frame_jitter));
}

/* Positions are stored with an offset of `origin_offset_m` from those of the problem. */
static void round_state(ll_motion *m, int i, const ll_ode *ode)
{
    const ll_motion_method *method = &m->config.methods[i];
    if (method->precision == LL_MOTION_SINGLE)
        ll_ode_round(ll_motion_run(m, i), ll_ode_mechanical(ode) ? m->dim / 2 : m->dim,
                     method->origin_offset_m);
}

void ll_motion_drive_start(ll_motion *m, int i, const ll_ode *ode)
{
    m->drive[i] = (ll_motion_drive){.saved = {.step = to_ns(m->config.methods[i].dt_s), .most = INT64_MAX}};
    round_state(m, i, ode);
}

/* At the time reversal the state becomes the start of a run to time 0. */
static void reverse_time(ll_motion *m, int i, const ll_ode *ode)
{
    double y[LL_ODE_DIM_MAX];
    ll_ode_run *run = ll_motion_run(m, i);
    ll_ode_control back = ll_motion_control(&m->config, i);
    memcpy(y, ll_ode_y(run), (size_t)m->dim * sizeof *y);
    m->drive[i].before = run->counters;
    m->drive[i].turned = 1;
    back.t0 = run->t;
    back.t_end = 0;
    ll_ode_start(run, ll_motion_method_of(&m->config, i), ode, &back, y);
}

/* The force sees the float clock; the state is that after this number of ticks. An event ends a step early:
 * its remainder follows. */
static void step_by_clock(ll_motion *m, int i, const ll_ode *ode)
{
    const ll_motion_method *method = &m->config.methods[i];
    ll_motion_drive *d = &m->drive[i];
    ll_ode_run *run = ll_motion_run(m, i);
    double end = run->t + method->dt_s;
    while (run->state == LL_ODE_RUNNING && end - run->t > SLACK * method->dt_s)
        ll_ode_step_by(run, ll_motion_method_of(&m->config, i), ode, end - run->t);
    d->ticks++;
    ll_single_clock_add(&d->clock, method->clock == LL_MOTION_COMPENSATED ? &d->lost : NULL,
                        (float)method->dt_s);
    ll_ode_set_time(run, (double)d->clock);
}

/* To the end of the present frame, or of the next one. */
static void step_by_frame(ll_motion *m, int i, const ll_ode *ode)
{
    ll_motion_drive *d = &m->drive[i];
    ll_ode_run *run = ll_motion_run(m, i);
    if (run->t >= ll_to_s(d->frames_end))
        d->frames_end += frame_length(&m->config, d->frames++);
    ll_ode_step_by(run, ll_motion_method_of(&m->config, i), ode, ll_to_s(d->frames_end) - run->t);
}

static void one_step(ll_motion *m, int i, const ll_ode *ode, ll_pace *pace)
{
    const ll_motion_method *method = &m->config.methods[i];
    if (method->clock != LL_MOTION_EXACT)
        step_by_clock(m, i, ode);
    else if (method->steps == LL_MOTION_FRAME)
        step_by_frame(m, i, ode);
    else
        ll_ode_step(ll_motion_run(m, i), ll_motion_method_of(&m->config, i), ode);
    round_state(m, i, ode);
    if (ll_motion_run(m, i)->state != LL_ODE_DIVERGED)
        ll_motion_measure_step(m, i, ode, pace);
}

/* All frames that have ended by `t`, each with as many steps as its time allows. */
static void spend_frames(ll_motion *m, int i, const ll_ode *ode, double t, ll_pace *pace)
{
    ll_motion_drive *d = &m->drive[i];
    ll_ode_run *run = ll_motion_run(m, i);
    for (;;) {
        ll_time length = frame_length(&m->config, d->frames);
        if (ll_to_s(d->frames_end + length) > t || !ll_goes_on(pace))
            return;
        d->frames++;
        d->frames_end += length;
        for (int64_t n = ll_accumulator_add(&d->saved, length);
             n > 0 && run->state == LL_ODE_RUNNING && ll_goes_on(pace); n--)
            one_step(m, i, ode, pace);
    }
}

static void go_to(ll_motion *m, int i, const ll_ode *ode, double t, ll_pace *pace)
{
    const ll_motion_method *method = &m->config.methods[i];
    ll_ode_run *run = ll_motion_run(m, i);
    double sign = m->drive[i].turned ? -1 : 1;
    double slack = ll_motion_method_of(&m->config, i)->adaptive ? 0 : SLACK * method->dt_s;
    if (method->steps == LL_MOTION_ACCUMULATOR)
        spend_frames(m, i, ode, t, pace);
    else
        while (run->state == LL_ODE_RUNNING && sign * (t - ll_motion_time(m, i)) > slack && ll_goes_on(pace))
            one_step(m, i, ode, pace);
}

ll_ode_state ll_motion_drive_to(ll_motion *m, int i, const ll_ode *ode, double t, ll_pace *pace)
{
    ll_ode_run *run = ll_motion_run(m, i);
    if (t > ll_motion_end(&m->config) && !m->drive[i].turned) {
        go_to(m, i, ode, ll_motion_end(&m->config), pace);
        if (run->state == LL_ODE_DIVERGED || ll_broken_off(pace))
            return (ll_ode_state)run->state;
        reverse_time(m, i, ode);
    }
    go_to(m, i, ode, ll_motion_moment(&m->config, t), pace);
    return (ll_ode_state)run->state;
}

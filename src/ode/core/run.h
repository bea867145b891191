/* One integration under way: a block of a size known beforehand, without pointers, so that a copy by memcpy
 * is a snapshot. Nothing is allocated, and the method, the system and the control are arguments.
 *
 * Methods of fixed step stand at t_n = t0 + n dt, by multiplication. Adaptive ones keep the estimated error
 * of a step below absolute + tolerance |y|, in the root mean square over the components, and
 * end exactly at t_end. t_end < t0 integrates backwards. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/run_status.h"
#include "base/status.h"
#include "ode/core/method.h"
#include "ode/core/ode.h"

typedef struct ll_ode_control {
    double t0, t_end;    /* s */
    double dt;           /* s, > 0: step of methods that are not adaptive */
    double tolerance;    /* 1e-15 to 0.1: of methods that are */
    double absolute;     /* the absolute part of it, where y is small by nature; 0: as `tolerance` */
    double first_step;   /* s; 0: chosen by the method */
    double largest_step; /* s; 0: no limit */
    int64_t max_steps;   /* accepted and rejected; 0: 100 million */
} ll_ode_control;

typedef enum ll_ode_state {
    LL_ODE_RUNNING,
    LL_ODE_FINISHED, /* at t_end */
    LL_ODE_DIVERGED, /* see the reason; the state is that of the last good step */
} ll_ode_state;

typedef enum ll_ode_reason {
    LL_ODE_NO_REASON,
    LL_ODE_NOT_FINITE,     /* a value of y */
    LL_ODE_STEP_TOO_SMALL, /* the tolerance asks for a step below the resolution of t */
    LL_ODE_NO_SOLUTION,    /* Newton's iteration of an implicit method does not converge */
    LL_ODE_STEP_LIMIT,     /* max_steps */
    LL_ODE_BLEW_UP,        /* the caller found it beyond all bounds: scale.h */
    LL_ODE_UNRESOLVED,     /* the caller found it far from the solution of a stiff problem: measure.h */
} ll_ode_reason;

typedef struct ll_ode_counters {
    int64_t steps; /* accepted */
    int64_t rejected;
    int64_t evaluations; /* of f or a; those for a Jacobian by differences count, those for sampling do not */
    int64_t jacobians;
    int64_t factorisations; /* LU */
    int64_t solves;         /* of a factorised system */
    int64_t events;
} ll_ode_counters;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_ode_run {
    int32_t dim, stride;                /* of a vector: dim rounded up, the rest zero */
    int32_t state;                      /* ll_ode_state */
    int32_t reason;                     /* ll_ode_reason */
    int32_t at_rest;                    /* an event has stopped the motion for good */
    int32_t event;                      /* index of the event that ended the last step, or -1 */
    double t;                           /* of the state */
    double t_last;                      /* of the state before the last step */
    double h;                           /* adaptive: the step to be tried next, with its sign */
    double h_last;                      /* adaptive: the last accepted step */
    double failed_t;                    /* where it diverged */
    double event_t[LL_ODE_EVENTS_MAX];  /* the last time of each event */
    int64_t event_n[LL_ODE_EVENTS_MAX]; /* how often each has happened */
    int64_t n;                          /* steps of dt since `origin` */
    double origin;                      /* t0, or where stepping by other steps ended */
    double growth;   /* adaptive: that the error of that step allows; at most 2; 0: no step yet */
    int32_t current; /* which of the two state vectors is y */
    int32_t partial; /* the step is not one of the method's own size: up to an event, or the rest after it */
    int32_t history; /* the method's own: what it has kept of the past; 0 after the start and a jump */
    int32_t dense;   /* the method's own: whether the dense output of the last step is prepared */
    ll_ode_control control;
    ll_ode_counters counters;
    double data[]; /* vectors: y and the state before it, y before a jump, then the method's own */
} ll_ode_run;

#pragma GCC diagnostic pop

size_t ll_ode_run_size(const ll_ode_method *method, const ll_ode *ode); /* bytes, a multiple of 8 */

/* The error names the field of `control` (dt, tolerance, t_end, max_steps), its range and the value. */
ll_status ll_ode_check_control(const ll_ode_method *method, const ll_ode_control *control);

/* Checks the control, and the method against the system; then makes the run ready. The error names the field
 * of `control` (dt, tolerance, t_end, max_steps), its range and the value. */
ll_status ll_ode_start(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode,
                       const ll_ode_control *control, const double *y0);

/* One accepted step, or up to the first event within it. Returns the state afterwards. */
ll_ode_state ll_ode_step(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode);

/* Steps until run->t has reached or passed `t`, which is then within the last step. */
ll_ode_state ll_ode_advance(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t);

/* One step of `h` instead of dt, for methods of fixed step: what a variable frame time does to them. */
ll_ode_state ll_ode_step_by(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h);

/* Another time for what comes: the forces see it. What a wrong clock does to them. */
void ll_ode_set_time(ll_ode_run *run, double t);

/* Rounds the state to single precision, its first `positions` components after `origin` was added to them.
 * What it does to a body that is far from the origin. */
void ll_ode_round(ll_ode_run *run, int positions, double origin);

/* y at `t` within the last step: by the method's own dense output where it has one, otherwise by the cubic
 * through both ends. */
void ll_ode_sample(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t, double *y);

/* Fails a run for what its caller has found, though its values are finite: LL_ODE_BLEW_UP, LL_ODE_UNRESOLVED.
 */
void ll_ode_give_up(ll_ode_run *run, ll_ode_reason reason);

/* What has become of it: ok as long as it has not failed. */
ll_run_status ll_ode_run_status(const ll_ode_run *run);

/* Why the run diverged, as a sentence with the time: `A value was not finite at t = 1.25 s.` */
void ll_ode_reason_text(const ll_ode_run *run, char *text, size_t size);

static inline const double *ll_ode_y(const ll_ode_run *run)
{
    return run->data + run->current * run->stride;
}

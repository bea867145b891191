/* An integration in progress: a block of known size without pointers, so that a memcpy is a snapshot. Nothing
 * is allocated; the method, the system and the control are arguments.
 *
 * Fixed-step methods are at t_n = t0 + n dt, by multiplication. Adaptive ones keep the estimated error of a
 * step below absolute + tolerance |y|, as the root mean square over the components, and end exactly at t_end.
 * t_end < t0 integrates backwards. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/run_status.h"
#include "base/status.h"
#include "ode/core/method.h"
#include "ode/core/ode.h"

typedef struct ll_ode_control {
    double t0, t_end;    /* s */
    double dt;           /* s, > 0: step of fixed-step methods */
    double tolerance;    /* 1e-15 to 0.1: of adaptive methods */
    double absolute;     /* absolute tolerance, for components that are small by nature; 0: as `tolerance` */
    double first_step;   /* s; 0: chosen by the method */
    double largest_step; /* s; 0: no limit */
    int64_t max_steps;   /* accepted and rejected; 0: 100 million */
} ll_ode_control;

typedef enum ll_ode_state {
    LL_ODE_RUNNING,
    LL_ODE_FINISHED, /* at t_end */
    LL_ODE_DIVERGED, /* see the reason; the state is the last valid one */
} ll_ode_state;

typedef enum ll_ode_reason {
    LL_ODE_NO_REASON,
    LL_ODE_NOT_FINITE,     /* a component of y */
    LL_ODE_STEP_TOO_SMALL, /* the tolerance needs a step below the resolution of t */
    LL_ODE_NO_SOLUTION,    /* Newton's iteration of an implicit method does not converge */
    LL_ODE_STEP_LIMIT,     /* max_steps */
    LL_ODE_BLEW_UP,        /* the caller found it outside all bounds: scale.h */
    LL_ODE_UNRESOLVED,     /* the caller found it far from the solution of a stiff problem: measure.h */
} ll_ode_reason;

typedef struct ll_ode_counters {
    int64_t steps; /* accepted */
    int64_t rejected;
    int64_t evaluations; /* of f or a, including those for a Jacobian by differences, without those for
                            sampling */
    int64_t jacobians;
    int64_t factorisations; /* LU factorisations */
    int64_t solves;         /* solutions of factorised systems */
    int64_t events;
} ll_ode_counters;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_ode_run {
    int32_t dim, stride;                /* of a vector: dim rounded up; the rest is zero */
    int32_t state;                      /* ll_ode_state */
    int32_t reason;                     /* ll_ode_reason */
    int32_t at_rest;                    /* an event has stopped the motion permanently */
    int32_t event;                      /* index of the event that ended the last step, or -1 */
    double t;                           /* of the state */
    double t_last;                      /* of the state before the last step */
    double h;                           /* adaptive: next step to try, with its sign */
    double h_last;                      /* adaptive: the last accepted step */
    double failed_t;                    /* time of failure */
    double event_t[LL_ODE_EVENTS_MAX];  /* the last time of each event */
    int64_t event_n[LL_ODE_EVENTS_MAX]; /* count of each event */
    int64_t n;                          /* steps of dt since `origin` */
    double origin;                      /* t0, or where steps of other lengths ended */
    double growth;   /* adaptive: growth that the error of that step allows; at most 2; 0: no step yet */
    int32_t current; /* index of the state vector that is y */
    int32_t partial; /* the step is shorter than the method's: up to an event, or the rest after it */
    int32_t history; /* of the method: stored past values; 0 after the start and a jump */
    int32_t dense;   /* of the method: whether the dense output of the last step is prepared */
    ll_ode_control control;
    ll_ode_counters counters;
    double data[]; /* vectors: y and the last state, y before a jump, then the method's own */
} ll_ode_run;

#pragma GCC diagnostic pop

size_t ll_ode_run_size(const ll_ode_method *method, const ll_ode *ode); /* bytes, a multiple of 8 */

/* The error names the field of `control` (dt, tolerance, t_end, max_steps), its range and the value. */
ll_status ll_ode_check_control(const ll_ode_method *method, const ll_ode_control *control);

/* Checks the control, and the method against the system; then initialises the run. The error names the field
 * of `control` (dt, tolerance, t_end, max_steps), its range and the value. */
ll_status ll_ode_start(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode,
                       const ll_ode_control *control, const double *y0);

/* One accepted step, or up to the first event within it. Returns the new state of the run. */
ll_ode_state ll_ode_step(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode);

/* Steps until run->t has reached or passed `t`, which is then within the last step. */
ll_ode_state ll_ode_advance(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t);

/* One step of `h` instead of dt, for fixed-step methods: the effect of a variable frame time. */
ll_ode_state ll_ode_step_by(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h);

/* Changes the time that the forces see: the effect of a wrong clock. */
void ll_ode_set_time(ll_ode_run *run, double t);

/* Rounds the state to single precision; to its first `positions` components `origin` is added before. The
 * effect on a body far from the origin. */
void ll_ode_round(ll_ode_run *run, int positions, double origin);

/* y at `t` within the last step, by the method's dense output or, without one, by cubic Hermite
 * interpolation. */
void ll_ode_sample(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t, double *y);

/* Fails a run for a reason that its caller found, with finite values: LL_ODE_BLEW_UP, LL_ODE_UNRESOLVED. */
void ll_ode_give_up(ll_ode_run *run, ll_ode_reason reason);

/* Outcome of the run; ok if it has not failed. */
ll_run_status ll_ode_run_status(const ll_ode_run *run);

/* Why the run diverged, as a sentence with the time: `A value was not finite at t = 1.25 s.` */
void ll_ode_reason_text(const ll_ode_run *run, char *text, size_t size);

static inline const double *ll_ode_y(const ll_ode_run *run)
{
    return run->data + run->current * run->stride;
}

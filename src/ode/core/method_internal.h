/* For the methods: how a row of the table steps, and shared arithmetic.
 *
 * A vector of a run has `stride` doubles: dim rounded up to even. The extra one, if dim is odd, stays zero,
 * so that loops run over pairs. */
#pragma once

#include "base/detmath.h"
#include "ode/core/kernels.h"
#include "ode/core/run.h"

/* Steps of a method. The driver (run.c) owns t, counts steps, accepts or rejects them, looks for events and
 * checks that values are finite. */
typedef struct ll_ode_body {
    int vectors;              /* work vectors of `stride` doubles: ll_ode_work(run, 0) and on */
    size_t (*extra)(int dim); /* further doubles after the vectors: ll_ode_extra; NULL: none */

    /* The step that the error allows from (run->t, y), known before the attempt, > 0; may be infinite. The
     * driver does not exceed it. NULL: by the error of the step before. */
    double (*limit)(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode);

    /* Writes the state after a step of `h` from (run->t, y) to ll_ode_next(run). Leaves everything that
     * another attempt needs. Returns the mean square of the estimated error relative to the tolerance, 0 for
     * fixed-step methods; NaN or infinite: failed. */
    double (*attempt)(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h);

    /* The attempt was accepted; run->t, run->t_last and the two states are updated. NULL: nothing to do. */
    void (*accept)(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h);

    /* Step size after a step of `h` with this error. NULL: by the order and a PI controller. */
    double (*propose)(ll_ode_run *run, const ll_ode_method *method, double h, double error);

    /* y at t_last + theta h of the last step. NULL: cubic Hermite interpolation. */
    void (*dense)(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y);

    int error_order; /* order of the estimate: the error of a step is proportional to h^error_order; adaptive
                        methods */
} ll_ode_body;

static inline ll_pair ll_pair_at(const double *x)
{
    return *(const ll_pair *)x;
}

static inline void ll_pair_put(double *x, ll_pair value)
{
    *(ll_pair *)x = value;
}

static inline double *ll_ode_state_y(ll_ode_run *run)
{
    return run->data + run->current * run->stride;
}

static inline double *ll_ode_next(ll_ode_run *run)
{
    return run->data + (1 - run->current) * run->stride;
}

/* The state at the end of the last step, before an event's jump. */
static inline double *ll_ode_end(ll_ode_run *run)
{
    return run->data + (run->event >= 0 ? 2 : run->current) * run->stride;
}

static inline double *ll_ode_work(ll_ode_run *run, int vector)
{
    return run->data + (3 + vector) * run->stride;
}

static inline double *ll_ode_extra(ll_ode_run *run, const ll_ode_method *method)
{
    return ll_ode_work(run, method->body->vectors);
}

static inline void ll_ode_f(ll_ode_run *run, const ll_ode *ode, double t, const double *y, double *dy)
{
    run->counters.evaluations++;
    ll_ode_eval(ode, t, y, dy);
}

/* Acceleration of a mechanical system. */
static inline void ll_ode_a(ll_ode_run *run, const ll_ode *ode, double t, const double *q, const double *v,
                            double *a)
{
    run->counters.evaluations++;
    ode->acceleration(ode->params, t, q, v, a);
}

/* Mean over the components of (e / (tolerance + tolerance max(|y|, |next|)))^2. */
double ll_ode_norm2(const ll_ode_run *run, const double *e);

/* Step size after one of `h` with the mean square `error`, where the error of a step is proportional to
 * h^order. */
double ll_ode_propose(ll_ode_run *run, double h, double error, double order);

/* x^p for x > 0, within 1 %: for step sizes, which need not be exact but must be the same everywhere. */
double ll_ode_power(double x, double p);

static inline void ll_ode_copy(int stride, const double *from, double *to)
{
    for (int i = 0; i < stride; i += 2)
        ll_pair_put(to + i, ll_pair_at(from + i));
}

static inline ll_ode_trial ll_ode_trial_of(ll_ode_run *run, double h, double *k)
{
    return (ll_ode_trial){.t = run->t,
                          .h = h,
                          .absolute = run->control.absolute,
                          .relative = run->control.tolerance,
                          .y = ll_ode_state_y(run),
                          .k = k,
                          .next = ll_ode_next(run),
                          .stride = run->stride};
}

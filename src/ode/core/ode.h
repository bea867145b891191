/* A system of ordinary differential equations y' = f(t, y), as data for every integrator.
 *
 * A mechanical system has y = (q, v), positions first, then velocities in the same order, and gives its
 * acceleration a(t, q, v); its f is then (v, a). Any other system gives f. SI units throughout.
 *
 * All functions are pure: they depend on their arguments only; `params` is the problem's own struct. They
 * write every component of their result and nothing else. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/pair.h"

enum { LL_ODE_DIM_MAX = 256, LL_ODE_EVENTS_MAX = 4 };

/* dy/dt at (t, y), `dim` components each. */
typedef void ll_ode_rhs(const void *params, double t, const double *y, double *dy);

/* d2q/dt2 at (t, q, v), dim / 2 components each. */
typedef void ll_ode_acceleration(const void *params, double t, const double *q, const double *v, double *a);

/* jacobian[i * dim + j] = df_i / dy_j, of the whole first-order system. */
typedef void ll_ode_jacobian(const void *params, double t, const double *y, double *jacobian);

/* The parts of an acceleration e(t, q) + v x b(t, q): `e` has dim / 2 components, `b` three (charge and mass
 * are included in both). In the plane only b[2] counts. */
typedef void ll_ode_magnetic(const void *params, double t, const double *q, double *e, double *b);

/* Taylor coefficients of the solution through (t, y): row k of `series` is its k-th derivative over k!, row
 * 0, which the caller fills in, is y. Writes rows 1 to `order` (at most LL_SERIES_ORDER: ode/core/series.h).
 * A row has dim numbers, rounded up to even; the extra one is not written. */
typedef void ll_ode_series(const void *params, double t, int order, double *series);

/* Two states at once, component by component: lane l of y[i] is component i of state l. Each lane computes
 * the same bits as the function of one state. */
typedef void ll_ode_rhs_pair(const void *params, const ll_pair *t, const ll_pair *y, ll_pair *dy);
typedef void ll_ode_acceleration_pair(const void *params, const ll_pair *t, const ll_pair *q,
                                      const ll_pair *v, ll_pair *a);
typedef void ll_ode_magnetic_pair(const void *params, const ll_pair *t, const ll_pair *q, ll_pair *e,
                                  ll_pair *b);

/* Action after an event. A system at rest keeps its state until the end. */
typedef enum ll_ode_action { LL_ODE_GO_ON, LL_ODE_REST } ll_ode_action;

/* A zero crossing of g(t, y), located to the last digits of t. Checked at the ends of steps: two crossings
 * within one step cancel. If g is exactly 0 at the start of a step, it counts as the side from which a
 * crossing in `direction` starts, since a jump puts y exactly on the surface. */
typedef struct ll_ode_event {
    const char *name; /* `impact` */
    int direction;    /* -1: g decreases through zero; +1: increases; 0: either */
    double (*g)(const void *params, double t, const double *y);
    ll_ode_action (*jump)(const void *params, double t, double *y); /* changes y; NULL: only recorded */
} ll_ode_event;

typedef struct ll_ode {
    int dim;                 /* 1 to LL_ODE_DIM_MAX; even in a mechanical system */
    bool velocity_dependent; /* whether a(t, q, v) depends on v */
    bool autonomous;         /* whether f is independent of t */
    const void *params;      /* passed to every function */

    ll_ode_rhs *f; /* of a system that is not mechanical, otherwise NULL */
    ll_ode_acceleration *acceleration;
    ll_ode_jacobian *jacobian; /* NULL: by finite differences */
    ll_ode_magnetic *magnetic; /* NULL: none; e + v x b must equal the acceleration */
    ll_ode_series *series;     /* of a system that is smooth, with every set of parameters; NULL: none */

    const struct ll_ode_kernels *kernels; /* loops of methods compiled with this system's f; NULL: none */

    const ll_ode_event *events; /* in the order in which simultaneous ones are applied */
    int event_count;            /* at most LL_ODE_EVENTS_MAX */
} ll_ode;

static inline bool ll_ode_mechanical(const ll_ode *ode)
{
    return ode->acceleration != NULL;
}

/* f of either kind of system. `dy` must not overlap `y`. */
static inline void ll_ode_eval(const ll_ode *ode, double t, const double *y, double *dy)
{
    if (ode->acceleration == NULL) {
        ode->f(ode->params, t, y, dy);
        return;
    }
    int half = ode->dim / 2;
    if (half <= 2) { /* a call of memcpy would cost as much as the rest */
        dy[0] = y[half];
        dy[half - 1] = y[2 * half - 1];
    } else {
        for (int i = 0; i < half; i++)
            dy[i] = y[half + i];
    }
    ode->acceleration(ode->params, t, y, y + half, dy + half);
}

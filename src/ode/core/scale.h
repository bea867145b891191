/* How large what a problem is about is: against this an error is large or small. */
#pragma once

#include <stdbool.h>

#include "ode/core/method.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"

/* The largest so far, along the solution. */
typedef struct ll_ode_scale {
    double state;  /* Euclidean length of the state, in the units of its components */
    double energy; /* J: of the total, the kinetic and the potential energy; 0 without an energy */
} ll_ode_scale;

/* Takes the solution's state at `t` into account. Values that are not finite are passed over. */
void ll_ode_scale_see(ll_ode_scale *scale, const ll_ode_problem *problem, const ll_ode *ode, double t,
                      const double *y);

/* Of both together. */
void ll_ode_scale_join(ll_ode_scale *scale, const ll_ode_scale *other);

/* Whether a state whose distance from the solution is `error`, and whose energy has changed by `energy` J, is
 * beyond LL_BLOWN_UP times the scale. Where the scale is 0 nothing is known to be large; a value that is not
 * finite always is. */
bool ll_ode_blown_up(const ll_ode_scale *scale, double error, double energy);

/* ---- solutions where there is no formula ----
 *
 * Two references of different families, each at the least tolerance that serves: what they differ by is what
 * is not known of the solution. An error below that is not known either. */

enum { LL_ODE_REFERENCES = 2 };

const ll_ode_method *ll_ode_reference_method(const ll_ode_problem *problem, int which);
ll_ode_control ll_ode_reference_control(double t_end);

/* The solution of a chaotic problem is predictable as long as its references differ by less than this part of
 * the scale. */
#define LL_ODE_PREDICTABLE 1e-3

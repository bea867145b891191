/* How large what a problem is about is: against this an error is large or small. */
#pragma once

#include <stdbool.h>

#include "ode/problem.h"

/* The largest so far, along the solution. */
typedef struct ll_ode_scale {
    double state;  /* Euclidean length of the state, in the units of its components */
    double energy; /* J: of the total, the kinetic and the potential energy; 0 without an energy */
} ll_ode_scale;

/* Takes the solution's state at `t` into account. Values that are not finite are passed over. */
void ll_ode_scale_see(ll_ode_scale *scale, const ll_ode_problem *problem, const ll_ode *ode, double t,
                      const double *y);

/* Whether a state whose distance from the solution is `error`, and whose energy has changed by `energy` J, is
 * beyond LL_BLOWN_UP times the scale. Where the scale is 0 nothing is known to be large; a value that is not
 * finite always is. */
bool ll_ode_blown_up(const ll_ode_scale *scale, double error, double energy);

/* Scale of a problem: errors are large or small relative to it. */
#pragma once

#include <stdbool.h>

#include "ode/core/method.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"

/* Largest values so far along the solution. */
typedef struct ll_ode_scale {
    double state;  /* Euclidean norm of the state, in the units of its components */
    double energy; /* J: largest of total, kinetic and potential energy; 0 without an energy */
} ll_ode_scale;

/* Includes the solution's state at `t`. Values that are not finite are ignored. */
void ll_ode_scale_see(ll_ode_scale *scale, const ll_ode_problem *problem, const ll_ode *ode, double t,
                      const double *y);

/* Maximum of both. */
void ll_ode_scale_join(ll_ode_scale *scale, const ll_ode_scale *other);

/* Whether a state with this distance from the solution and this change of energy, J, is beyond LL_BLOWN_UP
 * times the scale. With a scale of 0, only a value that is not finite is. */
bool ll_ode_blown_up(const ll_ode_scale *scale, double error, double energy);

/* ---- solutions without a closed form ----
 *
 * Two references of different families, each at the smallest useful tolerance: their difference is the
 * uncertainty of the solution. Smaller errors are unknown. */

enum { LL_ODE_REFERENCES = 2 };

const ll_ode_method *ll_ode_reference_method(const ll_ode_problem *problem, int which);
ll_ode_control ll_ode_reference_control(double t_end);

/* A chaotic problem is predictable while its references differ by less than this fraction of the scale. */
#define LL_ODE_PREDICTABLE 1e-3

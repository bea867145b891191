/* Distance of a run from the solution, over all of its steps: at the end of each and, with dense output, at
 * three times within. It does not depend on when it is read.
 *
 * There are two errors: the Euclidean distance of the whole state, in which large components hide small ones,
 * and the weighted error, each component relative to its own scale, of which the largest counts. */
#pragma once

#include "ode/core/scale.h"

/* Fractions of a step at which it is measured. */
#define LL_ODE_POINTS 4

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* part of blocks that are hashed */

typedef struct ll_ode_measure {
    double t;                               /* s, of the last measurement */
    double error, error_max, error_squares; /* last, largest, integral of the square over time */
    double time;                            /* s, of that integral */
    double energy_start;                    /* J */
    double drift, drift_max;                /* J, since the start: last, largest magnitude */
    double sums[5];                         /* over time: 1, t, t^2, drift, t drift; for the secular drift */
    ll_ode_scale scale;
} ll_ode_measure;

#pragma GCC diagnostic pop

/* Values per component, in `each` by rows: magnitude of its error, as above, and its largest magnitude in the
 * solution. */
enum { LL_ODE_LAST, LL_ODE_MOST, LL_ODE_SQUARES, LL_ODE_SIZE, LL_ODE_ROWS };

void ll_ode_measure_start(ll_ode_measure *m, double *each, const ll_ode_problem *problem, const ll_ode *ode,
                          const double *y0);

/* Compares both states at `t`, with a weight of `span` seconds. With `known` false the largest and the
 * integral skip it: the solution is not known there. */
void ll_ode_measure_at(ll_ode_measure *m, double *each, const ll_ode *ode, double t, double span,
                       const double *y, const double *solution, bool known);

/* Energy of the state at the end of a step of `span` seconds; `passed`: time since the start. */
void ll_ode_measure_energy(ll_ode_measure *m, const ll_ode_problem *problem, const ll_ode *ode, double passed,
                           double span, const double *y);

/* Times at which to measure the last step, at most LL_ODE_POINTS, its end last; only the end if the method
 * has no dense output. Returns their count. */
int ll_ode_measure_points(const ll_ode_run *run, const ll_ode_method *method, double *t);

/* Whether the last measurement exceeds all bounds. */
bool ll_ode_measure_blown_up(const ll_ode_measure *m);

/* Methods that are stable at any step stay bounded even if they do not resolve a stiff problem. If no energy
 * shows that, a whole run is compared with the solution: false if the weighted error, last or root mean
 * square, is above LL_ODE_RESOLVED. */
#define LL_ODE_RESOLVED (1. / 3)
bool ll_ode_measure_resolved(const ll_ode_measure *m, const double *each, const ll_ode_problem *problem,
                             const ll_ode *ode);

/* Over the time for which the solution is known; 0 before. */
double ll_ode_measure_rms(const ll_ode_measure *m);

/* Weighted error by one of the rows: last, largest or root mean square. In a mechanical system positions
 * share a scale, and so do velocities; otherwise each component has its own. */
double ll_ode_measure_weighted(const ll_ode_measure *m, const double *each, const ll_ode *ode, int row);

/* `drift` J relative to the initial energy, or, if that is negligible against the solution's kinetic and
 * potential energies, to the largest of these. In J if there is none. */
double ll_ode_measure_relative(const ll_ode_measure *m, double drift);

double ll_ode_measure_slope(const ll_ode_measure *m); /* of the relative drift, 1/s: by least squares */

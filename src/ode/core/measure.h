/* How far a run is from the solution, over all of its steps: at the end of each and, where the method has
 * dense output, at three times within. What is told does not depend on when anybody looks.
 *
 * The error is told twice: as the Euclidean distance of the whole state, in which large components hide small
 * ones, and weighted, each component against its own scale, of which the worst counts. */
#pragma once

#include "ode/core/scale.h"

/* The times of a step at which it is measured, in parts of it. */
#define LL_ODE_POINTS 4

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* part of blocks that are hashed */

typedef struct ll_ode_measure {
    double t;                               /* s, of the point measured last */
    double error, error_max, error_squares; /* last, largest, integral of the square over time */
    double time;                            /* s, of that integral */
    double energy_start;                    /* J */
    double drift, drift_max;                /* J, since the start: last, largest magnitude */
    double sums[5];                         /* over time: 1, t, t^2, drift, t drift; for the secular slope */
    ll_ode_scale scale;
} ll_ode_measure;

#pragma GCC diagnostic pop

/* What is kept of each component, behind one another in `each`: the magnitude of its error, as above, and the
 * largest magnitude that it has in the solution. */
enum { LL_ODE_LAST, LL_ODE_MOST, LL_ODE_SQUARES, LL_ODE_SIZE, LL_ODE_ROWS };

void ll_ode_measure_start(ll_ode_measure *m, double *each, const ll_ode_problem *problem, const ll_ode *ode,
                          const double *y0);

/* Both states at `t`, which stands for `span` seconds. With `known` false the largest and the integral leave
 * it out: the solution is not known there. */
void ll_ode_measure_at(ll_ode_measure *m, double *each, const ll_ode *ode, double t, double span,
                       const double *y, const double *solution, bool known);

/* The energy of the state at the end of a step of `span` seconds; `passed` is the time since the start. */
void ll_ode_measure_energy(ll_ode_measure *m, const ll_ode_problem *problem, const ll_ode *ode, double passed,
                           double span, const double *y);

/* The times at which to measure the step that a run has made last, at most LL_ODE_POINTS, the end last: that
 * alone where the method has no dense output. Returns how many. */
int ll_ode_measure_points(const ll_ode_run *run, const ll_ode_method *method, double *t);

/* Whether what was measured last is beyond all bounds. */
bool ll_ode_measure_blown_up(const ll_ode_measure *m);

/* Methods that are stable at any step stay bounded however little of a stiff problem they resolve. Where no
 * energy shows that, a whole run is held against the solution: false where the weighted error, last or root
 * mean square, is above LL_ODE_RESOLVED. */
#define LL_ODE_RESOLVED (1. / 3)
bool ll_ode_measure_resolved(const ll_ode_measure *m, const double *each, const ll_ode_problem *problem,
                             const ll_ode *ode);

/* Of a known stretch; 0 before there is one. */
double ll_ode_measure_rms(const ll_ode_measure *m);

/* The weighted error by one of the rows: last, largest or root mean square. In a mechanical system positions
 * share a scale, and so do velocities; otherwise each component has its own. */
double ll_ode_measure_weighted(const ll_ode_measure *m, const double *each, const ll_ode *ode, int row);

/* `drift` J against the energy at the start; where that is next to nothing beside the kinetic and potential
 * energies of the solution, against the largest of these. In J where there is none at all. */
double ll_ode_measure_relative(const ll_ode_measure *m, double drift);

double ll_ode_measure_slope(const ll_ode_measure *m); /* of the relative drift, 1/s: by least squares */

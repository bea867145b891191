/* Work-precision of integrators: a series of steps or tolerances per method on one problem; each level has
 * its cost and its error (Hairer, Norsett and Wanner; SciMLBenchmarks). */
#pragma once

#include "base/interrupt.h"
#include "base/status.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"

/* One refinement level. Errors are Euclidean distances of the whole state from the solution, and weighted as
 * in simulations of kind motion: `e_max` and `e_l2` over all steps (ode/core/measure.h), while the solution
 * is predictable. Errors and drifts of a failed run (ll_ode_scale has its cause) are NaN. */
typedef struct ll_work_precision {
    double setting; /* dt in s, or the tolerance */
    ll_run_status status;
    ll_ode_reason reason;
    ll_ode_counters counters;
    double cpu_min_s, cpu_median_s;
    int runs; /* whose time was measured */
    double e_final, e_max, e_l2;
    double e_final_weighted, e_max_weighted, e_l2_weighted;
    double size;        /* of the solution: its largest norm */
    double uncertainty; /* largest uncertainty of the solution; 0 by formula. Smaller errors are NaN */
    double
        predictable_s; /* until when the solution is known to LL_ODE_PREDICTABLE of its size; NaN: always */
    double drift_final, drift_max, drift_per_s; /* relative, of the energy; 0 if the problem has none */
    double order; /* against the previous level: log of errors over log of settings. NaN for the first level,
                     and where one of the errors is not well above uncertainty and rounding, or is above a
                     tenth of the size */
} ll_work_precision;

typedef struct ll_work_precision_request {
    const ll_ode_problem *problem;
    const void *params; /* prepared */
    double duration;    /* s; 0: that of the problem */
    int64_t steps_max;  /* most fixed steps of a run; 0: a million */
    int64_t (*now_ns)(void);
    const ll_interrupt *interrupt; /* NULL: none; may change between two levels */
} ll_work_precision_request;

enum { LL_WORK_PRECISION_LEVELS_MAX = 40 };

/* A series in progress. */
typedef struct ll_work_precision_run ll_work_precision_run;

/* `request` must outlive the run. A fixed step halves from a sixteenth of the duration until the error is
 * that of rounding, or `steps_max` is reached; a tolerance falls by tens from 1e-2 to 1e-14. LL_BAD_INPUT
 * when the method does not support the problem; LL_INTERRUPTED. */
ll_status ll_work_precision_start(const ll_work_precision_request *request, const ll_ode_method *method,
                                  ll_work_precision_run **run);
/* Measures the next level; false after the last, or on failure. */
bool ll_work_precision_next(ll_work_precision_run *run, ll_work_precision *level, ll_status *status);
void ll_work_precision_end(ll_work_precision_run *run); /* NULL: no effect */

/* Levels of a series at most. */
int ll_work_precision_levels(const ll_ode_method *method, int64_t steps_max);

/* Measures a whole series; fills at most LL_WORK_PRECISION_LEVELS_MAX levels and returns their count. */
ll_status ll_work_precision_series(const ll_work_precision_request *request, const ll_ode_method *method,
                                   ll_work_precision *refinement_levels, int *count);

/* A single level. */
ll_status ll_work_precision_level(const ll_work_precision_request *request, const ll_ode_method *method,
                                  double setting, ll_work_precision *refinement_level);

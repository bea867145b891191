/* Work against precision: a ladder of steps or tolerances per method on one problem, each rung with its cost
 * and its error (Hairer, Norsett and Wanner; SciMLBenchmarks). */
#pragma once

#include "base/status.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"

/* One rung. Errors are Euclidean distances of the whole state from the solution, and weighted, as in
 * simulations of kind motion: `e_max` and `e_l2` over all steps (ode/core/measure.h), as far as the solution
 * is predictable. Of a run that failed (ll_ode_scale tells what has blown up) errors and drifts are NaN. */
typedef struct ll_work_precision {
    double setting; /* dt in s, or the tolerance */
    ll_run_status status;
    ll_ode_reason reason;
    ll_ode_counters counters;
    double cpu_min_s, cpu_median_s;
    double e_final, e_max, e_l2;
    double e_final_weighted, e_max_weighted, e_l2_weighted;
    double size;          /* of the solution: its largest length */
    double uncertainty;   /* of the solution, the most: 0 by formula. Errors below are NaN */
    double predictable_s; /* until when the solution is known to LL_ODE_PREDICTABLE of its size; NaN: all
                             along */
    double drift_final, drift_max, drift_per_s; /* of the energy, relative; 0 where the problem has none */
    double order; /* of this rung against the one before: log of errors over log of settings; NaN for the
                     first, and where an error of both is not well above the uncertainty and rounding, or
                     above a tenth of the size */
} ll_work_precision;

typedef struct ll_work_precision_request {
    const ll_ode_problem *problem;
    const void *params; /* prepared */
    double duration;    /* s; the problem's own when 0 */
    int64_t (*now_ns)(void);
} ll_work_precision_request;

enum { LL_WORK_PRECISION_LEVELS_MAX = 40 };

/* Measures a method's ladder; fills at most LL_WORK_PRECISION_LEVELS_MAX rungs and tells how many. A fixed
 * step halves from a sixteenth of the duration until the error is that of rounding or a million steps are
 * reached; a tolerance falls by tens from 1e-2 to 1e-14. LL_BAD_INPUT when the method cannot do the problem.
 */
ll_status ll_work_precision_series(const ll_work_precision_request *order, const ll_ode_method *method,
                                   ll_work_precision *refinement_levels, int *count);

/* One rung alone. */
ll_status ll_work_precision_level(const ll_work_precision_request *order, const ll_ode_method *method,
                                  double setting, ll_work_precision *refinement_level);

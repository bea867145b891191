/* Outcome of a run, or of one of its side-by-side parts: a method, a solver, a fluid. Every kind of
 * simulation reports it as `status`, with a `reason` if it is not `ok`. Errors and metrics of such a part are
 * null, and comparisons of runs (averages, fronts, advice) omit it. */
#pragma once

typedef enum ll_run_status {
    LL_RUN_OK,
    LL_RUN_DIVERGED, /* a value was not finite, or beyond LL_BLOWN_UP times the problem's scale */
    LL_RUN_OFF,      /* not run */
    LL_RUN_FAILED, /* it gave up: no solution of its equations, too small a step, too many steps; or its steps
                      do not resolve the problem */
} ll_run_status;

extern const char *const ll_run_status_names[]; /* `ok`, `diverged`, `off`, `failed`; NULL-terminated */

/* Factor of the scale above which an error or a gain of energy has no meaning. */
#define LL_BLOWN_UP 10

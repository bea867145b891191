/* How a run ended, or a part of it that goes beside others: a method, a solver, a fluid. Every kind of
 * simulation tells it as `status`, with a `reason` where it is not `ok`. What is not `ok` has no errors and
 * no measures: they are null, and whatever compares runs (averages, fronts, advice) leaves it out. */
#pragma once

typedef enum ll_run_status {
    LL_RUN_OK,
    LL_RUN_DIVERGED, /* a value was not finite, or blew up: beyond LL_BLOWN_UP times the problem's scale */
    LL_RUN_OFF,      /* it was not run */
    LL_RUN_FAILED, /* it gave up: no solution of its equations, too small a step, too many steps; or its steps
                    do not resolve the problem */
} ll_run_status;

extern const char *const ll_run_status_names[]; /* `ok`, `diverged`, `off`, `failed`; NULL-terminated */

/* An error or a gain of energy above so many times the scale of what is computed says nothing any more. */
#define LL_BLOWN_UP 10

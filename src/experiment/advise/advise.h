/* The adviser: finds the cheapest setting whose error stays within a limit, with few of an experiment's runs.
 *
 * If the runs are enough, every point is run with one seed. Else three tenths of the runs go to points spread
 * evenly over the grid, and then the search tries the untried point nearest to the best one so far: the
 * cheapest that holds, or before any does the one with the smallest error. More seeds follow, doubling each
 * time, while a point may still be the best (successive halving), until all its repeats were run or its error
 * is certainly too large.
 *
 * The advised setting has run all repeats and holds on fresh seeds, which the search has not used: the upper
 * bound of the 95 % interval of their mean error is within the limit. If fresh seeds give the same as the
 * others, nothing is random, and one is enough; but equal errors that may be rare counts do not prove that.
 * Of settings with equal cost over their common seeds it takes the one with the smaller error. Fresh seeds
 * go to the setting with the largest saving times probability to hold per seed needed: indices of
 * constrained best-arm identification, with common random numbers for cost differences and variances
 * moderated by those of all settings. The search stops when the runs are used up, or when no setting that
 * could be cheaper is left: then the optimum is proven, unless one of them may hold after all. Part of the
 * runs is reserved for verification. Errors and costs are compared by magnitude, and a setting with a failed
 * run is never advised. */
#pragma once

#include "experiment/spec/experiment.h"

enum { LL_ADVISE_POINTS_MAX = 5000 };

typedef struct ll_advise_request {
    const ll_experiment *experiment; /* its error and cost metrics are used; must not be sampled */
    double max_error;
    int64_t most_runs; /* 0: one of each point and 40; where seeds matter two fifths of all and 1024, if that
                          is more */
    const ll_interrupt *interrupt; /* NULL: cannot be interrupted; else LL_INTERRUPTED */
    _Atomic int64_t *runs;         /* NULL, or a counter of finished runs */
} ll_advise_request;

ll_status ll_advise_check(const ll_advise_request *request); /* errors that can be found before any run */
int64_t ll_advise_runs(const ll_advise_request *request);    /* maximum number of runs */

/* The answer as JSON:
 * {"holds","optimum","max_error","error_metric","cost_metric","advice":{...},"nearest":{...},"front":[...],
 * "ruled_out":[...],"runs","of_runs"}. `advice` is null when no setting holds; then `nearest` is the one with
 * the smallest error. Each setting has "point","set","error","error_ci95","cost","runs", and the advice
 * "verified" with "runs","error","error_ci95" over fresh seeds. `optimum` is `proven`, or `best found`: more
 * runs might find a cheaper one. Caller deletes. */
ll_status ll_advise(const ll_advise_request *request, struct cJSON **answer);

/* The adviser: finds the cheapest setting whose error stays within a limit, with few of an experiment's runs.
 *
 * Constrained Bayesian optimisation (Gardner et al., ICML 2014): a surrogate predicts cost and error of each
 * point; the next point tried is the one with the largest expected saving times the probability to hold. A
 * point is first tried with one seed. More seeds follow, doubling each time, while it may still be the best
 * (successive halving), until all its repeats were run or its error is certainly too large.
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

typedef struct ll_advise_request {
    const ll_experiment *experiment; /* its error and cost metrics are used; must not be sampled */
    double max_error;
    int64_t
        most_runs; /* 0: a fifth of all, at least 40; where seeds matter, as many again and 1024 fresh ones */
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

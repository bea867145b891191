/* The adviser: the cheapest setting whose error stays within a limit, found with few of an experiment's runs.
 *
 * Bayesian optimisation under a constraint (Gardner et al., ICML 2014): a surrogate tells for each point what
 * its cost and its error may be; next is tried where the expected saving times the chance to hold is largest.
 * A point is first tried with one seed; more seeds follow, twice as many each time, only while it may still
 * be the best (successive halving), until all its repeats were run or its error is surely too large.
 *
 * What it advises has run all repeats and holds on fresh seeds, that no search has seen: the upper bound of
 * the 95 % interval of their mean error is within the limit. Where fresh seeds give the same as the others
 * nothing is random, and one is enough; where errors are counts that may be rare, equal ones are not taken
 * for certain. Of settings that cost the same, over the seeds that both have run, it takes the one of less
 * error. Fresh seeds go where the saving times the chance to hold is most per seed that it may take: indices
 * of best-arm identification under a constraint, with common random numbers for the differences of costs and
 * variances moderated by those of all settings. It stops when the runs are spent, or when nothing is left
 * that could be cheaper: then the optimum is proven, unless one of them may hold after all. Part of the runs
 * is kept for verifying. Errors and costs are compared by magnitude, and a setting with a run that failed is
 * never advised. */
#pragma once

#include "experiment/spec/experiment.h"

typedef struct ll_advise_request {
    const ll_experiment *experiment; /* error and cost are its two metrics of the trade; not sampled */
    double max_error;
    int64_t
        most_runs; /* 0: a fifth of all, at least 40; where seeds matter as many again and 1024 fresh ones */
    const ll_interrupt *interrupt; /* NULL: it is never broken off; else LL_INTERRUPTED */
    _Atomic int64_t *runs;         /* NULL, or where it counts the runs as they are done */
} ll_advise_request;

ll_status ll_advise_check(const ll_advise_request *order); /* what can be told before any run */
int64_t ll_advise_runs(const ll_advise_request *order);    /* that it may do */

/* The answer as JSON:
 * {"holds","optimum","max_error","error_metric","cost_metric","advice":{...},"nearest":{...},"front":[...],
 * "ruled_out":[...],"runs","of_runs"}. `advice` is null when none holds; `nearest` then is the one of least
 * error. Each setting has "point","set","error","error_ci95","cost","runs", and the advice
 * "verified" with "runs","error","error_ci95" over fresh seeds. `optimum` is `proven`, or `best found`: more
 * runs might find a cheaper one. Caller deletes. */
ll_status ll_advise(const ll_advise_request *order, struct cJSON **answer);

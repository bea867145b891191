/* The adviser: the cheapest setting whose error stays within a limit, found with few of an experiment's runs.
 *
 * Bayesian optimisation under a constraint (Gardner et al., ICML 2014): a surrogate tells for each point what
 * its cost and its error may be; next is tried where the expected saving times the chance to hold is largest.
 * A point is first tried with one seed; more seeds follow, twice as many each time, only while it may still
 * be the best (successive halving), until all its repeats were run or its error is surely too large. What it
 * advises has run all repeats. */
#pragma once

#include "experiment/experiment.h"

typedef struct ll_advice_order {
    const ll_experiment *experiment; /* error and cost are its two metrics of the trade; not sampled */
    double max_error;
    int64_t most_runs; /* 0: a fifth of all, but at least 10 */
} ll_advice_order;

/* The answer as JSON:
 * {"holds","max_error","error_metric","cost_metric","advice":{...},"nearest":{...},"front":[...],
 * "ruled_out":[...],"runs","of_runs"}. `advice` is null when none holds; `nearest` then is the one of least
 * error. Each setting has "point","set","error","error_ci95","cost","runs". Caller deletes. */
ll_status ll_advise(const ll_advice_order *order, struct cJSON **answer);

/* Runs until the mean is known well enough: after some repeats of a point its interval is checked, and the
 * other repeats are skipped when half its width is small enough.
 *
 * Repeated checks make intervals too optimistic: 93 % of such intervals cover for normal values, 92 % for
 * lognormal ones. So checks are few, at `least` runs, twice as many, and so on up to `repeats`, and with K
 * checks the error is 0.05 / (1 + (K - 1) / 8), for every metric. Bonferroni's inequality would give 0.05 /
 * K, which covers 99 %, as checks of one growing sample mostly agree. tests/experiment/spec/test_until.c
 * counts the coverage. Whether a run is made depends only on earlier rows of its point. */
#pragma once

#include "experiment/spec/experiment.h"
#include "experiment/statistics/summary.h"

bool ll_until_is_set(const ll_experiment *experiment);

/* Maximum number of checks; 1 without a rule. */
int ll_until_checks(const ll_experiment *experiment);

/* Whether the interval is as narrow as the rule requires; true without a rule. */
bool ll_until_is_met(const ll_experiment *experiment, const ll_summary *summary);

/* Whether `made` runs of a point, its first ones, are enough. */
bool ll_until_reached(const ll_experiment *experiment, const ll_row *rows, int64_t made,
                      ll_resampler *resampler);

/* The row of a run that was not needed. */
void ll_until_skip(int64_t run, ll_row *row);

/* Parameters of a metric's intervals, without the values. `t_s`: end of the runs of the point, NaN if they
 * ended at different times. */
ll_interval_request ll_experiment_interval_request(const ll_experiment *experiment, int metric, int64_t point,
                                                   double t_s);

/* Runs until the mean is known well enough: after some of a point's repeats its interval is looked at, and
 * the rest are skipped when half of its width is small enough.
 *
 * Who looks often and stops when it looks good is too sure: of normal values 93 % of such intervals cover, of
 * lognormal ones 92 %. So looks are few, at `least` runs, twice as many, and so on up to `repeats`, and with
 * K looks the error is 0.05 / (1 + (K - 1) / 8), of every metric: less than the share that Bonferroni's
 * inequality would leave (0.05 / K, which covers 99 %), as looks at one growing sample agree for the most
 * part. tests/experiment/spec/test_until.c counts the coverage. Whether a run is made follows from the rows
 * before it of its point alone. */
#pragma once

#include "experiment/spec/experiment.h"
#include "experiment/statistics/summary.h"

bool ll_until_is_set(const ll_experiment *experiment);

/* How many looks there are at most; 1 without a rule. */
int ll_until_looks(const ll_experiment *experiment);

/* Whether the interval is as narrow as the rule wants; true without a rule. */
bool ll_until_is_met(const ll_experiment *experiment, const ll_summary *summary);

/* Whether `made` runs of a point, which are its first, are enough. */
bool ll_until_reached(const ll_experiment *experiment, const ll_row *rows, int64_t made,
                      ll_resampler *resampler);

/* A row in place of a run that was not needed. */
void ll_until_skip(int64_t run, ll_row *row);

/* How the intervals of a metric are made, but for the values. `t_s`: where the runs of the point ended, NaN
 * where they did not end together. */
ll_interval_order ll_experiment_order(const ll_experiment *experiment, int metric, int64_t point, double t_s);

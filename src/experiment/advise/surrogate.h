/* What a few runs let one expect of the others: a Gaussian process over the points of an experiment, for cost
 * and error at once (Rasmussen and Williams 2006, chapters 2, 4 and 5). Both are taken as logarithms, in
 * which the error of a method is nearly linear in the logarithm of its step. Of a few kernels each takes the
 * one under which its values are most likely, with the deviation that they show. */
#pragma once

#include "experiment/spec/experiment.h"

enum { LL_SURROGATE_OUTPUTS = 2, LL_SURROGATE_POINTS_MAX = 5000, LL_SURROGATE_SEEN_MAX = 1000 };

typedef struct ll_surrogate ll_surrogate;

/* For at most `most_seen` points that are seen. */
ll_status ll_surrogate_create(const ll_experiment *experiment, int64_t most_seen, ll_surrogate **surrogate);
void ll_surrogate_free(ll_surrogate *surrogate);

/* A point that was not seen before joins; its values may be told anew later. LL_LIMIT: they are too many. */
ll_status ll_surrogate_see(ll_surrogate *surrogate, int point);
void ll_surrogate_tell(ll_surrogate *surrogate, int point, const double values[LL_SURROGATE_OUTPUTS]);
void ll_surrogate_fit(ll_surrogate *surrogate); /* after telling, before expecting */

/* Mean and standard deviation at a point. */
void ll_surrogate_expect(const ll_surrogate *surrogate, int point, double mean[LL_SURROGATE_OUTPUTS],
                         double deviation[LL_SURROGATE_OUTPUTS]);
double ll_surrogate_doubt(const ll_surrogate *surrogate,
                          int point); /* relative variance, before any value is told */

/* Surrogate: predicts cost and error of all points of an experiment from a few runs, by a Gaussian process
 * (Rasmussen and Williams 2006, chapters 2, 4 and 5). Both are taken as logarithms, in which the error of a
 * method is nearly linear in the logarithm of its step. Of several kernels each output uses the one with the
 * highest likelihood, and the standard deviation estimated with it. */
#pragma once

#include "experiment/spec/experiment.h"

enum { LL_SURROGATE_OUTPUTS = 2, LL_SURROGATE_POINTS_MAX = 5000, LL_SURROGATE_SEEN_MAX = 1000 };

typedef struct ll_surrogate ll_surrogate;

/* For at most `most_seen` seen points. */
ll_status ll_surrogate_create(const ll_experiment *experiment, int64_t most_seen, ll_surrogate **surrogate);
void ll_surrogate_free(ll_surrogate *surrogate);

/* Adds a point that was not seen before; its values may be updated later. LL_LIMIT: too many. */
ll_status ll_surrogate_see(ll_surrogate *surrogate, int point);
void ll_surrogate_tell(ll_surrogate *surrogate, int point, const double values[LL_SURROGATE_OUTPUTS]);
void ll_surrogate_fit(ll_surrogate *surrogate); /* after values have changed, before predictions */

/* Mean and standard deviation at a point. */
void ll_surrogate_expect(const ll_surrogate *surrogate, int point, double mean[LL_SURROGATE_OUTPUTS],
                         double deviation[LL_SURROGATE_OUTPUTS]);
double ll_surrogate_doubt(const ll_surrogate *surrogate,
                          int point); /* relative variance, before values are known */

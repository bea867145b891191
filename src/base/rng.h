/* Counter-based random numbers: a value is a hash of (seed, stream, counter) and nothing else.
 *
 * There is no state to advance, so a stage that is switched off leaves the draws of the others as they were,
 * and a replay or a fork needs only the counters. */
#pragma once

#include <stdint.h>

uint64_t ll_rng_u64(uint64_t seed, uint64_t stream, uint64_t counter);

/* Uniform in [0, 1), a multiple of 2^-53. */
double ll_rng_unit(uint64_t seed, uint64_t stream, uint64_t counter);

/* Standard normal deviate of one uniform draw: inverse of the distribution function, Wichura's AS 241
 * (PPND16, Applied Statistics 37(3), 1988), relative error about 1e-15. */
double ll_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter);
double ll_normal_quantile(double p); /* p in (0, 1) */

/* Standard normal distribution function; relative error below 1e-14 for |x| <= 7, 3e-13 for |x| <= 36. */
double ll_normal_cdf(double x);

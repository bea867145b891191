/* Counter-based random numbers: a value is a hash of (seed, stream, counter) only.
 *
 * There is no state to advance, so a disabled stage does not change the draws of the others, and a replay or
 * a fork needs only the counters. */
#pragma once

#include <stdint.h>

#include "base/mix.h"

/* The seed and the stream choose a start; the counter steps from there. Half of the mixer scrambles the
 * start, to separate neighbouring seeds and streams; the whole mixer is applied to start + counter * step.
 * Inline, since scripts draw several times per tick. */
static inline uint64_t ll_rng_u64(uint64_t seed, uint64_t stream, uint64_t counter)
{
    uint64_t start = seed + (stream + 1) * UINT64_C(0xd1e8d69ec377210f); /* + 1: the mixer maps 0 to 0 */
    start ^= start >> 32;
    start *= UINT64_C(0xd60927fc6f0de0d1);
    start ^= start >> 29;
    return ll_mix(start + counter * LL_MIX_STEP);
}

/* Uniform in [0, 1), a multiple of 2^-53. */
static inline double ll_rng_unit(uint64_t seed, uint64_t stream, uint64_t counter)
{
    return (double)(ll_rng_u64(seed, stream, counter) >> 11) * 0x1p-53;
}

/* Standard normal deviate of one uniform draw: inverse of the distribution function, Wichura's AS 241
 * (PPND16, Applied Statistics 37(3), 1988), relative error about 1e-15. */
double ll_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter);
double ll_normal_quantile(double p); /* p in (0, 1) */

/* Standard normal distribution function; relative error below 1e-14 for |x| <= 7, 3e-13 for |x| <= 36. */
double ll_normal_cdf(double x);

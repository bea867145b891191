/* Distribution of non-negative values in constant memory.
 *
 * Count, mean, rms and maximum are exact. A quantile is the smallest value that the fraction q of all values
 * does not exceed. Quantiles come from log-linear buckets: 32 of one unit, centred on integer multiples of
 * it, then 32 per octave. So their error is at most half a unit below 32 units and at most 1/63 above;
 * integer multiples below 63 units are exact. They are within [min, max]; the smallest and the largest value
 * are exact. Beyond 2^18 units all values share the last bucket.
 *
 * An event that never happens is an infinite value: it counts, and quantiles that fall on it are infinite;
 * mean, rms and maximum are those of the finite values. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "base/assert.h"

#define LL_HISTOGRAM_BUCKETS 448 /* 32 linear, then 13 octaves of 32 */
#define LL_HISTOGRAM_LINEAR 32   /* also the number of buckets per octave */

typedef struct ll_histogram {
    double unit;     /* width of the linear buckets, in the metric's unit */
    double per_unit; /* 1 / unit: values are added in every frame, and a division is slow */
    double sum, sum_squares;
    double min, max;                       /* infinite and 0 before the first value */
    int64_t count;                         /* of the finite values */
    int64_t never;                         /* infinite ones */
    uint32_t bucket[LL_HISTOGRAM_BUCKETS]; /* the last one includes larger values */
} ll_histogram;

typedef struct ll_summary {
    double mean, rms, p50, p95, p99, max; /* NaN without values */
    int64_t count, never;                 /* `count` includes infinite ones */
} ll_summary;

void ll_histogram_init(ll_histogram *h, double unit);

/* Buckets of v = value / unit + 1/2: this centres the linear ones on integer multiples of the unit, so that
 * counts come out as integers.
 *
 * From 32 on, the exponent of v and the five bits after it are the bucket's number, and stand in the double
 * as such: no logarithm. */
static inline int ll_histogram_bucket(double v)
{
    if (v < LL_HISTOGRAM_LINEAR)
        return (int)v;
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    uint64_t i = (bits >> 47) - (1023 + 5) * LL_HISTOGRAM_LINEAR +
                 LL_HISTOGRAM_LINEAR; /* 32 = 2^5 has exponent 1023 + 5 */
    return i < LL_HISTOGRAM_BUCKETS ? (int)i : LL_HISTOGRAM_BUCKETS - 1;
}

/* value >= 0. Inline, since a frame adds about ten values per player. */
static inline void ll_histogram_add(ll_histogram *h, double value)
{
    h->count++;
    if (!(value > 0)) {        /* most errors and corrections of a clean link */
        LL_ASSERT(value == 0); /* fails for NaN too */
        h->min = 0;
        h->bucket[0]++;
        return;
    }
    if (value > h->max)
        h->max = value;
    if (value < h->min)
        h->min = value;
    h->sum += value;
    h->sum_squares += value * value;
    h->bucket[ll_histogram_bucket(value * h->per_unit + 0.5)]++;
}

void ll_histogram_add_never(ll_histogram *h);

/* q in [0, 1]; NaN when empty */
double ll_histogram_quantile(const ll_histogram *h, double q);
ll_summary ll_histogram_summary(const ll_histogram *h);

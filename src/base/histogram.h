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

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/assert.h"
#include "base/pair.h"

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
    static const double top =
        0x1.fffffffffffffp17; /* the largest of the last bucket but for what shares it */
    if (v < LL_HISTOGRAM_LINEAR)
        return (int)v;
    uint64_t bits;
    v = v < top ? v : top;
    memcpy(&bits, &v, sizeof bits);
    return (int)(bits >> 47) - (1023 + 5) * LL_HISTOGRAM_LINEAR +
           LL_HISTOGRAM_LINEAR; /* 32 = 2^5 has exponent 1023 + 5 */
}

/* Both sums at once: they lie side by side. */
static inline ll_pair *ll_histogram_sums(ll_histogram *h)
{
    _Static_assert(offsetof(ll_histogram, sum_squares) == offsetof(ll_histogram, sum) + sizeof(double),
                   "the sums are a pair");
    return (ll_pair *)(void *)&h->sum;
}

/* Adds a value >= 0 `times` times: the same as that many calls of ll_histogram_add. Inline, since a frame
 * adds about ten values per player. */
LL_INLINE void ll_histogram_add_times(ll_histogram *h, double value, int times)
{
    h->count += times;
    if (!(value > 0)) {        /* most errors and corrections of a clean link */
        LL_ASSERT(value == 0); /* fails for NaN too */
        h->min = 0;
        h->bucket[0] += (uint32_t)times;
        return;
    }
    if (value > h->max)
        h->max = value;
    if (value < h->min)
        h->min = value;
    const ll_pair both = {value, value * value};
    ll_pair sums = *ll_histogram_sums(h);
    for (int i = 0; i < times; i++)
        sums += both;
    *ll_histogram_sums(h) = sums;
    h->bucket[ll_histogram_bucket(value * h->per_unit + 0.5)] += (uint32_t)times;
}

static inline void ll_histogram_add(ll_histogram *h, double value)
{
    ll_histogram_add_times(h, value, 1);
}

void ll_histogram_add_never(ll_histogram *h);

/* q in [0, 1]; NaN when empty */
double ll_histogram_quantile(const ll_histogram *h, double q);
ll_summary ll_histogram_summary(const ll_histogram *h);

/* A distribution of non-negative values in constant memory.
 *
 * Count, mean, rms and maximum are exact. Quantiles (of the smallest value that the share q of all does not
 * exceed) come from log-linear buckets: 32 of one unit, centred on whole multiples of it, then 32 an octave.
 * Hence they are at most half a unit off below 32 units and at most 1/63 above, and exact for whole multiples
 * below 63 units. They lie within [min, max]; the smallest and the largest value are exact. Beyond 2^18 units
 * all values share the last bucket.
 *
 * What never comes about is an infinite value: it counts, and quantiles that fall on it are infinite; mean,
 * rms and maximum are those of the finite values.
 */
#pragma once

#include <stdint.h>

#define LL_HISTOGRAM_BUCKETS 448 /* 32 linear, then 13 octaves of 32 */

typedef struct ll_histogram {
    double unit;     /* width of the linear buckets, in the metric's own unit */
    double per_unit; /* 1 / unit: a value is added in every frame, and a division takes its time */
    double sum, sum_squares, min, max;
    int64_t count;                         /* of the finite values */
    int64_t never;                         /* infinite ones */
    uint32_t bucket[LL_HISTOGRAM_BUCKETS]; /* the last also takes what is beyond */
} ll_histogram;

typedef struct ll_summary {
    double mean, rms, p50, p95, p99, max; /* NaN where there is no value */
    int64_t count, never;                 /* `count` has the infinite ones too */
} ll_summary;

void ll_histogram_init(ll_histogram *h, double unit);
void ll_histogram_add(ll_histogram *h, double value); /* value >= 0 */
void ll_histogram_add_never(ll_histogram *h);

/* q in [0, 1]; NaN when empty */
double ll_histogram_quantile(const ll_histogram *h, double q);
ll_summary ll_histogram_summary(const ll_histogram *h);

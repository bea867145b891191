#include "base/histogram.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

#define LINEAR LL_HISTOGRAM_LINEAR

/* Centre of bucket `i`, in units. */
static double middle_of(int i)
{
    if (i < LINEAR)
        return i;
    double width = (double)(INT64_C(1) << (i / LINEAR - 1));
    return width * (LINEAR + i % LINEAR + 0.5) - 0.5;
}

void ll_histogram_init(ll_histogram *h, double unit)
{
    LL_ASSERT(unit > 0);
    memset(h, 0, sizeof *h);
    h->unit = unit;
    h->per_unit = 1 / unit;
    h->min = INFINITY;
}

void ll_histogram_add_never(ll_histogram *h)
{
    h->never++;
}

/* 1-based rank of the smallest value that at least the fraction `q` of all values does not exceed. */
static int64_t rank_of(double q, int64_t count)
{
    double exact = q * (double)count;
    int64_t rank = (int64_t)exact;
    if (exact - (double)rank > 1e-9) /* 0.07 * 100 is 7 plus a rounding error */
        rank++;
    return rank < 1 ? 1 : rank > count ? count : rank;
}

double ll_histogram_quantile(const ll_histogram *h, double q)
{
    if (h->count + h->never == 0)
        return NAN;
    int64_t rank = rank_of(q, h->count + h->never);
    if (rank > h->count)
        return INFINITY;
    if (rank == 1)
        return h->min;
    if (rank == h->count)
        return h->max;
    int i = 0;
    for (int64_t seen = h->bucket[0]; seen < rank && i < LL_HISTOGRAM_BUCKETS - 1; seen += h->bucket[i])
        i++;
    double value = middle_of(i) * h->unit;
    return value < h->min ? h->min : value > h->max ? h->max : value;
}

ll_summary ll_histogram_summary(const ll_histogram *h)
{
    double n = (double)h->count;
    bool any = h->count > 0;
    return (ll_summary){
        .mean = any ? h->sum / n : NAN,
        .rms = any ? ll_sqrt(h->sum_squares / n) : NAN,
        .p50 = ll_histogram_quantile(h, 0.5),
        .p95 = ll_histogram_quantile(h, 0.95),
        .p99 = ll_histogram_quantile(h, 0.99),
        .max = any ? h->max : NAN,
        .count = h->count + h->never,
        .never = h->never,
    };
}

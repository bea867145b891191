/* Intervals of a mean over repeats, chosen by what the values are so that their coverage is what they say.
 *
 * Which method is taken is told with every interval. Where no method can be held to the level the interval is
 * none and the reason is told. tests/experiment/statistics/test_interval.c counts the coverage of each over
 * simulated experiments.
 *
 * bootstrap-t: studentised bootstrap (Efron 1982; Hall, The Bootstrap and Edgeworth Expansion, 1992, 3.2).
 * The quantiles of Student's t are replaced by those of (mean* - mean) / sd* over LL_RESAMPLES resamples; so
 *     it is right for skewed values too. From LL_INTERVAL_LEAST values on; up to LL_BOOTSTRAP_MOST. Of fewer
 *     than LL_INTERVAL_LEVEL it is wide enough for values as skewed as lognormal ones of sigma 1: a bound,
 *     which covers even distributions more often than the level.
 * skewness-t: beyond that, Hall's transformation of t by the sample's skewness (J. R. Stat. Soc. B 54, 1992).
 * t: Student's. From LL_INTERVAL_LEVEL values on for those without tails (two modes, or flat), of which the
 *     bootstrap's are too wide; else only where it was asked for: of few values nobody can tell whether they
 *     are skewed.
 * clopper-pearson: of a share, from the binomial distribution (Biometrika 26, 1934). At least the level.
 * poisson: of counts, from the Poisson distribution (Garwood, Biometrika 28, 1936); none in n runs leave
 *     room for 3.69 / n. At least the level where events come by themselves. Of counts that scatter more, the
 *     same of total / dispersion events of that size (quasi-Poisson).
 * rare-events: values more than a third of which are one value, the least or the most: the others are
 *     weighted events (Fay and Feuer, Stat. Med. 16, 1997). At least the level, unless their sizes differ
 *     widely. Where one alone differs an amount's bound on its side is infinite.
 * order-statistics: of a median, by the binomial distribution; at least the level, whatever the distribution.
 *
 * No method knows of what no value shows: where one run in a hundred makes the mean (skewness near 5 and few
 * values that show it) amounts are covered by some 90 % up to 50 values, and groups of unlike size by 92 to
 * 98.7 %; ll_interval_covers says so. Student's t, Johnson's, Hall's transformation, plain bootstrap-t, BCa,
 * bootstrapped Hall and empirical likelihood were tried on the first, and cover it less often (82 to 87 % of
 * 20). Of extremes no interval of the mean is told, but of the median. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef enum ll_interval_method {
    LL_INTERVAL_NONE,
    LL_INTERVAL_T,
    LL_INTERVAL_BOOTSTRAP_T,
    LL_INTERVAL_SKEWNESS_T,
    LL_INTERVAL_CLOPPER_PEARSON,
    LL_INTERVAL_POISSON,
    LL_INTERVAL_RARE,
    LL_INTERVAL_ORDER,
} ll_interval_method;

extern const char *const ll_interval_method_names[];

/* What a metric's values are. */
typedef enum ll_metric_scale {
    LL_SCALE_AMOUNT,  /* any number */
    LL_SCALE_COUNT,   /* whole numbers of events, from 0 */
    LL_SCALE_FLAG,    /* 0 or 1 */
    LL_SCALE_EXTREME, /* the largest, or nearly, of what a run has */
} ll_metric_scale;

enum {
    LL_EVENTS_LEAST = 5,    /* counts, and amounts that most values lack */
    LL_INTERVAL_LEAST = 10, /* amounts: fewer tell nothing of their distribution */
    LL_INTERVAL_LEVEL =
        20, /* amounts, from which the level is neither missed nor exceeded; below, it is a bound */
    LL_INTERVAL_MANY = 100,  /* amounts, from which that is so even where rare runs make much of the mean */
    LL_BOOTSTRAP_MOST = 200, /* values; beyond, skewness alone matters */
    LL_RESAMPLES = 1999,
};

typedef struct ll_interval {
    double low, high; /* NaN: none */
    ll_interval_method method;
    const char *why; /* of none: the reason */
} ll_interval;

/* The resamples, which are the same for all samples of a size: kept between calls. A value of its own per
 * thread; all 0 at first. */
typedef struct ll_resampler {
    int64_t n;
    uint8_t *index;   /* LL_RESAMPLES * n */
    double *deviates; /* LL_RESAMPLES */
} ll_resampler;

void ll_resampler_free(ll_resampler *resampler);

typedef struct ll_interval_order {
    const double *values; /* finite */
    int64_t n;
    ll_metric_scale scale;
    double unit;  /* of a count: what one event is worth, such as 1 / (seconds that were counted) for a rate;
                     0: 1 */
    double error; /* 1 - level, such as 0.05; above 0 and at most 0.2 */
    bool use_t;   /* Student's t for amounts, from two values on: who asks for it vouches for their shape */
} ll_interval_order;

/* Without memory for the resamples the interval is none. */
ll_interval ll_interval_of(const ll_interval_order *order, ll_resampler *resampler);

/* How often intervals that this method makes of such values hold their mean, in words, after what was
 * counted; empty of LL_INTERVAL_NONE. */
const char *ll_interval_covers(const ll_interval_order *order, ll_interval_method method);

/* Bounds of a share of which `k` of `n` were seen. */
ll_interval ll_interval_share(int64_t k, int64_t n, double error);

/* Of the median of sorted values. Tied values count as they stand. */
ll_interval ll_interval_median(const double *sorted, int64_t n, double error);

/* The quantile of sorted values between order statistics (Hyndman and Fan's type 7, as NumPy and R have it).
 */
double ll_sample_quantile(const double *sorted, int64_t n, double p);

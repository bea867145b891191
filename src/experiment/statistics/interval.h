/* Intervals of a mean over repeats. The method is chosen by the values, so that the coverage is as stated.
 *
 * Every interval comes with its method. If no method has the level, the interval is none, with the reason.
 * tests/experiment/statistics/test_interval.c counts the coverage of each method over simulated experiments.
 *
 * bootstrap-t: studentised bootstrap (Efron 1982; Hall, The Bootstrap and Edgeworth Expansion, 1992, 3.2).
 * The quantiles of Student's t are replaced by those of (mean* - mean) / sd* over LL_RESAMPLES resamples, so
 * that it is correct for skewed values too. From LL_INTERVAL_MIN to LL_BOOTSTRAP_MAX values. With fewer
 * than LL_INTERVAL_LEVEL it is wide enough for values as skewed as lognormal ones of sigma 1: a bound, which
 * covers symmetric distributions more often than the level.
 *
 * skewness-t: for more values, Hall's transformation of t by the sample's skewness (J. R. Stat. Soc. B 54,
 * 1992).
 *
 * t: Student's. From LL_INTERVAL_LEVEL values on for those without tails (two modes, or flat), for which the
 * bootstrap's are too wide; otherwise only on request, since a few values do not show whether they are
 * skewed.
 *
 * clopper-pearson: of a share, from the binomial distribution (Biometrika 26, 1934). At least the level.
 *
 * poisson: of counts, from the Poisson distribution (Garwood, Biometrika 28, 1936); with none in n runs the
 * bound is 3.69 / n. At least the level if events are independent. If counts scatter more, the same for total
 * / dispersion events of that size (quasi-Poisson).
 *
 * rare-events: for values more than a third of which are equal, to the minimum or the maximum: the others are
 * weighted events (Fay and Feuer, Stat. Med. 16, 1997). At least the level, unless their sizes differ widely.
 * If only one value differs, an amount's bound on its side is infinite.
 *
 * order-statistics: of a median, by the binomial distribution; at least the level, for any distribution.
 *
 * No method can see values that the sample lacks, and most samples of 20 lack what happens in one run of a
 * hundred. Such values are only ever large, so nearly all intervals that miss the mean are below it. Where
 * the table of metrics says so (LL_SCALE_TAILED), most of the error is therefore below the interval: 1.75
 * times half of it there, and 0.2 above (0.25 below LL_INTERVAL_LEVEL values). Normal values are covered as
 * often as before by an interval that is a tenth wider. Symmetric intervals (Student's t, Johnson's, Hall's
 * transformation, plain bootstrap-t, BCa, bootstrapped Hall, empirical likelihood) cover 82 to 91 % there.
 *
 * Differences of such values have the tail on the side of their mean. It is known from the same sample, so
 * the error on the other side keeps its half.
 *
 * Where a few runs make most of the mean there is no interval of the mean, but one of the median. Amounts in
 * two groups of different size are covered by 92 to 98.7 % below LL_INTERVAL_MANY values; ll_interval_covers
 * says so. */
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

/* Scale of a metric's values. */
typedef enum ll_metric_scale {
    LL_SCALE_AMOUNT,  /* any number */
    LL_SCALE_TAILED,  /* at least 0; a few runs in a hundred make much of the mean */
    LL_SCALE_COUNT,   /* whole numbers of events, from 0 */
    LL_SCALE_FLAG,    /* 0 or 1 */
    LL_SCALE_EXTREME, /* the maximum of a run, or nearly; or a few runs make most of the mean */
} ll_metric_scale;

enum {
    LL_EVENTS_MIN = 5,    /* minimum of values for counts, and for amounts that are mostly equal */
    LL_INTERVAL_MIN = 10, /* minimum for amounts: fewer do not show their distribution */
    LL_INTERVAL_LEVEL =
        20, /* amounts: with at least that many the coverage is the level; with fewer it is a bound */
    LL_INTERVAL_MANY =
        100, /* amounts: with at least that many this holds even when rare runs dominate the mean */
    LL_BOOTSTRAP_MAX = 200, /* values; with more, skewness-t */
    LL_RESAMPLES = 1999,
};

typedef struct ll_interval {
    double low, high; /* NaN: none */
    ll_interval_method method;
    const char *why; /* reason, if none */
} ll_interval;

/* The resamples, which are the same for all samples of a size, kept between calls. One per thread; initially
 * all 0. */
typedef struct ll_resampler {
    int64_t n;
    uint8_t *index;   /* LL_RESAMPLES * n */
    double *deviates; /* LL_RESAMPLES */
} ll_resampler;

void ll_resampler_free(ll_resampler *resampler);

typedef struct ll_interval_request {
    const double *values; /* finite */
    int64_t n;
    ll_metric_scale scale;
    double unit;     /* for counts: value of one event, such as 1 / (counted seconds) for a rate; 0: 1 */
    double error;    /* 1 - level, such as 0.05; above 0 and at most 0.2 */
    bool difference; /* of tailed values: those of two settings, with either sign */
    bool use_t; /* Student's t for amounts, from two values on: only if their distribution is known to suit */
} ll_interval_request;

/* Without memory for the resamples the interval is none. */
ll_interval ll_interval_of(const ll_interval_request *request, ll_resampler *resampler);

/* Coverage of intervals of this method for such values, in words, as counted by the tests; empty for
 * LL_INTERVAL_NONE. */
const char *ll_interval_covers(const ll_interval_request *request, ll_interval_method method);

/* Bounds of a share, from `k` of `n`. */
ll_interval ll_interval_share(int64_t k, int64_t n, double error);

/* Interval of the median of sorted values. Ties are allowed. */
ll_interval ll_interval_median(const double *sorted, int64_t n, double error);

/* Quantile of sorted values, interpolated (Hyndman and Fan's type 7, as in NumPy and R). */
double ll_sample_quantile(const double *sorted, int64_t n, double p);

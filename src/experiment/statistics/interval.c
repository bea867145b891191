#include "experiment/statistics/interval.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/assert.h"
#include "base/rng.h"
#include "experiment/statistics/distributions.h"

#define RESAMPLE_SEED 20170113

enum {
    FEW_EVENTS = 40, /* smaller counts are taken as Poisson distributed */
    FEW_OTHERS =
        15, /* with fewer values that differ from the most frequent one, the bootstrap is unreliable */
};

/* For samples as skewed as this, or as small, the bootstrap has less coverage than its level. The reduction
 * of the error was found with normal, uniform, gamma, exponential and lognormal samples, so that with
 * LL_INTERVAL_LEVEL values or more their coverage is within 2 % of the level, and with fewer not below it. */
#define SKEWED 0.8
#define SKEW_SHRINK_FEW 1.0
#define SKEW_SHRINK 0.7
#define SKEW_FEW 40 /* values */

/* Kurtosis minus the square of the skewness: 1 for two values, 1.8 for a uniform distribution, 3 for a normal
 * one (Pearson, Philos. Trans. R. Soc. A 216, 1916). Below this, values have no tails, unless they are
 * skewed. */
#define FLAT 1.7
#define FLAT_SKEWED 1.2
#define RARE_SHRINK 0.6 /* for amounts, whose sizes say less than those of counts */

const char *const ll_interval_method_names[] = {
    "none",    "t",           "bootstrap-t",     "skewness-t", "clopper-pearson",
    "poisson", "rare-events", "order-statistics"};

static const char too_few[] = "fewer than 10 runs have it";

static ll_interval none(const char *why)
{
    return (ll_interval){.low = NAN, .high = NAN, .why = why};
}

/* ---- statistics of the values ---- */

typedef struct sample {
    const double *x;
    int64_t n;
    double mean, deviation;    /* of the sample, with n - 1 */
    double skewness, kurtosis; /* third and fourth central moments over sd^3 and sd^4 */
    double least, most;
    int64_t at_least, at_most; /* number of values equal to the minimum, to the maximum */
} sample;

static sample look_at(const double *x, int64_t n)
{
    sample s = {.x = x, .n = n, .least = INFINITY, .most = -INFINITY};
    double squares = 0;
    for (int64_t i = 0; i < n; i++) {
        double delta = x[i] - s.mean;
        s.mean += delta / (double)(i + 1);
        squares += delta * (x[i] - s.mean);
        s.least = fmin(s.least, x[i]);
        s.most = fmax(s.most, x[i]);
    }
    for (int64_t i = 0; i < n; i++) {
        s.at_least += x[i] == s.least;
        s.at_most += x[i] == s.most;
    }
    s.deviation = n > 1 ? sqrt(squares / (double)(n - 1)) : NAN;
    for (int64_t i = 0; i < n && s.deviation > 0; i++) {
        double z = (x[i] - s.mean) / s.deviation;
        s.skewness += z * z * z / (double)n;
        s.kurtosis += z * z * z * z / (double)n;
    }
    return s;
}

/* ---- amounts ---- */

/* Shares of the error below and above the interval, in halves of it. */
typedef struct sides {
    double below, above;
} sides;

#define EVEN ((sides){1, 1})
#define TAIL_BELOW 1.75
#define TAIL_ABOVE 0.2
#define TAIL_ABOVE_FEW 0.25

static sides sides_of(const sample *s, const ll_interval_request *o)
{
    double above = s->n < LL_INTERVAL_LEVEL ? TAIL_ABOVE_FEW : TAIL_ABOVE;
    if (o->scale != LL_SCALE_TAILED)
        return EVEN;
    if (!o->difference)
        return (sides){TAIL_BELOW, above};
    return s->mean < 0 ? (sides){above, 1} : (sides){1, above};
}

static ll_interval student(const sample *s, double error, sides share)
{
    double freedom = (double)(s->n - 1), unit = s->deviation / sqrt((double)s->n);
    return (ll_interval){s->mean - unit * ll_t_quantile(error / 2 * share.below, freedom),
                         s->mean + unit * ll_t_quantile(error / 2 * share.above, freedom), LL_INTERVAL_T,
                         NULL};
}

/* T + g T^2 / 3 + g^2 T^3 / 27 + g / (6 n), with T = (mean - mu) / sd and skewness g, is normal to a higher
 * order than T. It is monotonic, so its inverse gives the bounds; using Student's t instead of the normal is
 * exact without skewness. */
static ll_interval skewness_t(const sample *s, double error, sides share)
{
    double n = (double)s->n, g = s->skewness, bounds[2];
    for (int side = 0; side < 2; side++) {
        double t = ll_t_quantile(error / 2 * (side ? share.above : share.below), n - 1) / sqrt(n);
        double y = (side ? -t : t) - g / (6 * n);
        double moved = fabs(g) < 1e-9 ? y : 3 / g * (cbrt(1 + g * y) - 1);
        bounds[side] = s->mean - moved * s->deviation;
    }
    return (ll_interval){bounds[0], bounds[1], LL_INTERVAL_SKEWNESS_T, NULL};
}

void ll_resampler_free(ll_resampler *r)
{
    free(r->index);
    free(r->deviates);
    *r = (ll_resampler){0};
}

static bool draw(ll_resampler *r, int64_t n)
{
    if (r->n == n)
        return true;
    LL_ASSERT(n <= LL_BOOTSTRAP_MAX && LL_BOOTSTRAP_MAX <= UINT8_MAX);
    size_t size = (size_t)n * LL_RESAMPLES;
    ll_resampler_free(r);
    r->index = malloc(size);
    r->deviates = malloc(LL_RESAMPLES * sizeof *r->deviates);
    if (!r->index || !r->deviates)
        return false;
    for (size_t i = 0; i < size; i++)
        r->index[i] = (uint8_t)(ll_rng_unit(RESAMPLE_SEED, (uint64_t)n, i) * (double)n);
    r->n = n;
    return true;
}

/* Studentised deviation of a resample's mean from that of the sample. */
static double deviate(const double *z, const uint8_t *index, int64_t n)
{
    double sum = 0, squares = 0;
    for (int64_t i = 0; i < n; i++) {
        double v = z[index[i]];
        sum += v;
        squares += v * v;
    }
    double mean = sum / (double)n, variance = (squares - sum * mean) / (double)(n - 1);
    if (variance > 1e-12 * squares)
        return mean / sqrt(variance);
    return mean > 0 ? INFINITY : mean < 0 ? -INFINITY : 0;
}

/* The k-th smallest, moved to its place (Hoare's selection). */
static double select_kth(double *a, int n, int k)
{
    int low = 0, high = n - 1;
    while (low < high) {
        double pivot = a[k];
        int i = low, j = high;
        do {
            while (a[i] < pivot)
                i++;
            while (pivot < a[j])
                j--;
            if (i <= j) {
                double held = a[i];
                a[i++] = a[j];
                a[j--] = held;
            }
        } while (i <= j);
        if (j < k)
            low = i;
        if (k < i)
            high = j;
    }
    return a[k];
}

static double few_shrink(int64_t n)
{
    return n < 13 ? 0.5 : n < 20 ? 0.6 : n < 25 ? 0.8 : n < SKEW_FEW ? 0.9 : 1;
}

static ll_interval bootstrap_t(const sample *s, double error, sides share, ll_resampler *r)
{
    double z[LL_BOOTSTRAP_MAX], skewed = fmax(0, fabs(s->skewness) - SKEWED);
    error *= few_shrink(s->n) / (1 + (s->n < SKEW_FEW ? SKEW_SHRINK_FEW : SKEW_SHRINK) * skewed);
    if (!draw(r, s->n))
        return none("there was no memory");
    for (int64_t i = 0; i < s->n; i++)
        z[i] = (s->x[i] - s->mean) / s->deviation;
    for (int b = 0; b < LL_RESAMPLES; b++)
        r->deviates[b] = deviate(z, r->index + (int64_t)b * s->n, s->n);
    double half = error / 2 * (LL_RESAMPLES + 1);
    int above = (int)fmax(1, half * share.above), below = (int)fmax(1, half * share.below);
    double low = select_kth(r->deviates, LL_RESAMPLES, above - 1);
    double high = select_kth(r->deviates, LL_RESAMPLES, LL_RESAMPLES - below);
    if (!isfinite(low) || !isfinite(high))
        return none("too few values differ");
    return (ll_interval){s->mean - high * s->deviation, s->mean - low * s->deviation, LL_INTERVAL_BOOTSTRAP_T,
                         NULL};
}

static bool is_flat(const sample *s)
{
    return fabs(s->skewness) < FLAT_SKEWED && s->kurtosis - s->skewness * s->skewness < FLAT;
}

static ll_interval of_smooth(const sample *s, const ll_interval_request *o, ll_resampler *r)
{
    sides share = sides_of(s, o);
    if (s->n < LL_INTERVAL_MIN)
        return none(too_few);
    if (s->n > LL_BOOTSTRAP_MAX)
        return skewness_t(s, o->error, share);
    return s->n >= LL_INTERVAL_LEVEL && is_flat(s) ? student(s, o->error, share)
                                                   : bootstrap_t(s, o->error, share, r);
}

/* ---- shares and counts ---- */

ll_interval ll_interval_share(int64_t k, int64_t n, double error)
{
    double hits = (double)k, misses = (double)(n - k);
    if (n < 1)
        return none("no run has it");
    return (ll_interval){k == 0 ? 0 : ll_beta_quantile(error / 2, hits, misses + 1),
                         k == n ? 1 : ll_beta_quantile(1 - error / 2, hits + 1, misses),
                         LL_INTERVAL_CLOPPER_PEARSON, NULL};
}

/* Interval of the expected number of events when `total` were seen, each worth `size`. */
static ll_interval events(double total, double size, double error, ll_interval_method method)
{
    double seen = total / size;
    return (ll_interval){total > 0 ? size * ll_gamma_quantile(error / 2, seen) : 0,
                         size * ll_gamma_quantile(1 - error / 2, seen + 1), method, NULL};
}

static ll_interval scaled(ll_interval i, double from, double by)
{
    i.low = from + by * i.low;
    i.high = from + by * i.high;
    if (by < 0) {
        double held = i.low;
        i.low = i.high;
        i.high = held;
    }
    return i;
}

/* Counts of few events: Poisson's, or wider if they scatter more. */
static ll_interval poisson(const sample *s, double unit, double error)
{
    double n = (double)s->n, total = n * s->mean / unit;
    double dispersion = s->n > 1 && s->mean > 0 ? s->deviation * s->deviation / (s->mean * unit) : 1;
    return scaled(events(total, fmax(1, dispersion), error, LL_INTERVAL_POISSON), 0, unit / n);
}

/* Most values are `base`; the others, all on one side of it, are weighted events (Fay and Feuer). */
static ll_interval rare(const sample *s, double base, double least_weight, double error)
{
    double sign = s->most > base ? 1 : -1, y = 0, v = 0, w = least_weight;
    for (int64_t i = 0; i < s->n; i++) {
        double x = sign * (s->x[i] - base);
        y += x;
        v += x * x;
        w = fmax(w, x);
    }
    double low = y > 0 ? v / y * ll_gamma_quantile(error / 2, y * y / v) : 0;
    double up = (v + w * w) / (y + w), high = up * ll_gamma_quantile(1 - error / 2, (y + w) / up);
    return scaled((ll_interval){low, high, LL_INTERVAL_RARE, NULL}, base, sign / (double)s->n);
}

/* ---- choice of the method ---- */

static ll_interval of_counts(const sample *s, const ll_interval_request *o, ll_resampler *r)
{
    double unit = o->unit > 0 ? o->unit : 1, total = s->mean * (double)s->n / unit;
    if (s->n == 1 && total > 0)
        return none("one run alone has it");
    if (s->least == 0 && 2 * s->at_least > s->n && s->n - s->at_least < FEW_OTHERS)
        return rare(s, 0, unit, o->error);
    if (total < FEW_EVENTS)
        return poisson(s, unit, o->error);
    return of_smooth(s, o, r);
}

/* More than a third of the values are equal: no smooth distribution. */
static bool is_often(const sample *s, int64_t same)
{
    return same > 1 && 3 * same > s->n;
}

static ll_interval of_amounts(const sample *s, const ll_interval_request *o, ll_resampler *r)
{
    bool above = is_often(s, s->at_least), below = !above && is_often(s, s->at_most);
    int64_t others = s->n - (above ? s->at_least : s->at_most);
    if ((above || below) && others < FEW_OTHERS) {
        ll_interval i = rare(s, above ? s->least : s->most, 0, RARE_SHRINK * o->error);
        if (others == 1) /* one value does not show how large others may be */
            *(above ? &i.high : &i.low) = above ? INFINITY : -INFINITY;
        return i;
    }
    return of_smooth(s, o, r);
}

/* Of sorted values the k-th smallest and the k-th largest, with the largest k for which the probability that
 * the median is outside is at most the error: binomial, for any distribution. */
ll_interval ll_interval_median(const double *sorted, int64_t n, double error)
{
    int64_t k = 0;
    /* P(fewer than k of n are below the median) = I_1/2(n - k + 1, k) */
    while (k < n / 2 && ll_beta_cdf(0.5, (double)(n - k), (double)(k + 1)) <= error / 2)
        k++;
    if (k == 0)
        return none(n == 0 ? "no run has it" : "fewer than 6 runs have it");
    return (ll_interval){sorted[k - 1], sorted[n - k], LL_INTERVAL_ORDER, NULL};
}

ll_interval ll_interval_of(const ll_interval_request *o, ll_resampler *r)
{
    LL_ASSERT(o->error > 0 && o->error <= 0.2);
    sample s = look_at(o->values, o->n);
    if (s.n == 0)
        return none("no run has it");
    if (o->scale == LL_SCALE_FLAG)
        return ll_interval_share((int64_t)(s.mean * (double)s.n + 0.5), s.n, o->error);
    bool none_seen = o->scale == LL_SCALE_COUNT && s.most == 0;
    if (none_seen)
        return poisson(&s, o->unit > 0 ? o->unit : 1, o->error);
    if (s.n == 1)
        return none("one run alone has it");
    if (s.least == s.most)
        return none("all runs gave the same");
    if (o->scale != LL_SCALE_COUNT && o->use_t)
        return student(&s, o->error, EVEN);
    if (o->scale == LL_SCALE_EXTREME)
        return none("its mean depends on rare runs: use the median");
    if (o->scale != LL_SCALE_COUNT && s.n < LL_INTERVAL_MIN)
        return none(too_few);
    if (s.n < LL_EVENTS_MIN)
        return none("fewer than 5 runs have it");
    return o->scale == LL_SCALE_COUNT ? of_counts(&s, o, r) : of_amounts(&s, o, r);
}

static const char *amounts_cover(int64_t n, bool tailed)
{
    if (tailed)
        return n < LL_INTERVAL_LEVEL ? "a bound: at least 93 %" : "93 to 98 %";
    if (n < LL_INTERVAL_LEVEL)
        return "a bound: at least 93 %, down to 90 % where a few runs in a hundred make much of the mean";
    if (n < LL_INTERVAL_MANY)
        return "93 to 97 %, down to 89 % where a few runs in a hundred make much of the mean, up to 98 % of "
               "two unlike groups";
    return "93 to 97 %";
}

const char *ll_interval_covers(const ll_interval_request *o, ll_interval_method method)
{
    switch (method) {
    case LL_INTERVAL_T:
        return o->use_t ? "95 % of normal values, less of skewed ones and far less of rare events"
                        : "93 to 97 %";
    case LL_INTERVAL_BOOTSTRAP_T:
    case LL_INTERVAL_SKEWNESS_T:
        return amounts_cover(o->n, o->scale == LL_SCALE_TAILED);
    case LL_INTERVAL_CLOPPER_PEARSON:
    case LL_INTERVAL_ORDER:
        return "a bound: at least 95 %";
    case LL_INTERVAL_POISSON:
        return "a bound: at least 95 % of events that come by themselves";
    case LL_INTERVAL_RARE:
        return "a bound: at least 93 % of events of about one size";
    case LL_INTERVAL_NONE:
        break;
    }
    return "";
}

double ll_sample_quantile(const double *sorted, int64_t n, double p)
{
    double at = p * (double)(n - 1), below = floor(at);
    int64_t k = (int64_t)below;
    return k + 1 < n ? sorted[k] + (at - below) * (sorted[k + 1] - sorted[k]) : sorted[n - 1];
}

#include "experiment/statistics/sensitivity.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/assert.h"
#include "base/rng.h"

#define RESAMPLE_SEED 19971999

/* Terms of one dimension's estimates, of one base sample. */
typedef struct part {
    double a, b;            /* centred */
    double product, square; /* b (ab - a) and (a - ab)^2 */
} part;

typedef struct estimate {
    double first, total;
} estimate;

static estimate estimate_of(const part *parts, const uint32_t *index, int64_t n)
{
    double product = 0, square = 0, sum = 0, squares = 0;
    for (int64_t j = 0; j < n; j++) {
        LL_VALIDATE(index == NULL || index[j] < (uint64_t)n);
        const part *p = &parts[index ? index[j] : j];
        product += p->product;
        square += p->square;
        sum += p->a + p->b;
        squares += p->a * p->a + p->b * p->b;
    }
    double all = (double)n, mean = sum / (2 * all), variance = squares / (2 * all) - mean * mean;
    if (!(variance > 1e-14 * squares / all))
        return (estimate){NAN, NAN};
    return (estimate){product / all / variance, square / (2 * all) / variance};
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Percentiles 2.5 and 97.5. */
static void bounds(double *values, double *low, double *high)
{
    enum { OUTSIDE = (LL_SENSITIVITY_RESAMPLES + 1) / 40 };
    qsort(values, LL_SENSITIVITY_RESAMPLES, sizeof *values, by_size);
    _Static_assert((LL_SENSITIVITY_RESAMPLES + 1) % 40 == 0, "percentiles are order statistics");
    *low = values[OUTSIDE - 1];
    *high = values[LL_SENSITIVITY_RESAMPLES - OUTSIDE];
}

static void resample(const part *parts, uint32_t *index, int64_t n, double *drawn, ll_sensitivity *s)
{
    double *first = drawn, *total = drawn + LL_SENSITIVITY_RESAMPLES;
    for (int r = 0; r < LL_SENSITIVITY_RESAMPLES; r++) {
        for (int64_t j = 0; j < n; j++)
            index[j] = (uint32_t)(ll_rng_unit(RESAMPLE_SEED, (uint64_t)r, (uint64_t)j) * (double)n);
        estimate e = estimate_of(parts, index, n);
        if (isnan(e.first))
            return;
        first[r] = e.first;
        total[r] = e.total;
    }
    bounds(first, &s->first_low, &s->first_high);
    bounds(total, &s->total_low, &s->total_high);
}

/* Selects the complete base samples; returns their count. */
static int64_t complete(const double *values, int64_t count, int dimensions, int64_t *which)
{
    int64_t n = 0;
    for (int64_t j = 0; j < count; j++) {
        bool whole = true;
        for (int k = 0; k < dimensions + 2; k++)
            whole &= (bool)isfinite(values[j * (dimensions + 2) + k]);
        if (whole)
            which[n++] = j;
    }
    return n;
}

static void read_parts(const double *values, int dimensions, int dimension, const int64_t *which, int64_t n,
                       part *parts)
{
    double mean = 0;
    for (int64_t j = 0; j < n; j++) {
        const double *f = values + which[j] * (dimensions + 2);
        mean += (f[0] + f[1]) / (2 * (double)n);
    }
    for (int64_t j = 0; j < n; j++) {
        const double *f = values + which[j] * (dimensions + 2);
        double a = f[0] - mean, b = f[1] - mean, mixed = f[2 + dimension] - mean;
        parts[j] = (part){a, b, b * (mixed - a), (a - mixed) * (a - mixed)};
    }
}

ll_status ll_sensitivity_of(const double *values, int64_t count, int dimensions, ll_sensitivity *indices)
{
    size_t room = (size_t)(count > 0 ? count : 1);
    int64_t *which = malloc(room * sizeof *which);
    part *parts = malloc(room * sizeof *parts);
    uint32_t *index = malloc(room * sizeof *index);
    double *drawn = malloc(2 * LL_SENSITIVITY_RESAMPLES * sizeof *drawn);
    bool good = which && parts && index && drawn;
    int64_t n = good ? complete(values, count, dimensions, which) : 0;
    for (int d = 0; good && d < dimensions; d++) {
        indices[d] = (ll_sensitivity){NAN, NAN, NAN, NAN, NAN, NAN, n};
        if (n < 2)
            continue;
        read_parts(values, dimensions, d, which, n, parts);
        estimate e = estimate_of(parts, NULL, n);
        indices[d].first = e.first;
        indices[d].total = e.total;
        if (n >= LL_SENSITIVITY_MIN && isfinite(e.first))
            resample(parts, index, n, drawn, &indices[d]);
    }
    free(which);
    free(parts);
    free(index);
    free(drawn);
    return good ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: sensitivity indices");
}

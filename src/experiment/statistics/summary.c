#include "experiment/statistics/summary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/assert.h"

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

ll_summary ll_summarise(const ll_interval_request *request, double *values, ll_resampler *resampler)
{
    int64_t n = request->n;
    ll_summary s = {.n = n, .mean = NAN, .deviation = NAN, .quartiles = {NAN, NAN, NAN}, .others = NAN};
    double mean = 0, squares = 0;
    for (int64_t i = 0; i < n; i++) { /* Welford's */
        double delta = values[i] - mean;
        mean += delta / (double)(i + 1);
        squares += delta * (values[i] - mean);
    }
    s.of_mean = ll_interval_of(request, resampler);
    s.covers = ll_interval_covers(request, s.of_mean.method);
    qsort(values, (size_t)n, sizeof *values, by_size);
    s.of_median = ll_interval_median(values, n, request->error);
    LL_ASSERT(isnan(s.of_mean.low) || isnan(s.of_mean.high) || s.of_mean.low <= s.of_mean.high);
    LL_ASSERT(isnan(s.of_median.low) || isnan(s.of_median.high) || s.of_median.low <= s.of_median.high);
    if (n > 0)
        s.mean = mean;
    if (n > 1)
        s.deviation = sqrt(squares / (double)(n - 1));
    LL_ASSERT(!(squares < 0)); /* Welford's sum cannot cancel below 0 */
    for (int q = 0; q < 3 && n > 0; q++)
        s.quartiles[q] = ll_sample_quantile(values, n, 0.25 * (q + 1));
    if (n > 1 && values[0] == values[n - 1] && s.of_mean.method == LL_INTERVAL_NONE)
        s.others = ll_interval_share(0, n, request->error).high;
    return s;
}

double ll_interval_half(const ll_interval *i)
{
    double half = (i->high - i->low) / 2;
    return isfinite(half) ? half : NAN;
}

void ll_summary_text(const ll_summary *s, char text[LL_SUMMARY_TEXT_MAX])
{
    const ll_interval *i = &s->of_mean;
    if (i->method != LL_INTERVAL_NONE)
        snprintf(text, LL_SUMMARY_TEXT_MAX, "%s", ll_interval_method_names[i->method]);
    else if (s->n > 1 && isfinite(s->others))
        snprintf(text, LL_SUMMARY_TEXT_MAX, "none: %s; others are at most %.3g %% of runs", i->why,
                 100 * s->others);
    else
        snprintf(text, LL_SUMMARY_TEXT_MAX, "none: %s", i->why);
}

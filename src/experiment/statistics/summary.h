/* A metric over the repeats of a point: what tables, the report and the page tell of it. */
#pragma once

#include "experiment/statistics/interval.h"

enum { LL_SUMMARY_TEXT_MAX = 160 };

typedef struct ll_summary {
    int64_t n;              /* runs that have it; what follows is NaN where it is not known */
    double mean, deviation; /* of the sample, with n - 1 */
    double quartiles[3];
    ll_interval of_mean, of_median;
    const char *covers; /* ll_interval_covers of the mean's */
    double others; /* where all runs gave the same: others are at most this share of all (Clopper-Pearson) */
} ll_summary;

/* Of `order->values`, which are sorted. */
ll_summary ll_summarise(const ll_interval_order *order, double *values, ll_resampler *resampler);

/* Half of what is between the bounds; NaN where one is not there. */
double ll_interval_half(const ll_interval *interval);

/* The method, or `none: ` and the reason. */
void ll_summary_text(const ll_summary *summary, char text[LL_SUMMARY_TEXT_MAX]);

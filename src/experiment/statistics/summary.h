/* Summary of a metric over the repeats of a point, for tables, the report and the page. */
#pragma once

#include "experiment/statistics/interval.h"

enum { LL_SUMMARY_TEXT_MAX = 160 };

typedef struct ll_summary {
    int64_t n;              /* runs that have it; other members are NaN where unknown */
    double mean, deviation; /* of the sample, with n - 1 */
    double quartiles[3];
    ll_interval of_mean, of_median;
    const char *covers; /* ll_interval_covers of the mean's */
    double others;      /* if all of several runs gave the same: upper bound of the share of others
                           (Clopper-Pearson) */
} ll_summary;

/* Of `request->values`; sorts them. */
ll_summary ll_summarise(const ll_interval_request *request, double *values, ll_resampler *resampler);

/* Half the distance of the bounds; NaN if one is missing. */
double ll_interval_half(const ll_interval *interval);

/* The method, or `none: ` and the reason. */
void ll_summary_text(const ll_summary *summary, char text[LL_SUMMARY_TEXT_MAX]);

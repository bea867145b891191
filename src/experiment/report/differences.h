/* Paired differences between two values of a dimension of the axes: of runs with the same seed and otherwise
 * the same settings. */
#pragma once

#include "experiment/report/rows.h"

enum {
    LL_DIFFERENCE_VALUES_MAX = 16,        /* of a dimension that is compared */
    LL_DIFFERENCE_RESAMPLED_MAX = 150000, /* values in intervals: less than a second */
    LL_DIFFERENCE_DETAILS_MAX = 30000,    /* intervals of single settings */
};

/* `of` minus `from`, both values of the dimension. */
typedef struct ll_difference {
    int dimension, metric, from, of;
    int64_t settings, complete; /* of the other dimensions; those with all pairs of runs */
    ll_summary all;      /* by seed, of the mean over the complete settings: seeds are what is independent */
    ll_summary *details; /* by setting, in the order of points; NULL: left out */
} ll_difference;

typedef struct ll_differences {
    ll_difference *list;
    int count; /* 0: the points are no grid, or its rows are too many */
} ll_differences;

ll_status ll_differences_make(const ll_report_rows *rows, ll_differences *differences);
void ll_differences_free(ll_differences *differences);

/* The points of an experiment with the means of their metrics, held in memory. */
#pragma once

#include "experiment/format/table.h"

enum { LL_POINTS_CELLS_MAX = 800000 }; /* points times metrics: some 110 MB */

typedef struct ll_point {
    int64_t point, runs, failed;
    double *places;      /* by axis: the value, or a choice's index in the list of values */
    ll_summary *metrics; /* by metric */
    double *size;        /* by metric: mean magnitude, used in comparisons; NaN: not all runs have it */
    bool front;          /* ll_points_mark_front */
} ll_point;

typedef struct ll_points {
    ll_point *points;      /* ascending */
    int count;             /* beyond LL_POINTS_CELLS_MAX they are a random sample */
    int64_t identical;     /* number of points whose repeats gave the same */
    struct cJSON *notices; /* ll_result_table_notices */
    double *numbers;       /* memory of the points' places and sizes */
    ll_summary *summaries;
} ll_points;

ll_status ll_points_read(const ll_experiment *experiment, ll_row_source *source, void *context,
                         ll_points *points);
void ll_points_free(ll_points *points);

/* Marks the Pareto front of `count` metrics, by magnitude: of the points whose runs all have them, those for
 * which no other point is as good in all and better in one. */
void ll_points_mark_front(ll_points *points, const int *metrics, int count);

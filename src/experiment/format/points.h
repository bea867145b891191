/* The points of an experiment with the means of their metrics, held in memory. */
#pragma once

#include "experiment/format/table.h"

enum { LL_POINTS_CELLS_MAX = 800000 }; /* points times metrics: some 110 MB */

typedef struct ll_point {
    int64_t point, runs, failed;
    double *places;      /* by axis: the number, or of a choice its place in the list of values */
    ll_summary *metrics; /* by metric */
    double *size;        /* by metric: mean magnitude, what is compared; NaN: not all runs have it */
    bool front;          /* ll_points_mark_front */
} ll_point;

typedef struct ll_points {
    ll_point *points; /* in their order */
    int count;
    int64_t left_out;      /* beyond LL_POINTS_CELLS_MAX: those held are drawn at random from all */
    int64_t identical;     /* of all: their repeats gave the same */
    struct cJSON *notices; /* ll_result_table_notices */
    double *numbers;       /* what the points' places and sizes are in */
    ll_summary *summaries;
} ll_points;

ll_status ll_points_read(const ll_experiment *experiment, ll_row_source *source, void *context,
                         ll_points *points);
void ll_points_free(ll_points *points);

/* Marks the front of `count` metrics, by magnitude: of points all of whose runs have them, those to which no
 * other is as good in all and better in one. */
void ll_points_mark_front(ll_points *points, const int *metrics, int count);

/* Where a value of an axis is drawn: see `places`. */
double ll_axis_place(const ll_axis *axis, const struct cJSON *value);

/* `players.0.lag_ms 100, server.update_hz 30`; caller frees. */
char *ll_point_name(const struct cJSON *values);

/* Which of `count` things are shown where `most` have room: all, or those that are `first` (of too many every
 * n-th) and every n-th of the others. Tells both n, 0 where there are none. */
typedef struct ll_choice {
    int shown, every_first, every_other;
} ll_choice;

ll_choice ll_choose_shown(const bool *first, int count, int most, bool *shown);

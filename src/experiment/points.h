/* The points of an experiment with the means of their metrics, held in memory. */
#pragma once

#include "experiment/table.h"

enum { LL_POINTS_MAX = 20000 };

typedef struct ll_point {
    int64_t point, runs, failed;
    struct cJSON *values;                   /* what is varied; owned */
    char *name;                             /* `players.0.lag_ms 100, server.update_hz 30`; owned */
    ll_summary *metrics;                    /* by metric; owned */
    double size[LL_EXPERIMENT_METRICS_MAX]; /* mean magnitude: what is compared; NaN: not all runs have it */
    bool front;                             /* ll_points_mark_front */
} ll_point;

typedef struct ll_points {
    ll_point *points;
    int count;
    int64_t left_out;  /* beyond LL_POINTS_MAX */
    int64_t identical; /* of all: their repeats gave the same */
} ll_points;

ll_status ll_points_read(const ll_experiment *experiment, ll_row_source *source, void *context,
                         ll_points *points);
void ll_points_free(ll_points *points);

/* Marks the front of `count` metrics, by magnitude: of points all of whose runs have them, those to which no
 * other is as good in all and better in one. */
void ll_points_mark_front(ll_points *points, const int *metrics, int count);

char *ll_point_name(const struct cJSON *values); /* caller frees */

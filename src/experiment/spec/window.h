/* Windows: parts of a run over which metrics are taken, from one time to another or while a condition holds.
 *
 * Tick k stands for the time from tick k to tick k + 1, so that all ticks of a run but its last state cover
 * it once. It belongs to a window if from_s <= its time < to_s, and the condition holds at it. `PATH@NAME` is
 * a metric in a window: see ll_windowed. */
#pragma once

#include <stdint.h>

#include "param/param.h"

struct cJSON;
struct ll_experiment;
struct ll_session;

enum { LL_WINDOWS_MAX = 8, LL_WINDOW_NAME_MAX = 24, LL_WINDOW_PATH_MAX = 120 };

typedef struct ll_window {
    char name[LL_WINDOW_NAME_MAX + 8];
    double from_s, to_s;
    struct {
        char value[LL_WINDOW_PATH_MAX + 8]; /* column of the trace, or path of a parameter; empty: none */
        double above, below;
    } condition;
} ll_window;

extern const ll_param_table ll_window_table;

/* What a metric is in a window. */
typedef enum ll_windowed_as {
    LL_WINDOWED_NOT,    /* it is a metric of the whole run */
    LL_WINDOWED_TIME,   /* counted_s: length of the window */
    LL_WINDOWED_CHANGE, /* of a count or a time: what was added within the window */
    LL_WINDOWED_RATE,   /* per second of the window, from warmup_s on */
    LL_WINDOWED_MEAN,   /* of a distribution's values within the window */
    LL_WINDOWED_RMS,
    LL_WINDOWED_COLUMN, /* a statistic of a column of the trace over the ticks of the window */
} ll_windowed_as;

/* The statistics of a column, in the order of their names. */
typedef enum ll_column_statistic {
    LL_COLUMN_MEAN,
    LL_COLUMN_RMS,
    LL_COLUMN_MIN,
    LL_COLUMN_MAX,
    LL_COLUMN_P50,
    LL_COLUMN_P95,
    LL_COLUMN_P99,
    LL_COLUMN_STATISTICS
} ll_column_statistic;

typedef struct ll_windowed {
    ll_windowed_as as;
    int window;
    ll_column_statistic statistic;
    char path[LL_WINDOW_PATH_MAX + 8]; /* of the metric, of a distribution without its part; of a column its
                                          name */
} ll_windowed;

/* Checks the windows of a specification, at the first tick of a session of its first point. */
ll_status ll_windows_check(const struct ll_experiment *experiment, struct ll_session *session);

/* Reads `path`, the metric `field`, which has an @. `present` has the metrics of a run. */
ll_status ll_windowed_parse(const struct ll_experiment *experiment, const char *field, const char *path,
                            const struct cJSON *present, struct ll_session *session, ll_windowed *windowed);

/* Index of a trace's column at this tick; -1: none. */
int ll_column_find(struct ll_session *session, const char *name);

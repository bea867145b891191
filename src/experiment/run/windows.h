/* Counts the windows of one run: see experiment/spec/window.h.
 *
 * The run is advanced from one visited tick to the next. A metric of the engine is read where a window opens
 * and closes; columns of the trace and conditions at every tick. */
#pragma once

#include "experiment/spec/experiment.h"

/* Sums over values, and how many there were or how long it took. */
typedef struct ll_window_sum {
    double sum, weight;
} ll_window_sum;

typedef struct ll_window_metric {
    ll_window_sum at_opening, closed;
    int column; /* of the trace; -1: none */
    double sum, sum_squares, min, max;
    double *values; /* for percentiles */
    int64_t count, capacity;
} ll_window_metric;

typedef struct ll_windows {
    const ll_experiment *experiment;
    ll_session *session;
    double warmup_s;
    bool each_tick, reads_columns;
    int64_t visited; /* the last visited tick; -1: none */
    ll_time visited_at;
    ll_time counted[LL_WINDOWS_MAX]; /* time within each window so far */
    bool open[LL_WINDOWS_MAX];
    int condition_column[LL_WINDOWS_MAX]; /* -1: none */
    ll_window_metric metrics[LL_EXPERIMENT_METRICS_MAX];
    double columns[LL_TRACE_COLUMNS_MAX]; /* of the trace, at the visited tick */
} ll_windows;

bool ll_windows_wanted(const ll_experiment *experiment);
bool ll_windows_read_columns(const ll_experiment *experiment); /* which need all that a run observes */

/* Before the first tick. The caller frees. */
void ll_windows_begin(const ll_experiment *experiment, ll_session *session, ll_windows *windows);
void ll_windows_free(ll_windows *windows);

/* At the session's tick, from which it will be advanced: counts it, once. */
ll_status ll_windows_visit(ll_windows *windows);
int64_t ll_windows_next(const ll_windows *windows); /* the tick to visit next, or beyond the end */

/* At the last tick, whose state counts no more. */
void ll_windows_end(ll_windows *windows);

double ll_windows_value(const ll_windows *windows, int metric); /* NaN: nothing was counted */

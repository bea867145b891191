/* What is measured of one player's view. M1 to M13 are the metrics of the field; their definitions stand with
 * each.
 *
 * Everything is measured from virtual time `from` on, so that the start does not count. The clients write
 * what they know themselves; what needs the truth is written by the observer (instruments.c), who alone sees
 * both. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "game/history.h"

typedef enum ll_metric {
    LL_METRIC_INPUT_LATENCY,  /* M1: first frame that draws an input's effect - when it was made, ms */
    LL_METRIC_ACK_RTT,        /* M2: an input was sent until the client learns that it was applied, ms */
    LL_METRIC_VIEW_AGE,       /* M3: now - server time of the others as drawn, ms */
    LL_METRIC_OWN_ERROR,      /* M4: |own entity as drawn - truth now|, m */
    LL_METRIC_REMOTE_ERROR,   /* M4: the same of the others, m */
    LL_METRIC_TIMELINE_ERROR, /* M5: |others as drawn - truth at the time that is drawn|, m */
    LL_METRIC_CORRECTION, /* M6: |own entity before - after a server state|, at the same tick, m; only those
                             above 0 */
    LL_METRIC_POP,        /* M6b: the same as drawn, in the frame that takes the state, m */
    LL_METRIC_BUFFER,     /* M9: newest state - drawn time, ms */
    LL_METRIC_UNACKED,    /* M2b: inputs that wait for an acknowledgement */
    LL_METRICS,
} ll_metric;

typedef struct ll_metric_row {
    const char *name; /* with its unit */
    const char *help;
    double unit; /* of the histogram */
} ll_metric_row;

extern const ll_metric_row ll_metric_rows[LL_METRICS];

/* M8: smoothness of the others as drawn. */
#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_smoothness {
    double x[3], truth;        /* the last three positions drawn, the last true one */
    int64_t samples;           /* how many of these there are */
    double acceleration, jerk; /* sums of squares */
    double step_max, truth_step_sum;
    int64_t frames, moving, frozen, reversals;
} ll_smoothness;

typedef struct ll_instruments {
    ll_time from;
    ll_histogram histogram[LL_METRICS];
    int32_t entities, reserved;
    int64_t frames, underruns, held_frames;
    int64_t bytes[4], packets[4];             /* M13: by ll_message, payload */
    double own_error, remote_error, view_age; /* the last, signed, for views */
    double last_correction;
    int64_t corrections;
    ll_smoothness smooth[]; /* per entity */
} ll_instruments;

#pragma GCC diagnostic pop

size_t ll_instruments_size(int entities);
void ll_instruments_init(ll_instruments *in, int entities, ll_time from);

static inline void ll_measure(ll_instruments *in, ll_metric metric, ll_time now, double value)
{
    if (now >= in->from)
        ll_histogram_add(&in->histogram[metric], value);
}

struct ll_client;

/* After a frame of `client`: compares what it draws with the truth. `period` is the time between frames. */
void ll_instruments_frame(ll_instruments *in, const struct ll_client *client, const ll_world *world,
                          const ll_history *history, ll_time now, double period_s);

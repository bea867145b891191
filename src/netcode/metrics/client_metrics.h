/* Metrics of one player's view. docs/concepts.md defines them. Inconsistency, smoothness, changes and cheats
 * have files of their own.
 *
 * Everything counts from virtual time `from` on, so that the start does not count. Clients write what they
 * know themselves. The observer (client_metrics.c), the only one that sees both sides, writes what needs the
 * ground truth. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "game/core/history.h"
#include "netcode/metrics/changes.h"
#include "netcode/metrics/cheat_gain.h"
#include "netcode/metrics/honest_reference.h"
#include "netcode/metrics/inconsistency.h"
#include "netcode/metrics/input_history.h"
#include "netcode/metrics/rendered_views.h"
#include "netcode/metrics/smoothness.h"
#include "netcode/protocol/running_stats.h"
#include "netcode/protocol/wire.h"

/* The distributions, X(ID, type, name, unit, bucket, help, null): a row each. The type is that of
 * record/metric.h, the bucket the width of the histogram's, in the unit. The latencies of changes
 * (netcode/metrics/changes.h) stand first. */
#define LL_CLIENT_METRICS(X)                                                                                 \
    X(INPUT_LATENCY, latency, input_latency_ms, "ms", 0.1,                                                   \
      "time from making the first input with changed controls to the first frame on the player's own "       \
      "screen that includes this input; infinite if the server does not apply it",                           \
      "No change of controls has a final result; p50 also when more than half of the values are infinite.")  \
    X(CONFIRMED_LATENCY, latency, confirmed_latency_ms, "ms", 0.1,                                           \
      "time from making the first input with changed controls to its confirmation on the player's own "      \
      "screen: the first frame after the client has a snapshot of the step that applied it (deterministic, " \
      "rollback: the first frame of a confirmed tick with it); infinite if the server does not apply it",    \
      "No change of controls has a final result; p50 also when more than half of the values are infinite.")  \
    X(SEEN_LATENCY, latency, seen_latency_ms, "ms", 0.1,                                                     \
      "time from making the first input with changed controls to the first frame of each other player that " \
      "shows its effect on the player's entity; infinite if the server does not apply it",                   \
      "No change of controls has a final result, or there is one player; p50 also when more than half of "   \
      "the values are infinite.")                                                                            \
    X(ACK_RTT, distribution, ack_rtt_ms, "ms", 0.1,                                                          \
      "time from making an input to the arrival of the first snapshot that reports the input as applied "    \
      "(with a de-jitter buffer: to the play-out of that snapshot)",                                         \
      "No input was acknowledged.")                                                                          \
    X(VIEW_AGE, distribution, view_age_ms, "ms", 0.1,                                                        \
      "age of another entity as drawn: virtual time now less the server time of the drawn state; a value "   \
      "per frame and entity",                                                                                \
      "No frame was drawn, or there is no other entity.")                                                    \
    X(AGE_OF_INFORMATION, distribution, age_of_information_ms, "ms", 0.1,                                    \
      "age of information: virtual time now less the server time of the newest snapshot that the client "    \
      "has; a value per frame",                                                                              \
      "No frame was drawn.")                                                                                 \
    X(OWN_TIMELINE_ERROR, long_distribution, own_timeline_error_m, "m", 0.001,                               \
      "distance between the drawn position of the own entity and its position at the server at the drawn "   \
      "tick",                                                                                                \
      "No drawn tick of the own entity was compared with the server's.")                                     \
    X(OWN_LEAD, distribution, own_lead_m, "m", 0.001,                                                        \
      "distance between the drawn position of the own entity and the ground truth now: how far ahead of "    \
      "the server or behind it the entity is drawn; not an error",                                           \
      "No frame was drawn.")                                                                                 \
    X(REMOTE_ERROR, distribution, remote_error_m, "m", 0.001,                                                \
      "distance between the drawn position of another entity and the ground truth now; a value per frame "   \
      "and entity",                                                                                          \
      "No frame was drawn, or there is no other entity.")                                                    \
    X(TIMELINE_ERROR, long_distribution, timeline_error_m, "m", 0.001,                                       \
      "distance between the drawn position of another entity and its position at the server at the drawn "   \
      "time or tick: the error of interpolation, extrapolation or prediction",                               \
      "No drawn position of another entity was compared with the server's.")                                 \
    X(CORRECTION, extreme_distribution, correction_m, "m", 0.001,                                            \
      "distance by which a snapshot or a rollback changed the predicted position of the own entity at one "  \
      "tick; only values above 0",                                                                           \
      "There was no correction.")                                                                            \
    X(POP, long_distribution, pop_m, "m", 0.001,                                                             \
      "distance by which corrections moved a drawn position in a frame: that of the entity that was moved "  \
      "farthest",                                                                                            \
      "No frame was drawn.")                                                                                 \
    X(BUFFER, distribution, buffer_ms, "ms", 0.1,                                                            \
      "server time of the newest snapshot less the render time; 0 while the client extrapolates",            \
      "Interpolation and extrapolation are off.")                                                            \
    X(UNACKED, distribution, unacked, NULL, 1,                                                               \
      "unacknowledged inputs in each frame, as the client believes", "No frame was drawn.")

/* What is observed, as bits; what a client counts itself always is. Metrics that need more than that have no
 * meaning. */
typedef enum ll_observation {
    LL_OBSERVE_VIEWS = 1,   /* each display against the truth */
    LL_OBSERVE_INPUTS = 2,  /* the result of each input, and when a display shows it */
    LL_OBSERVE_CLIENTS = 4, /* the displays of the clients against each other */
    LL_OBSERVE_FRAMES = 8,  /* the open inputs of each tick, and how far each display jumps */
    LL_OBSERVE_GAIN = 16,   /* what a cheat gains */
    LL_OBSERVE_ALL = 31
} ll_observation;

#define LL_CLIENT_METRIC_ID(id, type, name, unit, bucket, help, null) LL_METRIC_##id,
typedef enum ll_metric { LL_CLIENT_METRICS(LL_CLIENT_METRIC_ID) LL_METRICS } ll_metric;
#undef LL_CLIENT_METRIC_ID

_Static_assert(LL_METRIC_INPUT_LATENCY == (int)LL_LATENCY_FELT &&
                   LL_METRIC_SEEN_LATENCY == (int)LL_LATENCY_SEEN,
               "the latencies of changes come first, in their order");

typedef struct ll_metric_row {
    const char *name; /* with its unit */
    double unit;      /* of the histogram */
} ll_metric_row;

extern const ll_metric_row ll_metric_rows[LL_METRICS];

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* An entity drawn at a time that the server has not reached, compared with the truth when the server gets
 * there. One at a time, since a lead is short. */
typedef struct ll_awaited {
    int64_t when; /* positive: a time; negative: a step; 0: none */
    double x, y;
} ll_awaited;

/* Kept per entity. */
typedef struct ll_track {
    ll_smoothness smooth; /* of the others */
    ll_divergence_episode server,
        clients;        /* inconsistency: against the truth; against the other clients' views */
    ll_awaited awaited; /* for the timeline error of what is drawn ahead of the server */
} ll_track;

/* Stalls, rollbacks and desync of a client that steps a world of its own (deterministic, rollback). */
typedef struct ll_stepping {
    int64_t stalls, stalled_frames;      /* without the input of another player */
    int32_t waited_frames[LL_PEERS_MAX]; /* of these, by the player whose input was missing */
    int64_t time_sync_frames;            /* frames that time sync left out so that the other peers catch up */
    int64_t rollbacks, rollback_ticks, rollback_ticks_max;
    int64_t sync_tests, sync_test_mismatches;
} ll_stepping;

/* The frames and the interpolation buffer. */
typedef struct ll_buffer_metrics {
    int64_t frames, held_frames, extrapolated_frames;
    int64_t underruns;           /* times that the buffer ran empty */
    int64_t overruns;            /* times that it was so full that render time jumped */
    ll_running_stats depth;      /* snapshots newer than what is drawn */
    ll_running_stats delay_ms;   /* interpolation delay: newest time that could be known - render time */
    ll_running_stats time_scale; /* render time per time */
} ll_buffer_metrics;

/* Bandwidth, by ll_message. */
typedef struct ll_traffic {
    int64_t bytes[LL_MESSAGES], messages[LL_MESSAGES];     /* of payloads */
    int64_t packets[LL_MESSAGES], wire_bytes[LL_MESSAGES]; /* with all headers */
} ll_traffic;

/* The last values, signed, for views. */
typedef struct ll_last_values {
    double own_lead, remote_error, view_age, age_of_information;
    double correction;
} ll_last_values;

/* Corrections, and those that are visible. */
typedef struct ll_correction_metrics {
    int64_t count;
    double pixel_m;   /* of the screen for which visible corrections are counted */
    double visible_m; /* farthest that a correction moved an entity since the last display; 0: none did */
    ll_running_stats visible_m_all; /* displays with a visible correction */
} ll_correction_metrics;

typedef struct ll_client_metrics {
    ll_time from;
    ll_time measured; /* length of all frames from `from` on */
    ll_histogram histogram[LL_METRICS];
    int32_t entities;
    uint32_t observes; /* bits of ll_observation */
    ll_buffer_metrics buffer;
    ll_inconsistency server, clients; /* inconsistency, over all entities */
    ll_traffic traffic;
    ll_stepping stepping;
    ll_last_values last;
    int64_t drawn_tick; /* found last for a drawn time: the next one is near it */
    ll_correction_metrics corrections;
    ll_histogram animation_error; /* smoothness: pixels, or m where `pixel_m` is 0 */
    ll_input_history input_history;
    ll_changes changes;
    ll_rendered_views rendered_views; /* of the own entity */
    ll_cheat_gain gain;
    ll_honest_reference honest;
    int64_t false_refusals; /* of a client that does not cheat */
    ll_action controls;     /* of the player in its last frame, before any cheat */
    ll_track track[];       /* per entity */
} ll_client_metrics;

#pragma GCC diagnostic pop

size_t ll_client_metrics_size(int entities);
void ll_client_metrics_init(ll_client_metrics *in, int entities, ll_time from);

static inline void ll_measure(ll_client_metrics *in, ll_metric metric, ll_time now, double value)
{
    if (now >= in->from)
        ll_histogram_add(&in->histogram[metric], value);
}

/* ---- reports of the clients ---- */

/* A client made an input for the server's step `tick` (LL_NEVER: applied on arrival) with these controls. */
static inline void ll_client_metrics_input(ll_client_metrics *in, uint32_t seq, int64_t tick,
                                           const ll_action *controls, ll_time touched, ll_time now)
{
    if (!(in->observes & LL_OBSERVE_INPUTS))
        return;
    ll_input_history_made(&in->input_history, seq, tick);
    const ll_made_input input = {controls, seq, now >= in->from, tick, touched};
    ll_changes_made(&in->changes, in->histogram, &input);
}

/* The player is not connected: its controls make no input. */
static inline void ll_client_metrics_missed(ll_client_metrics *in, const ll_action *controls, ll_time now)
{
    if (in->observes & LL_OBSERVE_INPUTS)
        ll_changes_missed(&in->changes, in->histogram, controls, now >= in->from);
}

/* At `acknowledged` a client learns from the snapshot after step `tick`, or from a relay of that step, that
 * its input was applied. Counts in the acknowledgement time if the input was applied. */
void ll_client_metrics_acknowledged(ll_client_metrics *in, uint32_t seq, int64_t tick, ll_time made,
                                    ll_time acknowledged, ll_time now);

/* A correction moved what is drawn by `moved` m; by its own speed it moved `step` m. Counts visible
 * corrections. */
void ll_client_metrics_moved(ll_client_metrics *in, double moved, double step);

/* The open inputs among `first` to `last` will never be applied: the client dropped them, or the server
 * accepts no more from it. */
void ll_client_metrics_never(ll_client_metrics *in, uint32_t first, uint32_t last);

/* ---- reports of the observer ---- */

/* The server has made a step. With `applies_on_arrival`: an update in which it applied all inputs that had
 * arrived, up to `acked`. The client of these metrics no longer sends inputs before `unsent_from`. */
typedef struct ll_stepped {
    const ll_world *world;
    const ll_history *history;
    int64_t step;
    uint32_t acked, unsent_from;
    bool applies_on_arrival;
} ll_stepped;

void ll_client_metrics_stepped(ll_client_metrics *in, int self, const ll_stepped *stepped, ll_time now);

/* A display, `elapsed` after the one before it: what is counted of each, observed or not. */
static inline void ll_client_metrics_drawn(ll_client_metrics *in, ll_time elapsed, ll_time now)
{
    if (now >= in->from) {
        if (in->corrections.visible_m > 0)
            ll_running_stats_add(&in->corrections.visible_m_all, in->corrections.visible_m);
        in->buffer.frames++;
        in->measured += elapsed;
    }
    in->corrections.visible_m = 0;
}

/* All clocks restart: awaited comparisons are discarded. */
void ll_client_metrics_resync(ll_client_metrics *in);

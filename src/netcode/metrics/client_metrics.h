/* What is measured of one player's view. M1 to M13 are the metrics of the field; their definitions stand with
 * each; M7 and M8 have files of their own.
 *
 * Everything is measured from virtual time `from` on, so that the start does not count. The clients write
 * what they know themselves; what needs the truth is written by the observer (client_metrics.c), who alone
 * sees both. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "game/core/history.h"
#include "netcode/metrics/changes.h"
#include "netcode/metrics/cheat_gain.h"
#include "netcode/protocol/running_stats.h"
#include "netcode/metrics/inconsistency.h"
#include "netcode/metrics/input_history.h"
#include "netcode/metrics/rendered_views.h"
#include "netcode/metrics/smoothness.h"
#include "netcode/metrics/twin.h"
#include "netcode/protocol/wire.h"

/* The distributions, X(ID, type, name, unit, bucket, help, null): a row each. The type is that of
 * record/metric.h, the bucket the width of the histogram's, in the unit. The latencies of changes
 * (netcode/metrics/changes.h) stand first. */
#define LL_CLIENT_METRICS(X)                                                                                 \
    X(INPUT_LATENCY, latency, input_latency_ms, "ms", 0.1,                                                   \
      "M1: from making the first input with changed controls to the first display of the own screen that "   \
      "shows it; infinite if it is not applied",                                                             \
      "No change was decided; p50 also when more than half are infinite.")                                   \
    X(CONFIRMED_LATENCY, latency, confirmed_latency_ms, "ms", 0.1,                                           \
      "M1: the same to the first display after a state of the step that applied it", "As input_latency_ms.") \
    X(SEEN_LATENCY, latency, seen_latency_ms, "ms", 0.1,                                                     \
      "M1: the same to the first display of each other player that shows it",                                \
      "As input_latency_ms; there is one player.")                                                           \
    X(ACK_RTT, distribution, ack_rtt_ms, "ms", 0.1,                                                          \
      "M2: from making an input to the first state that says that it was applied", "None did.")              \
    X(VIEW_AGE, distribution, view_age_ms, "ms", 0.1,                                                        \
      "M3: age of the others as drawn: from the server time of what is drawn to now",                        \
      "No display; no other entity.")                                                                        \
    X(AGE_OF_INFORMATION, distribution, age_of_information_ms, "ms", 0.1,                                    \
      "M3b: age of the newest state that the client has taken in", "No display.")                            \
    X(OWN_TIMELINE_ERROR, distribution, own_timeline_error_m, "m", 0.001,                                    \
      "M4: from the own entity as drawn to the truth at the tick that is drawn", "None was compared.")       \
    X(OWN_LEAD, distribution, own_lead_m, "m", 0.001,                                                        \
      "M4b: from the own entity as drawn to the truth now: how far ahead or behind, no error",               \
      "No display.")                                                                                         \
    X(REMOTE_ERROR, distribution, remote_error_m, "m", 0.001,                                                \
      "M4c: from another entity as drawn to the truth now", "No display; no other entity.")                  \
    X(TIMELINE_ERROR, distribution, timeline_error_m, "m", 0.001,                                            \
      "M5: from another entity as drawn to the truth at the time that is drawn", "None was compared.")       \
    X(CORRECTION, distribution, correction_m, "m", 0.001,                                                    \
      "M6: how far a state, or a rollback, moved the own entity at the same tick; only those above 0",       \
      "There was none.")                                                                                     \
    X(POP, distribution, pop_m, "m", 0.001,                                                                  \
      "M6b: how far corrections moved what is drawn in a frame, of the entity that was moved most",          \
      "No frame.")                                                                                           \
    X(BUFFER, distribution, buffer_ms, "ms", 0.1,                                                            \
      "M9: newest state less drawn time; 0 while it is extrapolated",                                        \
      "Interpolation and extrapolation are off.")                                                            \
    X(UNACKED, distribution, unacked, NULL, 1,                                                               \
      "M2b: inputs that wait for an acknowledgement, as the client believes", "No frame.")

#define LL_CLIENT_METRIC_ID(id, type, name, unit, bucket, help, null) LL_METRIC_##id,
typedef enum ll_metric { LL_CLIENT_METRICS(LL_CLIENT_METRIC_ID) LL_METRICS } ll_metric;
#undef LL_CLIENT_METRIC_ID

_Static_assert(LL_METRIC_INPUT_LATENCY == (int)LL_LATENCY_FELT &&
                   LL_METRIC_SEEN_LATENCY == (int)LL_LATENCY_SEEN,
               "the latencies of changes stand first, in their order");

typedef struct ll_metric_row {
    const char *name; /* with its unit */
    double unit;      /* of the histogram */
} ll_metric_row;

extern const ll_metric_row ll_metric_rows[LL_METRICS];

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

/* An entity as predicted for a time that the server has not reached: the truth of then is compared with it
 * when it is there. One at a time, since a lead is short. */
typedef struct ll_awaited {
    int64_t when; /* a time; negative: a step; 0: none */
    double x, y;
} ll_awaited;

/* What is kept per entity. */
typedef struct ll_track {
    ll_smoothness smooth;                  /* of the others */
    ll_divergence_episode server, clients; /* M7: against the truth; against the other clients' pictures */
    ll_awaited awaited;                    /* M5 of what is drawn ahead of the server */
} ll_track;

/* M12 and M14 of a client that steps a world of its own (deterministic, rollback). */
typedef struct ll_stepping {
    int64_t stalls, stalled_frames;        /* without the input of another */
    int32_t waited_frames[LL_PLAYERS_MAX]; /* of these, by whose input was missing */
    int64_t rested_frames;                 /* left out so that the others come after */
    int64_t rollbacks, rollback_ticks, rollback_ticks_max;
    int64_t sync_tests, sync_test_mismatches;
} ll_stepping;

typedef struct ll_client_metrics {
    ll_time from;
    ll_time measured; /* the length of all frames from then on */
    ll_histogram histogram[LL_METRICS];
    int32_t entities, reserved;
    int64_t frames, held_frames, extrapolated_frames;
    int64_t underruns;                /* M9: times that the buffer ran dry */
    int64_t overruns;                 /* M9: times that it was so full that the drawn time jumped */
    ll_running_stats depth;           /* M9: states newer than what is drawn */
    ll_running_stats delay_ms;        /* M9: drawn time behind the newest that could be known */
    ll_running_stats time_scale;      /* M9: drawn time per time */
    ll_inconsistency server, clients; /* M7, over all entities */
    /* M13, by ll_message: payload; how many; in so many packets; with all headers */
    int64_t bytes[LL_MESSAGES], messages[LL_MESSAGES], packets[LL_MESSAGES], wire_bytes[LL_MESSAGES];
    ll_stepping stepping;
    double own_lead, remote_error, view_age, age_of_information; /* the last, signed, for views */
    double last_correction;
    int64_t corrections;
    double pixel_m;                 /* of the screen on which visible corrections are told */
    double visible_m;               /* the farthest that one moved since the last display; 0: none did */
    ll_running_stats visible_m_all; /* M6c: displays with a visible correction */
    ll_histogram animation_error;   /* M8: pixels, or m where `pixel_m` is 0 */
    ll_input_history input_history;
    ll_changes changes;
    ll_rendered_views pictures; /* of the own entity */
    ll_cheat_gain gain;         /* M15 */
    ll_twin twin;               /* M15 */
    int64_t false_refusals;     /* M15: of a client that does not cheat */
    ll_action controls;         /* that drove the player in its last frame, before any cheat */
    ll_track track[];           /* per entity */
} ll_client_metrics;

#pragma GCC diagnostic pop

size_t ll_client_metrics_size(int entities);
void ll_client_metrics_init(ll_client_metrics *in, int entities, ll_time from);

static inline void ll_measure(ll_client_metrics *in, ll_metric metric, ll_time now, double value)
{
    if (now >= in->from)
        ll_histogram_add(&in->histogram[metric], value);
}

/* ---- what the actors tell ---- */

/* A client made an input for the server's step `tick` (LL_NEVER: applied as it comes) with these controls. */
static inline void ll_client_metrics_input(ll_client_metrics *in, uint32_t seq, int64_t tick,
                                           const ll_action *controls, ll_time touched, ll_time now)
{
    ll_input_history_made(&in->input_history, seq, tick);
    ll_changes_made(&in->changes, in->histogram, controls, seq, tick, now >= in->from, touched);
}

/* The player is not connected: no input is made of its controls. */
static inline void ll_client_metrics_missed(ll_client_metrics *in, const ll_action *controls, ll_time now)
{
    ll_changes_missed(&in->changes, in->histogram, controls, now >= in->from);
}

/* M2: `told`: a state after step `tick`, or a relay of that step, tells a client that its input was applied.
 * It counts if it was. */
void ll_client_metrics_acknowledged(ll_client_metrics *in, uint32_t seq, int64_t tick, ll_time made,
                                    ll_time told, ll_time now);

/* M6c: a correction moved what is drawn by `moved` m, while it went `step` m by its own speed. */
void ll_client_metrics_moved(ll_client_metrics *in, double moved, double step);

/* Open ones of inputs `first` to `last` will never be applied: their client has dropped them, or the server
 * will take no more of it. */
void ll_client_metrics_never(ll_client_metrics *in, uint32_t first, uint32_t last);

/* ---- what the observer sees ---- */

/* The server has made a step, or with `applies_on_arrival` an update in which it applied all that had come,
 * up to input `acked`; the client of these instruments sends inputs before `unsent_from` no more. */
typedef struct ll_stepped {
    const ll_world *world;
    const ll_history *history;
    int64_t step;
    uint32_t acked, unsent_from;
    bool applies_on_arrival;
} ll_stepped;

void ll_client_metrics_stepped(ll_client_metrics *in, int self, const ll_stepped *stepped, ll_time now);

/* The server and the clients start anew: what was awaited does not come. */
void ll_client_metrics_resync(ll_client_metrics *in);

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
#include "netcode/metrics/inconsistency.h"
#include "netcode/metrics/input_history.h"
#include "netcode/metrics/rendered_views.h"
#include "netcode/metrics/smoothness.h"
#include "netcode/metrics/twin.h"
#include "netcode/protocol/running_stats.h"
#include "netcode/protocol/wire.h"

typedef enum ll_metric {
    LL_METRIC_INPUT_LATENCY,     /* M1: a change of the controls is felt (netcode/metrics/changes.h), ms */
    LL_METRIC_CONFIRMED_LATENCY, /* M1: the same until it is sure */
    LL_METRIC_SEEN_LATENCY,      /* M1: the same until another player sees it */
    LL_METRIC_ACK_RTT,           /* M2: an input was made until its client has word that it was applied, ms */
    LL_METRIC_VIEW_AGE,          /* M3: now - server time of the others as drawn, ms */
    LL_METRIC_AGE_OF_INFORMATION, /* M3b: now - server time of the newest state taken in, ms */
    LL_METRIC_OWN_TIMELINE_ERROR, /* M4: |own entity as drawn - truth at the tick that is drawn|, m */
    LL_METRIC_OWN_LEAD,     /* M4b: |own entity as drawn - truth now|, m: how far ahead or behind, no error */
    LL_METRIC_REMOTE_ERROR, /* M4c: |others as drawn - truth now|, m */
    LL_METRIC_TIMELINE_ERROR, /* M5: |others as drawn - truth at the time that is drawn|, m */
    LL_METRIC_CORRECTION, /* M6: |own entity before - after a server state|, at the same tick, m; only those
                             above 0 */
    LL_METRIC_POP,     /* M6b: per frame, how far corrections moved what is drawn, the farthest of all, m */
    LL_METRIC_BUFFER,  /* M9: newest state - drawn time, ms; 0 beyond the newest */
    LL_METRIC_UNACKED, /* M2b: inputs that wait for an acknowledgement */
    LL_METRICS,
} ll_metric;

_Static_assert(LL_METRIC_INPUT_LATENCY == (int)LL_LATENCY_FELT &&
                   LL_METRIC_SEEN_LATENCY == (int)LL_LATENCY_SEEN,
               "the latencies of changes stand first, in their order");

typedef struct ll_metric_row {
    const char *name; /* with its unit */
    const char *help;
    double unit; /* of the histogram */
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

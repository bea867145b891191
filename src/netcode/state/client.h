/* A client: sends its player's inputs, and draws the world from the snapshots that it receives.
 *
 * It knows of the server only what packets contain. Part of a simulation's block: rings after the struct,
 * addressed by offsets. */
#pragma once

#include "base/recorder.h"
#include "base/status.h"
#include "netcode/metrics/client_metrics.h"
#include "netcode/protocol/config.h"
#include "netcode/protocol/connection.h"
#include "netcode/protocol/event.h"
#include "netcode/protocol/quantization.h"
#include "netcode/protocol/sync.h"
#include "netcode/protocol/wire.h"
#include "netcode/state/client_parts.h"
#include "netcode/state/recent.h"
#include "netcode/state/weapon_prediction.h"

#define LL_PENDING_RING 512 /* unacknowledged inputs: a new one overwrites the oldest */
#define LL_STATE_RING 64    /* snapshots kept for interpolation: 2 s at 30 updates per second */
#define LL_LARGE_RING 32    /* the same of a world that is larger than LL_SMALL_WORLD bytes */
#define LL_SMALL_WORLD 20000
_Static_assert(LL_RECENT_RING >= LL_STATE_RING, "what each kept snapshot contains is known");

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* What a client knows of an input. */
typedef enum ll_input_state {
    LL_INPUT_OPEN,
    LL_INPUT_APPLIED,
    LL_INPUT_SKIPPED, /* will never be applied */
} ll_input_state;

/* An input that the client has made. */
typedef struct ll_pending_input {
    uint32_t seq;
    uint8_t state;       /* ll_input_state */
    uint8_t closed_once; /* it was closed once */
    uint8_t reserved[2];
    ll_time made;
    double x; /* x of the own entity after it, as last predicted */
    ll_action action;
} ll_pending_input;

/* A received snapshot; its world follows in the ring. */
typedef struct ll_snapshot_entry {
    int64_t tick;
    ll_time time;      /* server's clock */
    ll_time arrived;   /* client's clock */
    uint32_t acked;    /* the last input whose step is over */
    uint32_t applied;  /* the newest applied input */
    uint16_t gridded;  /* others lie on the client's grid */
    uint16_t selected; /* it has only some of the entities */
    uint32_t before;   /* of a snapshot of some entities: LL_PART_RECEIVED */
} ll_snapshot_entry;

typedef enum ll_rendered_flag {
    LL_RENDERED_PREDICTED = 2,
    LL_RENDERED_INTERPOLATED = 4,
    LL_RENDERED_HELD = 8,          /* no newer snapshot */
    LL_RENDERED_EXTRAPOLATED = 32, /* beyond the newest snapshot */
} ll_rendered_flag;

/* How the others are drawn. */
typedef enum ll_view_state {
    LL_VIEW_NEWEST, /* as in the newest snapshot */
    LL_VIEW_NORMAL, /* at a delay, in real time */
    LL_VIEW_CATCHING_UP,
    LL_VIEW_SLOWING,
    LL_VIEW_STARVED, /* held: the buffer is empty */
    LL_VIEW_EXTRAPOLATING,
} ll_view_state;

/* How an entity is drawn. */
typedef struct ll_draw_info {
    ll_time time;   /* render time, by the server's clock */
    uint32_t flags; /* ll_rendered_flag */
    uint32_t reserved;
} ll_draw_info;

/* Drawn position - correct position: decays (netcode/view/smoothing.c). */
typedef struct ll_view_error {
    double x, y, angle;
} ll_view_error;

typedef struct ll_client {
    int32_t self;
    uint16_t epoch;
    uint8_t predicting; /* 0, or 1 + the scope of the predicted world */
    uint8_t reserved;
    ll_client_ticks ticks;
    ll_client_displays displays;
    ll_time due; /* when the client acts next, or earlier: a tick, a display, its connection */
    ll_connection connection;
    ll_client_inputs inputs;
    ll_client_snapshots snapshots;
    ll_client_latest_snapshot latest;
    int64_t view_step; /* the step whose world is drawn; -1: the draw infos contain the times */
    ll_client_results results;
    ll_client_layout layout;
    ll_client_prediction prediction;
    ll_client_view view;
    ll_client_arrivals arrivals;
    ll_client_drawing drawing;
    ll_pending_input pending[LL_PENDING_RING];
} ll_client;

#pragma GCC diagnostic pop

/* What a script did last, and in which time (without its end) it is sure to do the same. Kept outside of the
 * block: it says nothing that the script would not. Peers ask for ticks ahead, and again for earlier ones
 * after they have joined again. */
typedef struct ll_script_memo {
    ll_time from, until;
    ll_action action;
} ll_script_memo;

/* Set-up of a client: constant for its whole life but for `config`, which may change between frames. */
typedef struct ll_client_setup {
    const ll_game *game;
    const ll_game_env *env;
    const ll_sync_mode *sync;
    const ll_player_config *config;
    ll_client_metrics *client_metrics;
    const ll_recorder *recorder;
    const ll_server_config *rules;           /* the server's configuration */
    ll_weapon_prediction *weapon_prediction; /* NULL in a game without weapons */
    struct ll_shots *shots;
    struct ll_reckoning *reckoning;  /* NULL: no dead reckoning */
    struct ll_peer_choices *choices; /* NULL: peers are as by default */
    struct ll_reporter *reporter;    /* NULL: it sends controls alone */
    ll_recent *recent;               /* NULL: snapshots contain every entity */
    ll_script_memo *memo;            /* of one run; NULL: none */
    uint64_t seed;                   /* the session's */
    ll_freq display_freq;            /* of displays that are not made with the ticks */
    double bucket_delay_ms;          /* with buckets: the playout delay */
    bool selects;                    /* snapshots contain only some of the entities */
    bool usual;                      /* ll_client_is_usual */
} ll_client_setup;

/* Whether a client is as most are: a script plays it by the rules, it steps with the server's clock, sends an
 * input with each tick, and its machine is exact. Its ticks and displays ask for nothing that only others do;
 * apart from their cost they do the same. */
bool ll_client_is_usual(const ll_client_setup *setup);

size_t ll_client_size(ll_extent extent); /* a multiple of 8 */
void ll_client_init(ll_client *client, int self, const ll_world *start);

/* The client's clock at `now`. It differs from the server's by the machine's drift. */
static inline ll_time ll_client_local(const ll_client_setup *s, ll_time now)
{
    return now + (ll_time)((double)now * (s->config->drift_ppm * 1e-6));
}

/* The server's present, by the client's estimate of its clock. */
static inline ll_time ll_client_server_time(const ll_client *c, const ll_client_setup *s, ll_time now)
{
    return ll_client_local(s, now) + c->connection.clock.offset;
}

/* Where a client begins. */
typedef struct ll_client_begin {
    uint16_t epoch;
    ll_freq freq;          /* of its ticks; a client that joins keeps its own */
    int64_t step;          /* the server's step now */
    int64_t first;         /* of a client that joins: its inputs count for the steps after this one */
    int64_t own;           /* the server has its earlier inputs up to this step; later ones are neutral */
    const ll_world *world; /* after `step`; NULL, of a client that joins: the next snapshots bring it */
} ll_client_begin;

/* Starts, or restarts at `now` in a new epoch with all other clients. */
void ll_client_start(ll_client *client, const ll_client_setup *setup, const ll_client_begin *begin,
                     ll_time now);

/* Joins a game in progress. */
void ll_client_join(ll_client *client, const ll_client_setup *setup, const ll_client_begin *begin,
                    ll_time now);

/* The connection is over: open inputs will never be applied. */
void ll_client_leave(ll_client *client, const ll_client_setup *setup);

/* Delay of the arrival of its first input at the server after the game began, in whole intervals of its
 * ticks, by the measured clock; at most 255. */
uint8_t ll_client_offset(const ll_client *client, const ll_client_setup *setup);

/* Makes the next input for the first step that it can reach in time, by the measured clock, if the difference
 * is LL_CLOCK_SNAP or more, or if `always`. Steps in between get no input. */
void ll_client_align(ll_client *client, const ll_client_setup *setup, bool always, ll_time now);

/* ---- connection.c ---- */

/* Time of the next action without a received packet. */
ll_time ll_connection_due(const ll_client *client, const ll_client_setup *setup);

/* Does what is due at `now`: ends a state after a time without packets, or writes a connect or a ping.
 * Returns its size, 0 if there is none. */
int ll_connection_poll(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* A packet of the server has arrived. False: it belongs to the game, not to the connection. */
bool ll_connection_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int size,
                           ll_time now);

/* ---- receive.c, tick.c, client.c ---- */

/* A packet of the server has arrived. Returns its ll_outcome. */
int ll_client_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int size,
                      ll_time now);

/* One tick: applies received snapshots and makes inputs. Writes an ll_input_message and returns its size, 0
 * if there is nothing to send. */
int ll_client_tick(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* One display: applies received snapshots and draws. */
void ll_client_display(ll_client *client, const ll_client_setup *setup, ll_time now);

/* The same of a usual client. */
int ll_client_usual_tick(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);
void ll_client_usual_display(ll_client *client, const ll_client_setup *setup, ll_time now);

/* Recomputes client->due, after it acted or a packet arrived. */
void ll_client_set_due(ll_client *client, const ll_client_setup *setup);

/* After a tick: sets the time of the next, late according to `timer_jitter_ms`. After a display: the time of
 * the next one. */
void ll_client_set_timer(ll_client *client, const ll_client_setup *setup, ll_time now);
void ll_client_set_usual_timer(ll_client *client);
void ll_client_set_display(ll_client *client, const ll_client_setup *setup);

/* Packets that a lag switch held back and releases at `now`, to be sent after that of the frame. Returns the
 * size of the next, 0 if there is none. */
int ll_client_held(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* ---- shared by the client's files ---- */

/* Applies the newest snapshot that has arrived, also to the prediction. */
void ll_client_apply_newest(ll_client *client, const ll_client_setup *setup, ll_time now);

/* The next input will be for the step after `tick`; steps in between get none. */
void ll_client_snap(ll_client *client, int64_t tick);

/* A new epoch: inputs of the one before are discarded. */
void ll_client_forget_inputs(ll_client *client, const ll_client_setup *setup, uint16_t epoch, ll_time now);

/* The player's controls at `t`: those of a person, or of a script that has seen `seen`. */
ll_action ll_client_control(const ll_client *client, const ll_client_setup *setup, const ll_world *seen,
                            ll_time t);

/* Time at which a control must have been moved for the input made at `now` to contain it: input device
 * latency. */
ll_time ll_client_control_time(const ll_client *client, const ll_client_setup *setup, ll_time now);

/* A tick of a client that does not play: its player's controls have no effect. */
void ll_client_miss(const ll_client *client, const ll_client_setup *setup, ll_time now);

/* The number of snapshots that a client keeps. */
static inline int64_t ll_state_ring(int64_t world_size)
{
    return world_size <= LL_SMALL_WORLD ? LL_STATE_RING : LL_LARGE_RING;
}

/* Index of the oldest kept snapshot. */
static inline int64_t ll_client_oldest(const ll_client *c)
{
    int64_t oldest = c->snapshots.received - ll_state_ring(c->layout.world_size);
    return oldest > 0 ? oldest : 0;
}

static inline ll_snapshot_entry *ll_client_state(ll_client *c, int64_t index)
{
    return (ll_snapshot_entry *)((char *)c + c->layout.states +
                                 (index & (ll_state_ring(c->layout.world_size) - 1)) *
                                     (int64_t)(sizeof(ll_snapshot_entry) + (size_t)c->layout.world_size));
}

static inline ll_world *ll_snapshot_entry_world(ll_snapshot_entry *r)
{
    return (ll_world *)(r + 1);
}

static inline ll_world *ll_client_latest(ll_client *c)
{
    return (ll_world *)((char *)c + c->layout.latest);
}

static inline ll_world *ll_client_predicted(ll_client *c)
{
    return (ll_world *)((char *)c + c->layout.predicted);
}

/* The part of the prediction that has been compared with snapshots: the world from which the inputs that the
 * latest snapshot does not include give the predicted one. */
static inline ll_world *ll_client_checked(ll_client *c)
{
    return (ll_world *)((char *)c + c->layout.checked);
}

/* The world that the client draws. */
static inline ll_world *ll_client_rendered(ll_client *c)
{
    return (ll_world *)((char *)c + c->layout.rendered);
}

static inline const ll_world *ll_client_rendered_const(const ll_client *c)
{
    return (const ll_world *)((const char *)c + c->layout.rendered);
}

static inline ll_draw_info *ll_client_draw_infos(ll_client *c)
{
    return (ll_draw_info *)((char *)c + c->layout.draw_infos);
}

static inline const ll_draw_info *ll_client_draw_infos_const(const ll_client *c)
{
    return (const ll_draw_info *)((const char *)c + c->layout.draw_infos);
}

/* Start of a tick, in every sync mode. */
static inline void ll_client_begin_tick(ll_client *c, ll_time now)
{
    c->ticks.number++;
    c->ticks.elapsed = now - c->ticks.last;
    c->ticks.last = now;
}

/* Start of a display, in every sync mode. */
static inline void ll_client_begin_display(ll_client *c, ll_time now)
{
    c->displays.number++;
    c->displays.elapsed = now - c->displays.last;
    c->displays.last = now;
}

static inline ll_view_error *ll_client_errors(ll_client *c)
{
    return (ll_view_error *)((char *)c + c->layout.errors);
}

/* Time at which the server makes step `tick`, by its clock. Ticks are computed, not accumulated: the fraction
 * of a nanosecond of the period adds no error. */
static inline ll_time ll_client_step_time(const ll_client *c, int64_t tick)
{
    return c->latest.time + ll_tick_time(tick - c->snapshots.game_start_step, c->ticks.clock.freq) -
           ll_tick_time(c->latest.tick - c->snapshots.game_start_step, c->ticks.clock.freq);
}

static inline ll_pending_input *ll_client_pending(ll_client *c, uint32_t seq)
{
    return &c->pending[seq & (LL_PENDING_RING - 1)];
}

static inline bool ll_client_is_open(ll_client *c, uint32_t seq)
{
    return ll_client_pending(c, seq)->seq == seq && ll_client_pending(c, seq)->state == LL_INPUT_OPEN;
}

/* The input for the server's step `tick`, where inputs belong to steps; NULL: none was made, or it was
 * overwritten. */
static inline ll_pending_input *ll_client_input_at(ll_client *c, int64_t tick)
{
    int64_t seq = tick - (c->inputs.tick - (int64_t)c->inputs.seq);
    bool kept = seq >= 1 && seq <= (int64_t)c->inputs.seq && ll_client_pending(c, (uint32_t)seq)->seq == seq;
    return kept ? ll_client_pending(c, (uint32_t)seq) : NULL;
}

/* Whether the predicted world is that of the newest input that it contains. */
static inline bool ll_prediction_in_step(const ll_client *c)
{
    return c->predicting != 0 &&
           c->prediction.tick == c->inputs.tick - (int64_t)(c->inputs.seq - c->prediction.played);
}

/* dilate_time.c: adjusts the length of frames to the slack */
void ll_dilate_time_follow(ll_client *client, const ll_client_setup *setup,
                           const ll_snapshot_message *message, ll_time now);
void ll_dilate_time(ll_client *client); /* moves the next frame */

/* predict.c: the entities in the prediction scope */
void ll_predict_pending_inputs(ll_client *client, const ll_client_setup *setup); /* the inputs that are due */
void ll_resimulate(ll_client *client,
                   const ll_client_setup *setup); /* the latest snapshot and the open inputs */
bool ll_prediction_stands(ll_client *client, const ll_client_setup *setup, const ll_snapshot_entry *state,
                          uint32_t acked);
/* The same of a client that moves its own entity and reports it (netcode/protocol/report.h): whether it keeps
 * its own state, and does not take that of the snapshot. */
bool ll_report_stands(const ll_client *client, struct ll_reporter *reporter);
void ll_reconcile(ll_client *client, const ll_client_setup *setup, bool stands, ll_time now);
void ll_draw_predicted(ll_client *client, ll_time now);
void ll_note_correction(const ll_client *client, const ll_client_setup *setup, ll_cause cause, double moved,
                        ll_time now); /* correction of the own entity by this distance, signed by x */

/* interpolate.c: the entities of others */
void ll_interpolate_heard(
    ll_client *client,
    const ll_snapshot_entry *state); /* a snapshot has arrived: follow the server's clock */
void ll_interpolate_server_time(ll_client *client, const ll_client_setup *setup, ll_time now);
void ll_blend(ll_client *client, const ll_snapshot_entry *a, const ll_snapshot_entry *b,
              double alpha); /* linear */

/* netcode/view/smoothing.c: corrections of what is drawn */
#define LL_SMOOTH_MAX_M 4.0 /* a larger error is not smoothed: it is drawn as a jump at once */

/* `right` replaces `drawn` (without view errors), at the same time. */
void ll_smooth_correct(ll_client *client, int entity, const ll_entity *drawn, const ll_entity *right);

/* End of a frame: decays the errors and adds the rest to what is drawn. */
void ll_smooth_draw(ll_client *client, const ll_client_setup *setup, ll_time now);

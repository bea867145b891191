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
#include "netcode/state/weapon_prediction.h"

#define LL_PENDING_RING 512 /* unacknowledged inputs: a new one overwrites the oldest */
#define LL_STATE_RING 64    /* snapshots kept for interpolation: 2 s at 30 updates per second */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

#define LL_OFFSET_WINDOW 8 /* quarters of a second over which the fastest packet counts */

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
    ll_time time;     /* server's clock */
    ll_time arrived;  /* client's clock */
    uint32_t acked;   /* the last input whose step is over */
    uint32_t applied; /* the newest applied input */
    uint32_t gridded; /* others lie on the client's grid */
    uint32_t reserved;
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
    ll_clock clock;               /* of ticks, on a machine without drift */
    int64_t frame;                /* number of the next tick */
    ll_time period;               /* of a tick */
    ll_time framed, tick_elapsed; /* when the last tick was, and the time from the tick before it */
    ll_time tick_due;             /* the next tick */
    int64_t skipped;              /* ticks left out because the timer was late */
    ll_clock display;             /* of displays; freq 0: one with each tick */
    int64_t displays;             /* number of the next display */
    ll_time display_due;          /* LL_NEVER: with the next tick */
    ll_time displayed, elapsed;   /* when the last display was, and the time from the display before it */
    ll_time due; /* when the client acts next, or earlier: a tick, a display, its connection */
    ll_connection connection;

    /* inputs */
    int64_t tick;        /* the server's step that the newest input is meant for */
    uint32_t seq, acked; /* newest made; all up to there are closed */
    uint32_t run; /* from this input on numbers and steps correspond: a snap of the clock leaves out some */
    uint32_t newest_sent; /* the newest that was sent */
    int32_t extra_inputs; /* inputs to make beyond one per frame; negative: to skip */
    uint32_t settle;      /* slack is read again from this input on */
    int32_t least_slack;  /* smallest slack since `least_slack_since` */
    uint32_t unsent;      /* the first input that a lag switch holds back; 0: none */
    ll_time least_slack_since;
    ll_time least_slack_ns; /* the same with time dilation; LL_NEVER: none */
    ll_time
        clock_correction; /* remaining clock correction, spread over frames: positive makes them earlier */
    double scale;         /* of the last frame: nominal length over actual length */
    ll_action held;       /* the player's controls */
    int64_t refused;

    /* snapshots */
    int64_t newest;          /* number received: the newest is at newest - 1 modulo the ring */
    int64_t fresh;           /* of these, the number that frames have applied */
    int64_t newest_tick;     /* -1: none in this epoch */
    int64_t confirmed;       /* the server's last known step */
    int64_t game_start_step; /* the server's step when the game began, or after the last resync */
    ll_time game_start;      /* time of that step */
    int64_t stale, unreadable;
    ll_quantization grid; /* of the snapshots from `grid_tick` on */
    int64_t grid_tick;    /* LL_NEVER: none yet */
    ll_time latest_time;  /* server's clock, of the snapshot applied last */
    int64_t latest_tick;
    double update_hz;
    ll_action last_controls[LL_PLAYERS_MAX]; /* others' controls in the newest snapshot; zero until one
                                                contains them */
    int64_t view_step; /* the step whose world is drawn; -1: the draw infos contain the times */
    uint32_t results[LL_INPUT_RESULT_WORDS_MAX]; /* of the newest snapshot that contains them */
    ll_input_result_part result;
    uint32_t parts, reserved4; /* ll_part of the newest snapshot */
    int64_t world_size;
    /* from the start of this struct: worlds, and an ll_draw_info and an ll_view_error per entity for the
     * rendered one */
    int64_t states_offset, latest_offset, predicted_offset, checked_offset, rendered_offset,
        draw_infos_offset, errors_offset;

    /* prediction */
    int64_t predicted_tick;            /* of the predicted world */
    uint32_t played;                   /* newest input in it */
    uint32_t gaps;                     /* it lacks inputs after those of the snapshot that it started from */
    ll_entity_set predicted;           /* entities of it that are stepped */
    ll_action guessed[LL_PLAYERS_MAX]; /* others' controls that it is stepped with */
    int64_t begun_tick;         /* of the last snapshot that it started from, or was bitwise equal to */
    ll_quantization begun_grid; /* of the others in that snapshot; all 0: none */
    uint32_t begun_acked;       /* the newest input in that snapshot */
    uint32_t touched;           /* others may have acted on the own entity since */

    /* interpolation */
    ll_time offset; /* server's clock - client's clock when the fastest recent packet arrived */
    ll_time render; /* render time, server's clock; only increases */
    ll_time delay;  /* interpolation delay in use */
    double drift;   /* averaged distance from the target, ns (time_scale catch_up) */
    uint8_t has_render, extrapolated, held_now;
    uint8_t underrun;        /* under-run: nothing newer than what is drawn has arrived */
    uint8_t view_state;      /* ll_view_state */
    uint8_t has_view_errors; /* an error is not zero */
    uint8_t reserved2[2];
    ll_time offset_window[LL_OFFSET_WINDOW]; /* largest per quarter of a second */
    int64_t offset_quarter;
    ll_time last_arrival;      /* when the newest snapshot arrived; -1 */
    double gap, gap_deviation; /* between arrivals of snapshots, averages in ns; -1: none yet */
    double late;               /* of snapshots relative to the fastest, average in ns */

    /* drawing */
    ll_time view_time;    /* render time of the others, server's clock */
    double alpha;         /* between the two interpolated snapshots */
    double buffer_ms;     /* time of the newest snapshot - render time */
    double time_scale;    /* render time per time in the last frame */
    int64_t depth;        /* snapshots newer than what is drawn */
    int64_t drawn_newest; /* number of snapshots received when it was drawn */

    ll_pending_input pending[LL_PENDING_RING];
} ll_client;

#pragma GCC diagnostic pop

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
    uint64_t seed;        /* the session's */
    ll_freq display_freq; /* of displays that are not made with the ticks */
} ll_client_setup;

size_t ll_client_size(ll_extent extent); /* a multiple of 8 */
void ll_client_init(ll_client *client, int self, const ll_world *start);

/* The client's clock at `now`. It differs from the server's by the machine's drift. */
static inline ll_time ll_client_local(const ll_client_setup *s, ll_time now)
{
    return now + (ll_time)((double)now * (s->config->drift_ppm * 1e-6));
}

/* Starts, or restarts at `now` in a new epoch with all other clients. `step` is the server's step now and
 * `world` its state. */
void ll_client_start(ll_client *client, const ll_client_setup *setup, uint16_t epoch, ll_freq freq,
                     int64_t step, const ll_world *world, ll_time now);

/* Joins a game in progress: its inputs count for the steps after `first`. `world` is that after `step`; NULL:
 * the next snapshots bring it. */
void ll_client_join(ll_client *client, const ll_client_setup *setup, uint16_t epoch, int64_t step,
                    int64_t first, const void *world, ll_time now);

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

/* ---- client.c ---- */

/* A packet of the server has arrived. Returns its ll_outcome. */
int ll_client_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int size,
                      ll_time now);

/* One tick: applies received snapshots and makes inputs. Writes an ll_input_message and returns its size, 0
 * if there is nothing to send. */
int ll_client_tick(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* One display: applies received snapshots and draws. */
void ll_client_display(ll_client *client, const ll_client_setup *setup, ll_time now);

/* Recomputes client->due, after it acted or a packet arrived. */
void ll_client_set_due(ll_client *client, const ll_client_setup *setup);

/* After a tick: sets `client->tick_due`, late according to `timer_jitter_ms`. After a display: the time of
 * the next one. */
void ll_client_set_timer(ll_client *client, const ll_client_setup *setup, ll_time now);
void ll_client_set_display(ll_client *client, const ll_client_setup *setup);

/* Packets that a lag switch held back and releases at `now`, to be sent after that of the frame. Returns the
 * size of the next, 0 if there is none. */
int ll_client_held(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* ---- shared by the client's files ---- */

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

static inline ll_snapshot_entry *ll_client_state(ll_client *c, int64_t index)
{
    return (ll_snapshot_entry *)((char *)c + c->states_offset +
                                 (index & (LL_STATE_RING - 1)) *
                                     (int64_t)(sizeof(ll_snapshot_entry) + (size_t)c->world_size));
}

static inline ll_world *ll_snapshot_entry_world(ll_snapshot_entry *r)
{
    return (ll_world *)(r + 1);
}

static inline ll_world *ll_client_latest(ll_client *c)
{
    return (ll_world *)((char *)c + c->latest_offset);
}

static inline ll_world *ll_client_predicted(ll_client *c)
{
    return (ll_world *)((char *)c + c->predicted_offset);
}

/* The part of the prediction that has been compared with snapshots: the world from which the inputs that the
 * latest snapshot does not include give the predicted one. */
static inline ll_world *ll_client_checked(ll_client *c)
{
    return (ll_world *)((char *)c + c->checked_offset);
}

/* The world that the client draws. */
static inline ll_world *ll_client_rendered(ll_client *c)
{
    return (ll_world *)((char *)c + c->rendered_offset);
}

static inline const ll_world *ll_client_rendered_const(const ll_client *c)
{
    return (const ll_world *)((const char *)c + c->rendered_offset);
}

static inline ll_draw_info *ll_client_draw_infos(ll_client *c)
{
    return (ll_draw_info *)((char *)c + c->draw_infos_offset);
}

static inline const ll_draw_info *ll_client_draw_infos_const(const ll_client *c)
{
    return (const ll_draw_info *)((const char *)c + c->draw_infos_offset);
}

/* Start of a tick, in every sync mode. */
static inline void ll_client_begin_tick(ll_client *c, ll_time now)
{
    c->frame++;
    c->tick_elapsed = now - c->framed;
    c->framed = now;
}

/* Start of a display, in every sync mode. */
static inline void ll_client_begin_display(ll_client *c, ll_time now)
{
    c->displays++;
    c->elapsed = now - c->displayed;
    c->displayed = now;
}

static inline ll_view_error *ll_client_errors(ll_client *c)
{
    return (ll_view_error *)((char *)c + c->errors_offset);
}

/* Time at which the server makes step `tick`, by its clock. Ticks are computed, not accumulated: the fraction
 * of a nanosecond of the period adds no error. */
static inline ll_time ll_client_step_time(const ll_client *c, int64_t tick)
{
    return c->latest_time + ll_tick_time(tick - c->game_start_step, c->clock.freq) -
           ll_tick_time(c->latest_tick - c->game_start_step, c->clock.freq);
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
    int64_t seq = tick - (c->tick - (int64_t)c->seq);
    bool kept = seq >= 1 && seq <= (int64_t)c->seq && ll_client_pending(c, (uint32_t)seq)->seq == seq;
    return kept ? ll_client_pending(c, (uint32_t)seq) : NULL;
}

/* `state`, the newest snapshot, decides that input `seq` was applied or never will be. */
void ll_client_close(ll_client *client, const ll_client_setup *setup, uint32_t seq, ll_input_state how,
                     const ll_snapshot_entry *state, ll_time now);

/* decode.c: the world of a snapshot, in `size` bytes; `world` is undefined after an error */
ll_status ll_client_decode(ll_client *client, const ll_snapshot_message *message, const void *bytes, int size,
                           ll_world *world);

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

/* extrapolate.c: `from` after `dt` seconds at its velocity */
void ll_extrapolate(const ll_client_setup *setup, const ll_entity *from, double dt, ll_entity *out);

/* netcode/view/smoothing.c: corrections of what is drawn */
#define LL_SMOOTH_MAX_M 4.0 /* a larger error is not smoothed: it is drawn as a jump at once */

/* `right` replaces `drawn` (without view errors), at the same time. */
void ll_smooth_correct(ll_client *client, int entity, const ll_entity *drawn, const ll_entity *right);

/* End of a frame: decays the errors and adds the rest to what is drawn. */
void ll_smooth_draw(ll_client *client, const ll_client_setup *setup, ll_time now);

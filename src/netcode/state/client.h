/* A client: sends its player's inputs, and draws the world from what it has received.
 *
 * It knows of the server only what packets say. Part of a simulation's block: rings behind the struct,
 * reached by offsets. */
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

#define LL_PENDING_RING 512 /* inputs that are not acknowledged: the oldest gives way to a newer one */
#define LL_STATE_RING 64    /* states kept for interpolation: 2 s at 30 updates a second */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

#define LL_OFFSET_WINDOW 8 /* quarters of a second over which the fastest packet counts */

/* What a client knows of an input. */
typedef enum ll_input_state {
    LL_INPUT_OPEN,
    LL_INPUT_APPLIED,
    LL_INPUT_SKIPPED, /* it will never be applied */
} ll_input_state;

/* An input that was made. */
typedef struct ll_pending_input {
    uint32_t seq;
    uint8_t state; /* ll_input_state */
    uint8_t told;  /* it was closed once */
    uint8_t reserved[2];
    ll_time made;
    double x; /* where it put the own entity, as predicted last */
    ll_action action;
} ll_pending_input;

/* A state as received; its world follows in the ring. */
typedef struct ll_snapshot_entry {
    int64_t tick;
    ll_time time;     /* server's clock */
    ll_time arrived;  /* client's clock */
    uint32_t acked;   /* the last input whose step is over */
    uint32_t applied; /* the newest that was really applied */
    uint32_t gridded; /* others lie on the client's grid */
    uint32_t reserved;
} ll_snapshot_entry;

typedef enum ll_rendered_flag {
    LL_RENDERED_PREDICTED = 2,
    LL_RENDERED_INTERPOLATED = 4,
    LL_RENDERED_HELD = 8,          /* for want of a state */
    LL_RENDERED_EXTRAPOLATED = 32, /* beyond the newest state */
} ll_rendered_flag;

/* How the others are drawn. */
typedef enum ll_view_state {
    LL_VIEW_NEWEST, /* as the newest state has them */
    LL_VIEW_NORMAL, /* at a delay, in real time */
    LL_VIEW_CATCHING_UP,
    LL_VIEW_SLOWING,
    LL_VIEW_STARVED, /* held: the buffer has run dry */
    LL_VIEW_EXTRAPOLATING,
} ll_view_state;

/* How an entity is drawn. */
typedef struct ll_draw_info {
    ll_time time;   /* of the server's clock: what is drawn is of that time */
    uint32_t flags; /* ll_rendered_flag */
    uint32_t reserved;
} ll_draw_info;

/* What is drawn - what is right: decays (netcode/view/smoothing.c). */
typedef struct ll_view_error {
    double x, y, angle;
} ll_view_error;

typedef struct ll_client {
    int32_t self;
    uint16_t epoch;
    uint8_t predicting; /* 0, or 1 + the scope that the predicted world was made with */
    uint8_t reserved;
    ll_clock clock;               /* of ticks, by a machine without drift */
    int64_t frame;                /* number of the next tick */
    ll_time period;               /* of a tick */
    ll_time framed, tick_elapsed; /* when the last tick was, and how long after the one before it */
    ll_time tick_due;             /* the next tick */
    int64_t skipped;              /* ticks that passed without one, the timer being late */
    ll_clock display;             /* of displays; freq 0: one with each tick */
    int64_t displays;             /* number of the next display */
    ll_time display_due;          /* LL_NEVER: with the next tick */
    ll_time displayed, elapsed;   /* when the last display was, and how long after the one before it */
    ll_time due;                  /* when it acts next, or before: a tick, a display, its connection */
    ll_connection connection;

    /* inputs */
    int64_t tick;        /* the server's step that the newest input is meant for */
    uint32_t seq, acked; /* newest made; all up to there are closed */
    uint32_t
        run; /* inputs from this one on have a number for every step: a snap of the clock leaves out some */
    uint32_t composed; /* the newest that was sent */
    int32_t debt;      /* inputs to make beyond one a frame, or (negative) to leave out */
    uint32_t settle;   /* slack is read again from this input on */
    int32_t spare;     /* least slack since `spare_since` */
    uint32_t unsent;   /* the first input that a lag switch holds back; 0: none */
    ll_time spare_since;
    ll_time spare_ns; /* the same where time is dilated; LL_NEVER: none */
    ll_time shift;    /* how much earlier than they would the frames come, a little each */
    double scale;     /* of the last frame's length: its own one over that which it had */
    ll_action held;   /* the player's controls */
    int64_t refused;

    /* states */
    int64_t newest;      /* how many were received: the newest is at newest - 1 modulo the ring */
    int64_t fresh;       /* of these, how many a frame has taken */
    int64_t newest_tick; /* -1: none in this epoch */
    int64_t confirmed;   /* the server's last step that is known of */
    int64_t met;         /* the server's step when the game began, or began anew */
    ll_time met_at;      /* and when that was */
    int64_t stale, unreadable;
    ll_quantization grid; /* of the states from `grid_tick` on */
    int64_t grid_tick;    /* LL_NEVER: none yet */
    ll_time latest_time;  /* server's clock, of the state that was taken last */
    int64_t latest_tick;
    double update_hz;
    ll_action told[LL_PLAYERS_MAX]; /* others' controls at the newest state; zeroes until it tells */
    int64_t view_step;              /* the step whose world is drawn; -1: the marks tell the times */
    uint32_t verdicts[LL_INPUT_RESULT_WORDS_MAX]; /* of the newest state, where it tells */
    ll_input_result_part verdict;
    uint32_t parts, reserved4; /* ll_part of the newest state */
    int64_t world_size;
    /* from the start of this struct: worlds, and a ll_draw_info and a ll_view_error per entity for the one
     * that is shown */
    int64_t states_offset, latest_offset, predicted_offset, checked_offset, shown_offset, marks_offset,
        errors_offset;

    /* prediction */
    int64_t predicted_tick;            /* of the predicted world */
    uint32_t played;                   /* newest input in it */
    uint32_t gaps;                     /* it lacks inputs behind those of the state that it began with */
    ll_entity_set predicted;           /* what of it is stepped */
    ll_action guessed[LL_PLAYERS_MAX]; /* others' controls that it is stepped with */
    int64_t begun_tick;                /* of the last state that it began with, or was equal to the bit */
    ll_quantization begun_grid;        /* that the others lay on in that state; all 0: none */
    uint32_t begun_acked;              /* the newest input in that state */
    uint32_t touched;                  /* others may have acted on the own entity since */

    /* interpolation */
    ll_time offset; /* server's clock - client's clock when the fastest recent packet came */
    ll_time render; /* server time that is drawn; moves forward only */
    ll_time delay;  /* interpolation delay in use */
    double drift;   /* averaged distance from the target, ns (time_scale catch_up) */
    uint8_t has_render, extrapolated, held_now;
    uint8_t dry;        /* nothing newer than what is drawn is in stock */
    uint8_t view_state; /* ll_view_state */
    uint8_t erring;     /* an error is not zero */
    uint8_t reserved2[2];
    ll_time offset_window[LL_OFFSET_WINDOW]; /* largest per quarter of a second */
    int64_t offset_quarter;
    ll_time heard;             /* when the newest state came; -1 */
    double gap, gap_deviation; /* between the arrivals of states, averages in ns; -1: none yet */
    double late;               /* of states against the fastest, average in ns */

    /* drawing */
    ll_time view_time;    /* server's clock: the others are drawn as of then */
    double alpha;         /* between the two states that are interpolated */
    double buffer_ms;     /* newest state - drawn time */
    double time_scale;    /* drawn time per time in the last frame */
    int64_t depth;        /* states newer than what is drawn */
    int64_t drawn_newest; /* of the states, how many had come when it was drawn */

    ll_pending_input pending[LL_PENDING_RING];
} ll_client;

#pragma GCC diagnostic pop

/* What a client is set up with; the same for its whole life but for `config`, which may change between
 * frames. */
typedef struct ll_client_setup {
    const ll_game *game;
    const ll_game_env *env;
    const ll_sync_mode *sync;
    const ll_player_config *config;
    ll_client_metrics *client_metrics;
    const ll_recorder *recorder;
    const ll_server_config *rules;           /* what everybody has agreed on */
    ll_weapon_prediction *weapon_prediction; /* NULL in a game without weapons */
    struct ll_shots *shots;
    uint64_t seed;        /* the session's */
    ll_freq display_freq; /* of displays where they are not with the ticks */
} ll_client_setup;

size_t ll_client_size(ll_extent extent); /* a multiple of 8 */
void ll_client_init(ll_client *client, int self, const ll_world *start);

/* The client's clock at `now`. It differs from the server's by the machine's drift. */
static inline ll_time ll_client_local(const ll_client_setup *s, ll_time now)
{
    return now + (ll_time)((double)now * (s->config->drift_ppm * 1e-6));
}

/* Starts, or starts again at `now` in a new epoch with everybody else. `step` is the server's step now and
 * `world` its state. */
void ll_client_start(ll_client *client, const ll_client_setup *setup, uint16_t epoch, ll_freq freq,
                     int64_t step, const ll_world *world, ll_time now);

/* Comes to a game that is under way: its inputs count for the steps behind `first`. `world` is that after
 * `step`; NULL: the states that follow tell it. */
void ll_client_join(ll_client *client, const ll_client_setup *setup, uint16_t epoch, int64_t step,
                    int64_t first, const void *world, ll_time now);

/* The connection is over: what is open will never be applied. */
void ll_client_leave(ll_client *client, const ll_client_setup *setup);

/* How many whole intervals of its ticks after the game began its first input would come at the server, by the
 * measured clock; at most 255. */
uint8_t ll_client_offset(const ll_client *client, const ll_client_setup *setup);

/* Makes the next input for the step that it can be in time for, by the measured clock: where the difference
 * is LL_CLOCK_SNAP or more, or `always`. Steps in between get no input. */
void ll_client_align(ll_client *client, const ll_client_setup *setup, bool always, ll_time now);

/* ---- connection.c ---- */

/* When something is to be done next, whatever comes. */
ll_time ll_connection_due(const ll_client *client, const ll_client_setup *setup);

/* What is due at `now`: a state that ends for want of packets, a connect or a ping that is to be sent.
 * Writes it and returns its size, 0 when there is none. */
int ll_connection_tend(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* Any packet of the server has come. False: it is not of the connection but of the game. */
bool ll_connection_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int size,
                           ll_time now);

/* ---- client.c ---- */

/* A packet of the server has come. Returns its ll_outcome. */
int ll_client_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int size,
                      ll_time now);

/* One tick: takes what has come and makes inputs. Writes an ll_input_message and returns its size, 0 when
 * there is nothing to send. */
int ll_client_tick(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* One display: takes what has come and draws. */
void ll_client_display(ll_client *client, const ll_client_setup *setup, ll_time now);

/* Sets client->due anew, after it acted or something has come. */
void ll_client_set_due(ll_client *client, const ll_client_setup *setup);

/* After a tick: sets `client->tick_due`, late as `timer_jitter_ms` has it. After a display: the next one. */
void ll_client_set_timer(ll_client *client, const ll_client_setup *setup, ll_time now);
void ll_client_set_display(ll_client *client, const ll_client_setup *setup);

/* What a lag switch has held back and lets go at `now`: packets to be sent behind that of the frame. Returns
 * the size of the next, 0 when there is none. */
int ll_client_held(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);

/* ---- between the client's files ---- */

/* The step that the next input is for becomes that behind `tick`; those in between get none. */
void ll_client_snap(ll_client *client, int64_t tick);

/* A new epoch: what was made in the one before is void. */
void ll_client_forget_inputs(ll_client *client, const ll_client_setup *setup, uint16_t epoch, ll_time now);

/* The player's controls at `t`: those of a person, or what a script does that has seen `seen`. */
ll_action ll_client_control(const ll_client *client, const ll_client_setup *setup, const ll_world *seen,
                            ll_time t);

/* When a control must have been moved so that the input made at `now` has it: by the latency of the device.
 */
ll_time ll_client_touched(const ll_client *client, const ll_client_setup *setup, ll_time now);

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

/* What of the prediction has been compared with states: the world that the predicted one is made of by the
 * inputs that the latest state does not include. */
static inline ll_world *ll_client_checked(ll_client *c)
{
    return (ll_world *)((char *)c + c->checked_offset);
}

/* What the client draws. */
static inline ll_world *ll_client_rendered(ll_client *c)
{
    return (ll_world *)((char *)c + c->shown_offset);
}

static inline const ll_world *ll_client_rendered_const(const ll_client *c)
{
    return (const ll_world *)((const char *)c + c->shown_offset);
}

static inline ll_draw_info *ll_client_draw_infos(ll_client *c)
{
    return (ll_draw_info *)((char *)c + c->marks_offset);
}

static inline const ll_draw_info *ll_client_draw_infos_const(const ll_client *c)
{
    return (const ll_draw_info *)((const char *)c + c->marks_offset);
}

/* First of a tick, of every sync's. */
static inline void ll_client_begin_tick(ll_client *c, ll_time now)
{
    c->frame++;
    c->tick_elapsed = now - c->framed;
    c->framed = now;
}

/* First of a display, of every sync's. */
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

/* When the server makes step `tick`, by its clock. Steps are where that clock has them, whatever the period's
 * fraction of a nanosecond. */
static inline ll_time ll_client_step_time(const ll_client *c, int64_t tick)
{
    return c->latest_time + ll_tick_time(tick - c->met, c->clock.freq) -
           ll_tick_time(c->latest_tick - c->met, c->clock.freq);
}

static inline ll_pending_input *ll_client_pending(ll_client *c, uint32_t seq)
{
    return &c->pending[seq & (LL_PENDING_RING - 1)];
}

static inline bool ll_client_is_open(ll_client *c, uint32_t seq)
{
    return ll_client_pending(c, seq)->seq == seq && ll_client_pending(c, seq)->state == LL_INPUT_OPEN;
}

/* The input for the server's step `tick`, where inputs belong to steps; NULL: none was made, or it is no
 * longer kept. */
static inline ll_pending_input *ll_client_input_at(ll_client *c, int64_t tick)
{
    int64_t seq = tick - (c->tick - (int64_t)c->seq);
    bool kept = seq >= 1 && seq <= (int64_t)c->seq && ll_client_pending(c, (uint32_t)seq)->seq == seq;
    return kept ? ll_client_pending(c, (uint32_t)seq) : NULL;
}

/* `state` tells that input `seq` was applied or never will be. */
void ll_client_close(ll_client *client, const ll_client_setup *setup, uint32_t seq, ll_input_state how,
                     const ll_snapshot_entry *state, ll_time now);

/* decode.c: the world of a state, in `size` bytes; `world` is of no use on an error */
ll_status ll_client_decode(ll_client *client, const ll_snapshot_message *message, const void *bytes, int size,
                           ll_world *world);

/* dilate_time.c: following the slack by the length of frames */
void ll_dilate_time_follow(ll_client *client, const ll_client_setup *setup,
                           const ll_snapshot_message *message, ll_time now);
void ll_dilate_time(ll_client *client); /* moves the next frame */

/* predict.c: what is in the prediction's scope */
void ll_predict_pending_inputs(ll_client *client, const ll_client_setup *setup); /* the inputs that are due */
void ll_resimulate(ll_client *client, const ll_client_setup *setup); /* the latest state, and what is open */
bool ll_prediction_stands(ll_client *client, const ll_client_setup *setup, const ll_snapshot_entry *state,
                          uint32_t acked);
void ll_reconcile(ll_client *client, const ll_client_setup *setup, bool stands, ll_time now);
void ll_draw_predicted(ll_client *client, ll_time now);
void ll_note_correction(const ll_client *client, const ll_client_setup *setup, ll_cause cause, double moved,
                        ll_time now); /* M6 of the own entity: moved by so many m, signed by x */

/* interpolate.c: the entities of others */
void ll_interpolate_heard(ll_client *client,
                          const ll_snapshot_entry *state); /* a state came: follow the server's clock */
void ll_interpolate_server_time(ll_client *client, const ll_client_setup *setup, ll_time now);
void ll_blend(ll_client *client, const ll_snapshot_entry *a, const ll_snapshot_entry *b,
              double alpha); /* linear */

/* extrapolate.c: `from` after `dt` seconds of its own */
void ll_extrapolate(const ll_client_setup *setup, const ll_entity *from, double dt, ll_entity *out);

/* netcode/view/smoothing.c: corrections of what is drawn */
#define LL_SMOOTH_MAX_M 4.0 /* a larger error is not smoothed: it is drawn as a jump at once */

/* What was drawn as `drawn` (errors aside) is `right`, at the same time. */
void ll_smooth_correct(ll_client *client, int entity, const ll_entity *drawn, const ll_entity *right);

/* Last of a frame: lets the errors decay and adds what is left to what is drawn. */
void ll_smooth_draw(ll_client *client, const ll_client_setup *setup, ll_time now);

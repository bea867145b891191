/* The parts of a client's state (ll_client in netcode/state/client.h), in the order in which they lie there.
 *
 * Each is plain data of a simulation's block: no pointers, no padding, a multiple of 8 bytes. */
#pragma once

#include "base/vtime.h"
#include "netcode/protocol/quantization.h"
#include "netcode/protocol/wire.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

#define LL_OFFSET_WINDOW 8 /* quarters of a second over which the fastest packet counts */

/* When the client makes inputs: its ticks. */
typedef struct ll_client_ticks {
    ll_clock clock; /* on a machine without drift */
    int64_t number; /* of the next tick */
    ll_time period;
    ll_time last, elapsed; /* when the last tick was, and the time from the tick before it */
    ll_time due;           /* the next tick */
    int64_t skipped;       /* ticks left out because the timer was late */
} ll_client_ticks;

/* When the client draws. */
typedef struct ll_client_displays {
    ll_clock clock;        /* freq 0: one display with each tick */
    int64_t number;        /* of the next display */
    ll_time due;           /* LL_NEVER: with the next tick */
    ll_time last, elapsed; /* when the last display was, and the time from the display before it */
} ll_client_displays;

/* The inputs that it makes, and how far ahead of the server it makes them. */
typedef struct ll_client_inputs {
    int64_t tick;        /* the server's step that the newest input is meant for */
    uint32_t seq, acked; /* newest made; all up to there are closed */
    uint32_t run; /* from this input on numbers and steps correspond: a snap of the clock leaves out some */
    uint32_t newest_sent; /* the newest that was sent */
    int32_t extra;        /* inputs to make beyond one per frame; negative: to skip */
    uint32_t settle;      /* slack is read again from this input on */
    int32_t least_slack;  /* smallest slack since `least_slack_since` */
    uint32_t unsent;      /* the first input that a lag switch holds back; 0: none */
    ll_time least_slack_since;
    ll_time least_slack_ns; /* the same with time dilation; LL_NEVER: none */
    ll_time correction;     /* of the clock, that remains, spread over frames: positive makes them earlier */
    double scale;           /* of the last frame: nominal length over actual length */
    ll_action held;         /* the player's controls */
    int64_t refused;
} ll_client_inputs;

/* The snapshots that it received. */
typedef struct ll_client_snapshots {
    int64_t received;        /* number: the newest is at received - 1 modulo the ring */
    int64_t used;            /* of these, the number that frames have applied */
    int64_t newest_tick;     /* -1: none in this epoch */
    int64_t confirmed;       /* the server's last known step */
    int64_t game_start_step; /* the server's step when the game began, or after the last resync */
    ll_time game_start;      /* time of that step */
    int64_t stale, unreadable;
    ll_quantization grid; /* of the snapshots from `grid_tick` on */
    int64_t grid_tick;    /* LL_NEVER: none yet */
} ll_client_snapshots;

/* What the latest snapshots say; the world of the one applied last is ll_client_latest. */
typedef struct ll_client_latest_snapshot {
    ll_time time; /* server's clock, of the snapshot applied last */
    int64_t tick; /* of the same */
    double update_hz;
    ll_action controls[LL_PEERS_MAX]; /* others' controls in the newest snapshot; zero until one contains
                                           them */
} ll_client_latest_snapshot;

/* Which inputs the server applied, by the newest snapshot that contains it. */
typedef struct ll_client_results {
    uint32_t applied[LL_INPUT_RESULT_WORDS_MAX]; /* a bit per input, the newest first */
    ll_input_result_part head;
    uint32_t parts, reserved; /* ll_part of the newest snapshot */
} ll_client_results;

/* Where its worlds lie, from the start of the client; and an ll_draw_info and an ll_view_error per entity of
 * the rendered one. */
typedef struct ll_client_layout {
    int64_t world_size;
    int64_t states, latest, predicted, checked, rendered, draw_infos, errors;
} ll_client_layout;

/* What the predicted world contains, and the snapshot that it started from. */
typedef struct ll_client_prediction {
    int64_t tick;                    /* of the predicted world */
    uint32_t played;                 /* newest input in it */
    uint32_t gaps;                   /* it lacks inputs after those of the snapshot that it started from */
    ll_entity_set entities;          /* of it that are stepped */
    ll_action guessed[LL_PEERS_MAX]; /* others' controls that it is stepped with */
    int64_t begun_tick;              /* of the last snapshot that it started from, or was bitwise equal to */
    ll_quantization begun_grid;      /* of the others in that snapshot; all 0: none */
    uint32_t begun_acked;            /* the newest input in that snapshot */
    uint32_t touched;                /* others may have acted on the own entity since */
} ll_client_prediction;

/* The render time of the others, and how they are drawn at it. */
typedef struct ll_client_view {
    ll_time offset; /* server's clock - client's clock when the fastest recent packet arrived */
    ll_time render; /* render time, server's clock; only increases */
    ll_time delay;  /* interpolation delay in use */
    double drift;   /* averaged distance from the target, ns (time_scale catch_up) */
    uint8_t has_render, extrapolated, held;
    uint8_t underrun;   /* under-run: nothing newer than what is drawn has arrived */
    uint8_t state;      /* ll_view_state */
    uint8_t has_errors; /* an error is not zero */
    uint8_t reserved[2];
} ll_client_view;

/* When snapshots arrive: their offsets from the client's clock, and the spread of their arrivals. */
typedef struct ll_client_arrivals {
    ll_time offsets[LL_OFFSET_WINDOW]; /* largest per quarter of a second */
    int64_t quarter;
    ll_time last;              /* when the newest snapshot arrived; -1 */
    double gap, gap_deviation; /* between arrivals, averages in ns; -1: none yet */
    double late;               /* relative to the fastest, average in ns */
} ll_client_arrivals;

/* The last display. */
typedef struct ll_client_drawing {
    ll_time view_time; /* render time of the others, server's clock */
    double alpha;      /* between the two interpolated snapshots */
    double buffer_ms;  /* time of the newest snapshot - render time */
    double time_scale; /* render time per time in the last frame */
    int64_t depth;     /* snapshots newer than what is drawn */
    int64_t received;  /* number of snapshots received when it was drawn */
} ll_client_drawing;

#pragma GCC diagnostic pop

/* How long a player waits for the effect of a change of its controls, on its own screen and on the others'.
 *
 * A change is an input whose controls (axes, buttons) differ from those of the previous input. Before the
 * first input, and where no input is made while no control is touched, controls are neutral. Three latencies
 * run from the instant at which the input was made, each to a display:
 * - felt: first display on the player's own screen that includes the input, predicted or confirmed;
 * - sure: first display on that screen from a snapshot, or a confirmed tick, that includes the input as the
 *   server applied it;
 * - seen: first display on each other screen that draws the player's entity at the tick that applied the
 *   input or a later one, its client having received that tick.
 *
 * A latency counts when the result of the input is known. An input that is never applied has no effect,
 * even if a prediction of it was drawn: its latency counts as infinite. An applied change that is not
 * displayed before LL_CHANGES_RING more are made counts as infinite too. `latency` points to LL_LATENCIES
 * histograms. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "game/core/game.h"
#include "netcode/metrics/input_history.h"

#define LL_CHANGES_RING 256
#define LL_CHANGE_VIEWERS 32   /* players, the first, whose displays are read */
#define LL_CHANGE_EPSILON 1e-6 /* an axis that moves by less is unchanged */

typedef enum ll_latency { LL_LATENCY_FELT, LL_LATENCY_SURE, LL_LATENCY_SEEN, LL_LATENCIES } ll_latency;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_change {
    ll_time made;
    ll_time at[2];   /* displays: felt, sure; LL_NEVER: not yet */
    int64_t tick;    /* the server's tick that applies it; LL_NEVER: not known yet */
    uint32_t seq;    /* UINT32_MAX: of an epoch that is over */
    uint32_t seen;   /* bit p: by player p */
    uint8_t decided; /* 0, or its ll_input_result_kind */
    uint8_t counted; /* bit: ll_latency */
    uint8_t reserved[6];
} ll_change;

typedef struct ll_changes {
    int64_t made;  /* number made; the newest is at made - 1 modulo the ring */
    int64_t first; /* first change that still waits for something */
    float axis[2]; /* of the input made last */
    uint32_t buttons;
    uint32_t others;            /* bit p: player p, one of the first 32, has another screen */
    int64_t lost[LL_LATENCIES]; /* of the infinite ones: inputs that were never applied */
    ll_change ring[LL_CHANGES_RING];
} ll_changes;

#pragma GCC diagnostic pop

/* The player's own inputs that a display includes: up to `seq`, of steps up to `tick`; confirmed up to
 * `sure_tick`. */
typedef struct ll_included {
    uint32_t seq, reserved;
    int64_t tick, sure_tick;
} ll_included;

/* An input was made with these controls. */
typedef struct ll_made_input {
    const ll_action *controls;
    uint32_t seq;
    bool counts;     /* in the latencies */
    int64_t tick;    /* LL_NEVER where inputs are applied on arrival */
    ll_time touched; /* when the controls were moved */
} ll_made_input;

void ll_changes_made(ll_changes *changes, ll_histogram *latency, const ll_made_input *input);

/* The controls changed, and no input is made since the player is not connected: a change has no effect. */
void ll_changes_missed(ll_changes *changes, ll_histogram *latency, const ll_action *controls, bool counts);

void ll_changes_idle(ll_changes *changes); /* no control is touched, and no input made */

/* Results of inputs have become known. */
void ll_changes_decide(ll_changes *changes, ll_histogram *latency, ll_input_history *input_history);

/* A new epoch, after all results of the old one: sequence numbers and controls start again. */
void ll_changes_resync(ll_changes *changes);

/* A display of the player's own screen, or of that of player `other`, whose client has all steps up to
 * `tick`. */
void ll_changes_shown(ll_changes *changes, ll_histogram *latency, const ll_included *included, ll_time now);
void ll_changes_seen(ll_changes *changes, ll_histogram *latency, ll_input_history *input_history, int other,
                     int64_t tick, ll_time now);

static inline bool ll_changes_waiting(const ll_changes *changes)
{
    return changes->first < changes->made;
}

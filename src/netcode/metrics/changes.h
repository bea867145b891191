/* How long a player waits for the effect of a change of its controls, on its own screen and on the others'.
 *
 * A change is an input whose controls (axes, buttons) differ from those of the input made before it; before
 * the first, and where no input is made while no control is touched, they are neutral. Three latencies count
 * from the instant at which it was made, each to a display: felt   the first of the player's own screen whose
 * picture includes it, predicted or confirmed sure   the first of that screen by a state, or a confirmed
 * tick, that includes it as the server applied it seen   the first of each other screen whose picture of the
 * player's entity is of the tick that applied it or of a later one, its client having heard of that tick They
 * count when the input's verdict is known. One that is never applied has no effect, whatever was drawn: it
 * counts as infinite. An applied change that is still waited for when LL_CHANGES_RING more are made is given
 * up as infinite. `latency` is of LL_LATENCIES histograms. */
#pragma once

#include <stdint.h>

#include "base/histogram.h"
#include "base/vtime.h"
#include "game/core/game.h"
#include "netcode/metrics/input_history.h"

#define LL_CHANGES_RING 256
#define LL_CHANGE_EPSILON 1e-6 /* an axis that moved by less stood still */

typedef enum ll_latency { LL_LATENCY_FELT, LL_LATENCY_SURE, LL_LATENCY_SEEN, LL_LATENCIES } ll_latency;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_change {
    ll_time made;
    ll_time at[2];   /* displays: felt, sure; LL_NEVER: not yet */
    int64_t tick;    /* of the server: applies it; LL_NEVER: not known yet */
    uint32_t seq;    /* UINT32_MAX: of an epoch that is over */
    uint32_t seen;   /* bit p: by player p */
    uint8_t decided; /* 0, or its ll_input_result_kind */
    uint8_t counted; /* bit: ll_latency */
    uint8_t reserved[6];
} ll_change;

typedef struct ll_changes {
    int64_t made;  /* so many; the newest lies at made - 1 modulo the ring */
    int64_t first; /* those before it wait for nothing */
    float axis[2]; /* of the input made last */
    uint32_t buttons;
    uint32_t others;            /* bit p: player p has another screen */
    int64_t lost[LL_LATENCIES]; /* of the infinite ones, those that were never applied */
    ll_change ring[LL_CHANGES_RING];
} ll_changes;

#pragma GCC diagnostic pop

/* What a display has of a player's own inputs: those up to `seq`, and of steps up to `tick`; and surely of
 * those up to `sure_tick`. */
typedef struct ll_included {
    uint32_t seq, reserved;
    int64_t tick, sure_tick;
} ll_included;

/* An input was made with these controls. `tick`: LL_NEVER where it is applied as it comes. */
void ll_changes_made(ll_changes *changes, ll_histogram *latency, const ll_action *controls, uint32_t seq,
                     int64_t tick, bool counts, ll_time now);

/* The controls are such, and no input is made, since the player is not connected: a change has no effect. */
void ll_changes_missed(ll_changes *changes, ll_histogram *latency, const ll_action *controls, bool counts);

void ll_changes_idle(ll_changes *changes); /* no control is touched, and no input made */

/* Verdicts have been given. */
void ll_changes_decide(ll_changes *changes, ll_histogram *latency, ll_input_history *input_history);

/* A new epoch, after all verdicts of the old one: numbers and controls begin anew. */
void ll_changes_meet(ll_changes *changes);

/* A display of the player's own screen, or of that of player `other` with all steps up to `tick`. */
void ll_changes_shown(ll_changes *changes, ll_histogram *latency, const ll_included *included, ll_time now);
void ll_changes_seen(ll_changes *changes, ll_histogram *latency, ll_input_history *input_history, int other,
                     int64_t tick, ll_time now);

static inline bool ll_changes_waiting(const ll_changes *changes)
{
    return changes->first < changes->made;
}

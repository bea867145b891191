/* Cheat gain against the honest reference: how much farther a cheating player's entity came on the server
 * than with a client that follows the rules.
 *
 * The reference is kept by the observer: a second entity that starts where the cheat begins. The game's own
 * step moves it with the controls that the same player's client had before it altered them: one input for
 * each of the server's steps. Where inputs are applied on arrival, one for each of the client's frames,
 * delayed by the link's delay without jitter. None of the reference's inputs is lost, late or refused, and no
 * other entity touches it. */
#pragma once

#include "game/core/game.h"

#define LL_HONEST_RING 256 /* inputs; more than a client is ahead */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_honest_input {
    ll_time due;
    float axis[2];
} ll_honest_input;

typedef struct ll_honest_reference {
    ll_honest_input
        inputs[LL_HONEST_RING]; /* by number: the server's step that it is for, or a running number */
    int64_t newest, taken;      /* numbers */
    float axis[2];              /* honest controls of the client's newest frame */
    ll_entity entity;           /* the reference */
    double x, y;                /* m, of the player's entity at the last step */
    double ahead;               /* m, distance of the player's entity minus that of the reference */
    double most;                /* m, largest so far */
} ll_honest_reference;

#pragma GCC diagnostic pop

/* All clients resync: the next input is for step `tick` + 1. */
void ll_honest_resync(ll_honest_reference *honest, int64_t tick);

/* The client's controls in this frame, before it alters them; the code that makes them reports them. */
static inline void ll_honest_controls(ll_honest_reference *honest, const ll_action *action)
{
    honest->axis[0] = action->axis[0];
    honest->axis[1] = action->axis[1];
}

/* After a frame: an honest client's newest input is for `tick`. Each new input is due at `due`. */
void ll_honest_frame(ll_honest_reference *honest, int64_t tick, ll_time due);

/* The same for a client that makes more than one input per frame, or holds inputs back: one counts. */
void ll_honest_frame_once(ll_honest_reference *honest, int64_t tick, ll_time due);

/* The entity of a player that does not cheat, or before the first step: the reference is there too, at
 * `now`. */
void ll_honest_watch(ll_honest_reference *honest, const ll_entity *entity, ll_time now);

/* A step that the server has made. */
typedef struct ll_honest_stepped {
    const ll_world *world;
    int64_t step;
    ll_time now;
    bool drains; /* inputs are applied on arrival */
} ll_honest_stepped;

/* After a step, for `player`, who cheats. */
void ll_honest_step(ll_honest_reference *honest, const ll_game *game, const ll_game_env *env, int player,
                    const ll_honest_stepped *stepped);

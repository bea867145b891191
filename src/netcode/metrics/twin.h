/* M15 against the honest twin: how much farther a cheat's entity came on the server than it would have come
 * had its client played by the rules.
 *
 * The twin is the observer's: a second entity that starts where the cheat begins, and is stepped by the
 * game's own step with the controls that the same player's client had before it tampered with them, one input
 * for each of the server's steps (or, where inputs count as they come, one for each of the client's frames,
 * as long after it as the link takes without jitter). None of the twin's inputs is lost, late or refused, and
 * nobody touches it. */
#pragma once

#include "game/core/game.h"

#define LL_TWIN_RING 256 /* inputs; more than a client is ahead */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_twin_input {
    ll_time due;
    float axis[2];
} ll_twin_input;

typedef struct ll_twin {
    ll_twin_input inputs[LL_TWIN_RING]; /* by number: the server's step that it is for, or just the next */
    int64_t newest, taken;              /* numbers */
    float axis[2];                      /* the honest controls of the client's newest frame */
    ll_entity entity;                   /* the twin */
    double x, y;                        /* m, of the player's at the last step */
    double ahead;                       /* m, that the player has covered and the twin has not */
    double most;                        /* m, of that, at any time so far */
} ll_twin;

#pragma GCC diagnostic pop

/* Everybody meets: the next input is for step `tick` + 1. */
void ll_twin_meet(ll_twin *twin, int64_t tick);

/* The client's controls in this frame, before it tampers with them: whoever makes them tells. */
static inline void ll_twin_controls(ll_twin *twin, const ll_action *action)
{
    twin->axis[0] = action->axis[0];
    twin->axis[1] = action->axis[1];
}

/* After a frame: an honest client's newest input is for `tick`. Each that is new is due at `due`. */
void ll_twin_frame(ll_twin *twin, int64_t tick, ll_time due);

/* The same of a client that makes more inputs than one a frame, or holds them back: one counts. */
void ll_twin_frame_once(ll_twin *twin, int64_t tick, ll_time due);

/* The entity of a player that does not cheat, or before the first step: the twin is there too, at `now`. */
void ll_twin_watch(ll_twin *twin, const ll_entity *entity, ll_time now);

/* The server has made `step` at `now`, and `player` cheats. `applies_on_arrival`: inputs count as they come.
 */
void ll_twin_step(ll_twin *twin, const ll_game *game, const ll_game_env *env, const ll_world *world,
                  int player, bool drains, int64_t step, ll_time now);

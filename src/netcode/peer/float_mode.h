/* The floating-point arithmetic of a player's machine: the same step on other hardware gives other bits.
 *
 * Deterministic lockstep depends on equal bits on every machine (paper, "Deterministic Lockstep"). A row of
 * the table stands for a machine that breaks this, and how. */
#pragma once

#include "game/core/game.h"

struct ll_client_setup;

typedef struct ll_float_mode {
    bool fused; /* multiply-adds of the games' integrators are rounded once */

    /* Changes a world after a step as the machine would; NULL: no change. A function of its arguments alone,
     * so that a resimulated step gives the same result. */
    void (*after)(ll_world *world, int player, int64_t tick);
} ll_float_mode;

extern const ll_float_mode ll_float_modes[];
extern const char *const ll_float_mode_names[]; /* NULL-terminated; the index is the choice `float_mode` */

/* Makes step `tick`, of virtual time `now`, on the machine of `player`. */
void ll_float_mode_step(const struct ll_client_setup *setup, int player, ll_world *world,
                        const ll_action *actions, int64_t tick, ll_time now);

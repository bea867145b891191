/* Random choices of scripts. Each is a hash of (session's seed, player, purpose, counter) only, so a script
 * is a pure function of the seed, the time and what its client draws: it may be evaluated at any time, in any
 * order, at the same cost. docs/concepts.md lists the choices of each script.
 *
 * A player's time is divided into slots of random length: boundaries at multiples of `mean`, with a random
 * phase, are each moved by up to `spread`. So a slot is between mean - spread and mean + spread long, and
 * finding the one of a time needs at most two draws. */
#pragma once

#include "base/rng.h"
#include "game/core/game.h"

#define LL_SCRIPT_STREAM UINT64_C(0x7363726970740000) /* `script`; 16 purposes per player */

/* Purposes of slots; choices within a slot use purposes of the game, from LL_SCRIPT_OWN on. */
enum { LL_SCRIPT_SLOTS, LL_SCRIPT_AIM_SLOTS, LL_SCRIPT_WEAPON_SLOTS, LL_SCRIPT_OWN };

typedef struct ll_slot {
    int64_t number; /* from 0 on */
    ll_time since;  /* time since the slot began; slot 0 may begin before time 0 */
} ll_slot;

static inline uint64_t ll_script_draw(uint64_t seed, int player, int purpose, int64_t counter)
{
    return ll_rng_u64(seed, LL_SCRIPT_STREAM + (uint64_t)(player * 16 + purpose), (uint64_t)counter);
}

/* Uniform in [0, 1). */
static inline double ll_script_unit(uint64_t seed, int player, int purpose, int64_t counter)
{
    return ll_rng_unit(seed, LL_SCRIPT_STREAM + (uint64_t)(player * 16 + purpose), (uint64_t)counter);
}

/* Uniform in [0, below) ns. */
static inline ll_time ll_script_time(uint64_t seed, int player, int purpose, int64_t counter, ll_time below)
{
    return (ll_time)(ll_script_draw(seed, player, purpose, counter) % (uint64_t)below);
}

/* The slot of `player` at t >= 0. 0 < spread <= mean. */
static inline ll_slot ll_script_slot(uint64_t seed, int player, int purpose, ll_time t, ll_time mean,
                                     ll_time spread)
{
    ll_time at = t + ll_script_time(seed, player, purpose, 0, mean);
    int64_t k = at / mean;
    ll_time begin = k > 0 ? k * mean + ll_script_time(seed, player, purpose, k, spread) : 0;
    if (begin > at) {
        k--;
        begin = k > 0 ? k * mean + ll_script_time(seed, player, purpose, k, spread) : 0;
    }
    return (ll_slot){k, at - begin};
}

/* When the slot of that time ends and the next begins. */
static inline ll_time ll_script_slot_end(uint64_t seed, int player, int purpose, ll_time t, ll_time mean,
                                         ll_time spread)
{
    int64_t next = ll_script_slot(seed, player, purpose, t, mean, spread).number + 1;
    return next * mean + ll_script_time(seed, player, purpose, next, spread) -
           ll_script_time(seed, player, purpose, 0, mean);
}

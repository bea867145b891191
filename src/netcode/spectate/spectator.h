/* A spectator of deterministic lockstep or rollback: it steps the whole world by settled inputs alone, so
 * that nothing that it shows is changed later (GGRS, SpectatorSession).
 *
 * It makes a tick of the game at each tick of its machine, and two while it has inputs for more than
 * `behind_ticks`. With inputs for more than `buffer_ticks`, or when the sender no longer has the next ones,
 * it has fallen out: it shows the same tick until it has a whole world, which it asks for.
 *
 * Cost per tick: one step of the whole world. Part of a simulation's block: no pointers. */
#pragma once

#include "netcode/protocol/config.h"
#include "netcode/protocol/spectate.h"

#define LL_SPECTATOR_RING 64 /* ticks of inputs */
#define LL_SPECTATOR_ASKS 15 /* ticks of its machine between two requests for a world */

_Static_assert(LL_SPECTATOR_BUFFER_MAX <= LL_SPECTATOR_RING, "the ring holds the buffer");

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_spectator {
    ll_clock ticks;    /* time of a tick of the game, as players pass it to steps */
    int64_t tick;      /* that it shows */
    int64_t known;     /* it has the inputs up to this tick */
    int64_t number;    /* of the last tick of its machine */
    int64_t asked;     /* the one at which it last asked; -1: it has not since it fell out */
    int64_t falls;     /* times that it fell out, and number of its last request */
    int64_t worlds;    /* whole ones that it took */
    int64_t made;      /* ticks of the game */
    int64_t catch_up;  /* of these, second ones at a tick of its machine */
    int64_t waits;     /* ticks of its machine without an input for the next tick */
    int64_t out_ticks; /* ticks of its machine that it was out */
    int32_t players;
    uint16_t epoch;
    uint8_t out;          /* it has fallen out */
    uint8_t heard;        /* a packet has come since it last sent one */
    ll_controls inputs[]; /* of a tick and all players, LL_SPECTATOR_RING times; then the world */
} ll_spectator;

#pragma GCC diagnostic pop

size_t ll_spectator_size(int players, size_t world_size); /* a multiple of 8 */

static inline ll_world *ll_spectator_world(const ll_spectator *s)
{
    return (ll_world *)((char *)s + ll_spectator_size(s->players, 0));
}

/* The game begins, in this epoch, with this world after `step`. `ticks`: time of a tick. */
void ll_spectator_start(ll_spectator *spectator, const ll_world *world, uint16_t epoch, int64_t step,
                        ll_clock ticks);

void ll_spectator_receive(ll_spectator *spectator, const ll_spectator_params *params, const void *packet);

/* A tick of its machine; returns how many of the game it made. */
int ll_spectator_tick(ll_spectator *spectator, const ll_spectator_params *params, const ll_game *game,
                      const ll_game_env *env);

/* Writes what is to be sent after it, if anything: false otherwise. */
bool ll_spectator_compose(ll_spectator *spectator, ll_watch_message *message);

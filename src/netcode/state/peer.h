/* A client of the peer-to-peer syncs: it has everybody's inputs by tick, and steps a world of its own by
 * them.
 *
 * Deterministic lockstep makes a tick when all its inputs are there, and waits otherwise. Rollback guesses
 * that a player does what it did last, steps on up to `max_rollback_ticks` beyond what is certain, and when
 * an input is other than guessed goes back and makes the ticks again (GGPO, GGRS). The first is the second
 * with none to go back. What is certain, the confirmed tick, is hashed: the referee compares.
 *
 * Cost per frame: one step of the whole world, a copy of it, and those steps that are made again. */
#pragma once

#include "netcode/state/client.h"

#define LL_PEER_RING 64 /* ticks of inputs, worlds and hashes that a client keeps */

/* How far a client may be beyond the server's step, at most: its own inputs that are still on their way to
 * the server are certain to itself alone. */
_Static_assert(2 * LL_ROLLBACK_MAX + LL_INPUT_DELAY_MAX + LL_SYNC_TEST_MAX < LL_PEER_RING,
               "the ring holds them");

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

/* What a client knows of a player. */
typedef struct ll_peer_player {
    int64_t known; /* its inputs up to this tick have come (one's own: are made); those behind are guesses */
    int32_t at;    /* its tick when last heard of; -1: not heard of */
    int32_t heard; /* so often, at most as often as counts */
    double ahead;  /* how many ticks we are ahead of it, by what we hear of it; mean */
    double behind; /* how many ticks it is ahead of us, by what it hears of us; mean */
    ll_controls inputs[LL_PEER_RING];
} ll_peer_player;

typedef struct ll_peer {
    ll_clock ticks; /* when a tick would be if nobody ever waited: the time that steps and scripts are told */
    int64_t start;  /* tick of the world that it began with */
    int64_t first;  /* its own inputs are for the ticks behind this one; those before are neutral */
    int64_t tick;   /* that the newest world is of */
    int64_t confirmed; /* up to here everybody's inputs are known */
    int64_t wrong;     /* the first tick that a wrong guess went into; LL_NEVER: none */
    int64_t hashed;    /* the referee has the hashes up to this tick */
    ll_time stalled_since;
    ll_time relayed; /* when the last relay came; 0: none has */
    int64_t hold;    /* makes no inputs for ticks beyond this one (netcode/server/hold.h); 0: no hold */
    int64_t resume;  /* until so many ticks have passed since the game began; 0: that is not known yet */
    int64_t paced;   /* the frame before that from which on looks at the pace are counted */
    int64_t began;   /* the tick that it began with, or that the last hold was at */
    ll_time since;   /* when it went on from there; LL_NEVER: it has not yet */
    ll_time spread;  /* what ticks are apart up to `spread_until`; 0: that is not known yet */
    int64_t spread_until;
    ll_time stepped;  /* when the last tick was made */
    uint32_t waiting; /* bit p: cannot go on without the input of player p */
    int32_t rest;     /* frames to leave out so that the others come after */
    uint32_t gap;     /* relays had stopped for a while, and the server does not know it yet */
    uint32_t reserved;
    uint32_t hashes[LL_PEER_RING];
    ll_peer_player player[]; /* one per player; then LL_PEER_RING worlds */
} ll_peer;

#pragma GCC diagnostic pop

static inline size_t ll_peer_size(int players, size_t world_size)
{
    return sizeof(ll_peer) + (size_t)players * sizeof(ll_peer_player) + LL_PEER_RING * world_size;
}

void ll_peer_start(ll_client *client, const ll_client_setup *setup, int64_t step, int64_t first,
                   const ll_world *world);
int ll_peer_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int bytes,
                    ll_time now);
int ll_peer_tick(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);
void ll_peer_display(ll_client *client, const ll_client_setup *setup, ll_time now);

/* The peer lies where an authoritative client keeps its states. */
static inline ll_peer *ll_client_peer(const ll_client *c)
{
    return (ll_peer *)((char *)c + c->states_offset);
}

static inline ll_world *ll_peer_world(const ll_client *c, int64_t tick)
{
    const ll_peer *peer = ll_client_peer(c);
    return (ll_world *)((char *)&peer->player[ll_client_rendered_const(c)->players] +
                        (tick & (LL_PEER_RING - 1)) * c->world_size);
}

static inline ll_controls *ll_peer_input(ll_peer *peer, int player, int64_t tick)
{
    return &peer->player[player].inputs[tick & (LL_PEER_RING - 1)];
}

/* ---- between the peer's files ---- */

/* step.c */
void ll_peer_step(ll_client *client, const ll_client_setup *setup); /* on to the next tick */
void ll_peer_roll_back(ll_client *client, const ll_client_setup *setup,
                       ll_time now); /* if a guess was wrong */
void ll_peer_confirm(ll_client *client);
void ll_peer_sync_test(ll_client *client, const ll_client_setup *setup, ll_time now);

/* Deterministic and rollback: a barrier, which restores the timing of a game that the network has disturbed.
 *
 * Clients that wait for each other keep the distances in time between their ticks. After an outage, or when a
 * player joins again, the ticks stay bunched differently than at the start. A gap is a pause of a client's
 * packets, or of the relays to it, of LL_BARRIER_GAP beyond their interval (two relays, where they are
 * rarer). When packets arrive again after a gap, the server sends all clients a tick, `barrier`, beyond which
 * they make no inputs; no client can have passed it. When the server has all inputs up to that tick, the next
 * relays bring them to all clients, with the time to continue. That instant has the same phase to ticks and
 * updates as the start of the game, and all clients will have made the barrier's tick by then. So nothing is
 * in flight, as before the first tick. No input is lost. A client that learns of a barrier too late moves it
 * to a later tick. */
#pragma once

#include "netcode/protocol/limits.h"
#include "netcode/server/server.h"

/* A packet of `player` has been processed. */
void ll_barrier_follow(ll_server *server, const ll_sync_mode *sync, int player,
                       const ll_peer_message *message, ll_time now);

/* `player` has been accepted into a game in progress. */
void ll_barrier_join(ll_server *server, const ll_sync_mode *sync, int player, ll_time now);

/* Whether a player whose newest input is for `tick` still waits. */
static inline bool ll_barrier_waits(const ll_server *server, int64_t tick)
{
    return server->barriers.resume != 0 && tick <= server->barriers.tick;
}

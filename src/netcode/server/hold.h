/* Deterministic and rollback: a hold, after which a game that the network has disturbed goes on as it began.
 *
 * Clients that wait for each other keep the distances in time that their ticks have: an outage, or a player
 * who joins again, leaves their ticks bunched in another way than at the start, for good. So when a client's
 * packets, or the relays to it, come again that had stopped for LL_HOLD_GAP beyond their own rhythm (two
 * relays, where they are rarer), the server tells everybody to make no inputs beyond tick `hold`, one that
 * nobody can have passed. When it has everybody's inputs up to there, the next relays bring them to all, and
 * when to go on: at an instant that lies to ticks and updates as the beginning of the game does, and by which
 * all will have made that tick. Then nothing is in flight, as before the first tick. No input is lost. Who
 * hears of a hold too late raises it. */
#pragma once

#include "netcode/protocol/limits.h"
#include "netcode/server/server.h"

/* A packet of `player` has been taken. */
void ll_hold_follow(ll_server *server, const ll_sync_mode *sync, int player, const ll_peer_message *message,
                    ll_time now);

/* `player` has been let into a game that is under way. */
void ll_hold_join(ll_server *server, const ll_sync_mode *sync, int player, ll_time now);

/* Whether a player whose newest input is for `tick` is yet to go on. */
static inline bool ll_hold_waits(const ll_server *server, int64_t tick)
{
    return server->resume != 0 && tick <= server->hold;
}

/* What the sender of a spectator keeps for it: the inputs of all players by tick, as long as the spectator
 * has not acknowledged them.
 *
 * Only settled inputs are sent, which no one will change. Those that a client has for a confirmed tick are
 * not all settled: when it loses its connection, the server makes inputs in place of its own that have not
 * arrived. So its own inputs are settled when the server has acknowledged them. Those of others have passed
 * the server before, over a mesh too. Of the server all inputs of its steps are.
 *
 * Part of a simulation's block: no pointers. */
#pragma once

#include "netcode/protocol/spectate.h"
#include "netcode/server/server.h"
#include "netcode/state/peer.h"

#define LL_FEED_RING 128 /* ticks (GGPO: as many outputs wait for acknowledgement) */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_feed {
    int64_t begun;     /* inputs for ticks after this one have come since the sender joined */
    int64_t newest;    /* those up to this tick */
    int64_t settled;   /* up to this tick they are */
    int64_t acked;     /* the spectator has them up to this tick */
    int64_t joins;     /* of the sending client, when `begun` was */
    uint32_t request;  /* for a world, to be answered; 0: none */
    uint32_t answered; /* the last one that was answered */
    int32_t players;
    uint32_t epoch;
    ll_controls inputs[]; /* of a tick and all players, LL_FEED_RING times */
} ll_feed;

#pragma GCC diagnostic pop

size_t ll_feed_size(int players); /* a multiple of 8 */

/* The game begins, in this epoch, with the world after `step`, which the spectator has. */
void ll_feed_start(ll_feed *feed, int players, uint16_t epoch, int64_t step);

/* After a tick of the sending client, or steps of the sending server: takes their inputs. */
void ll_feed_follow_client(ll_feed *feed, const ll_client *client);
void ll_feed_follow_server(ll_feed *feed, const ll_server *server);

/* The client's world after the newest settled tick; NULL: it no longer has that. */
const ll_world *ll_feed_client_world(const ll_feed *feed, const ll_client *client);

void ll_feed_receive(ll_feed *feed, const ll_watch_message *message);

/* Writes what is to be sent now and returns its size; 0: nothing is. A request is answered with `world`, that
 * after the newest settled tick; where it is NULL the request waits. */
int ll_feed_compose(ll_feed *feed, const ll_world *world, void *packet);

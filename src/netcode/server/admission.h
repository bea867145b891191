/* The server's side of a connection: who is let in, who is kept, who is dropped.
 *
 * A player's seat is there from the start; its player is connected or not. A request tells the newest answer
 * that its client has, so that the server knows that both ways are alive: nobody is let in, and so waited
 * for, who cannot hear it, and who tells of no newer answer for `timeout_s` is dropped. The game then goes on
 * with neutral inputs for that player. Who is let in starts a new epoch. Every request is answered at once.
 */
#pragma once

#include "netcode/server/server.h"

#define LL_FRESH                                                                                             \
    (3 * LL_SECOND) /* an answer is so young when the request that tells of it comes: the longest round      \
                       trip, and a retry */

/* What became of a packet of a player's. */
typedef struct ll_admitted {
    bool game;   /* of the game, in the present epoch: the way of keeping in step takes it */
    bool joined; /* the player is connected from now on */
    int reply;   /* bytes that are written to be sent back; 0: none */
} ll_admitted;

/* Takes any packet. `world` is sent along to whom is let in. */
ll_admitted ll_admission_receive(ll_server *server, bool with_world, int player, const void *packet,
                                 ll_time now, void *reply);

/* Every LL_TEND_EVERY: drops `player` when it has told of no newer answer for `timeout`; LL_NEVER keeps
 * everybody. True when it was dropped now. */
bool ll_admission_tend(ll_server *server, int player, ll_time timeout, ll_time now);

/* Writes a keep-alive for a player to whom nothing was sent for a while; 0 when none is needed. */
int ll_admission_keep_alive(ll_server *server, int player, ll_time now, void *packet);

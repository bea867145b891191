/* The server's side of a connection: accepts, keeps and drops players.
 *
 * A player's client slot exists from the start; the player is connected or not. A request acknowledges the
 * newest answer that its client has received, so the server knows that both directions work. A client that
 * cannot receive is not accepted, so no player waits for it. A client that acknowledges no newer answer for
 * `timeout_s` is dropped. The game then continues with neutral inputs for that player. An accepted player
 * starts a new epoch. Every request is answered at once. */
#pragma once

#include "netcode/server/server.h"

/* maximum age of an acknowledged answer: the longest round trip, and a retry */
#define LL_FRESH (3 * LL_SECOND)

/* Result of a packet of a player. */
typedef struct ll_admitted {
    bool game;   /* of the game, in the present epoch: the sync mode processes it */
    bool joined; /* the player is connected from now on */
    int reply;   /* bytes written as an answer; 0: none */
} ll_admitted;

/* Whether a packet is of the game, in the present epoch. */
bool ll_admission_is_of_game(const ll_server *server, int player, const void *packet);

/* Processes any packet. `with_world`: the answer to an accepted player contains the world. */
ll_admitted ll_admission_receive(ll_server *server, bool with_world, int player, const void *packet,
                                 ll_time now, void *reply);

/* Every LL_CONNECTION_CHECK_INTERVAL: drops `player` if it has acknowledged no newer answer for `timeout`;
 * LL_NEVER keeps all players. True if it was dropped now. */
bool ll_admission_check(ll_server *server, int player, ll_time timeout, ll_time now);

/* Writes a keep-alive for a player to whom nothing was sent for some time; 0: none needed. */
int ll_admission_keep_alive(ll_server *server, int player, ll_time now, void *packet);

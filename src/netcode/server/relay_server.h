/* The server of the peer-to-peer syncs: it forwards everybody's inputs to the others, and steps a world of
 * its own by them as soon as it has all of a tick. That world is the truth that clients' hashes are compared
 * with. */
#pragma once

#include "netcode/server/server.h"

ll_time ll_relay_server_due(const ll_server *server);
void ll_relay_server_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                          ll_time now);
int ll_relay_server_take(ll_server *server, const ll_sync_mode *sync, int player, const void *packet,
                         ll_time now, ll_input_result verdicts[LL_INPUTS_MAX]);
int ll_relay_server_compose(ll_server *server, const ll_sync_mode *sync, int player, void *packet);

/* Neutral inputs for who is not connected, as far as those of the others reach. */
void ll_relay_server_fill(ll_server *server, ll_time now);

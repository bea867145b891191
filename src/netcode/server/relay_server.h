/* The relay server of the peer-to-peer syncs. It forwards each player's inputs to the others, and steps a
 * world of its own as soon as it has all inputs of a tick. That world is the truth that clients' hashes are
 * compared with.
 *
 * Over a mesh it forwards nothing of its own: it sees the packets that pass from player to player, steps the
 * same world, admits players, makes the inputs of those who have left, and sets barriers. */
#pragma once

#include "netcode/server/server.h"

ll_time ll_relay_server_due(const ll_server *server);
void ll_relay_server_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                          ll_time now);
int ll_relay_server_take(ll_server *server, const ll_sync_mode *sync, int player, const void *packet,
                         ll_time now, ll_input_result results[LL_INPUTS_MAX]);
int ll_relay_server_compose(ll_server *server, const ll_sync_mode *sync, int player,
                            struct ll_snapshot_common *common, void *packet);

/* Makes neutral inputs for players who are not connected, as far as the inputs of the others reach. */
void ll_relay_server_fill(ll_server *server, ll_time now);

/* Shared by the sync modes in which the server steps on its own clock and does not wait. It applies at
 * step k the inputs meant for k; the parameter `starved` selects the replacement of a missing one. */
#pragma once

#include "netcode/server/server.h"

ll_time ll_by_clock_due(const ll_server *server);
void ll_by_clock_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                      ll_time now);

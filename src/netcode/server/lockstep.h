/* Shared by the two lockstep modes: the server makes step k one interval after the last connected player's
 * input for k has arrived, and sends the snapshot (paper, Figure 10). */
#pragma once

#include "netcode/server/server.h"

/* rate of steps that were delayed by a late input, relative to the normal rate */
#define LL_LOCKSTEP_CATCH_UP 4

ll_time ll_lockstep_due(const ll_server *server);
void ll_lockstep_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                      ll_time now);

/* The same where inputs are in flight: for a time after an outage, steps are made when the inputs of the
 * farthest player arrive, as at the start. */
ll_time ll_lockstep_due_in_rhythm(const ll_server *server);
void ll_lockstep_step_in_rhythm(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                                ll_time now);

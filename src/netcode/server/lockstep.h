/* What the two kinds of lockstep share: a server that makes step k one interval after the last connected
 * player's input for k has come, and sends the state (paper, Figure 10). */
#pragma once

#include "netcode/server/server.h"

/* Steps that waited for an input that then came late are made up for, this many times as fast. */
#define LL_LOCKSTEP_CATCH_UP 4

ll_time ll_lockstep_due(const ll_server *server);
void ll_lockstep_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                      ll_time now);

/* The same where inputs are in flight: for a while after an outage steps are made where the inputs of the
 * player who is farthest have them, as at the start. */
ll_time ll_lockstep_due_in_rhythm(const ll_server *server);
void ll_lockstep_step_in_rhythm(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                                ll_time now);

/* Clients that break the rules on inputs, to test the server's validation. Cheats with weapons are in
 * weapon_prediction.h. */
#pragma once

#include <stdbool.h>

#include "base/vtime.h"
#include "game/core/game.h"
#include "netcode/protocol/config.h"

struct ll_client;
struct ll_client_setup;

/* Changes the action of a frame as the cheat does; no cheat: no change. */
void ll_cheat_action(const struct ll_client *client, const struct ll_client_setup *setup, ll_action *action);

/* Whether the cheat moves the own entity by itself, and how, after the client's own step to `tick`. */
static inline bool ll_cheat_moves(const ll_player_config *config)
{
    return config->cheat >= LL_CHEAT_SPEED;
}
void ll_cheat_move(const struct ll_client *client, const struct ll_client_setup *setup, ll_entity *own,
                   int64_t tick);

/* An aim bot aims and fires for the player, who acts on `seen` at time `t`. */
void ll_cheat_aim(const struct ll_client *client, const struct ll_client_setup *setup, const ll_world *seen,
                  ll_time t, ll_action *action);

/* Number of inputs that the cheat makes beyond one per frame. */
int ll_cheat_extra(const struct ll_client *client, const struct ll_client_setup *setup);

/* Whether the client adjusts its clock when the server reports that its inputs come too early or too late. */
bool ll_cheat_minds(const struct ll_client_setup *setup);

/* Whether the client holds its packets back at `now`. */
bool ll_cheat_holds(const struct ll_client_setup *setup, ll_time now);

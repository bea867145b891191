/* Clients that break the rules on inputs, to test the server's validation. Cheats with weapons are in
 * weapon_prediction.h. */
#pragma once

#include <stdbool.h>

#include "base/vtime.h"
#include "game/core/game.h"

struct ll_client;
struct ll_client_setup;

/* Changes the action of a frame as the cheat does; no cheat: no change. */
void ll_cheat_action(const struct ll_client *client, const struct ll_client_setup *setup, ll_action *action);

/* Number of inputs that the cheat makes beyond one per frame. */
int ll_cheat_extra(const struct ll_client *client, const struct ll_client_setup *setup);

/* Whether the client adjusts its clock when the server reports that its inputs come too early or too late. */
bool ll_cheat_minds(const struct ll_client_setup *setup);

/* Whether the client holds its packets back at `now`. */
bool ll_cheat_holds(const struct ll_client_setup *setup, ll_time now);

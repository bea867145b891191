/* Clients that do not play by the rules on inputs, to try the server's validation. Those with weapons are
 * weapon_prediction.h's. */
#pragma once

#include <stdbool.h>

#include "base/vtime.h"
#include "game/core/game.h"

struct ll_client;
struct ll_client_setup;

/* What each does to the action of a frame; none: nothing. */
void ll_cheat_action(const struct ll_client *client, const struct ll_client_setup *setup, ll_action *action);

/* How many inputs it makes beyond one a frame. */
int ll_cheat_extra(const struct ll_client *client, const struct ll_client_setup *setup);

/* Whether it minds being told that its inputs come too early or too late. */
bool ll_cheat_minds(const struct ll_client_setup *setup);

/* Whether it holds its packets back at `now`. */
bool ll_cheat_holds(const struct ll_client_setup *setup, ll_time now);

/* A person's hand on a simulation that is no game: player 0's axes point across the view, a button holds. */
#pragma once

#include "base/status.h"
#include "input/action.h"

/* Refuses other players and axes beyond [-1, 1]. `does`: `drags`, `stirs`. */
ll_status ll_pointer_drag_accepts(int player, const ll_action *action, const char *does);

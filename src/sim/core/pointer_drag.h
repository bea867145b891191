/* Pointer control of a simulation that is not a game: player 0's axes are a position in the view, a button
 * holds. */
#pragma once

#include "base/status.h"
#include "input/action.h"

/* Rejects other players and axes beyond [-1, 1]. `does` completes the message: `drags`, `stirs`. */
ll_status ll_pointer_drag_accepts(int player, const ll_action *action, const char *does);

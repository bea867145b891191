#include "sim/core/pointer_drag.h"

ll_status ll_pointer_drag_accepts(int player, const ll_action *action, const char *does)
{
    if (player != 0)
        return ll_field_error(LL_BAD_INPUT, "player", "player: must be 0, the one that %s; got %d", does,
                              player);
    for (int i = 0; i < 2; i++)
        if (!(action->axis[i] >= -1 && action->axis[i] <= 1))
            return ll_field_error(LL_BAD_INPUT, "axes", "axes: must be -1 to 1; got %g",
                                  (double)action->axis[i]);
    return ll_ok();
}

/* Independent losses, or a two-state chain (see ll_link_params): mean burst length 1 / ((1 - p) (1 - corr)).
 * One draw per packet. */
#include "link/stages/stage.h"

/* State 1: after a lost packet. */
static bool lost(const ll_passage *p, int32_t *state)
{
    const ll_link_params *params = p->params;
    *state =
        100 * ll_draw(p, LL_STREAM_LOSS) < ll_chain_percent(params->loss_pct, params->loss_corr_pct, *state);
    return *state;
}

const ll_loss_model ll_loss_random = {.name = "random", .lost = lost};

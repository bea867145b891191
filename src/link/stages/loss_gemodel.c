/* E. N. Gilbert, "Capacity of a burst-noise channel", Bell Syst. Tech. J. 39, 1960; E. O. Elliott, "Estimates
 * of error rates for codes on burst-noise channels", 42, 1963. In the long run p / (p + r) of the packets are
 * sent in the bad state, in runs of 1 / r. Two draws per packet. */
#include "link/stages/stage.h"

/* State 1: bad. */
static bool lost(const ll_passage *p, int32_t *state)
{
    const ll_link_params *params = p->params;
    bool bad = *state;
    double leave = bad ? params->ge_r_pct : params->ge_p_pct;
    if (100 * ll_draw(p, LL_STREAM_TRANSITION) < leave)
        *state = !bad;
    return 100 * ll_draw(p, LL_STREAM_LOSS) < (bad ? params->ge_1h_pct : params->ge_1k_pct);
}

const ll_loss_model ll_loss_gemodel = {.name = "gemodel", .lost = lost};

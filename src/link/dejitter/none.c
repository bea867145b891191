#include "link/dejitter/policy.h"

static ll_time delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet)
{
    (void)h, (void)params, (void)packet;
    return 0;
}

const ll_dejitter_policy ll_dejitter_none = {.name = "none", .delay = delay};

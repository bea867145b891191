/* Each packet is held for a fixed time after its arrival, as in the paper. Jitter remains. */
#include "link/dejitter/policy.h"

static ll_time delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet)
{
    (void)h, (void)packet;
    return ll_ms(params->delay_ms);
}

const ll_dejitter_policy ll_dejitter_arrival_plus = {.name = "arrival", .delay = delay};

/* Each packet is due the same time from its sending: that of the fastest packet's way, and delay_ms. With
 * transit times spread uniformly over w, 1 - delay / w of the packets are late, and delay^2 / 2w are added on
 * average. */
#include "link/dejitter/policy.h"

static ll_time delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet)
{
    (void)h, (void)packet;
    return ll_ms(params->delay_ms);
}

const ll_dejitter_policy ll_dejitter_send_time = {.name = "send_time", .by_sending = true, .delay = delay};

/* Each packet is due at a fixed time after sending: the transit time of the fastest packet plus delay_ms. If
 * transit times are uniform over a width w, 1 - delay / w of the packets are late, and delay^2 / 2w is added
 * on average. */
#include "link/dejitter/policy.h"

static ll_time delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet)
{
    (void)h, (void)packet;
    return ll_ms(params->delay_ms);
}

const ll_dejitter_policy ll_dejitter_send_time = {.name = "send_time", .by_sending = true, .delay = delay};

/* Hybrid: a young view is rewound whole, an old one less, and from hybrid_none_ms on not at all. So a shooter
 * with little lag hits what it saw, and one with much lag must lead instead of hitting players who hid long
 * ago. Between the two ages the share of the rewind falls linearly. Cost: that of rewind. */
#include "game/weapons/policies.h"

static int judge(const ll_field *field, const ll_shot *shot)
{
    return ll_hitscan_rewind.judge(field, shot);
}

static double share(const ll_policy_params *params, ll_time age)
{
    double ms = ll_to_ms(age), full = params->hybrid_full_ms, none = params->hybrid_none_ms;
    if (ms <= full)
        return 1;
    return ms >= none ? 0 : (none - ms) / (none - full);
}

const ll_hitscan_policy ll_hitscan_hybrid = {
    .name = "hybrid",
    .help = "As rewind for young views, less for older ones, none from hybrid_none_ms on.",
    .rewinds = true,
    .judge = judge,
    .share = share};

/* Mirror's snapshot interpolation (SnapshotInterpolation.cs): interval * (1 + deviation / interval + 1), with
 * the deviation of the times between arrivals over 2 s, and a tolerance of 1. Mirror counts from an average
 * packet, over 1 s; here time counts from the fastest one, so the average lateness relative to it is added.
 * Play-out runs 4 % slower or 2 % faster to adapt. */
#include "base/assert.h"
#include "base/detmath.h"
#include "link/dejitter/policy.h"

/* Weight of a value in an average over `seconds`. */
static double weight_of(double seconds, double interval_ms)
{
    LL_ASSERT(interval_ms > 0);
    return 2 / (seconds * 1000 / interval_ms + 1);
}

static ll_time delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet)
{
    double interval = params->interval_ms;
    if (h->packets == 0) {
        h->gap_ms = interval;
        h->spread_ms = 0;
        h->late_ms = 0;
        return ll_ms(2 * interval);
    }
    double weight = weight_of(2, interval), off = ll_to_ms(packet->arrived - h->arrived) - h->gap_ms;
    h->gap_ms += weight * off;
    h->spread_ms = (1 - weight) * (h->spread_ms + weight * off * off); /* a variance */
    ll_dejitter_average(&h->late_ms, packet->late_ms, weight_of(1, interval));
    return ll_dejitter_approach(h, packet, 2 * interval + ll_sqrt(h->spread_ms) + h->late_ms, 0.04, 0.02);
}

const ll_dejitter_policy ll_dejitter_mirror = {.name = "mirror", .by_sending = true, .delay = delay};

/* Unity's Netcode for Entities (NetworkTimeSystem.cs): the larger of the average time between arrivals and
 * the average gap between send times + 1.25 of its mean deviation, each with a weight of 0.25; at most six
 * intervals, at least the configured delay. The gaps show loss and reordering, not jitter. It counts from an
 * average packet, with a weight of 1/8; here time counts from the fastest one, so the average lateness
 * relative to it is added. The delay changes by at most a tenth of the time. */
#include "link/dejitter/policy.h"

#define WEIGHT 0.25

static double size_of(double x)
{
    return x < 0 ? -x : x;
}

static ll_time delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet)
{
    double interval = params->interval_ms, least = params->delay_ms;
    if (h->packets == 0) {
        h->gap_ms = h->arrivals_ms = interval;
        h->spread_ms = h->late_ms = 0;
        return ll_ms(interval > least ? interval : least);
    }
    double gap = ll_to_ms(packet->sent - h->sent);
    ll_dejitter_average(&h->gap_ms, gap, WEIGHT);
    ll_dejitter_average(&h->spread_ms, size_of(gap - h->gap_ms), WEIGHT);
    ll_dejitter_average(&h->arrivals_ms, ll_to_ms(packet->arrived - h->arrived), WEIGHT);
    ll_dejitter_average(&h->late_ms, packet->late_ms, 1.0 / 8);
    double want = h->gap_ms + 1.25 * h->spread_ms;
    want = want > h->arrivals_ms ? want : h->arrivals_ms;
    want = want < 6 * interval ? want : 6 * interval;
    want = (want > least ? want : least) + h->late_ms;
    return ll_dejitter_approach(h, packet, want, 0.1, 0.1);
}

const ll_dejitter_policy ll_dejitter_nfe = {.name = "nfe", .by_sending = true, .delay = delay};

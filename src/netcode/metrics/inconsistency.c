#include "netcode/metrics/inconsistency.h"

#include <stdbool.h>

void ll_inconsistency_lasts(ll_inconsistency *total, ll_divergence_episode *open, double distance,
                            ll_time elapsed)
{
    bool counts = open->time >= LL_DIVERGENCE_EPISODE;
    double part = distance * ll_to_s(elapsed);
    open->sum += part;
    open->time += elapsed;
    if (open->time < LL_DIVERGENCE_EPISODE)
        return;
    total->sum += counts ? part : open->sum;
    total->time += counts ? elapsed : open->time;
    total->episodes += !counts;
}

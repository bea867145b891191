#include "netcode/metrics/inconsistency.h"

#include <stdbool.h>

void ll_inconsistency_lasts(ll_inconsistency *total, ll_divergence_episode *open, double distance,
                            ll_time elapsed)
{
    double part = distance * ll_to_s(elapsed);
    bool counts = open->time >= LL_DIVERGENCE_EPISODE;
    open->sum += part;
    open->time += elapsed;
    if (counts) {
        total->sum += part;
        total->time += elapsed;
    } else if (open->time >= LL_DIVERGENCE_EPISODE) {
        total->sum += open->sum;
        total->time += open->time;
        total->episodes++;
    }
}

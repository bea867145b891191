/* A measured delay and loss: a row holds from its stamp to the next one's, the last as long as the one before
 * it; then the trace begins again. */
#include "link/stages/stage.h"

static ll_time period_of(const int64_t *times, int32_t count)
{
    return count < 2 ? 0 : times[count - 1] + (times[count - 1] - times[count - 2]);
}

/* The last row whose stamp is not after `now`. The first stamp is 0. */
static int32_t row_at(const int64_t *times, int32_t count, ll_time now)
{
    ll_time period = period_of(times, count), at = period > 0 ? now % period : 0;
    int32_t low = 0, high = count - 1;
    at += at < 0 ? period : 0;
    while (low < high) {
        int32_t middle = high - (high - low) / 2;
        if (times[middle] <= at)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

void ll_stage_trace(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_profile *profile = p->profile;
    int32_t row = row_at(ll_profile_trace_times(profile), profile->trace_count, p->now);
    p->delay_ms += ll_profile_trace_delays(profile)[row];
    if (p->fate != LL_FATE_DELIVERED || ll_profile_trace_losses(profile)[row] == 0)
        return;
    p->fate = LL_FATE_LOST;
    p->state->trace_lost++;
    ll_count_loss(p, m, stats);
}

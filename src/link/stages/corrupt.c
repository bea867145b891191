/* A corrupted packet takes its delay, and its time in the queue; the receiver drops it. */
#include "link/stages/stage.h"

void ll_stage_corrupt(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)stats;
    const ll_link_params *params = p->params;
    p->damaged =
        ll_chance(p, LL_STREAM_CORRUPT, params->corrupt_pct, params->corrupt_corr_pct, &m->corrupted);
}

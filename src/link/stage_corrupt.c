#include "link/stage.h"

void ll_stage_corrupt(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    bool happens =
        ll_chance(p, LL_STAGE_CORRUPT, params->corrupt_pct, params->corrupt_corr_pct, &m->corrupted);
    if (!happens || p->fate != LL_FATE_DELIVERED)
        return;
    p->fate = LL_FATE_CORRUPTED;
    stats->corrupted++;
}

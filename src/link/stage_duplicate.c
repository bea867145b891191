#include "link/stage.h"

void ll_stage_duplicate(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    bool happens =
        ll_chance(p, LL_STAGE_DUPLICATE, params->duplicate_pct, params->duplicate_corr_pct, &m->duplicated);
    p->duplicated = happens && p->fate == LL_FATE_DELIVERED;
    stats->duplicated += p->duplicated;
}

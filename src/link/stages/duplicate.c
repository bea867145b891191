/* First of all, as in netem: a loss may then take one of the two copies. */
#include "link/stages/stage.h"

void ll_stage_duplicate(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    p->duplicated =
        ll_chance(p, LL_STREAM_DUPLICATE, params->duplicate_pct, params->duplicate_corr_pct, &m->duplicated);
    stats->duplicated += p->duplicated;
}

/* netem's reordering: a packet goes ahead without the delay of its link, `lag_ms` aside. After one did, the
 * next reorder_gap - 1 do not. Its place in the rate's queue is taken all the same, so others wait as they
 * would. */
#include "link/stage.h"

void ll_stage_reorder(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    bool happens =
        ll_chance(p, LL_STAGE_REORDER, params->reorder_pct, params->reorder_corr_pct, &m->reordered);
    bool ahead = happens && m->since_reorder >= params->reorder_gap - 1;
    if (!p->is_copy)
        m->since_reorder = ahead ? 0 : m->since_reorder + 1;
    if (!ahead || p->fate != LL_FATE_DELIVERED)
        return;
    p->reordered = true;
    p->delay_ms = p->lag_ms;
    p->queued = 0;
    stats->sent_ahead++;
}

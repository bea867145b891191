/* netem's reordering: a packet goes ahead without the delay of its link, except `lag_ms`, and past the rate's
 * queue, in which it takes no time. The next reorder_gap - 1 packets are not reordered. */
#include "link/stages/stage.h"

void ll_stage_reorder(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    bool happens =
        ll_chance(p, LL_STREAM_REORDER, params->reorder_pct, params->reorder_corr_pct, &m->reordered);
    bool ahead = happens && m->since_reorder >= params->reorder_gap - 1;
    if (!p->is_copy)
        m->since_reorder = ahead ? 0 : m->since_reorder + 1;
    if (!ahead || p->fate != LL_FATE_DELIVERED)
        return;
    p->reordered = true;
    p->delay_ms = p->lag_ms;
    stats->reordered_ahead++;
}

/* The stages of a link in their order, and the short ones. */
#include "link/stages/stage.h"

/* First of all, as in netem: a loss may then take one of the two copies. */
static void duplicate(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    p->duplicated =
        ll_chance(p, LL_STREAM_DUPLICATE, params->duplicate_pct, params->duplicate_corr_pct, &m->duplicated);
    stats->duplicated += p->duplicated;
}

/* A corrupted packet takes its delay, and its time in the queue; the receiver drops it. */
static void corrupt(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)stats;
    const ll_link_params *params = p->params;
    p->damaged =
        ll_chance(p, LL_STREAM_CORRUPT, params->corrupt_pct, params->corrupt_corr_pct, &m->corrupted);
}

/* netem's reordering: a packet goes ahead without the delay of its link, except `lag_ms`, and past the rate's
 * queue, in which it takes no time. The next reorder_gap - 1 packets are not reordered. */
static void reorder(ll_passage *p, ll_memory *m, ll_link_stats *stats)
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

static ll_stage_pass *const passes[LL_STAGES] = {
    duplicate,      ll_stage_loss,     ll_stage_trace, corrupt,        ll_stage_bottleneck,
    ll_stage_cells, ll_stage_limit,    ll_stage_delay, ll_stage_table, reorder,
    ll_stage_rate,  ll_stage_capacity, ll_stage_slot};

uint32_t ll_stages_used(const ll_link_params *p)
{
    uint32_t loss = p->loss_pct > 0 || p->loss_model != LL_LOSS_RANDOM || p->blackout_length_ms > 0;
    uint32_t duplicate = p->duplicate_pct > 0;
    uint32_t delay = p->jitter_ms > 0 || p->spike_length_ms > 0;
    uint32_t rate = p->rate_kbps > 0;
    uint32_t reorder = p->reorder_pct > 0;
    uint32_t corrupt = p->corrupt_pct > 0;
    return loss << LL_STAGE_LOSS | duplicate << LL_STAGE_DUPLICATE | delay << LL_STAGE_DELAY |
           rate << LL_STAGE_LIMIT | rate << LL_STAGE_RATE | reorder << LL_STAGE_REORDER |
           corrupt << LL_STAGE_CORRUPT;
}

#define BIT(STAGE) (UINT32_C(1) << LL_STAGE_##STAGE)

uint32_t ll_stages_profiled(const ll_link_params *params, const ll_link_profile *profile)
{
    uint32_t used = ll_stages_any(params) ? ll_stages_used(params) : 0;
    if (!profile)
        return used;
    if (profile->trace_count > 0)
        used |= BIT(TRACE);
    if (profile->table_count > 0 && params->jitter_ms > 0)
        used = (used & ~BIT(DELAY)) | BIT(TABLE);
    if (profile->capacity_count > 0)
        used |= BIT(CAPACITY);
    if (profile->cell_bytes > 0 && (used & (BIT(RATE) | BIT(CAPACITY))))
        used |= BIT(CELLS);
    return used | (profile->slot_max_ms > 0 ? BIT(SLOT) : 0);
}

void ll_stages_pass(uint32_t stages, ll_passage *passage, ll_memory *memory, ll_link_stats *stats)
{
    for (; stages != 0; stages &= stages - 1)
        passes[__builtin_ctz(stages)](passage, memory, stats);
}

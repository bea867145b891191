#include "link/stages/stage.h"

static ll_stage_pass *const passes[LL_STAGES] = {
    ll_stage_duplicate, ll_stage_loss,     ll_stage_trace, ll_stage_corrupt, ll_stage_bottleneck,
    ll_stage_cells,     ll_stage_limit,    ll_stage_delay, ll_stage_table,   ll_stage_reorder,
    ll_stage_rate,      ll_stage_capacity, ll_stage_slot};

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

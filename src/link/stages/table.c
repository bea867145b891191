#include "link/stages/stage.h"

static ll_stage_pass *const passes[LL_STAGES] = {ll_stage_duplicate, ll_stage_loss,  ll_stage_corrupt,
                                                 ll_stage_limit,     ll_stage_delay, ll_stage_reorder,
                                                 ll_stage_rate};

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

void ll_stages_pass(uint32_t stages, ll_passage *passage, ll_memory *memory, ll_link_stats *stats)
{
    for (; stages != 0; stages &= stages - 1)
        passes[__builtin_ctz(stages)](passage, memory, stats);
}

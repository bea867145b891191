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

bool ll_chance(const ll_passage *p, ll_stream stream, double percent, double corr_pct, int64_t *last)
{
    bool happens = 100 * ll_draw(p, stream) < ll_chain_percent(percent, corr_pct, *last == ll_draw_before(p));
    if (happens && !p->is_copy)
        *last = p->number;
    return happens;
}

bool ll_window_open(double at_ms, double every_ms, double length_ms, ll_time now)
{
    if (length_ms <= 0)
        return false;
    ll_time since = now - ll_ms(at_ms), every = ll_ms(every_ms);
    if (since < 0)
        return false;
    return (every > 0 ? since % every : since) < ll_ms(length_ms);
}

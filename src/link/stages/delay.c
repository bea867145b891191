#include "base/detmath.h"
#include "link/stages/stage.h"

#define ROW(KIND, NAME) &ll_delay_##NAME,
const ll_delay_model *const ll_delay_models[] = {LL_DELAY_MODELS(ROW) NULL};

/* The distribution function of a normal deviate is uniform, so correlated deviates can be mapped to any
 * distribution. The first one of a chain is not scaled, so that it has the same variance. */
static __attribute__((noinline)) double correlated_unit(const ll_passage *p, const ll_delay_model *model,
                                                        ll_memory *m)
{
    double corr = model->deviate_corr(p->params->delay_corr_pct / 100);
    double deviate = ll_rng_normal(p->seed, p->stream + LL_STREAM_DELAY, p->counter);
    if (m->deviate_number == ll_draw_before(p))
        deviate = corr * m->deviate + ll_sqrt(1 - corr * corr) * deviate;
    if (!p->is_copy) {
        m->deviate = deviate;
        m->deviate_number = p->number;
    }
    return ll_normal_cdf(deviate);
}

static double unit_of(const ll_passage *p, const ll_delay_model *model, ll_memory *m)
{
    return p->params->delay_corr_pct > 0 ? correlated_unit(p, model, m) : ll_draw(p, LL_STREAM_DELAY);
}

static double jitter_ms(const ll_passage *p, ll_memory *m)
{
    const ll_delay_model *model = ll_delay_models[p->params->distribution];
    return p->params->jitter_ms * model->variate(unit_of(p, model, m));
}

static void bound(ll_passage *p)
{
    const ll_link_params *params = p->params;
    if (p->delay_ms < 0)
        p->delay_ms = 0;
    if (ll_window_open(params->spike_at_ms, params->spike_every_ms, params->spike_length_ms, p->now))
        p->delay_ms += params->spike_add_ms;
}

void ll_stage_delay(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)stats;
    const ll_link_params *params = p->params;
    if (params->jitter_ms > 0)
        p->delay_ms += jitter_ms(p, m);
    bound(p);
}

static double same_corr(double corr)
{
    return corr;
}

/* The table's values at their middles; their correlation is that of the normal deviates. */
static const ll_delay_model table_model = {.name = "table", .deviate_corr = same_corr};

void ll_stage_table(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)stats;
    const int32_t count = p->profile->table_count;
    double u = unit_of(p, &table_model, m);
    int32_t at = (int32_t)(u * count);
    double value = ll_profile_delay_table(p->profile)[at < count ? at : count - 1];
    p->delay_ms += p->params->jitter_ms * value / LL_DELAY_TABLE_SCALE;
    bound(p);
}

double ll_link_delay_max_ms(const ll_link_params *params, double lag_ms)
{
    double longest =
        lag_ms + params->delay_ms + params->jitter_ms * ll_delay_models[params->distribution]->max;
    if (params->spike_length_ms > 0)
        longest += params->spike_add_ms;
    if (params->rate_kbps > 0)
        longest += params->limit_ms;
    return longest;
}

double ll_link_delay_max_with_ms(const ll_link_params *params, double lag_ms, const ll_profile_params *p)
{
    double longest = ll_link_delay_max_ms(params, lag_ms);
    if (!p)
        return longest;
    if (p->table_count > 0)
        longest += params->jitter_ms * (ll_profile_table_max(p) - ll_delay_models[params->distribution]->max);
    longest += ll_profile_distance_ms(p) + ll_profile_trace_max_ms(p);
    longest += p->capacity_count > 0 ? params->limit_ms : 0;
    return longest + (p->slot_max_ms > 0 ? params->limit_ms : 0);
}

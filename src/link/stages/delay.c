/* Delay, by one of the distributions of parameters.h or by the table of a profile. */
#include "base/detmath.h"
#include "link/stages/stage.h"

/* ---- distributions: quantile functions, and correlations of the normal deviates that they need ---- */

/* That of the deviates themselves. Of `normal` truncation changes it by less than 1.1e-5. */
static double same_corr(double corr)
{
    return corr;
}

static double uniform_variate(double u)
{
    return 2 * u - 1;
}

/* K. Pearson's relation of rank and product-moment correlation, 1907: corr = 6/pi asin(deviate_corr / 2). */
static double uniform_corr(double corr)
{
    return 2 * ll_sin(corr * (3.14159265358979323846 / 6));
}

/* Standard normal within 4 standard deviations, like netem's table. With a = Phi(-4) its variance is 1 - 8
 * phi(4) / (1 - 2 a) = 0.99892929; the variates are scaled to 1. */
#define NORMAL_A 3.16712418331199e-05
#define NORMAL_SD 0.999464501807080

static double normal_variate(double u)
{
    return ll_normal_quantile(NORMAL_A + u * (1 - 2 * NORMAL_A)) / NORMAL_SD;
}

/* Pareto of shape 3 and minimum 1, truncated at B = 10. With c = 1 - B^-3 its moments are mean = 3/2 (1 -
 * B^-2) / c and 3 (1 - B^-1) / c for the square: a mean of 55/37 and a variance of 100/37 - mean^2. Without
 * truncation the fourth moment, and with it a measured variance, would not converge. */
#define PARETO_C 0.999
#define PARETO_MEAN (55.0 / 37)
#define PARETO_SD 0.702182759825220524

static double pareto_variate(double u)
{
    return (ll_exp(ll_detmath_log(1 - u * PARETO_C) * (-1.0 / 3)) - PARETO_MEAN) / PARETO_SD;
}

/* Inverse of corr = sum of c_k^2 deviate_corr^k, with c_k the coefficients of the variate in normalised
 * Hermite polynomials of the deviate: a fit; correlations are off by at most 1.4e-4. */
static double pareto_corr(double corr)
{
    return corr * (1.63449 + corr * (-1.24896 + corr * (1.10949 + corr * (-0.678146 + corr * 0.183126))));
}

/* A quarter normal and three quarters pareto at the same quantile. Both have variance 1 and their covariance
 * is c = 0.78050503 (by quadrature), so that of the sum is (10 + 6 c) / 16. */
#define MIXED_SD 0.957961055882941

static double mixed_variate(double u)
{
    return (normal_variate(u) + 3 * pareto_variate(u)) / (4 * MIXED_SD);
}

/* A fit as for pareto, off by at most 1e-5. */
static double mixed_corr(double corr)
{
    return corr * (1.3142 + corr * (-0.4234 + corr * (0.140642 + corr * -0.031442)));
}

const ll_delay_model ll_delay_models[LL_DISTRIBUTIONS] = {
    [LL_DISTRIBUTION_UNIFORM] = {uniform_variate, uniform_corr, 1},
    [LL_DISTRIBUTION_NORMAL] = {normal_variate, same_corr, 4 / NORMAL_SD},
    [LL_DISTRIBUTION_PARETO] = {pareto_variate, pareto_corr, (10 - PARETO_MEAN) / PARETO_SD},
    [LL_DISTRIBUTION_PARETONORMAL] = {mixed_variate, mixed_corr, 10.5367566487743540}};

/* ---- the stages ---- */

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
    const ll_delay_model *model = &ll_delay_models[p->params->distribution];
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

/* The table's values at their middles; their correlation is that of the normal deviates. */
static const ll_delay_model table_model = {.deviate_corr = same_corr};

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
        lag_ms + params->delay_ms + params->jitter_ms * ll_delay_models[params->distribution].max;
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
        longest += params->jitter_ms * (ll_profile_table_max(p) - ll_delay_models[params->distribution].max);
    longest += ll_profile_distance_ms(p) + ll_profile_trace_max_ms(p);
    longest += p->capacity_count > 0 ? params->limit_ms : 0;
    return longest + (p->slot_max_ms > 0 ? params->limit_ms : 0);
}

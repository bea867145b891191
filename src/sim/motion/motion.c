#include "sim/motion/motion.h"

#include <string.h>

#include "base/hash.h"
#include "sim/core/scenario_rows.h"

/* ---- layout ---- */

/* Any method may be chosen during a run: the largest counts. */
static size_t largest_run(const ll_ode *ode)
{
    size_t largest = 0;
    for (int i = 0; ll_ode_methods[i]; i++) {
        ll_status fits = ll_ode_method_fits(ll_ode_methods[i], ode);
        size_t size = ll_failed(&fits) ? 0 : ll_ode_run_size(ll_ode_methods[i], ode);
        largest = size > largest ? size : largest;
    }
    return largest;
}

/* Computes the offsets of all parts; with a NULL block only the size. */
static int64_t lay_out(ll_motion *m, const ll_motion_config *c)
{
    ll_motion_config copy = *c;
    ll_ode ode = ll_motion_system(&copy);
    const ll_ode_problem *problem = ll_motion_problem(c);
    int64_t vector = ode.dim * (int64_t)sizeof(double), end = (int64_t)sizeof(ll_motion);
    int64_t run = (int64_t)largest_run(&ode);
    int64_t reference = (int64_t)ll_ode_run_size(ll_ode_reference_method(problem, 0), &ode);
    int64_t second = (int64_t)ll_ode_run_size(ll_ode_reference_method(problem, 1), &ode);
    ll_motion counted, *at = m ? m : &counted;
    at->dim = ode.dim;
    at->solution = end;
    at->reference = end + vector;
    at->first = at->reference + reference;
    at->second = at->first + reference;
    at->ahead = at->second + second;
    at->uncertainty_each = at->ahead + reference;
    end = at->uncertainty_each + LL_ODE_ROWS * vector;
    for (int i = 0; i < c->method_count; i++) {
        at->at[i].shown = end;
        at->at[i].wanted = end + vector;
        at->at[i].each = end + 2 * vector;
        at->at[i].run = at->at[i].each + LL_ODE_ROWS * vector;
        end = at->at[i].run + run;
        at->at[i].reference = end;
        end += reference;
    }
    return end;
}

static size_t size(const void *config)
{
    return (size_t)lay_out(NULL, config);
}

/* References, what they differ in, and the measures. */
static ll_block_use use(const void *block)
{
    const ll_motion *m = block;
    const int methods = m->config.method_count;
    int64_t measures = (methods > 0 ? m->at[0].shown : m->size) - m->first;
    for (int i = 0; i < methods; i++)
        measures += m->at[i].run - m->at[i].wanted + (m->second - m->first);
    return (ll_block_use){.metrics = (size_t)measures};
}

/* ---- start ---- */

static void start_one(ll_motion *m, const ll_ode *ode, int i, const double *y0)
{
    ll_ode_control control = ll_motion_control(&m->config, i);
    size_t vector = (size_t)m->dim * sizeof(double);
    ll_ode_start(ll_motion_run(m, i), ll_motion_method_of(&m->config, i), ode, &control,
                 y0); /* checked before */
    memcpy(ll_motion_vector(m, m->at[i].shown), y0, vector);
    memcpy(ll_motion_vector(m, m->at[i].wanted), y0, vector);
    ll_motion_drive_start(m, i, ode);
}

static ll_status init(void *block, const void *config)
{
    ll_motion *m = block;
    double y0[LL_ODE_DIM_MAX];
    memset(block, 0, size(config));
    m->config = *(const ll_motion_config *)config;
    ll_scenario_head_strip(&m->config.head);
    m->size = lay_out(m, &m->config);
    ll_ode ode = ll_motion_system(&m->config);
    ll_motion_problem(&m->config)->start(m->config.params, y0);
    memcpy(ll_motion_vector(m, m->solution), y0, (size_t)m->dim * sizeof *y0);
    for (int i = 0; i < m->config.method_count; i++)
        start_one(m, &ode, i, y0);
    ll_motion_measure_start(m, &ode, y0);
    return ll_ok();
}

static ll_freq tick_freq(const void *config)
{
    return ll_freq_from_hz(((const ll_motion_config *)config)->tick_hz);
}

static void settle(void *config, const void *before)
{
    (void)config;
    (void)before;
}

/* ---- time ---- */

/* Where its last step passed `t` it is interpolated; with a wrong clock or a rounded state, drawn as it is.
 * Between two huge values the interpolation can overflow: then the method's own state is drawn. */
static void draw(ll_motion *m, const ll_ode *ode, int i, double t)
{
    const ll_motion_method *method = &m->config.methods[i];
    ll_ode_run *run = ll_motion_run(m, i);
    bool passed = m->drive[i].turned ? t > run->t : t < run->t;
    if (!passed || method->clock != LL_MOTION_EXACT || method->precision != LL_MOTION_DOUBLE)
        t = run->t;
    double *shown = ll_motion_vector(m, m->at[i].shown), sum = 0;
    ll_ode_sample(run, ll_motion_method_of(&m->config, i), ode, t, shown);
    for (int k = 0; k < m->dim; k++)
        sum += shown[k] * 0;
    if (sum != 0)
        memcpy(shown, ll_ode_y(run), (size_t)m->dim * sizeof *shown);
}

static void advance_one(ll_motion *m, const ll_ode *ode, int i, double t, bool last, ll_pace *pace)
{
    ll_ode_run *run = ll_motion_run(m, i);
    if (!m->config.methods[i].shown || run->state == LL_ODE_DIVERGED)
        return;
    if (ll_motion_drive_to(m, i, ode, t, pace) == LL_ODE_DIVERGED || ll_broken_off(pace))
        return;
    draw(m, ode, i,
         last ? run->t : ll_motion_moment(&m->config, t)); /* at the end the reported state is drawn */
}

static ll_status advance(void *block, ll_time until, const ll_recorder *recorder,
                         ll_step_profiler *step_profiler, const ll_interrupt *interrupt, ll_team *team)
{
    (void)team;
    ll_motion *m = block;
    ll_pace pace = ll_pace_by(interrupt, 1);
    ll_freq freq = tick_freq(&m->config);
    ll_ode ode = ll_motion_system(&m->config);
    int64_t last = ll_tick_at((ll_time)(m->config.head.duration_s * 1e9 + 0.5), freq);
    (void)recorder;
    (void)step_profiler;
    for (int64_t tick = ll_tick_at(m->now, freq) + 1; ll_tick_time(tick, freq) <= until && ll_goes_on(&pace);
         tick++) {
        m->now = ll_tick_time(tick, freq);
        double t = tick == last ? m->config.head.duration_s
                                : ll_to_s(m->now); /* the end is not the time of a tick */
        ll_motion_solve(m, &ode, t, &pace);
        for (int i = 0; i < m->config.method_count && !pace.broken; i++) {
            advance_one(m, &ode, i, t, tick == last, &pace);
            if (!pace.broken && tick == last && m->config.methods[i].shown)
                ll_motion_judge(m, i, &ode);
        }
    }
    m->now = until;
    return pace.broken ? ll_error(LL_INTERRUPTED, "a tick was interrupted") : ll_ok();
}

static void change(void *block, const void *config, ll_time now)
{
    (void)now;
    init(block, config);
}

static uint64_t hash(const void *block)
{
    return ll_hash(0, block, (size_t)((const ll_motion *)block)->size);
}

const ll_sim_kind ll_sim_motion = {
    .name = "motion",
    .help = "A problem of motion, solved by several methods side by side.",
    .table = &ll_motion_table,
    .size = size,
    .init = init,
    .settle = settle,
    .tick_freq = tick_freq,
    .advance = advance,
    .use = use,
    .change = change,
    .begins_anew = true,
    .hash = hash,
    .state = ll_motion_state,
    .metrics = ll_motion_metrics,
    .no_rare_events = true,
    .metric_tables = ll_motion_metric_tables,
    .time_parts = ll_motion_time_parts,
    .text = ll_motion_text,
    .layout = ll_motion_layout,
    .records = ll_motion_records,
    .fill = ll_motion_fill,
    .trace_tables = ll_motion_trace_tables,
    .trace = ll_motion_trace,
};

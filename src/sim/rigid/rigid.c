#include "sim/rigid/rigid.h"

#include <string.h>

#include "base/hash.h"
#include "sim/core/pointer_drag.h"
#include "sim/core/scenario_rows.h"

/* ---- start ---- */

static void settle(void *config, const void *before)
{
    (void)config;
    (void)before;
}

static ll_freq tick_freq(const void *config)
{
    return ll_freq_from_hz(((const ll_rigid_config *)config)->setup.hz);
}

/* ---- pointer drag ---- */

#define MOUSE_HERTZ 5
#define MOUSE_FORCE_PER_KG 1000

/* The static body at the other end of a mouse joint. */
static ll_status fixed_body(ll_rigid *w, ll_rigid_record *r, ll_body_id *out)
{
    for (int32_t i = 0; i < ll_rigid_body_end(w); i++) {
        ll_body_state state;
        *out = ll_rigid_body_at(w, i);
        ll_status status = ll_rigid_get_body(w, *out, &state);
        if (!ll_failed(&status) && state.type == LL_BODY_STATIC)
            return ll_ok();
    }
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    ll_status status = ll_rigid_add_body(w, &def, &r->hand);
    *out = r->hand;
    return status;
}

static ll_status grab_body(ll_rigid *w, ll_rigid_record *r, ll_vec2 point)
{
    ll_body_id body = ll_rigid_pick(w, point), fixed;
    ll_body_state state;
    if (body.index == 0)
        return ll_ok();
    LL_TRY(ll_rigid_get_body(w, body, &state));
    LL_TRY(fixed_body(w, r, &fixed));
    ll_joint_def def = ll_joint_defaults(w, LL_JOINT_MOUSE, fixed, body, point);
    def.hertz = MOUSE_HERTZ;
    def.damping = 1;
    def.max_force = MOUSE_FORCE_PER_KG * state.mass;
    def.collide = 1;
    return ll_rigid_add_joint(w, &def, &r->mouse);
}

/* The body under the pointer when the button goes down is dragged to the pointer until the button is released
 * or the body is removed. */
static void drag(ll_rigid_sim *s, int i)
{
    ll_rigid *w = ll_rigid_sim_world(s, i);
    ll_rigid_record *r = &s->record[i];
    ll_vec2 point = ll_vec(s->target[0], s->target[1]);
    ll_status status = ll_ok();
    if (r->mouse.index != 0)
        status = s->held ? ll_rigid_set_target(w, r->mouse, point) : ll_rigid_remove_joint(w, r->mouse);
    else if (s->pressed)
        status = grab_body(w, r, point);
    if (!s->held || ll_failed(&status))
        r->mouse = (ll_joint_id){0, 0};
}

static ll_status accepts(const void *config, int player, const ll_action *action)
{
    (void)config;
    return ll_pointer_drag_accepts(player, action, "drags");
}

static void input(void *block, int player, const ll_action *action)
{
    ll_rigid_sim *s = block;
    bool held = (action->buttons & LL_BUTTON_FIRE) != 0;
    (void)player;
    s->pressed |= held && !s->held;
    s->held = held;
    for (int i = 0; i < 2; i++) {
        double low = s->view[2 * i], high = s->view[2 * i + 1];
        s->target[i] = 0.5 * (low + high) + 0.5 * (high - low) * (double)action->axis[i];
    }
}

/* ---- time ---- */

ll_status ll_rigid_sim_step(ll_rigid_sim *s, int i, const ll_rigid_probe *probe, ll_team *team)
{
    ll_rigid *w = ll_rigid_sim_world(s, i);
    ll_rigid_record *r = &s->record[i];
    const ll_scene *scene = ll_rigid_sim_scene(&s->setup);
    ll_status status = ll_ok();
    drag(s, i);
    if (scene != NULL && scene->drive != NULL) {
        ll_scene_args args = ll_scene_args_of(scene, &s->setup.params);
        status = scene->drive(w, &args, ll_rigid_get_stats(w).step);
    }
    LL_THEN(status, ll_rigid_step_by_team(w, 1 / s->setup.hz, probe, team));
    if (status.code == LL_LIMIT) { /* the step was made without them */
        r->over_limit++;
        return ll_ok();
    }
    if (ll_failed(&status)) {
        r->diverged_at = ll_rigid_get_stats(w).step;
        memcpy(r->reason, status.text, sizeof r->reason);
    }
    return status;
}

/* Reads the profiler's clock at the end of a phase. */
typedef struct stopwatch {
    ll_step_profiler *step_profiler;
    int64_t last;
    int first; /* part of the profiler: a world's phases are consecutive */
} stopwatch;

static void ended(void *context, ll_rigid_phase phase)
{
    stopwatch *watch = context;
    ll_step_profiler_add(watch->step_profiler, watch->first + (int)phase, watch->last);
    watch->last = ll_step_profiler_start(watch->step_profiler);
}

static ll_status step_metered(ll_rigid_sim *s, int i, ll_step_profiler *step_profiler, ll_team *team)
{
    int64_t from = ll_step_profiler_start(step_profiler);
    stopwatch watch = {.step_profiler = step_profiler, .last = from, .first = i * LL_RIGID_PARTS};
    ll_rigid_probe probe = {ended, &watch};
    ll_status status = ll_rigid_sim_step(s, i, step_profiler ? &probe : NULL, team);
    ll_step_profiler_add(step_profiler, i * LL_RIGID_PARTS + LL_PHASES, from);
    return status;
}

/* A failure of the first world stops its session; a failure of another stops only that world. */
static ll_status step_all(ll_rigid_sim *s, ll_step_profiler *step_profiler, ll_pace *pace, ll_team *team)
{
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++) {
        if (!ll_goes_on(pace))
            return ll_error(LL_INTERRUPTED, "a tick was interrupted");
        if (s->record[i].diverged_at >= 0) {
            if (i == 0)
                return ll_error(LL_DIVERGED, "%s", s->record[0].reason);
            continue;
        }
        ll_status status = step_metered(s, i, step_profiler, team);
        LL_THEN(status, ll_rigid_sim_measure(s, i, step_profiler));
        if (ll_failed(&status) && i == 0)
            return ll_error(LL_DIVERGED, "%s", status.text);
    }
    s->pressed = 0;
    return ll_ok();
}

static ll_status advance(void *block, ll_time until, const ll_recorder *recorder,
                         ll_step_profiler *step_profiler, const ll_interrupt *interrupt, ll_team *team)
{
    ll_rigid_sim *s = block;
    ll_pace pace = ll_pace_by(interrupt, 1);
    ll_freq freq = ll_freq_from_hz(s->setup.hz);
    (void)recorder;
    for (int64_t tick = ll_tick_at(s->now, freq) + 1; ll_tick_time(tick, freq) <= until; tick++) {
        LL_TRY(step_all(s, step_profiler, &pace, team));
        s->now = ll_tick_time(tick, freq);
    }
    s->now = until;
    return ll_ok();
}

static void change(void *block, const void *config, ll_time now)
{
    ll_rigid_sim *s = block;
    (void)now;
    s->setup = ((const ll_rigid_config *)config)->setup;
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++) {
        ll_rigid *w = ll_rigid_sim_world(s, i);
        ll_rigid_params params = ll_rigid_sim_params(&s->setup, i);
        ll_rigid_set_params(w, &params); /* all records fit */
        ll_rigid_set_broad(w, (ll_broad_kind)s->setup.broad_phase);
    }
}

/* Without the parameters: equal for every broad phase and SIMD width. */
static uint64_t hash(const void *block)
{
    const ll_rigid_sim *s = block;
    uint64_t h = ll_hash_u64((uint64_t)s->now, (uint64_t)s->held);
    h = ll_hash(h, s->record, (size_t)ll_rigid_sim_worlds(&s->setup) * sizeof s->record[0]);
    for (int i = 0; i < ll_rigid_sim_worlds(&s->setup); i++)
        h = ll_hash_u64(h, ll_rigid_hash(ll_rigid_sim_world(s, i)));
    return h;
}

/* The measures of each world, and where its bodies are expected. */
static ll_block_use use(const void *block)
{
    const ll_rigid_sim *s = block;
    size_t records = (size_t)ll_rigid_sim_worlds(&s->setup) * sizeof s->record[0];
    return (ll_block_use){.metrics = records + (size_t)(s->world[0] - s->reference)};
}

const ll_sim_kind ll_sim_rigid = {
    .name = "rigid",
    .help = "Rigid bodies that collide, by exchangeable volumes, phases and solvers.",
    .table = &ll_rigid_scenario_table,
    .size = ll_rigid_sim_size,
    .init = ll_rigid_sim_init,
    .settle = settle,
    .tick_freq = tick_freq,
    .advance = advance,
    .use = use,
    .change = change,
    .accepts = accepts,
    .input = input,
    .hash = hash,
    .state = ll_rigid_sim_state,
    .metrics = ll_rigid_sim_metrics,
    .no_rare_events = true,
    .metric_tables = ll_rigid_sim_metric_tables,
    .costs = ll_rigid_sim_costs,
    .time_parts = ll_rigid_sim_time_parts,
    .layout = ll_rigid_sim_layout,
    .records = ll_rigid_sim_records,
    .fill = ll_rigid_sim_fill,
    .trace_tables = ll_rigid_sim_trace_tables,
    .trace = ll_rigid_sim_trace,
};

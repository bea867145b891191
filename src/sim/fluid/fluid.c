#include "sim/fluid/fluid.h"

#include <stdio.h>
#include <string.h>

#include "base/hash.h"
#include "sim/core/pointer_drag.h"
#include "sim/core/scenario_rows.h"

static void settle(void *config, const void *before)
{
    (void)config;
    (void)before;
}

static ll_freq tick_freq(const void *config)
{
    return ll_freq_from_hz(((const ll_fluid_config *)config)->setup.hz);
}

/* ---- pointer drag ---- */

#define DRAG_RADIUS 0.04 /* of the larger side of the view */
#define DRAG_SPEED 4.0   /* sides per second, at most */

static double larger_side(const ll_fluid_sim *s, double box[4])
{
    ll_fluid_sim_scene(&s->setup)->method->extent(ll_fluid_sim_block(s), &box[0], &box[1], &box[2], &box[3]);
    double width = box[2] - box[0], height = box[3] - box[1];
    return width > height ? width : height;
}

static double limited(double value, double most)
{
    return value < -most ? -most : value > most ? most : value;
}

/* With the speed of the pointer since the previous tick. */
static void drag_force(ll_fluid_sim *s)
{
    double box[4], side = larger_side(s, box);
    ll_drag_force what = {
        .x = s->pointer[0],
        .y = s->pointer[1],
        .velocity_x = limited((s->pointer[0] - s->before[0]) * s->setup.hz, DRAG_SPEED * side),
        .velocity_y = limited((s->pointer[1] - s->before[1]) * s->setup.hz, DRAG_SPEED * side),
        .radius = s->held ? DRAG_RADIUS * side : 0};
    if (ll_fluid_sim_scene(&s->setup)->method->drag_force)
        ll_fluid_sim_scene(&s->setup)->method->drag_force(ll_fluid_sim_block(s), &what);
    memcpy(s->before, s->pointer, sizeof s->before);
}

static ll_status accepts(const void *config, int player, const ll_action *action)
{
    (void)config;
    return ll_pointer_drag_accepts(player, action, "stirs");
}

static void point(ll_fluid_sim *s, const ll_action *action)
{
    bool held = (action->buttons & LL_BUTTON_FIRE) != 0;
    double box[4];
    larger_side(s, box);
    for (int i = 0; i < 2; i++)
        s->pointer[i] = 0.5 * (box[i] + box[i + 2]) + 0.5 * (box[i + 2] - box[i]) * (double)action->axis[i];
    if (held && !s->held)
        memcpy(s->before, s->pointer, sizeof s->before);
    s->held = held;
}

static void input(void *block, int player, const ll_action *action)
{
    (void)player;
    for (ll_fluid_sim *s = block; s != NULL; s = ll_fluid_sim_next(s))
        point(s, action);
}

/* ---- time ---- */

static ll_status step(ll_fluid_sim *s, const ll_fluid_run *run)
{
    drag_force(s);
    ll_status status =
        ll_fluid_sim_scene(&s->setup)->method->step(ll_fluid_sim_block(s), 1 / s->setup.hz, run);
    if (ll_broken_off(run->pace))
        return ll_error(LL_INTERRUPTED, "a tick was interrupted");
    if (!ll_failed(&status)) {
        s->ticks++;
        return status;
    }
    s->failed = 1;
    memset(s->reason, 0, sizeof s->reason);
    snprintf(s->reason, sizeof s->reason, "tick %lld: %.220s", (long long)s->ticks + 1, status.text);
    return status;
}

static ll_status advance_one(ll_fluid_sim *s, ll_time until, const ll_fluid_run *run)
{
    ll_freq freq = ll_freq_from_hz(s->setup.hz);
    for (int64_t tick = ll_tick_at(s->now, freq) + 1; ll_tick_time(tick, freq) <= until; tick++) {
        ll_status status = s->failed ? ll_error(LL_DIVERGED, "%s", s->reason) : step(s, run);
        if (status.code == LL_INTERRUPTED)
            return status;
        if (ll_failed(&status))
            return ll_error(LL_DIVERGED, "%s", s->reason);
        s->now = ll_tick_time(tick, freq);
    }
    s->now = until;
    return ll_ok();
}

/* A failure of the first fluid stops its session; a failure of another stops only that fluid. */
static ll_status advance(void *block, ll_time until, const ll_recorder *recorder,
                         ll_step_profiler *step_profiler, const ll_interrupt *interrupt, ll_team *team)
{
    ll_status first = ll_ok();
    ll_pace pace = ll_pace_by(interrupt, 1);
    ll_fluid_run run = {&pace, team};
    int i = 0;
    (void)recorder;
    for (ll_fluid_sim *s = block; s != NULL && !ll_failed(&first); s = ll_fluid_sim_next(s), i++) {
        ll_time from = ll_step_profiler_start(step_profiler);
        ll_status status = advance_one(s, until, &run);
        ll_step_profiler_add(step_profiler, i, from);
        if (i == 0 || pace.broken)
            first = status;
    }
    return first;
}

static void change(void *block, const void *config, ll_time now)
{
    ll_fluid_sim *s = block;
    (void)now;
    for (int i = 0; s != NULL; i++, s = ll_fluid_sim_next(s)) {
        s->setup = ll_fluid_sim_setup(config, i);
        ll_fluid_sim_scene(&s->setup)->method->set_solver(ll_fluid_sim_block(s), s->setup.solver);
    }
}

/* Without the choice of scene and field: a new row in a table leaves hashes unchanged. */
static uint64_t hash(const void *block)
{
    uint64_t h = 0;
    for (const ll_fluid_sim *s = block; s != NULL; s = ll_fluid_sim_next(s)) {
        h = ll_hash(h, s, offsetof(ll_fluid_sim, setup));
        const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
        uint64_t own = method->hash ? method->hash(ll_fluid_sim_block(s)) : 0;
        h = method->hash ? ll_hash(h, &own, sizeof own)
                         : ll_hash(h, ll_fluid_sim_block(s), (size_t)(s->size - s->fluid));
    }
    return h;
}

const ll_sim_kind ll_sim_fluid = {
    .name = "fluid",
    .help = "Fluids by particles, on a grid, and as the surface of an ocean.",
    .table = &ll_fluid_scenario_table,
    .size = ll_fluid_sim_size,
    .init = ll_fluid_sim_init,
    .settle = settle,
    .tick_freq = tick_freq,
    .advance = advance,
    .change = change,
    .accepts = accepts,
    .input = input,
    .hash = hash,
    .state = ll_fluid_sim_state,
    .metrics = ll_fluid_sim_metrics,
    .no_rare_events = true,
    .metric_tables = ll_fluid_sim_metric_tables,
    .costs = ll_fluid_sim_costs,
    .layout = ll_fluid_sim_layout,
    .records = ll_fluid_sim_records,
    .fill = ll_fluid_sim_fill,
    .trace_tables = ll_fluid_sim_trace_tables,
    .trace = ll_fluid_sim_trace,
};

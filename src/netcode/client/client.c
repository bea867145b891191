#include "netcode/state/client.h"

#include <string.h>

#include "base/rng.h"
#include "netcode/client/ack.h"
#include "netcode/reckoning/reckoning.h"
#include "netcode/state/peer.h"

static size_t round8(size_t n)
{
    return (n + 7) & ~(size_t)7;
}

/* The worlds latest, predicted, checked and shown, the draw infos and the view errors; then the snapshots, or
 * the peer of a peer-to-peer sync. */
size_t ll_client_size(ll_extent extent)
{
    size_t world = ll_extent_size(extent),
           states = (size_t)ll_state_ring((int64_t)world) * (sizeof(ll_snapshot_entry) + world);
    size_t peer = ll_peer_size(extent.entities < LL_PEERS_MAX ? extent.entities : LL_PEERS_MAX, world);
    if (extent.entities > LL_TOUCHING_MAX)
        peer = 0; /* no such sync steps that many */
    return round8(sizeof(ll_client)) + 4 * world +
           (size_t)extent.entities * (sizeof(ll_draw_info) + sizeof(ll_view_error)) +
           (peer > states ? peer : states);
}

void ll_client_init(ll_client *c, int self, const ll_world *start)
{
    memset(c, 0, ll_client_size((ll_extent){start->entities, start->tail}));
    c->self = self;
    c->layout.world_size = (int64_t)ll_world_size(start);
    c->layout.latest = (int64_t)round8(sizeof(ll_client));
    c->layout.predicted = c->layout.latest + c->layout.world_size;
    c->layout.checked = c->layout.predicted + c->layout.world_size;
    c->layout.rendered = c->layout.checked + c->layout.world_size;
    c->layout.draw_infos = c->layout.rendered + c->layout.world_size;
    c->layout.errors = c->layout.draw_infos + start->entities * (int64_t)sizeof(ll_draw_info);
    c->layout.states = c->layout.errors + start->entities * (int64_t)sizeof(ll_view_error);
    ll_connection_init(&c->connection, -LL_LOBBY);
    c->ticks.due = c->displays.due = LL_NEVER;
    c->due = -LL_LOBBY;
    memcpy(ll_client_latest(c), start, (size_t)c->layout.world_size);
    memcpy(ll_client_predicted(c), start, (size_t)c->layout.world_size);
    memcpy(ll_client_checked(c), start, (size_t)c->layout.world_size);
    memcpy(ll_client_rendered(c), start, (size_t)c->layout.world_size);
}

#define PHASE_STREAM 0x7068617365 /* `phase`; one per player */

/* Delay of the machine's ticks relative to a clock that starts now. */
static ll_time phase_of(const ll_client *c, const ll_client_setup *s)
{
    double phase = s->config->clock_phase;
    if (phase < 0)
        phase = ll_rng_unit(s->seed, PHASE_STREAM + (uint64_t)c->self, 0);
    return (ll_time)(phase * (double)c->ticks.period);
}

/* Time of tick `k` of a clock on a machine whose clock drifts. */
static ll_time machine_time(const ll_client_setup *s, const ll_clock *clock, int64_t k)
{
    ll_time since = ll_tick_time(k - clock->k0, clock->freq);
    return clock->epoch + since - (ll_time)((double)since * (s->config->drift_ppm * 1e-6));
}

static void start_clocks(ll_client *c, const ll_client_setup *s, ll_freq freq, ll_time now)
{
    c->ticks.period = ll_tick_time(1, freq);
    c->ticks.clock = (ll_clock){now + phase_of(c, s), 0, freq};
    c->ticks.number = c->displays.number = 0;
    c->ticks.last = c->ticks.clock.epoch - c->ticks.period;
    c->ticks.due = c->ticks.clock.epoch;
    c->ticks.skipped = 0;
    c->displays.clock = (ll_clock){c->ticks.clock.epoch, 0, s->display_freq};
    c->displays.last =
        s->display_freq > 0 ? c->ticks.clock.epoch - ll_tick_time(1, s->display_freq) : c->ticks.last;
    c->displays.due = s->display_freq > 0 ? c->ticks.clock.epoch : LL_NEVER;
}

void ll_client_start(ll_client *c, const ll_client_setup *s, const ll_client_begin *begin, ll_time now)
{
    const ll_world *world = begin->world;
    int64_t step = begin->step;
    ll_connection *n = &c->connection;
    bool in = n->state != LL_CONNECTION_CONNECTING && n->state != LL_CONNECTION_DISCONNECTED;
    start_clocks(c, s, begin->freq, now);
    c->inputs.tick = step;
    n->epoch = in ? begin->epoch : n->epoch;
    ll_client_forget_inputs(c, s, n->epoch, now);
    c->inputs.scale = 1;
    c->snapshots.received = c->snapshots.used = 0;
    c->snapshots.newest_tick = -1;
    c->snapshots.grid_tick = LL_NEVER;
    c->snapshots.confirmed = c->snapshots.game_start_step = step;
    c->snapshots.game_start = now;
    c->latest.time = c->drawing.view_time = c->view.render = now;
    c->latest.tick = step;
    c->view.has_render = c->view.extrapolated = c->view.held = c->view.underrun = c->view.has_errors = 0;
    c->view.state = LL_VIEW_NEWEST;
    c->drawing.received = c->drawing.depth = 0;
    c->predicting = 0;
    memset(c->latest.controls, 0, sizeof c->latest.controls);
    c->view_step = -1;
    memcpy(ll_client_latest(c), world, (size_t)c->layout.world_size);
    memcpy(ll_client_rendered(c), world, (size_t)c->layout.world_size);
    for (int i = 0; i < world->entities; i++) {
        ll_client_draw_infos(c)[i] = (ll_draw_info){.time = now};
        ll_client_errors(c)[i] = (ll_view_error){0};
    }
    ll_client_align(c, s, true, now);
    ll_client_set_due(c, s);
    if (s->recent)
        ll_recent_start(s->recent);
    if (s->sync->start)
        s->sync->start(c, s, &(ll_client_begin){.step = step, .first = step, .own = step, .world = world});
}

/* The latest world becomes that of the newest snapshot. */
static void take_world(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state)
{
    const ll_world *world = (const ll_world *)(state + 1);
    if (s->recent)
        ll_recent_copy(s->recent, &s->recent->latest, true, ll_client_latest(c), world);
    else
        memcpy(ll_client_latest(c), world, (size_t)c->layout.world_size);
}

static void take_newest_state(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_snapshot_entry *state = ll_client_state(c, c->snapshots.received - 1);
    uint32_t acked = c->inputs.acked;
    c->snapshots.used = c->snapshots.received;
    ll_acks[s->config->ack]->take(c, s, state, now);
    bool stands = s->reporter ? ll_report_stands(c, s->reporter)
                              : s->config->prediction && ll_prediction_stands(c, s, state, acked);
    c->latest.time = state->time;
    c->latest.tick = state->tick;
    take_world(c, s, state);
    if (s->config->prediction)
        ll_reconcile(c, s, stands, now);
}

/* Whether others are drawn at a render time of their own (true) or as in the newest snapshot. */
static bool draws_by_time(const ll_client *c, const ll_client_setup *s)
{
    return c->snapshots.received > 0 && !s->reckoning &&
           (s->config->interpolation || (s->sync->extrapolates && s->config->extrapolation_ms > 0));
}

/* Dead reckoning: the others at the server's present. */
static __attribute__((noinline)) void draw_reckoned(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_world *shown = ll_client_rendered(c);
    const ll_draw_info mark = {.time = ll_client_server_time(c, s, now), .flags = LL_RENDERED_EXTRAPOLATED};
    ll_reckoning_draw(s->reckoning, c->self, mark.time, shown);
    for (int i = 0; i < shown->entities; i++)
        if (i != c->self)
            ll_client_draw_infos(c)[i] = mark;
}

static bool predicts_others(const ll_client *c)
{
    ll_entity_set alone = {{0}};
    ll_entity_set_add(&alone, c->self);
    return memcmp(&alone, &c->prediction.entities, sizeof alone) != 0;
}

/* Whether the own entity is drawn as predicted, and not by what the server says. */
static bool predicts_own(const ll_client *c, const ll_client_setup *s)
{
    return s->config->prediction && ll_entity_set_has(&c->prediction.entities, c->self);
}

static __attribute__((always_inline)) inline void draw(ll_client *c, const ll_client_setup *s, ll_time now,
                                                       const bool usual)
{
    const ll_world *latest = ll_client_latest(c);
    ll_world *shown = ll_client_rendered(c);
    ll_draw_info *marks = ll_client_draw_infos(c);
    const bool by_time = draws_by_time(c, s);
    for (int i = 0; i < latest->entities && !by_time; i++) {
        shown->entity[i] = latest->entity[i];
        marks[i] = (ll_draw_info){.time = c->latest.time};
    }
    if (by_time && !(usual && predicts_own(c, s))) {
        shown->entity[c->self] = latest->entity[c->self];
        marks[c->self] = (ll_draw_info){.time = c->latest.time};
    }
    memcpy(ll_world_tail(shown), ll_world_tail_const(latest), (size_t)latest->tail);
    if (by_time) {
        s->sync->interpolate(c, s, now);
    } else {
        c->view.has_render = c->view.extrapolated = c->view.held = c->view.underrun = 0;
        c->view.state = LL_VIEW_NEWEST;
        c->drawing.received = c->snapshots.received;
        c->drawing.depth = 0;
        c->drawing.alpha = c->drawing.time_scale = 1;
        c->drawing.buffer_ms = 0;
    }
    if (!usual && s->reckoning && c->snapshots.received > 0)
        draw_reckoned(c, s, now);
    if (s->config->prediction)
        ll_draw_predicted(c, now);
    if (!usual && s->recent && s->config->prediction && predicts_others(c))
        s->recent->drawn = s->recent->shows = 0;
    if (c->view.has_errors || s->client_metrics->observes & LL_OBSERVE_FRAMES) /* few frames */
        ll_smooth_draw(c, s, now);
    int other = c->self == 0;
    c->drawing.view_time = other < shown->entities ? marks[other].time : now;
}

static __attribute__((noinline)) void apply(ll_client *c, const ll_client_setup *s, uint8_t predicting,
                                            ll_time now)
{
    if (c->snapshots.received > c->snapshots.used)
        take_newest_state(c, s, now);
    if (predicting != 0 && predicting != c->predicting)
        ll_resimulate(c, s);
    c->predicting = predicting;
}

/* Most ticks and displays find nothing new. */
void ll_client_apply_newest(ll_client *c, const ll_client_setup *s, ll_time now)
{
    uint8_t predicting = (uint8_t)(s->config->prediction ? 1 + s->config->prediction_scope : 0);
    if (c->snapshots.received > c->snapshots.used || c->predicting != predicting)
        apply(c, s, predicting, now);
}

void ll_client_usual_display(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_client_begin_display(c, now);
    ll_client_apply_newest(c, s, now);
    draw(c, s, now, true);
}

void ll_client_display(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_client_begin_display(c, now);
    ll_client_apply_newest(c, s, now);
    if (s->recent)
        ll_recent_begin_display(s->recent);
    draw(c, s, now, false);
    if (s->recent)
        ll_recent_end_display(s->recent, ll_client_rendered(c));
    if (s->weapon_prediction)
        ll_weapon_prediction_frame(c, s);
}

void ll_client_set_due(ll_client *c, const ll_client_setup *s)
{
    c->due = ll_connection_due(c, s);
    c->due = c->ticks.due < c->due ? c->ticks.due : c->due;
    c->due = c->displays.due < c->due ? c->displays.due : c->due;
}

#define TIMER_STREAM 0x74696d6572 /* `timer`; one per player */

/* An input without an answer is sent again after this time plus twice the measured round trip. The time that
 * earlier answers took is no measure: it includes earlier losses, and losses of other players. */
#define REPEAT_MS 200

void ll_client_set_usual_timer(ll_client *c)
{
    ll_dilate_time(c);
    c->ticks.due = ll_clock_time(&c->ticks.clock, c->ticks.number);
    c->ticks.skipped = 0;
}

/* A timer that fires late sets the next one from that time, as a browser's does. */
void ll_client_set_timer(ll_client *c, const ll_client_setup *s, ll_time now)
{
    double late_ms = s->config->timer_jitter_ms;
    ll_dilate_time(c);
    c->ticks.due = machine_time(s, &c->ticks.clock, c->ticks.number);
    c->ticks.skipped = 0;
    if (s->sync->answers)
        c->ticks.due = now + ll_ms(REPEAT_MS) + 2 * ll_clock_sync_round_trip(&c->connection.clock);
    if (late_ms == 0 || s->sync->answers)
        return;
    uint64_t draw = (uint64_t)c->epoch << 32 | (uint64_t)c->ticks.number;
    c->ticks.due =
        now + c->ticks.period + ll_ms(late_ms * ll_rng_unit(s->seed, TIMER_STREAM + (uint64_t)c->self, draw));
    if (s->choices)
        c->ticks.due += s->choices->longer;
    for (; machine_time(s, &c->ticks.clock, c->ticks.number + 1) <= c->ticks.due; c->ticks.number++)
        c->ticks.skipped++;
}

void ll_client_set_display(ll_client *c, const ll_client_setup *s)
{
    c->displays.due =
        c->displays.clock.freq > 0 ? machine_time(s, &c->displays.clock, c->displays.number) : LL_NEVER;
}

/* Client-side prediction and server reconciliation (paper, "Working Around Lockstep Delay"; Figure 12).
 *
 * The predicted world is the server's latest snapshot plus the inputs that the snapshot does not include,
 * within the player's prediction scope. The client also keeps the checked world: the same without those
 * inputs. When a snapshot arrives, the client steps the checked world to the same tick with the same inputs
 * and guesses. If the entities in scope then agree with the snapshot (agree.h), the prediction stands and the
 * checked world continues from itself, so that the next comparison sees its whole error and errors never add
 * up unseen. Otherwise both worlds are rebuilt from the new snapshot. Cost: a step of the scope for each tick
 * between two snapshots, and one for each open input after a misprediction. */
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "netcode/client/agree.h"
#include "netcode/client/cheat.h"
#include "netcode/client/scope.h"
#include "netcode/protocol/report.h"
#include "netcode/state/client.h"

static const ll_prediction_scope *scope_of(const ll_client_setup *s)
{
    return ll_scopes[s->config->prediction_scope];
}

static uint8_t mark_of(const ll_client_setup *s)
{
    return (uint8_t)(1 + s->config->prediction_scope);
}

static void step(ll_client *c, const ll_client_setup *s, ll_world *world, const ll_action *own, int64_t tick)
{
    const ll_prediction_scope *scope = scope_of(s);
    if (c->self < LL_PEERS_MAX) /* with more players clients step their own alone */
        c->prediction.guessed[c->self] = *own;
    ll_scope_step one = {
        .actions = c->prediction.guessed, .own = own, .self = c->self, .set = &c->prediction.entities};
    if (scope->guesses)
        one.now = ll_client_step_time(c, tick);
    scope->step(s->game, s->env, world, &one);
    if (ll_cheat_moves(s->config))
        ll_cheat_move(c, s, &world->entity[c->self], tick);
}

/* The next step, with input `seq`; without an input where the clock has snapped beyond it. */
static ll_pending_input *predict_input(ll_client *c, const ll_client_setup *s, uint32_t seq)
{
    const ll_action none = {0};
    ll_pending_input *input = ll_client_pending(c, seq);
    bool made = input->seq == seq;
    step(c, s, ll_client_predicted(c), made ? &input->action : &none, ++c->prediction.tick);
    if (made)
        input->x = ll_client_predicted(c)->entity[c->self].x;
    return made ? input : NULL;
}

/* Time from a snapshot of `tick` to the client's newest input, and on until the next snapshot. Where inputs
 * are applied on arrival they have no ticks: the number of open inputs counts. */
static double horizon_from(const ll_client *c, const ll_client_setup *s, int64_t tick)
{
    int64_t ahead =
        s->sync->applies_on_arrival ? (int64_t)c->inputs.seq - c->inputs.acked : c->inputs.tick - tick;
    double horizon_s = (double)(ahead + 1) * s->env->dt;
    return c->latest.update_hz > 0 ? horizon_s + 1 / c->latest.update_hz : horizon_s;
}

/* The entities in scope for that time. */
static ll_entity_set entities_in_scope(const ll_client *c, const ll_client_setup *s, const ll_world *state,
                                       int64_t tick)
{
    ll_entity_set set = {{0}};
    scope_of(s)->choose(s->game, s->env, state, c->self, horizon_from(c, s, tick), &set);
    return set;
}

/* Records that the prediction agreed with a snapshot of `tick` on `grid`. */
static void record_agreement(ll_client *c, int64_t tick, const ll_quantization *grid)
{
    c->prediction.begun_tick = tick;
    c->prediction.begun_acked = c->inputs.acked;
    c->prediction.begun_grid = *grid;
    c->prediction.touched = 0;
}

static ll_quantization grid_of(const ll_client *c, const ll_snapshot_entry *state)
{
    return state->gridded ? c->snapshots.grid : (ll_quantization){0};
}

/* Copies the newest snapshot to the predicted or the checked world, whose content `holds` notes.
 * Others stay as they are there, if the scope does not step them. */
static void copy_snapshot(const ll_client *c, const ll_client_setup *s, int64_t *holds, ll_world *to,
                          const ll_world *newest)
{
    if (holds)
        ll_recent_copy(s->recent, holds, !scope_of(s)->guesses, to, newest);
    else
        memcpy(to, newest, (size_t)c->layout.world_size);
}

/* The predicted world becomes the latest snapshot. */
static void reset_to_snapshot(ll_client *c, const ll_client_setup *s)
{
    ll_quantization grid = c->snapshots.received > 0
                               ? grid_of(c, ll_client_state(c, c->snapshots.received - 1))
                               : (ll_quantization){0};
    copy_snapshot(c, s, s->recent ? &s->recent->predicted : NULL, ll_client_predicted(c),
                  ll_client_latest(c));
    copy_snapshot(c, s, s->recent ? &s->recent->checked : NULL, ll_client_checked(c), ll_client_latest(c));
    memcpy(c->prediction.guessed, c->latest.controls, sizeof c->prediction.guessed);
    c->prediction.entities = entities_in_scope(c, s, ll_client_latest(c), c->latest.tick);
    c->prediction.tick = c->latest.tick;
    record_agreement(c, c->latest.tick, &grid);
}

/* The newest input whose step has come: the client's present is `input_delay_ticks` before the tick of its
 * newest input, but not before the latest snapshot. */
static uint32_t newest_due(const ll_client *c, const ll_client_setup *s)
{
    uint32_t delay = s->sync->applies_on_arrival ? 0 : (uint32_t)s->config->input_delay_ticks;
    uint32_t due = c->inputs.seq > delay ? c->inputs.seq - delay : 0;
    return due > c->inputs.acked ? due : c->inputs.acked;
}

void ll_predict_pending_inputs(ll_client *c, const ll_client_setup *s)
{
    for (uint32_t due = newest_due(c, s); c->prediction.played < due;) {
        c->prediction.played++;
        predict_input(c, s, c->prediction.played);
    }
}

/* Inputs that belong to steps: one for each step after the snapshot, none where none was made. */
static void apply_by_step(ll_client *c, const ll_client_setup *s)
{
    const ll_action none = {0};
    int64_t newest = c->inputs.tick - (int64_t)(c->inputs.seq - c->prediction.played);
    while (c->prediction.tick < newest) {
        ll_pending_input *input = ll_client_input_at(c, c->prediction.tick + 1);
        step(c, s, ll_client_predicted(c), input ? &input->action : &none, ++c->prediction.tick);
        if (input)
            input->x = ll_client_predicted(c)->entity[c->self].x;
    }
}

/* Whether all inputs after the acknowledged one are open. Where inputs are applied on arrival, an input that
 * overtook another is not open: the snapshot has it, and the prediction applied it last. Inputs that an older
 * snapshot lacks but a newer one had are not open either: the prediction then lacks them, which the checked
 * world does not know. */
static bool all_are_open(ll_client *c, const ll_client_setup *s)
{
    for (uint32_t seq = c->inputs.acked + 1; s->sync->applies_on_arrival && seq <= c->prediction.played;
         seq++)
        if (!ll_client_is_open(c, seq))
            return false;
    return true;
}

void ll_resimulate(ll_client *c, const ll_client_setup *s)
{
    reset_to_snapshot(c, s);
    c->prediction.played = newest_due(c, s);
    c->prediction.gaps = !all_are_open(c, s);
    if (!s->sync->applies_on_arrival)
        apply_by_step(c, s);
    for (uint32_t seq = c->inputs.acked + 1; s->sync->applies_on_arrival && seq <= c->prediction.played;
         seq++)
        if (ll_client_is_open(c, seq))
            predict_input(c, s, seq);
}

static void forget(ll_client *c, const ll_client_setup *s)
{
    reset_to_snapshot(c, s);
    c->prediction.played = newest_due(c, s);
    c->prediction.gaps = c->prediction.played > c->inputs.acked;
}

static void replay(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_input_history *input_history = &s->client_metrics->input_history;
    ll_resimulate(c, s);
    if (now < s->client_metrics->from)
        return;
    input_history->replays++;
    input_history->replayed += c->prediction.played - c->inputs.acked;
}

static bool guessed_right(const ll_client *c, const ll_client_setup *s, int players)
{
    for (int i = 0; i < players && scope_of(s)->guesses; i++)
        if (i != c->self &&
            memcmp(&c->prediction.guessed[i], &c->latest.controls[i], sizeof c->latest.controls[i]) != 0)
            return false;
    return true;
}

/* Steps the checked world to `state` with the inputs of the prediction. False if the prediction was not made
 * with one input per step, which `acked`, the acknowledged input before, shows. */
static bool check_upto(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, uint32_t acked)
{
    const ll_action none = {0};
    int64_t steps =
        s->sync->applies_on_arrival ? (int64_t)c->inputs.acked - acked : state->tick - c->latest.tick;
    if (steps < 0 || steps > LL_PENDING_RING)
        return false;
    for (int64_t k = 1; k <= steps; k++) {
        const ll_pending_input *input = s->sync->applies_on_arrival
                                            ? ll_client_pending(c, acked + (uint32_t)k)
                                            : ll_client_input_at(c, c->latest.tick + k);
        step(c, s, ll_client_checked(c), input ? &input->action : &none, c->latest.tick + k);
    }
    return true;
}

/* Whether others may have acted on the own entity within `steps`. */
static bool may_be_touched(const ll_client *c, const ll_client_setup *s, const ll_world *world, int64_t steps)
{
    ll_entity_set set = {{0}}, alone = {{0}};
    if (!s->game->reach)
        return s->game->own_reads_world;
    ll_entity_set_add(&set, c->self);
    ll_entity_set_add(&alone, c->self);
    s->game->reach(world, s->env, (double)steps * s->env->dt, &set);
    return memcmp(&set, &alone, sizeof set) != 0;
}

static __attribute__((noinline)) bool agrees(ll_client *c, const ll_client_setup *s, const ll_world *checked,
                                             const ll_snapshot_entry *state)
{
    int64_t ticks = s->sync->applies_on_arrival ? (int64_t)c->inputs.acked - c->prediction.begun_acked
                                                : state->tick - c->prediction.begun_tick;
    if (scope_of(s)->guesses && (c->prediction.begun_grid.m > 0 || state->gridded))
        c->prediction.touched |=
            may_be_touched(c, s, checked, s->sync->applies_on_arrival ? ticks : state->tick - c->latest.tick);
    ll_agreement agreement = {.tolerance_m = s->config->reconciliation_tolerance_m,
                              .horizon_s = horizon_from(c, s, state->tick),
                              .drift_s = (double)ticks * s->env->dt,
                              .begun = c->prediction.begun_grid,
                              .state = grid_of(c, state),
                              .exact = c->prediction.touched ? -1 : c->self};
    return ll_agrees_in(&agreement, checked, (const ll_world *)(state + 1), &c->prediction.entities);
}

/* Whether the prediction agrees with `state`, which is about to become the latest snapshot. `acked` is the
 * input that was acknowledged before it. */
bool ll_prediction_stands(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state,
                          uint32_t acked)
{
    const ll_world *truth = (const ll_world *)(state + 1);
    ll_world *checked = ll_client_checked(c);
    ll_quantization grid = grid_of(c, state);
    if (c->predicting != mark_of(s) || !s->config->reconciliation || !scope_of(s)->closed(s->game) ||
        !guessed_right(c, s, truth->players) || c->prediction.gaps || !all_are_open(c, s) ||
        !check_upto(c, s, state, acked))
        return false;
    ll_entity_set set = entities_in_scope(c, s, truth, state->tick);
    if (memcmp(&set, &c->prediction.entities, sizeof set) != 0)
        return false;
    if (!ll_same_in(checked, truth, &set))
        return agrees(c, s, checked, state);
    /* entities out of scope come from the snapshot */
    copy_snapshot(c, s, s->recent ? &s->recent->checked : NULL, checked, truth);
    record_agreement(c, state->tick, &grid);
    return true;
}

/* Reports that were on their way when the client took the server's state are refused too. */
bool ll_report_stands(const ll_client *c, ll_reporter *reporter)
{
    if (ll_prediction_in_step(c) && reporter->refused <= reporter->corrected)
        return true;
    reporter->corrected = c->inputs.seq;
    return false;
}

/* The newest input that the latest snapshot decides. Before the server has received any input it reports
 * none; where inputs belong to steps the client still knows it. */
static uint32_t newest_decided(const ll_client *c, const ll_client_setup *s)
{
    int64_t seq =
        s->sync->applies_on_arrival ? 0 : (int64_t)c->inputs.seq - (c->inputs.tick - c->latest.tick);
    return seq > (int64_t)c->inputs.acked && seq <= (int64_t)c->inputs.seq ? (uint32_t)seq : c->inputs.acked;
}

/* Why the latest snapshot differs from the prediction made from the snapshot at `tick` with the inputs after
 * `acked`. */
static ll_cause cause_of(ll_client *c, const ll_client_setup *s, uint32_t acked, int64_t tick)
{
    uint32_t last = newest_decided(c, s);
    int64_t inputs = (int64_t)last - acked, steps = c->latest.tick - tick;
    if (s->reporter)
        return LL_CAUSE_REFUSED;
    if (!s->config->reconciliation || !(s->client_metrics->observes & LL_OBSERVE_INPUTS))
        return LL_CAUSE_OTHER;
    ll_cause cause = ll_input_history_blame(&s->client_metrics->input_history, acked + 1, last);
    if (cause != LL_CAUSE_OTHER)
        return cause;
    if (!s->sync->applies_on_arrival && acked > 0 && steps > inputs)
        return LL_CAUSE_LATE; /* there was no input to apply */
    return may_be_touched(c, s, ll_client_latest(c), steps) ? LL_CAUSE_CONTACT : LL_CAUSE_OTHER;
}

void ll_note_correction(const ll_client *c, const ll_client_setup *s, ll_cause cause, double moved,
                        ll_time now)
{
    ll_client_metrics *in = s->client_metrics;
    double size = moved < 0 ? -moved : moved;
    if (!(size >= 0))
        return; /* not finite: the next display ends the session */
    ll_measure(in, LL_METRIC_CORRECTION, now, size);
    if (now >= in->from)
        ll_input_history_correction(&in->input_history, cause, size);
    in->corrections.count += now >= in->from;
    in->last.correction = moved;
    if (s->recorder)
        s->recorder->record(s->recorder->context, &(ll_event){.type = LL_EVENT_CORRECTION,
                                                              .player = (uint8_t)c->self,
                                                              .begin = now,
                                                              .end = now,
                                                              .number = (uint32_t)c->latest.tick,
                                                              .value = (float)in->last.correction});
}

/* Reports to the view how far each entity in the old or new scope moved. Returns the distance of the own
 * entity, signed by x. The others' controls are guessed, and their positions affect only what is drawn. */
static double correct(ll_client *c, const ll_entity_set *set, const ll_entity *before)
{
    const ll_world *world = ll_client_predicted(c);
    double own = 0;
    const int end = ll_set_end(world);
    for (int i = 0; i < end; i++) {
        if (!ll_entity_set_has(set, i) || !ll_entity_set_has(&c->prediction.entities, i))
            continue;
        const ll_entity *after = &world->entity[i];
        double dx = after->x - before[i].x, dy = after->y - before[i].y, size = ll_sqrt(dx * dx + dy * dy);
        if (size == 0)
            continue;
        ll_smooth_correct(c, i, &before[i], after);
        if (i == c->self)
            own = dx < 0 ? -size : size;
    }
    return own;
}

/* With input delay the client's present may lie before the newest snapshot: the prediction is then first
 * stepped to the snapshot's tick, so that the predicted and the correct state are of one tick. */
static void reach_state(ll_client *c, const ll_client_setup *s)
{
    const ll_action none = {0};
    while (!s->sync->applies_on_arrival && c->prediction.tick < c->latest.tick) {
        const ll_pending_input *input = ll_client_input_at(c, c->prediction.tick + 1);
        step(c, s, ll_client_predicted(c), input ? &input->action : &none, ++c->prediction.tick);
    }
    if (c->prediction.played < c->inputs.acked)
        c->prediction.played = c->inputs.acked;
}

/* Where the clock has snapped since the last frame, the replay goes on to the step before the next input: the
 * prediction first makes those steps too, without inputs. */
static void reach_snap(ll_client *c, const ll_client_setup *s)
{
    const uint32_t delay = (uint32_t)s->config->input_delay_ticks;
    while (!s->sync->applies_on_arrival && c->prediction.played + delay < c->inputs.seq)
        predict_input(c, s, ++c->prediction.played);
}

/* Rebuilds the prediction from a snapshot that it does not agree with. */
static __attribute__((noinline)) void rebuild(ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_world *world = ll_client_predicted(c);
    ll_entity before[LL_TOUCHING_MAX];
    ll_entity_set set = c->prediction.entities;
    uint32_t acked = c->prediction.begun_acked;
    int64_t tick = c->prediction.begun_tick;
    memcpy(before, world->entity, (size_t)ll_set_end(world) * sizeof before[0]);
    if (s->config->reconciliation)
        replay(c, s, now);
    else
        forget(c, s); /* the paper's plain prediction: back to the server's state */
    double moved = correct(c, &set, before);
    if (moved != 0)
        ll_note_correction(c, s, cause_of(c, s, acked, tick), moved, now);
}

void ll_reconcile(ll_client *c, const ll_client_setup *s, bool stands, ll_time now)
{
    if (c->predicting != mark_of(s))
        return; /* it is about to start, from the same snapshot */
    if (s->config->reconciliation)
        reach_snap(c, s);
    if (s->config->input_delay_ticks > 0 && s->config->reconciliation)
        reach_state(c, s);
    if (!stands)
        rebuild(c, s, now);
}

void ll_draw_predicted(ll_client *c, ll_time now)
{
    const ll_world *world = ll_client_predicted(c);
    ll_time present = now;
    LL_VALIDATE(c->predicting > 0);
    if (ll_scopes[c->predicting - 1]->guesses)
        present = ll_client_step_time(c, c->prediction.tick);
    const ll_entity_set *set = &c->prediction.entities;
    const int end = ll_set_end(world);
    for (int i = ll_entity_set_next(set, 0, end); i < end; i = ll_entity_set_next(set, i + 1, end)) {
        ll_client_rendered(c)->entity[i] = world->entity[i];
        ll_client_draw_infos(c)[i] =
            (ll_draw_info){.time = i == c->self ? now : present, .flags = LL_RENDERED_PREDICTED};
    }
}

/* Prediction and reconciliation (paper, "Working Around Lockstep Delay"; Figure 12).
 *
 * The predicted world is the server's latest state with the inputs that it does not include applied on top,
 * in the player's prediction scope. When a state comes, the state before it is stepped to the same tick by
 * the same inputs and guesses. If what is in scope then equals the new state to the bit, the predicted world
 * is right as it stands; otherwise it is made again from the new state. Cost: a step of the scope for each
 * tick between two states, and one for each open input where something was mispredicted. */
#include <string.h>

#include "base/detmath.h"
#include "netcode/client.h"
#include "netcode/scope.h"

static const ll_scope *scope_of(const ll_client_setup *s)
{
    return ll_scopes[s->config->prediction_scope];
}

static uint8_t mark_of(const ll_client_setup *s)
{
    return (uint8_t)(1 + s->config->prediction_scope);
}

static void step(ll_client *c, const ll_client_setup *s, ll_world *world, const ll_action *own, int64_t tick)
{
    c->guessed[c->self] = *own;
    scope_of(s)->step(s->game, s->env, world, c->guessed, ll_client_step_time(c, tick), c->self,
                      &c->predicted);
}

/* The next step, by input `seq`; by none where the clock has snapped beyond it. */
static ll_pending *predict_input(ll_client *c, const ll_client_setup *s, uint32_t seq)
{
    const ll_action none = {0};
    ll_pending *input = ll_client_pending(c, seq);
    bool made = input->seq == seq;
    step(c, s, ll_client_predicted(c), made ? &input->action : &none, ++c->predicted_tick);
    if (made)
        input->x = ll_client_predicted(c)->entity[c->self].x;
    return made ? input : NULL;
}

/* What is in scope from a state at `tick` to the client's newest input, and on until the next state. */
static ll_entity_set choose(const ll_client *c, const ll_client_setup *s, const ll_world *state, int64_t tick)
{
    ll_entity_set set = {{0}};
    double horizon_s = (double)(c->tick - tick + 1) * s->env->dt;
    if (c->update_hz > 0)
        horizon_s += 1 / c->update_hz;
    scope_of(s)->choose(s->game, s->env, state, c->self, horizon_s, &set);
    return set;
}

/* The predicted world is the latest state. */
static void begin(ll_client *c, const ll_client_setup *s)
{
    memcpy(ll_client_predicted(c), ll_client_latest(c), (size_t)c->world_size);
    memcpy(c->guessed, c->told, sizeof c->guessed);
    c->predicted = choose(c, s, ll_client_latest(c), c->latest_tick);
    c->predicted_tick = c->latest_tick;
}

/* The newest input whose time has come: the client's present lies `input_delay_ticks` before the tick of its
 * newest, but not before the latest state. */
static uint32_t newest_due(const ll_client *c, const ll_client_setup *s)
{
    uint32_t delay = s->sync->drains ? 0 : (uint32_t)s->config->input_delay_ticks;
    uint32_t due = c->seq > delay ? c->seq - delay : 0;
    return due > c->acked ? due : c->acked;
}

void ll_predict_due(ll_client *c, const ll_client_setup *s)
{
    for (uint32_t due = newest_due(c, s); c->played < due;) {
        c->played++;
        predict_input(c, s, c->played);
    }
}

/* Inputs that belong to steps: one for each step behind the state, none where none was made. */
static void apply_by_step(ll_client *c, const ll_client_setup *s)
{
    const ll_action none = {0};
    int64_t newest = c->tick - (int64_t)(c->seq - c->played);
    while (c->predicted_tick < newest) {
        ll_pending *input = ll_client_input_at(c, c->predicted_tick + 1);
        step(c, s, ll_client_predicted(c), input ? &input->action : &none, ++c->predicted_tick);
        if (input)
            input->x = ll_client_predicted(c)->entity[c->self].x;
    }
}

void ll_predict_again(ll_client *c, const ll_client_setup *s)
{
    begin(c, s);
    c->played = newest_due(c, s);
    if (!s->sync->drains)
        apply_by_step(c, s);
    for (uint32_t seq = c->acked + 1; s->sync->drains && seq <= c->played; seq++)
        if (ll_client_is_open(c, seq))
            predict_input(c, s, seq);
}

static void forget(ll_client *c, const ll_client_setup *s)
{
    begin(c, s);
    c->played = newest_due(c, s);
}

static void replay(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_ledger *ledger = &s->instruments->ledger;
    ll_predict_again(c, s);
    if (now < s->instruments->from)
        return;
    ledger->replays++;
    ledger->replayed += c->played - c->acked;
}

static bool guessed_right(const ll_client *c, const ll_client_setup *s, int players)
{
    for (int i = 0; i < players && scope_of(s)->guesses; i++)
        if (i != c->self && memcmp(&c->guessed[i], &c->told[i], sizeof c->told[i]) != 0)
            return false;
    return true;
}

static bool same_in_scope(const ll_client *c, const ll_world *a, const ll_world *b)
{
    for (int i = 0; i < a->entities; i++)
        if (ll_entity_set_has(&c->predicted, i) &&
            memcmp(&a->entity[i], &b->entity[i], sizeof a->entity[i]) != 0)
            return false;
    return true;
}

/* Whether `state` is what the prediction was made of. `acked` is what had been acknowledged before it; steps
 * the latest state, which is about to be replaced. */
bool ll_foretold(ll_client *c, const ll_client_setup *s, const ll_received *state, uint32_t acked)
{
    const ll_action none = {0};
    const ll_world *truth = (const ll_world *)(state + 1);
    ll_world *world = ll_client_latest(c);
    int64_t steps = s->sync->drains ? (int64_t)c->acked - acked : state->tick - c->latest_tick;
    if (c->predicting != mark_of(s) || !s->config->reconciliation || s->game->own_reads_world ||
        !guessed_right(c, s, world->players) || steps < 0 || steps > LL_PENDING_RING)
        return false;
    for (int64_t k = 1; k <= steps; k++) {
        const ll_pending *input = s->sync->drains ? ll_client_pending(c, acked + (uint32_t)k)
                                                  : ll_client_input_at(c, c->latest_tick + k);
        step(c, s, world, input ? &input->action : &none, c->latest_tick + k);
    }
    ll_entity_set set = choose(c, s, truth, state->tick);
    return memcmp(&set, &c->predicted, sizeof set) == 0 && same_in_scope(c, world, truth);
}

/* Others may have acted on the own entity within `steps`. */
static bool touched(const ll_client *c, const ll_client_setup *s, const ll_world *world, int64_t steps)
{
    ll_entity_set set = {{0}}, alone = {{0}};
    if (!s->game->reach)
        return s->game->own_reads_world;
    ll_entity_set_add(&set, c->self);
    ll_entity_set_add(&alone, c->self);
    s->game->reach(world, s->env, (double)steps * s->env->dt, &set);
    return memcmp(&set, &alone, sizeof set) != 0;
}

/* Why the latest state differs from the one at `tick` and the inputs behind `acked`. */
static ll_cause cause_of(ll_client *c, const ll_client_setup *s, uint32_t acked, int64_t tick)
{
    int64_t inputs = (int64_t)c->acked - acked, steps = c->latest_tick - tick;
    if (!s->config->reconciliation)
        return LL_CAUSE_OTHER;
    ll_cause cause = ll_ledger_blame(&s->instruments->ledger, acked + 1, c->acked);
    if (cause != LL_CAUSE_OTHER)
        return cause;
    if (!s->sync->drains && acked > 0 && steps > inputs)
        return LL_CAUSE_LATE; /* there was none to be applied */
    return touched(c, s, ll_client_latest(c), steps) ? LL_CAUSE_CONTACT : LL_CAUSE_OTHER;
}

void ll_note_correction(const ll_client *c, const ll_client_setup *s, ll_cause cause, double moved,
                        ll_time now)
{
    ll_instruments *in = s->instruments;
    double size = moved < 0 ? -moved : moved;
    ll_measure(in, LL_METRIC_CORRECTION, now, size);
    if (now >= in->from)
        ll_ledger_correction(&in->ledger, cause, size);
    in->corrections += now >= in->from;
    in->last_correction = moved;
    if (s->recorder)
        s->recorder->record(s->recorder->context, &(ll_event){.type = LL_EVENT_CORRECTION,
                                                              .player = (uint8_t)c->self,
                                                              .begin = now,
                                                              .end = now,
                                                              .number = (uint32_t)c->latest_tick,
                                                              .value = (float)in->last_correction});
}

/* How far each entity that was and is in scope moved: the view learns of it. Returns the own entity's, signed
 * by x; others are guessed, and nobody acts by their place but the eye. */
static double correct(ll_client *c, const ll_entity_set *set, const ll_entity *before)
{
    const ll_world *world = ll_client_predicted(c);
    double own = 0;
    for (int i = 0; i < world->entities; i++) {
        const ll_entity *after = &world->entity[i];
        double dx = after->x - before[i].x, dy = after->y - before[i].y, size = ll_sqrt(dx * dx + dy * dy);
        if (size == 0 || !ll_entity_set_has(set, i) || !ll_entity_set_has(&c->predicted, i))
            continue;
        ll_smooth_correct(c, i, &before[i], after);
        if (i == c->self)
            own = dx < 0 ? -size : size;
    }
    return own;
}

/* `acked` and `tick` are what was acknowledged by, and the tick of, the state before the latest. */
void ll_reconcile(ll_client *c, const ll_client_setup *s, bool foretold, uint32_t acked, int64_t tick,
                  ll_time now)
{
    const ll_world *world = ll_client_predicted(c);
    ll_entity before[LL_ENTITIES_MAX];
    ll_entity_set set = c->predicted;
    if (c->predicting != mark_of(s))
        return; /* it is about to start, from the same state */
    if (foretold && c->played >= c->acked)
        return; /* the prediction stands */
    memcpy(before, world->entity, (size_t)world->entities * sizeof before[0]);
    if (s->config->reconciliation)
        replay(c, s, now);
    else
        forget(c, s); /* the paper's plain prediction: back to what the server says */
    double moved = correct(c, &set, before);
    if (moved != 0)
        ll_note_correction(c, s, cause_of(c, s, acked, tick), moved, now);
}

void ll_draw_predicted(ll_client *c, ll_time now)
{
    const ll_world *world = ll_client_predicted(c);
    ll_time present = ll_client_step_time(c, c->predicted_tick);
    for (int i = 0; i < world->entities; i++) {
        if (!ll_entity_set_has(&c->predicted, i))
            continue;
        ll_client_shown(c)->entity[i] = world->entity[i];
        ll_client_marks(c)[i] = (ll_mark){.time = i == c->self ? now : present, .flags = LL_SHOWN_PREDICTED};
    }
}

/* A tick of a client: it reads the controls, makes inputs of them, and composes the packet to send. */
#include <string.h>

#include "base/assert.h"
#include "base/rng.h"
#include "netcode/client/ack.h"
#include "netcode/client/cheat.h"
#include "netcode/client/scope.h"
#include "netcode/protocol/limits.h"
#include "netcode/protocol/report.h"
#include "netcode/state/client.h"

#define FAKED_VIEW (500 * LL_MS)

/* The controls of a client that fakes its view time: it acts on the snapshot of an earlier time, `seen`, with
 * its own entity as it is now. */
static __attribute__((noinline)) ll_action act_on_the_past(ll_client *c, const ll_client_setup *s,
                                                           ll_time *seen, ll_time now)
{
    int64_t oldest = ll_client_oldest(c), i = c->snapshots.received - 1;
    _Alignas(8) char bytes[LL_GAME_WORLD_MAX];
    ll_world *old = (ll_world *)(void *)bytes;
    while (i > oldest && ll_client_state(c, i)->time > c->drawing.view_time - FAKED_VIEW)
        i--;
    *seen = ll_client_state(c, i)->time;
    memcpy(old, ll_snapshot_entry_world(ll_client_state(c, i)), (size_t)c->layout.world_size);
    old->entity[c->self] = ll_client_rendered(c)->entity[c->self];
    return ll_client_control(c, s, old, now);
}

/* The controls of a player who acts on the rendered view, or on an older one; `seen`: its time. */
static inline ll_action act(ll_client *c, const ll_client_setup *s, ll_time *seen, ll_time now)
{
    *seen = c->drawing.view_time;
    if (s->config->cheat == LL_CHEAT_VIEW_TIME && c->snapshots.received > 0)
        return act_on_the_past(c, s, seen, now);
    return ll_client_control(c, s, ll_client_rendered(c), now);
}

/* Whether the duration of a key press counts. */
static bool counts_time(const ll_client_setup *s)
{
    return s->sync->press_s != 0 && s->config->timer_jitter_ms > 0;
}

static double ticks_pressed(const ll_client *c)
{
    return (double)c->ticks.elapsed / (double)c->ticks.period;
}

static ll_action for_its_time(const ll_client *c, const ll_client_setup *s, ll_action a)
{
    if (counts_time(s)) {
        a.axis[0] = (float)(a.axis[0] * ticks_pressed(c));
        a.axis[1] = (float)(a.axis[1] * ticks_pressed(c));
    }
    return a;
}

#define DEVICE_STREAM 0x646576696365 /* `device`; one per player */

ll_time ll_client_control_time(const ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_player_config *config = s->config;
    const double slowest_hz = 1e-3; /* as of all rates: nearer to 0 the wait is no number of ns */
    double read_hz = config->input_hz > slowest_hz ? config->input_hz : slowest_hz;
    double read_ms = config->input_hz > 0 ? 1e3 / read_hz : 0;
    if (read_ms > 0)
        read_ms *=
            ll_rng_unit(s->seed, DEVICE_STREAM + (uint64_t)c->self, (uint64_t)c->epoch << 32 | c->inputs.seq);
    return now - ll_ms(config->input_device_ms + read_ms);
}

void ll_client_miss(const ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_client_control(c, s, ll_client_rendered_const(c), now);
    ll_client_metrics_missed(s->client_metrics, &s->client_metrics->controls, now);
}

static ll_action ask_script(const ll_client *c, const ll_client_setup *s, const ll_world *seen, ll_time t)
{
    const ll_script script = (ll_script)s->config->script;
    ll_action a = s->game->drive(seen, s->env, s->seed, c->self, script, t);
    if (s->memo && s->game->same_until)
        *s->memo = (ll_script_memo){t, s->game->same_until(s->env, s->seed, c->self, script, t), a};
    return a;
}

/* What the server gets instead of the player's controls `a`. */
static __attribute__((noinline)) ll_action cheated(const ll_client *c, const ll_client_setup *s,
                                                   const ll_world *seen, ll_time t, ll_action a)
{
    ll_cheat_action(c, s, &a);
    if (s->config->cheat == LL_CHEAT_AIM_BOT)
        ll_cheat_aim(c, s, seen, t, &a);
    return for_its_time(c, s, a);
}

ll_action ll_client_control(const ll_client *c, const ll_client_setup *s, const ll_world *seen, ll_time t)
{
    const ll_player_config *config = s->config;
    ll_action a = c->inputs.held;
    if (config->control == LL_CONTROL_SCRIPT)
        a = s->memo && t >= s->memo->from && t < s->memo->until ? s->memo->action : ask_script(c, s, seen, t);
    s->client_metrics->controls = a;
    const ll_action honest = for_its_time(c, s, a);
    ll_honest_controls(&s->client_metrics->honest, &honest);
    return config->cheat == LL_CHEAT_NONE ? honest : cheated(c, s, seen, t, a);
}

/* The same of a usual client: a script plays it. */
static inline ll_action act_usually(ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_script_memo *memo = s->memo;
    const ll_action a =
        now >= memo->from && now < memo->until ? memo->action : ask_script(c, s, ll_client_rendered(c), now);
    s->client_metrics->controls = a;
    ll_honest_controls(&s->client_metrics->honest, &a);
    return a;
}

#define QUIET 4 /* intervals without a step: some player's inputs are missing */

/* Number of inputs that a client may make while the server waits for inputs. Inputs that the server would
 * refuse as too far ahead are not sent. While no step is made, it is the number that fits into the round
 * trip: enough to continue at the full rate, and no more, because inputs made beyond that stay late for
 * good. */
static __attribute__((noinline)) int64_t inputs_allowed(const ll_client *c, const ll_client_setup *s,
                                                        ll_time now)
{
    int64_t ahead = c->inputs.tick - c->snapshots.confirmed;
    ll_time last_arrival =
        c->arrivals.last < 0 ? 0
                             : c->arrivals.last; /* before the first snapshot: the time of step 0, at once */
    if (s->sync->answers)
        return ahead == 0;
    if (now - last_arrival > QUIET * c->ticks.period)
        return ll_clock_sync_round_trip(&c->connection.clock) / c->ticks.period + QUIET - ahead;
    return ll_budget_ticks(c->ticks.clock.freq) - 1 - ahead;
}

static __attribute__((always_inline)) inline int
inputs_due(ll_client *c, const ll_client_setup *s, const ll_action *action, ll_time now, const bool usual)
{
    ll_input_history *input_history = &s->client_metrics->input_history;
    const bool counts = (s->client_metrics->observes & LL_OBSERVE_INPUTS) && now >= s->client_metrics->from;
    int n = 1;
    if (usual)
        n += (int)c->ticks.skipped;
    else
        n += ll_cheat_extra(c, s);
    if (!usual && !s->sync->applies_on_arrival)
        n += (int)c->ticks.skipped;
    if (!usual && !s->sync->sends_idle && action->axis[0] == 0 && action->axis[1] == 0 &&
        action->buttons == 0) {
        ll_changes_idle(&s->client_metrics->changes);
        return 0;
    }
    if (__builtin_expect(c->inputs.extra > 0, 0)) {
        c->inputs.extra--;
        input_history->doubled += counts;
        n++;
    } else if (__builtin_expect(c->inputs.extra < 0, 0)) {
        c->inputs.extra++;
        input_history->left_out += counts;
        n--;
    }
    if (counts)
        ll_running_stats_add(&input_history->scale, c->inputs.scale);
    if (usual)
        return n;
    int64_t room = s->sync->waits ? inputs_allowed(c, s, now) : n;
    return (int)(n < room ? n : room > 0 ? room : 0);
}

static uint32_t age_ns(ll_time age)
{
    return age < 0 ? 0 : age > UINT32_MAX ? UINT32_MAX : (uint32_t)age;
}

/* Records the player's controls, without the duration of the key press. */
static void note_input(const ll_client *c, const ll_client_setup *s, const ll_action *action, ll_time now)
{
    ll_action controls = *action;
    if (!(s->client_metrics->observes & LL_OBSERVE_INPUTS))
        return;
    if (counts_time(s)) {
        controls.axis[0] = (float)(controls.axis[0] / ticks_pressed(c));
        controls.axis[1] = (float)(controls.axis[1] / ticks_pressed(c));
    }
    ll_client_metrics_input(s->client_metrics, c->inputs.seq,
                            s->sync->applies_on_arrival ? LL_NEVER : c->inputs.tick, &controls,
                            ll_client_control_time(c, s, now), now);
}

static __attribute__((always_inline)) inline void make_input(ll_client *c, const ll_client_setup *s,
                                                             const ll_action *action, ll_time seen,
                                                             ll_time now, const bool usual)
{
    ll_pending_input *p = ll_client_pending(c, ++c->inputs.seq);
    c->inputs.tick++;
    if (c->inputs.seq - c->inputs.acked > LL_PENDING_RING)
        c->inputs.acked = c->inputs.seq - LL_PENDING_RING; /* the oldest is dropped */
    LL_ASSERT(c->inputs.acked < c->inputs.seq && c->inputs.newest_sent < c->inputs.seq);
    note_input(c, s, action, now);
    *p = (ll_pending_input){.seq = c->inputs.seq, .made = now, .action = *action};
    p->action.view_age_ns =
        age_ns((!usual && s->sync->applies_on_arrival ? now : ll_client_step_time(c, c->inputs.tick)) - seen);
    if (!usual && s->weapon_prediction)
        ll_weapon_prediction_input(c, s, p, seen, now);
    if (s->config->prediction)
        ll_predict_pending_inputs(c, s);
}

/* Number of steps from the newest snapshot that the client has to `tick`; 0: it has none. */
static uint16_t snapshot_age_of(const ll_client *c, const ll_client_setup *s, int64_t tick)
{
    int64_t lead = tick - c->snapshots.newest_tick;
    return c->snapshots.received == 0 || s->sync->applies_on_arrival || lead < 0 || lead > UINT16_MAX
               ? 0
               : (uint16_t)lead;
}

/* Adds which snapshots have come, of those that contain only some of the entities. Returns its size. */
static __attribute__((noinline)) int put_received(const ll_client *c, ll_input_message *m, int count)
{
    const ll_snapshot_entry *newest = ll_client_state((ll_client *)c, c->snapshots.received - 1);
    if (m->lead == 0 || !newest->selected)
        return 0;
    m->wants |= LL_PART_RECEIVED;
    memcpy((char *)m + ll_input_message_size(count), &newest->before, sizeof newest->before);
    return (int)sizeof newest->before;
}

/* Adds the own entity after the newest input, if that is the last of the message and the client has predicted
 * it. Returns its size. */
static __attribute__((noinline)) int put_state(const ll_client *c, ll_input_message *m, int size)
{
    const ll_world *world = ll_client_predicted((ll_client *)(uintptr_t)c);
    const ll_motion state = ll_motion_of(&world->entity[c->self]);
    const uint32_t last = m->head.seq + m->head.count - 1;
    if (!ll_prediction_in_step(c) || last != c->inputs.seq || c->prediction.played != last)
        return 0;
    m->wants |= LL_PART_STATE;
    memcpy((char *)m + size, &state, sizeof state);
    return (int)sizeof state;
}

static __attribute__((always_inline)) inline int put(const ll_client *c, const ll_client_setup *s,
                                                     uint32_t first, uint32_t count, uint32_t fresh,
                                                     ll_input_message *m, const bool usual)
{
    const ll_pending_input *pending = c->pending;
    LL_ASSERT(count <= LL_INPUTS_MAX && first + count <= c->inputs.seq + 1);
    m->head = (ll_message_head){LL_MESSAGE_INPUT, (uint8_t)count, c->epoch, first};
    m->tick = (int32_t)(c->inputs.tick - (int64_t)(c->inputs.seq - first));
    m->fresh = (uint8_t)(fresh < count ? fresh : count);
    m->wants = (uint8_t)ll_acks[s->config->ack]->wants;
    if (s->config->prediction && ll_scopes[s->config->prediction_scope]->guesses)
        m->wants |= LL_PART_AXES;
    m->lead = snapshot_age_of(c, s, m->tick);
    for (uint32_t i = 0; i < count; i++)
        m->inputs[i] = pending[(first + i) & (LL_PENDING_RING - 1)].action;
    if (usual)
        return ll_input_message_size((int)count);
    int size = ll_input_message_size((int)count) + (s->selects ? put_received(c, m, (int)count) : 0);
    return s->reporter ? size + put_state(c, m, size) : size;
}

static __attribute__((noinline)) int put_inputs(const ll_client *c, const ll_client_setup *s, uint32_t first,
                                                uint32_t count, uint32_t fresh, ll_input_message *m)
{
    return put(c, s, first, count, fresh, m, false);
}

__attribute__((noinline)) int ll_client_held(ll_client *c, const ll_client_setup *s, ll_time now,
                                             void *packet)
{
    if (c->inputs.unsent == 0 || ll_cheat_holds(s, now))
        return 0;
    uint32_t first = c->inputs.unsent, count = c->inputs.seq - first + 1;
    if (count > LL_INPUTS_MAX)
        count = LL_INPUTS_MAX;
    c->inputs.unsent = first + count <= c->inputs.seq ? first + count : 0;
    return put_inputs(c, s, first, count, count, packet);
}

/* Whether a packet is to be sent with this tick. */
static bool sends_now(const ll_client *c, const ll_client_setup *s)
{
    if (s->config->send_hz == 0 || s->sync->waits)
        return true;
    ll_freq freq = ll_freq_from_hz(s->config->send_hz);
    if (freq >= c->ticks.clock.freq)
        return true;
    return c->ticks.number * freq / c->ticks.clock.freq != (c->ticks.number - 1) * freq / c->ticks.clock.freq;
}

/* Whether the answer to the oldest open input is overdue. */
static bool overdue(const ll_client *c, ll_time now)
{
    const ll_pending_input *oldest = &c->pending[(c->inputs.acked + 1) & (LL_PENDING_RING - 1)];
    return now - oldest->made > ll_clock_sync_round_trip(&c->connection.clock) + QUIET * c->ticks.period;
}

/* A packet holds a run of inputs up to the newest. Where the server waits for each input, more are open than
 * a packet holds, and the oldest is overdue, every other packet instead holds older inputs, from the oldest
 * open one on, in turn. */
static int compose(ll_client *c, const ll_client_setup *s, ll_time now, ll_input_message *m)
{
    uint32_t open = c->inputs.seq - c->inputs.acked, fresh = c->inputs.seq - c->inputs.newest_sent;
    if (ll_cheat_holds(s, now) && c->inputs.unsent == 0 && fresh > 0)
        c->inputs.unsent = c->inputs.newest_sent + 1;
    if (fresh > 0 && sends_now(c, s))
        c->inputs.newest_sent = c->inputs.seq;
    else if (!s->sync->waits)
        return 0;
    if (c->inputs.unsent != 0)
        return ll_client_held(c, s, now, m);
    if (open < fresh && !s->sync->waits)
        open = fresh; /* even if too late: the server reports by how much */
    if (open > c->inputs.seq + 1 - c->inputs.run)
        open = c->inputs.seq + 1 - c->inputs.run;
    if (open == 0)
        return 0;
    uint32_t wanted = s->sync->waits ? LL_INPUTS_MAX : fresh + (uint32_t)s->config->redundancy;
    uint32_t count = wanted < open ? wanted : open;
    if (count > LL_INPUTS_MAX)
        count = LL_INPUTS_MAX;
    uint32_t first = c->inputs.seq - count + 1;
    if (s->sync->waits && open > count && (c->ticks.number & 1) && overdue(c, now)) {
        uint32_t turns = (open - 1) / count;
        first = c->inputs.acked + 1 + (uint32_t)(c->ticks.number / 2) % turns * count;
        c->inputs.newest_sent -= fresh; /* the next packet sends them */
        fresh = 0;
    }
    return put_inputs(c, s, first, count, fresh, m);
}

/* The same of a usual client. */
static inline int compose_usually(ll_client *c, const ll_client_setup *s, ll_time now, ll_input_message *m)
{
    const uint32_t seq = c->inputs.seq, fresh = seq - c->inputs.newest_sent, run = seq + 1 - c->inputs.run;
    uint32_t open = seq - c->inputs.acked;
    if (fresh == 0)
        return 0;
    c->inputs.newest_sent = seq;
    if (c->inputs.unsent != 0) /* of a lag switch until now */
        return ll_client_held(c, s, now, m);
    if (open < fresh)
        open = fresh; /* even if too late: the server reports by how much */
    if (open > run)
        open = run;
    if (open == 0)
        return 0;
    const uint32_t wanted = fresh + (uint32_t)s->config->redundancy;
    uint32_t count = wanted < open ? wanted : open;
    if (count > LL_INPUTS_MAX)
        count = LL_INPUTS_MAX;
    return put(c, s, seq - count + 1, count, fresh, m, true);
}

static __attribute__((always_inline)) inline int tick(ll_client *c, const ll_client_setup *s, ll_time now,
                                                      void *packet, const bool usual)
{
    ll_client_begin_tick(c, now);
    ll_client_apply_newest(c, s, now);
    if (!ll_connection_plays(&c->connection)) {
        c->inputs.tick += s->sync->client_runs_ahead; /* the clock continues */
        ll_client_miss(c, s, now);
        return 0;
    }
    ll_time seen = c->drawing.view_time;
    const ll_action action = usual ? act_usually(c, s, now) : act(c, s, &seen, now);
    for (int made = inputs_due(c, s, &action, now, usual); made > 0; made--)
        make_input(c, s, &action, seen, now, usual);
    if (s->client_metrics->observes & LL_OBSERVE_FRAMES)
        ll_measure(s->client_metrics, LL_METRIC_UNACKED, now, (double)(c->inputs.seq - c->inputs.acked));
    return usual ? compose_usually(c, s, now, packet) : compose(c, s, now, packet);
}

int ll_client_usual_tick(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
{
    return tick(c, s, now, packet, true);
}

int ll_client_tick(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
{
    return tick(c, s, now, packet, false);
}

bool ll_client_is_usual(const ll_client_setup *s)
{
    const ll_sync_mode *sync = s->sync;
    const ll_player_config *config = s->config;
    return sync->tick == ll_client_tick && sync->display == ll_client_display && !sync->applies_on_arrival &&
           sync->press_s == 0 && !sync->waits && !sync->answers && sync->sends_idle && !sync->observe &&
           config->control == LL_CONTROL_SCRIPT && config->cheat == LL_CHEAT_NONE && config->send_hz == 0 &&
           config->timer_jitter_ms == 0 && config->drift_ppm == 0 &&
           (s->rules->timeout_s == 0 || s->rules->timeout_s >= LL_NOTICE / 1e9) && s->memo &&
           !s->weapon_prediction && !s->reckoning && !s->reporter && !s->recent && !s->selects;
}

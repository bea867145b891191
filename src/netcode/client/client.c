#include "netcode/state/client.h"

#include <string.h>

#include "base/assert.h"
#include "base/rng.h"
#include "netcode/client/ack.h"
#include "netcode/client/cheat.h"
#include "netcode/client/scope.h"
#include "netcode/protocol/limits.h"
#include "netcode/snapshot/snapshot.h"
#include "netcode/state/peer.h"

static size_t round8(size_t n)
{
    return (n + 7) & ~(size_t)7;
}

/* The worlds latest, predicted, checked and shown, the draw infos and the view errors; then the snapshots, or
 * the peer of a peer-to-peer sync. */
size_t ll_client_size(ll_extent extent)
{
    size_t world = ll_extent_size(extent), states = LL_STATE_RING * (sizeof(ll_snapshot_entry) + world);
    size_t peer = ll_peer_size(extent.entities < LL_PLAYERS_MAX ? extent.entities : LL_PLAYERS_MAX, world);
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

void ll_client_start(ll_client *c, const ll_client_setup *s, uint16_t epoch, ll_freq freq, int64_t step,
                     const ll_world *world, ll_time now)
{
    ll_connection *n = &c->connection;
    bool in = n->state != LL_CONNECTION_CONNECTING && n->state != LL_CONNECTION_DISCONNECTED;
    start_clocks(c, s, freq, now);
    c->inputs.tick = step;
    n->epoch = in ? epoch : n->epoch;
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
    if (s->sync->start)
        s->sync->start(c, s, step, step, world);
}

#define SPARE_WINDOW (2 * LL_SECOND)

/* Keeps the client as far ahead of the server as the reported slack asks: at once when inputs come too late;
 * slowly, by the least slack of two seconds, when they come earlier than wanted. Waits for the effect of a
 * change before the next one. */
static void follow_slack(ll_client *c, const ll_client_setup *s, const ll_snapshot_message *m, ll_time now)
{
    ll_client_inputs *in = &c->inputs;
    if (m->slack == LL_SLACK_UNKNOWN || m->slack_seq < in->settle)
        return;
    int32_t want = (int32_t)s->config->slack_ticks, change = 0;
    if (in->least_slack == LL_SLACK_UNKNOWN)
        in->least_slack_since = now;
    if (m->slack < in->least_slack)
        in->least_slack = m->slack;
    if (m->slack < want)
        change = want - m->slack;
    else if (now - in->least_slack_since < SPARE_WINDOW)
        return;
    else if (in->least_slack > want + 1)
        change = want - in->least_slack;
    in->least_slack = LL_SLACK_UNKNOWN;
    if (change == 0)
        return;
    if (change * c->ticks.period >= LL_CLOCK_SNAP) {
        ll_client_snap(c, in->tick + change);
        return;
    }
    in->extra += change;
    in->settle = in->seq + (uint32_t)(change > 0 ? 2 * change : 0) +
                 1; /* first input made after the change is complete */
}

#define SURPLUS_WINDOW (LL_SECOND / 2)

#define SURPLUS 1 /* one interval early is in time: the server steps one interval after the last input */

/* Where the server waits for inputs: inputs of this client that always come before they are needed only wait
 * in the server's queue. Skips as many inputs as the least early one of half a second was early. */
static void drain_surplus(ll_client *c, const ll_snapshot_message *m, ll_time now)
{
    ll_client_inputs *in = &c->inputs;
    if (m->slack == LL_SLACK_UNKNOWN || m->slack_seq < in->settle)
        return;
    if (in->least_slack == LL_SLACK_UNKNOWN)
        in->least_slack_since = now;
    if (m->slack < in->least_slack)
        in->least_slack = m->slack;
    if (now - in->least_slack_since < SURPLUS_WINDOW)
        return;
    if (in->least_slack > SURPLUS) {
        in->extra -= in->least_slack - SURPLUS;
        in->settle = in->seq + 1;
    }
    in->least_slack = LL_SLACK_UNKNOWN;
}

/* Bytes between the header of a snapshot message and its world; more than `size` if they are missing. */
static int parts_size(const ll_client *c, const ll_snapshot_message *m, const char *packet, int size)
{
    int others = ll_client_rendered_const(c)->players - 1;
    int bytes = m->head.count & LL_PART_AXES ? others * (int)sizeof(ll_axes) : 0;
    ll_input_result_part part;
    if (!(m->head.count & LL_PART_APPLIED))
        return bytes;
    if ((int)sizeof *m + bytes + (int)sizeof part > size)
        return size;
    memcpy(&part, packet + sizeof *m + bytes, sizeof part);
    if (part.words > LL_INPUT_RESULT_WORDS_MAX)
        return size;
    return bytes + (int)sizeof part + (int)(part.words * sizeof(uint32_t));
}

/* Reads those parts. */
static void take_parts(ll_client *c, const ll_snapshot_message *m, const char *at)
{
    int players = ll_client_latest(c)->players;
    c->results.parts = m->head.count;
    for (int i = 0; i < players && c->results.parts & LL_PART_AXES; i++) {
        ll_axes axes;
        if (i == c->self)
            continue;
        memcpy(&axes, at, sizeof axes);
        at += sizeof axes;
        c->latest.controls[i] = (ll_action){.axis = {axes.axis[0], axes.axis[1]}};
    }
    if (!(c->results.parts & LL_PART_APPLIED))
        return;
    memcpy(&c->results.head, at, sizeof c->results.head);
    memcpy(c->results.applied, at + sizeof c->results.head, c->results.head.words * sizeof(uint32_t));
}

static int unreadable(ll_client *c)
{
    c->snapshots.unreadable++;
    return LL_OUTCOME_UNDECODABLE;
}

static int receive_state(ll_client *c, const ll_client_setup *s, const char *packet, int size, ll_time now)
{
    _Alignas(8) char bytes[LL_GAME_WORLD_MAX];
    ll_snapshot_message m;
    if (size < (int)sizeof m)
        return unreadable(c);
    memcpy(&m, packet, sizeof m);
    int start = (int)sizeof m + parts_size(c, &m, packet, size);
    if (size < start)
        return unreadable(c);
    if (s->sync->drops_stale && m.tick <= c->snapshots.newest_tick) {
        c->snapshots.stale++;
        return LL_OUTCOME_STALE;
    }
    ll_status status = ll_client_decode(c, &m, packet + start, size - start, (ll_world *)(void *)bytes);
    if (ll_failed(&status))
        return unreadable(c);
    ll_snapshot_entry *r = ll_client_state(c, c->snapshots.received++);
    *r = (ll_snapshot_entry){m.tick, m.time, now, m.head.seq, m.applied, ll_codec_at(m.codec)->gridded, 0};
    take_parts(c, &m, packet + sizeof m);
    memcpy(ll_snapshot_entry_world(r), bytes, (size_t)c->layout.world_size);
    c->snapshots.newest_tick = m.tick;
    c->snapshots.confirmed = m.tick;
    c->latest.update_hz = (double)m.update_hz;
    ll_interpolate_heard(c, r);
    if (s->sync->answers)
        c->ticks.due = now;
    if (s->sync->waits && !s->sync->answers)
        drain_surplus(c, &m, now);
    if (!s->sync->client_runs_ahead || !ll_cheat_minds(s))
        return LL_OUTCOME_APPLIED;
    if (s->config->time_dilation)
        ll_dilate_time_follow(c, s, &m, now);
    else
        follow_slack(c, s, &m, now);
    return LL_OUTCOME_APPLIED;
}

int ll_client_receive(ll_client *c, const ll_client_setup *s, const void *packet, int size, ll_time now)
{
    ll_message_head head;
    LL_ASSERT(size >= (int)sizeof head);
    memcpy(&head, packet, sizeof head);
    if (head.epoch != c->epoch)
        return LL_OUTCOME_STALE;
    if (head.type == LL_MESSAGE_SNAPSHOT)
        return receive_state(c, s, packet, size, now);
    /* the server applied another input instead: the next snapshot corrects the prediction */
    c->inputs.refused++;
    return LL_OUTCOME_REFUSED;
}

static void take_newest_state(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_snapshot_entry *state = ll_client_state(c, c->snapshots.received - 1);
    uint32_t acked = c->inputs.acked;
    c->snapshots.used = c->snapshots.received;
    ll_acks[s->config->ack]->take(c, s, state, now);
    bool stands = s->config->prediction && ll_prediction_stands(c, s, state, acked);
    c->latest.time = state->time;
    c->latest.tick = state->tick;
    memcpy(ll_client_latest(c), ll_snapshot_entry_world(state), (size_t)c->layout.world_size);
    if (s->config->prediction)
        ll_reconcile(c, s, stands, now);
}

#define FAKED_VIEW (500 * LL_MS)

/* The world that the player acts on, and its time: the rendered view. A client that fakes its view time acts
 * on the snapshot of an earlier time, with its own entity as it is now. */
static const ll_world *rendered_view_of(ll_client *c, const ll_client_setup *s, ll_world *old, ll_time *seen)
{
    int64_t oldest = c->snapshots.received > LL_STATE_RING ? c->snapshots.received - LL_STATE_RING : 0,
            i = c->snapshots.received - 1;
    *seen = c->drawing.view_time;
    if (s->config->cheat != LL_CHEAT_VIEW_TIME || c->snapshots.received == 0)
        return ll_client_rendered(c);
    while (i > oldest && ll_client_state(c, i)->time > c->drawing.view_time - FAKED_VIEW)
        i--;
    *seen = ll_client_state(c, i)->time;
    memcpy(old, ll_snapshot_entry_world(ll_client_state(c, i)), (size_t)c->layout.world_size);
    old->entity[c->self] = ll_client_rendered(c)->entity[c->self];
    return old;
}

/* Whether the duration of a key press counts. */
static bool counts_time(const ll_client_setup *s)
{
    return s->sync->press_s > 0 && s->config->timer_jitter_ms > 0;
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
    double read_ms = config->input_hz > 0 ? 1e3 / config->input_hz : 0;
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

ll_action ll_client_control(const ll_client *c, const ll_client_setup *s, const ll_world *seen, ll_time t)
{
    const ll_player_config *config = s->config;
    ll_action a = c->inputs.held;
    if (config->control == LL_CONTROL_SCRIPT)
        a = s->game->drive(seen, s->env, s->seed, c->self, (ll_script)config->script, t);
    s->client_metrics->controls = a;
    const ll_action honest = for_its_time(c, s, a);
    ll_twin_controls(&s->client_metrics->twin, &honest);
    ll_cheat_action(c, s, &a);
    return for_its_time(c, s, a);
}

#define QUIET 4 /* intervals without a step: some player's inputs are missing */

/* Number of inputs that a client may make while the server waits for inputs. Inputs that the server would
 * refuse as too far ahead are not sent. While no step is made, it is the number that fits into the round
 * trip: enough to continue at the full rate, and no more, because inputs made beyond that stay late for good.
 */
static int64_t inputs_allowed(const ll_client *c, const ll_client_setup *s, ll_time now)
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

static int inputs_due(ll_client *c, const ll_client_setup *s, const ll_action *action, ll_time now)
{
    ll_input_history *input_history = &s->client_metrics->input_history;
    bool counts = now >= s->client_metrics->from;
    int n = 1 + ll_cheat_extra(c, s);
    if (!s->sync->applies_on_arrival)
        n += (int)c->ticks.skipped;
    if (!s->sync->sends_idle && action->axis[0] == 0 && action->axis[1] == 0 && action->buttons == 0) {
        ll_changes_idle(&s->client_metrics->changes);
        return 0;
    }
    if (c->inputs.extra > 0) {
        c->inputs.extra--;
        input_history->doubled += counts;
        n++;
    } else if (c->inputs.extra < 0) {
        c->inputs.extra++;
        input_history->left_out += counts;
        n--;
    }
    if (counts)
        ll_running_stats_add(&input_history->scale, c->inputs.scale);
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
    if (counts_time(s)) {
        controls.axis[0] = (float)(controls.axis[0] / ticks_pressed(c));
        controls.axis[1] = (float)(controls.axis[1] / ticks_pressed(c));
    }
    ll_client_metrics_input(s->client_metrics, c->inputs.seq,
                            s->sync->applies_on_arrival ? LL_NEVER : c->inputs.tick, &controls,
                            ll_client_control_time(c, s, now), now);
}

static void make_input(ll_client *c, const ll_client_setup *s, const ll_action *action, ll_time seen,
                       ll_time now)
{
    ll_pending_input *p = ll_client_pending(c, ++c->inputs.seq);
    c->inputs.tick++;
    if (c->inputs.seq - c->inputs.acked > LL_PENDING_RING)
        c->inputs.acked = c->inputs.seq - LL_PENDING_RING; /* the oldest is dropped */
    LL_ASSERT(c->inputs.acked < c->inputs.seq && c->inputs.newest_sent < c->inputs.seq);
    note_input(c, s, action, now);
    *p = (ll_pending_input){.seq = c->inputs.seq, .made = now, .action = *action};
    p->action.view_age_ns =
        age_ns((s->sync->applies_on_arrival ? now : ll_client_step_time(c, c->inputs.tick)) - seen);
    if (s->weapon_prediction)
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

static int put_inputs(const ll_client *c, const ll_client_setup *s, uint32_t first, uint32_t count,
                      uint32_t fresh, ll_input_message *m)
{
    LL_ASSERT(count <= LL_INPUTS_MAX && first + count <= c->inputs.seq + 1);
    m->head = (ll_message_head){LL_MESSAGE_INPUT, (uint8_t)count, c->epoch, first};
    m->tick = (int32_t)(c->inputs.tick - (int64_t)(c->inputs.seq - first));
    m->fresh = (uint8_t)(fresh < count ? fresh : count);
    m->wants = (uint8_t)ll_acks[s->config->ack]->wants;
    if (s->config->prediction && ll_scopes[s->config->prediction_scope]->guesses)
        m->wants |= LL_PART_AXES;
    m->lead = snapshot_age_of(c, s, m->tick);
    for (uint32_t i = 0; i < count; i++)
        m->inputs[i] = c->pending[(first + i) & (LL_PENDING_RING - 1)].action;
    return ll_input_message_size((int)count);
}

int ll_client_held(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
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

/* Whether others are drawn at a render time of their own (true) or as in the newest snapshot. */
static bool draws_by_time(const ll_client *c, const ll_client_setup *s)
{
    return c->snapshots.received > 0 &&
           (s->config->interpolation || (s->sync->extrapolates && s->config->extrapolation_ms > 0));
}

static void draw(ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_world *latest = ll_client_latest(c);
    ll_world *shown = ll_client_rendered(c);
    ll_draw_info *marks = ll_client_draw_infos(c);
    bool by_time = draws_by_time(c, s);
    for (int i = 0; i < latest->entities; i++) {
        if (by_time && i != c->self)
            continue;
        shown->entity[i] = latest->entity[i];
        marks[i] = (ll_draw_info){.time = c->latest.time};
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
    if (s->config->prediction)
        ll_draw_predicted(c, now);
    ll_smooth_draw(c, s, now);
    int other = c->self == 0;
    c->drawing.view_time = other < shown->entities ? marks[other].time : now;
}

/* Applies the newest snapshot that has arrived, also to the prediction. */
static void apply_newest_snapshot(ll_client *c, const ll_client_setup *s, ll_time now)
{
    if (c->snapshots.received > c->snapshots.used)
        take_newest_state(c, s, now);
    uint8_t predicting = (uint8_t)(s->config->prediction ? 1 + s->config->prediction_scope : 0);
    if (predicting != 0 && predicting != c->predicting)
        ll_resimulate(c, s);
    c->predicting = predicting;
}

int ll_client_tick(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
{
    ll_client_begin_tick(c, now);
    apply_newest_snapshot(c, s, now);
    if (!ll_connection_plays(&c->connection)) {
        c->inputs.tick += s->sync->client_runs_ahead; /* the clock continues */
        ll_client_miss(c, s, now);
        return 0;
    }
    _Alignas(8) char old[LL_GAME_WORLD_MAX];
    ll_time seen;
    const ll_world *view = rendered_view_of(c, s, (ll_world *)old, &seen);
    ll_action action = ll_client_control(c, s, view, now);
    int made = inputs_due(c, s, &action, now);
    for (int i = 0; i < made; i++)
        make_input(c, s, &action, seen, now);
    ll_measure(s->client_metrics, LL_METRIC_UNACKED, now, (double)(c->inputs.seq - c->inputs.acked));
    return compose(c, s, now, packet);
}

void ll_client_display(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_client_begin_display(c, now);
    apply_newest_snapshot(c, s, now);
    draw(c, s, now);
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
    for (; machine_time(s, &c->ticks.clock, c->ticks.number + 1) <= c->ticks.due; c->ticks.number++)
        c->ticks.skipped++;
}

void ll_client_set_display(ll_client *c, const ll_client_setup *s)
{
    c->displays.due =
        c->displays.clock.freq > 0 ? machine_time(s, &c->displays.clock, c->displays.number) : LL_NEVER;
}

/* What a packet of the server changes at once: a snapshot goes into the ring, and the slack that it reports
 * moves the client's inputs. A frame applies it later (client.c). */
#include <string.h>

#include "base/assert.h"
#include "netcode/client/cheat.h"
#include "netcode/protocol/limits.h"
#include "netcode/protocol/report.h"
#include "netcode/reckoning/reckoning.h"
#include "netcode/snapshot/snapshot.h"
#include "netcode/state/client.h"

/* ---- decoding ---- */

/* The received world of `tick`, if it lies on the present grid. */
static const ll_world *baseline_of(const void *client, int64_t tick)
{
    ll_client *c = (ll_client *)client; /* nothing changes */
    int64_t oldest = ll_client_oldest(c);
    if (tick < c->snapshots.grid_tick)
        return NULL;
    for (int64_t i = c->snapshots.received - 1; i >= oldest; i--)
        if (ll_client_state(c, i)->tick == tick)
            return ll_snapshot_entry_world(ll_client_state(c, i));
    return NULL;
}

/* A grid is valid from the snapshot on that brings it; an earlier snapshot that arrives late changes
 * nothing. */
static void take_grid(ll_client *c, const ll_quantization *grid, int64_t tick)
{
    bool other = memcmp(grid, &c->snapshots.grid, sizeof *grid) != 0;
    if (c->snapshots.grid_tick != LL_NEVER && (!other || tick < c->snapshots.grid_tick))
        return;
    c->snapshots.grid = *grid;
    c->snapshots.grid_tick = tick;
}

/* The world of a snapshot, in `size` bytes, against a baseline that the client holds; `world` is undefined
 * after an error. `changed`: NULL, or, of a snapshot of some entities after another one, which of them are
 * set (ll_incoming). */
static ll_status decode(ll_client *c, const ll_snapshot_message *m, const void *bytes, int size,
                        ll_world *world, ll_changed *changed)
{
    const ll_codec *codec = ll_codec_at(m->codec);
    ll_quantization grid = c->snapshots.grid;
    ll_incoming in = {.world = world, .self = c->self, .grid = &grid};
    ll_bit_reader r = {.bytes = bytes, .size = 8 * (int64_t)size};
    if (!codec)
        return ll_error(LL_BAD_INPUT, "codec %d does not exist", m->codec);
    if (codec->compares || (codec->selects && m->baseline > 0))
        in.baseline = baseline_of(c, m->tick - m->baseline);
    if (codec->compares && !in.baseline)
        return ll_error(LL_NOT_FOUND, "snapshot %lld: baseline %lld missing", (long long)m->tick,
                        (long long)m->tick - m->baseline);
    if (codec->selects) {
        in.tick = m->tick;
        in.world_at = baseline_of;
        in.context = c;
        if (c->snapshots.received > 0)
            in.previous = ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 1));
        in.changed = changed;
    }
    *world = *ll_client_latest(c); /* copies the header */
    ll_status status = codec->decode(&r, &in);
    if (!ll_failed(&status) && codec->gridded)
        take_grid(c, &grid, m->tick);
    return status;
}

/* ---- slack ---- */

#define SPARE_WINDOW (2 * LL_SECOND)
#define BUDGET_MARGIN 8 /* ticks */

/* Keeps the client as far ahead of the server as the reported slack asks: at once when inputs come too late;
 * slowly, by the least slack of two seconds, when they come earlier than wanted. Waits for the effect of a
 * change before the next one.
 *
 * A stream that stood still brings inputs late that are no longer so: the server must still accept the next
 * ones, though they come as early as these came late. */
static void follow_slack(ll_client *c, const ll_client_setup *s, const ll_snapshot_message *m, ll_time now)
{
    ll_client_inputs *in = &c->inputs;
    if (m->slack == LL_SLACK_UNKNOWN || m->slack_seq < in->settle)
        return;
    int32_t want = (int32_t)s->config->slack_ticks, change = 0;
    int32_t most = (int32_t)ll_budget_ticks(c->ticks.clock.freq) - BUDGET_MARGIN - want;
    if (in->least_slack == LL_SLACK_UNKNOWN)
        in->least_slack_since = now;
    if (m->slack < in->least_slack)
        in->least_slack = m->slack;
    if (m->slack < want || m->slack >= most) /* too late, or so early that it may be refused */
        change = want - m->slack;
    else if (now - in->least_slack_since < SPARE_WINDOW)
        return;
    else if (in->least_slack > want + 1)
        change = want - in->least_slack;
    in->least_slack = LL_SLACK_UNKNOWN;
    if (change == 0)
        return;
    if (change * c->ticks.period >= LL_CLOCK_SNAP) {
        ll_client_snap(c, in->tick + (change < most ? change : most));
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
    for (int i = 0; i < players && i < LL_PEERS_MAX && c->results.parts & LL_PART_AXES; i++) {
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

/* Which of the 32 ticks before `tick` the client has a snapshot of, the latest first. */
static uint32_t received_before(ll_client *c, int64_t tick)
{
    if (c->snapshots.received == 0)
        return 0;
    const ll_snapshot_entry *last = ll_client_state(c, c->snapshots.received - 1);
    int64_t since = tick - last->tick;
    if (since < 1 || since > 32)
        return 0;
    return (since < 32 ? last->before << since : 0) | UINT32_C(1) << (since - 1);
}

/* A function of its own: most games have no dead reckoning. */
static __attribute__((noinline)) ll_status decode_reckoned(ll_client *c, const ll_client_setup *s,
                                                           const ll_snapshot_message *m, ll_bit_reader *r,
                                                           ll_world *world, ll_time now)
{
    *world = *ll_client_latest(c); /* copies the header */
    return ll_reckoning_decode(s->reckoning, c->self, r, world, m->time, ll_client_server_time(c, s, now));
}

/* Stores the world of the snapshot that was just counted. */
static void store_world(ll_client *c, ll_recent *recent, const ll_world *world)
{
    memcpy(ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 1)), world,
           (size_t)c->layout.world_size);
    if (recent)
        ll_recent_note(recent, world, NULL);
}

/* The same of its `changed` entities: its place in the ring has a world that is older by the length of the
 * ring. */
static void store_changed(ll_client *c, ll_recent *recent, const ll_world *world, const ll_changed *changed)
{
    int64_t holds = recent->newest + 1 - ll_state_ring(c->layout.world_size);
    ll_world *to = ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 1));
    ll_recent_copy(recent, &holds, true, to,
                   ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 2)));
    for (int k = 0; k < changed->count; k++)
        to->entity[changed->entity[k]] = world->entity[changed->entity[k]];
    ll_recent_note(recent, to, changed->has);
    memcpy(ll_world_tail(to), ll_world_tail_const(world), (size_t)world->tail);
}

static int receive_state(ll_client *c, const ll_client_setup *s, const char *packet, int size, ll_time now)
{
    _Alignas(8) char bytes[LL_GAME_WORLD_MAX];
    ll_changed some, *changed = s->recent && c->snapshots.received > 0 ? &some : NULL;
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
    ll_bit_reader bits = {.bytes = (const uint8_t *)packet + start, .size = 8 * (int64_t)(size - start)};
    ll_world *world = (ll_world *)(void *)bytes;
    ll_status status = s->reckoning ? decode_reckoned(c, s, &m, &bits, world, now)
                                    : decode(c, &m, packet + start, size - start, world, changed);
    if (ll_failed(&status))
        return unreadable(c);
    const ll_codec *codec = ll_codec_at(m.codec);
    const uint32_t before = codec->selects ? received_before(c, m.tick) : 0;
    ll_snapshot_entry *r = ll_client_state(c, c->snapshots.received++);
    *r = (ll_snapshot_entry){m.tick,         m.time,         now,   m.head.seq, m.applied,
                             codec->gridded, codec->selects, before};
    take_parts(c, &m, packet + sizeof m);
    if (s->reporter && m.refused > s->reporter->refused)
        s->reporter->refused = m.refused;
    if (changed && codec->selects)
        store_changed(c, s->recent, world, changed);
    else
        store_world(c, s->recent, world);
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

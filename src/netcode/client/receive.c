/* What a packet of the server changes at once: a snapshot goes into the ring, and the slack that it reports
 * moves the client's inputs. A frame applies it later (client.c). */
#include <string.h>

#include "base/assert.h"
#include "netcode/client/cheat.h"
#include "netcode/snapshot/snapshot.h"
#include "netcode/state/client.h"

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

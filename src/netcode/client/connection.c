#include "netcode/protocol/connection.h"

#include <string.h>

#include "netcode/state/client.h"

const char *const ll_connection_state_names[LL_CONNECTION_STATES + 1] = {
    "connecting", "synchronising", "playing", "stalled", "resynchronising", "disconnected", NULL};

void ll_connection_init(ll_connection *n, ll_time now)
{
    memset(n, 0, sizeof *n);
    n->since = n->last_received = n->sent = n->asks = now;
    n->seen = LL_NEVER;
    n->attempt = 1;
}

static bool asks_in(const ll_connection *n)
{
    return n->state == LL_CONNECTION_CONNECTING || n->state == LL_CONNECTION_DISCONNECTED;
}

static bool measures(const ll_connection *n)
{
    return n->state == LL_CONNECTION_SYNCHRONISING || n->state == LL_CONNECTION_RESYNCHRONISING;
}

static __attribute__((noinline)) void enter(ll_client *c, const ll_client_setup *s, ll_connection_state state,
                                            ll_time now)
{
    ll_connection *n = &c->connection;
    n->in_state[n->state] += now - n->since;
    n->since = now;
    n->state = (uint8_t)state;
    n->measured = 0;
    if (asks_in(n) || measures(n))
        n->asks = now;
    if (s->recorder)
        s->recorder->record(s->recorder->context, &(ll_event){.type = LL_EVENT_CONNECTION,
                                                              .player = (uint8_t)c->self,
                                                              .outcome = (uint8_t)state,
                                                              .begin = now,
                                                              .end = now,
                                                              .number = (uint32_t)n->joins});
}

/* ---- timers ---- */

static ll_time timeout_of(const ll_client_setup *s)
{
    return s->rules->timeout_s > 0 ? (ll_time)(s->rules->timeout_s * 1e9) : LL_NEVER;
}

static ll_time after(ll_time from, ll_time delay)
{
    return from == LL_NEVER || delay == LL_NEVER ? LL_NEVER : from + delay;
}

/* Time of the next connect or ping. */
static ll_time next_request(const ll_connection *n)
{
    ll_time idle = ll_connection_plays(n) ? n->sent + LL_KEEP_ALIVE : LL_NEVER;
    return n->asks < idle ? n->asks : idle;
}

/* Whether a client that plays is stalled before it is disconnected: as by default. */
static bool notices_first(const ll_client_setup *s)
{
    return s->usual || s->rules->timeout_s >= LL_NOTICE / 1e9 || s->rules->timeout_s == 0;
}

static ll_time ends_at(const ll_connection *n, const ll_client_setup *s)
{
    if (n->state == LL_CONNECTION_PLAYING && notices_first(s))
        return n->last_received + LL_NOTICE;
    if (asks_in(n))
        return LL_NEVER;
    ll_time notice = n->state == LL_CONNECTION_STALLED ? LL_NEVER : n->last_received + LL_NOTICE,
            end = after(n->last_received, timeout_of(s));
    return measures(n) || end < notice ? end : notice;
}

ll_time ll_connection_due(const ll_client *c, const ll_client_setup *s)
{
    ll_time asks = next_request(&c->connection), ends = ends_at(&c->connection, s);
    return asks < ends ? asks : ends;
}

static void end(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_connection *n = &c->connection;
    n->attempt++;
    ll_client_leave(c, s);
    enter(c, s, n->joined ? LL_CONNECTION_DISCONNECTED : LL_CONNECTION_CONNECTING, now);
}

/* Without packets the connection is first stalled, then disconnected. */
static void end_by_silence(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_connection *n = &c->connection;
    if (now < ends_at(n, s))
        return;
    if (now < after(n->last_received, timeout_of(s))) {
        enter(c, s, LL_CONNECTION_STALLED, now);
        return;
    }
    n->time_outs++;
    end(c, s, now);
}

__attribute__((noinline)) int ll_connection_poll(ll_client *c, const ll_client_setup *s, ll_time now,
                                                 void *packet)
{
    ll_connection *n = &c->connection;
    end_by_silence(c, s, now);
    if (now < next_request(n))
        return 0;
    bool in = asks_in(n);
    ll_request_message m = {.head = {.type = in ? LL_MESSAGE_CONNECT : LL_MESSAGE_PING,
                                     .count = in ? 0 : ll_client_offset(c, s),
                                     .epoch = n->epoch,
                                     .seq = in ? n->attempt : ++n->pings},
                            .sent = ll_client_local(s, now),
                            .seen = n->seen};
    n->asks = now + (in ? LL_CONNECT_RETRY : measures(n) ? LL_SYNC_EVERY : LL_PING_EVERY);
    memcpy(packet, &m, sizeof m);
    return (int)sizeof m;
}

/* ---- received packets ---- */

/* The clock is measured, for the first time or again: the player plays from now on. */
static void clock_measured(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_connection *n = &c->connection;
    bool first = n->state == LL_CONNECTION_SYNCHRONISING;
    n->joined = 1;
    enter(c, s, LL_CONNECTION_PLAYING, now);
    ll_client_align(c, s, first, now);
}

static void take_echo(ll_client *c, const ll_client_setup *s, const ll_answer_message *m, ll_time now)
{
    ll_connection *n = &c->connection;
    if (!(m->head.count & LL_ANSWER_ECHO))
        return;
    ll_clock_sync_add(&n->clock, ll_clock_filters[s->config->clock_filter], m->sent, m->received,
                      ll_client_local(s, now), n->state != LL_CONNECTION_PLAYING);
    n->measured++;
    if (measures(n) && n->measured >= LL_SYNC_SAMPLES)
        clock_measured(c, s, now);
}

static void take_accept(ll_client *c, const ll_client_setup *s, const ll_answer_message *m, const void *world,
                        ll_time now)
{
    ll_connection *n = &c->connection;
    if (!asks_in(n) || m->head.seq != n->attempt)
        return; /* already connected */
    n->epoch = m->head.epoch;
    n->joins++;
    enter(c, s, n->joined ? LL_CONNECTION_RESYNCHRONISING : LL_CONNECTION_SYNCHRONISING, now);
    ll_client_begin begin = {
        .epoch = m->head.epoch, .step = m->tick, .first = m->first, .own = m->tick, .world = world};
    if (m->head.count & LL_ANSWER_OWN)
        memcpy(&begin.own, (const char *)world + c->layout.world_size, sizeof begin.own);
    ll_client_join(c, s, &begin, now);
}

/* The player is not connected, or not in this epoch: the server dropped it, or its request was too old to be
 * accepted. */
static void take_refusal(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_connection *n = &c->connection;
    if (asks_in(n)) {
        n->asks = now; /* asks again, acknowledging this answer */
        return;
    }
    end(c, s, now);
}

/* Whether the server, which answers with `epoch`, has dropped the player or accepted it again without the
 * player knowing. An older epoch is from before a change of the sync mode. */
static bool is_dropped(const ll_connection *n, uint16_t epoch)
{
    return epoch == 0 || (int16_t)(uint16_t)(epoch - n->epoch) > 0;
}

/* A function of its own, as the start of a state: most packets are of the game. */
static __attribute__((noinline)) void take_answer(ll_client *c, const ll_client_setup *s, const void *packet,
                                                  int size, ll_time now)
{
    ll_connection *n = &c->connection;
    ll_answer_message m;
    memcpy(&m, packet, sizeof m);
    const char *world = size > (int)sizeof m ? (const char *)packet + sizeof m : NULL;
    bool news = n->seen == LL_NEVER || m.received > n->seen; /* and not an overtaken one */
    n->seen = news ? m.received : n->seen;
    if (m.head.type == LL_MESSAGE_ACCEPT)
        take_accept(c, s, &m, world, now);
    else if (asks_in(n) ? m.head.epoch == 0 : news && is_dropped(n, m.head.epoch))
        take_refusal(c, s, now);
    take_echo(c, s, &m, now);
}

bool ll_connection_receive(ll_client *c, const ll_client_setup *s, const void *packet, int size, ll_time now)
{
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    c->connection.last_received = now;
    if (c->connection.state == LL_CONNECTION_STALLED)
        enter(c, s, LL_CONNECTION_RESYNCHRONISING, now);
    if (head.type != LL_MESSAGE_ACCEPT && head.type != LL_MESSAGE_PONG)
        return false;
    take_answer(c, s, packet, size, now);
    return true;
}

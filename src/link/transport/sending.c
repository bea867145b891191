/* From chunks to packets: as many as the congestion window allows, in the order of their numbers, whether
 * they are sent for the first time or again. */
#include <string.h>

#include "base/assert.h"
#include "link/transport/core.h"

/* A packet as it is filled. */
typedef struct packing {
    char bytes[LL_TRANSPORT_PACKET_MAX];
    ll_packet_head head;
    int size;
    int headers; /* of that, everything but the bytes of messages */
    int resent, type;
} packing;

/* ---- acknowledgements ---- */

static void acknowledge(ll_transport *t, int side, packing *p, ll_time now)
{
    const ll_protocol *protocol = ll_protocol_of(t->kind);
    ll_receiver *r = &t->flow[1 - side].receiver;
    if (r->unacked == 0 && !protocol->always_acks)
        return;
    int bytes = protocol->write_ack(t, &t->flow[1 - side], &p->head, p->bytes + p->size, now);
    p->size += bytes;
    p->headers += bytes;
    p->head.flags |= LL_PACKET_ACK;
    r->unacked = 0;
    r->ack_due = LL_NEVER;
}

static void begin(ll_transport *t, int side, packing *p, ll_time now)
{
    const ll_protocol *protocol = ll_protocol_of(t->kind);
    const ll_sender *s = &t->flow[side].sender;
    p->head = (ll_packet_head){.generation = t->generation[side],
                               .kept = (uint32_t)s->kept,
                               .number = (uint32_t)(protocol->adjacent ? s->end : s->packet)};
    p->size = p->headers = protocol->header;
    p->resent = p->type = 0;
    memset(p->bytes, 0, (size_t)protocol->header);
    acknowledge(t, side, p, now);
}

static void send_off(ll_transport *t, const ll_transport_env *env, int side, packing *p, ll_time now)
{
    ll_sender *s = &t->flow[side].sender;
    if (s->answer && p->head.chunks > 0 && p->resent == 0) {
        p->head.flags |= LL_PACKET_REDUCED;
        s->answer = 0;
    }
    memcpy(p->bytes, &p->head, sizeof p->head);
    ll_sending sending = ll_link_send_by(env->link[side], env->plan[side], now, p->bytes, p->size);
    int wire = LL_IP_UDP_HEADER * sending.fragments +
               (sending.fragments > 1 ? sending.fragments : 0) * LL_FRAGMENT_HEADER;
    ll_transport_watch(env,
                       &(ll_transport_note){.event = LL_TRANSPORT_PACKET,
                                            .side = side,
                                            .type = p->type,
                                            .number = s->packet,
                                            .sending = sending,
                                            .wire_bytes = wire + p->size,
                                            .header_bytes = wire + p->headers,
                                            .chunks = p->head.chunks,
                                            .resent = p->resent,
                                            .window = s->window.bytes},
                       now);
    s->packet++;
}

void ll_transport_send_ack(ll_transport *t, const ll_transport_env *env, int side, uint8_t flags,
                           uint16_t generation, ll_time now)
{
    packing p;
    begin(t, side, &p, now);
    p.head.generation = generation;
    p.head.flags |= flags;
    send_off(t, env, side, &p, now);
}

/* ---- chunks ---- */

static void put_chunk(const ll_transport *t, ll_flow *f, packing *p, int64_t number, ll_time now)
{
    const ll_protocol *protocol = ll_protocol_of(t->kind);
    ll_sender *s = &f->sender;
    ll_chunk *c = ll_chunk_of(t, f, number);
    uint32_t wire = (uint32_t)number;
    uint16_t size = (uint16_t)(c->size | c->flags << 11 | c->type << 13);
    char *at = p->bytes + p->size;
    memset(at, 0, (size_t)protocol->chunk_header);
    if (protocol->adjacent) {
        memcpy(at, &size, sizeof size);
    } else {
        memcpy(at, &wire, sizeof wire);
        memcpy(at + 4, &size, sizeof size);
        memcpy(at + 6, &c->order, sizeof c->order);
    }
    memcpy(at + protocol->chunk_header, ll_sent_bytes(t, f, number), c->size);
    if (p->head.chunks == 0) {
        p->type = c->type;
        p->head.number = protocol->adjacent ? wire : p->head.number;
    }
    p->size += protocol->chunk_header + c->size;
    p->headers += protocol->chunk_header;
    p->head.chunks++;
    p->resent += c->sends > 0;
    c->sends = c->sends < 2 ? c->sends + 1 : 2;
    c->state = LL_CHUNK_FLYING;
    c->sent = now;
    c->packet = s->packet;
    c->misses = 0;
    s->queued--;
    s->flying++;
    s->flight += c->size;
}

/* The next queued chunk from `from` on; the end: none. */
static int64_t next_queued(const ll_transport *t, const ll_flow *f, int64_t from)
{
    while (from < f->sender.end && ll_chunk_of(t, f, from)->state != LL_CHUNK_QUEUED)
        from++;
    return from;
}

static bool fits(const ll_transport *t, const ll_flow *f, const packing *p, const ll_chunk *c, bool probe)
{
    int size = p->size + ll_protocol_of(t->kind)->chunk_header + c->size;
    bool first = p->head.chunks == 0;
    return size <= LL_TRANSPORT_PACKET_MAX && p->head.chunks < UINT8_MAX &&
           ((first && probe) || f->sender.flight + c->size <= f->sender.window.bytes);
}

static void fill(ll_transport *t, ll_flow *f, packing *p, bool probe, ll_time now)
{
    const ll_protocol *protocol = ll_protocol_of(t->kind);
    ll_sender *s = &f->sender;
    int64_t n = s->scan = next_queued(t, f, s->scan);
    while (n < s->end && fits(t, f, p, ll_chunk_of(t, f, n), probe)) {
        put_chunk(t, f, p, n, now);
        int64_t next = next_queued(t, f, n + 1);
        if (protocol->adjacent && next != n + 1)
            break;
        n = next;
    }
    s->scan = next_queued(t, f, s->scan);
}

/* Nagle: less than a full segment waits while something is unacknowledged. */
static bool waits(const ll_transport *t, const ll_flow *f)
{
    const ll_sender *s = &f->sender;
    if (!t->nagle || s->flying == 0)
        return false;
    int bytes = 0;
    for (int64_t n = s->scan; n < s->end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        if (c->state == LL_CHUNK_QUEUED && c->sends > 0)
            return false;
        bytes += c->state == LL_CHUNK_QUEUED ? c->size : 0;
    }
    return bytes < ll_mss(ll_protocol_of(t->kind));
}

void ll_transport_push(ll_transport *t, const ll_transport_env *env, int side, bool probe, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    while (s->queued > 0 && !waits(t, f)) {
        packing p;
        int64_t first = next_queued(t, f, s->scan);
        bool anyway = probe || s->flying == 0;
        if (!anyway && s->flight + ll_chunk_of(t, f, first)->size > s->window.bytes) {
            s->limited = 1;
            return;
        }
        bool idle = s->flying == 0;
        begin(t, side, &p, now);
        fill(t, f, &p, anyway, now);
        LL_ASSERT(p.head.chunks > 0);
        send_off(t, env, side, &p, now);
        s->last = now;
        if (idle || ll_protocol_of(t->kind)->timer_by_packet)
            ll_timer_start(t, s, now, now);
        probe = false;
    }
}

/* ---- messages ---- */

static bool has_room(const ll_flow *f, int chunks)
{
    return f->sender.end - f->sender.kept + chunks <= f->chunks;
}

static void queue_message(ll_transport *t, ll_flow *f, int type, const char *bytes, int size, ll_time now)
{
    ll_sender *s = &f->sender;
    uint16_t order = s->order[type]++;
    if (s->base == s->end && s->backoff == 0)
        s->progress = now;
    for (int at = 0; at < size; s->end++, s->queued++) {
        int part = size - at < f->cell ? size - at : f->cell;
        *ll_chunk_of(t, f, s->end) = (ll_chunk){
            .made = now,
            .size = (uint16_t)part,
            .order = order,
            .state = LL_CHUNK_QUEUED,
            .flags = (uint8_t)((at == 0 ? LL_CHUNK_FIRST : 0) | (at + part == size ? LL_CHUNK_LAST : 0)),
            .type = (uint8_t)type};
        memcpy(ll_sent_bytes(t, f, s->end), bytes + at, (size_t)part);
        at += part;
    }
}

bool ll_transport_send(ll_transport *t, const ll_transport_env *env, int side, int type, const void *bytes,
                       int size, ll_time now)
{
    ll_flow *f = &t->flow[side];
    LL_ASSERT(type >= 0 && type < LL_TRANSPORT_TYPES && size > 0 && size <= t->message_max);
    if (!t->open[side] || !has_room(f, (size + f->cell - 1) / f->cell)) {
        ll_transport_watch(
            env, &(ll_transport_note){.event = LL_TRANSPORT_REFUSED, .side = side, .type = type}, now);
        return false;
    }
    queue_message(t, f, type, bytes, size, now);
    ll_transport_push(t, env, side, false, now);
    ll_transport_renew_due(t, env);
    return true;
}

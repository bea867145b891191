#include "link/transport/transport.h"

#include <string.h>

#include "base/assert.h"
#include "link/transport/core.h"

/* ---- sizes ---- */

#define CHUNKS_MIN 64
#define CHUNKS_MAX 1024
#define HELD_S 3 /* of messages at full rate: more than the longest round trip */

static int32_t cell_of(const ll_protocol *p, int32_t message_max)
{
    int32_t most = ll_mss(p) & ~7, size = (message_max + 7) & ~7;
    return size < most ? size : most;
}

/* Places of a flow's rings: a power of two. At least the chunks of two messages of any length. */
static int32_t chunks_of(const ll_protocol *p, const ll_flow_limits *limits)
{
    int32_t cell = cell_of(p, limits->message_max), places = CHUNKS_MIN;
    int32_t pieces = (limits->message_max + cell - 1) / cell;
    double wanted = limits->messages_per_s * HELD_S * pieces;
    while (places < CHUNKS_MAX && places < wanted)
        places *= 2;
    while (places < 2 * pieces)
        places *= 2;
    return places;
}

static size_t rings_of(int32_t chunks, int32_t cell)
{
    return (size_t)chunks * (sizeof(ll_chunk) + sizeof(ll_cell) + 2 * (size_t)cell);
}

size_t ll_transport_size(const ll_transport_setup *setup)
{
    const ll_protocol *p = ll_protocol_of(setup->kind);
    size_t size = sizeof(ll_transport);
    for (int i = 0; i < LL_SIDES; i++)
        size += rings_of(chunks_of(p, &setup->flow[i]), cell_of(p, setup->flow[i].message_max));
    return size;
}

/* Chunks that are sent again take places too, and every packet may have an acknowledgement of its own. */
int ll_transport_link_slots(const ll_transport_setup *setup, int side)
{
    const ll_protocol *p = ll_protocol_of(setup->kind);
    return chunks_of(p, &setup->flow[side]) + chunks_of(p, &setup->flow[1 - side]);
}

int ll_transport_link_arena(const ll_transport_setup *setup, int side)
{
    const ll_protocol *p = ll_protocol_of(setup->kind);
    int headers = p->header + p->ack_max + p->chunk_header;
    return chunks_of(p, &setup->flow[side]) * (cell_of(p, setup->flow[side].message_max) + headers) +
           chunks_of(p, &setup->flow[1 - side]) * headers;
}

/* ---- start and end of a connection ---- */

static void start_sender(ll_sender *s, const ll_protocol *p, ll_time now)
{
    *s = (ll_sender){.largest = -1, .loss = LL_NEVER, .progress = now};
    ll_window_init(&s->window, ll_mss(p));
}

static void start_receiver(const ll_transport *t, ll_flow *f)
{
    f->receiver = (ll_receiver){.ack_due = LL_NEVER};
    for (int32_t i = 0; i < f->chunks; i++)
        ll_place_of(t, f, i)->number = -1;
}

void ll_transport_init(ll_transport *t, const ll_transport_setup *setup, ll_time now)
{
    const ll_protocol *p = ll_protocol_of(setup->kind);
    int64_t end = (int64_t)sizeof *t;
    memset(t, 0, ll_transport_size(setup));
    t->kind = setup->kind;
    t->delivery = setup->delivery == LL_DELIVERY_USUAL ? p->usual : setup->delivery;
    t->congestion = setup->congestion;
    t->nagle = setup->nagle;
    for (int i = 0; i < LL_SIDES; i++)
        t->message_max =
            setup->flow[i].message_max > t->message_max ? setup->flow[i].message_max : t->message_max;
    t->due = LL_NEVER;
    t->generation[LL_CLIENT_SIDE] = 1;
    t->open[LL_CLIENT_SIDE] = 1;
    for (int i = 0; i < LL_SIDES; i++) {
        ll_flow *f = &t->flow[i];
        f->chunks = chunks_of(p, &setup->flow[i]);
        f->cell = cell_of(p, setup->flow[i].message_max);
        f->ring = end;
        end += (int64_t)rings_of(f->chunks, f->cell);
        start_sender(&f->sender, p, now);
        start_receiver(t, f);
    }
}

void ll_transport_watch(const ll_transport_env *env, const ll_transport_note *note, ll_time now)
{
    if (env->watch)
        env->watch(env->context, note, now);
}

/* Messages that the sender still had, whole or in part. */
static int waiting(const ll_transport *t, const ll_flow *f)
{
    int messages = 0;
    for (int64_t n = f->sender.base; n < f->sender.end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        messages += c->state != LL_CHUNK_DONE && (c->flags & LL_CHUNK_LAST);
    }
    return messages;
}

/* What the endpoint of `side` knows of its connection is void. */
void ll_transport_reset(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    ll_flow *out = &t->flow[side], *in = &t->flow[1 - side];
    ll_transport_watch(
        env, &(ll_transport_note){.event = LL_TRANSPORT_ENDED, .side = side, .chunks = waiting(t, out)}, now);
    start_sender(&out->sender, ll_protocol_of(t->kind), now);
    start_receiver(t, in);
}

/* The client opens the next connection; the server waits for that. */
static void end_connection(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    ll_transport_reset(t, env, side, now);
    if (side == LL_CLIENT_SIDE)
        t->generation[side]++;
    else
        t->open[side] = 0;
}

/* ---- a packet arrives ---- */

typedef struct arrival {
    char bytes[LL_TRANSPORT_PACKET_MAX];
    int size;
    ll_packet_head head;
} arrival;

/* False: the packet is of another connection. */
static bool same_connection(ll_transport *t, const ll_transport_env *env, int side,
                            const ll_packet_head *head, ll_time now)
{
    int16_t ahead = (int16_t)(uint16_t)(head->generation - t->generation[side]);
    if (side == LL_SERVER_SIDE && ahead > 0) {
        if (t->generation[side] != 0)
            ll_transport_reset(t, env, side, now);
        t->generation[side] = head->generation;
        t->open[side] = 1;
        return true;
    }
    if (ahead != 0)
        return false;
    if (head->flags & LL_PACKET_RESET) {
        end_connection(t, env, side, now);
        return false;
    }
    if (!t->open[side])
        ll_transport_send_ack(t, env, side, LL_PACKET_RESET, t->generation[side], now);
    return t->open[side];
}

/* True: it is new. */
static bool take_chunk(ll_transport *t, ll_flow *f, int64_t number, const ll_chunk_head *head,
                       const char *bytes, ll_time now)
{
    ll_receiver *r = &f->receiver;
    ll_cell *cell = ll_place_of(t, f, number);
    uint16_t size = (uint16_t)ll_chunk_bytes(head);
    LL_ASSERT(size <= f->cell);
    if (number < r->floor || cell->number >= number)
        return false;
    *cell = (ll_cell){.number = number,
                      .arrived = now,
                      .size = size,
                      .order = head->order,
                      .flags = head->size >> 11 & 3,
                      .type = (uint8_t)(head->size >> 13)};
    memcpy(ll_received_bytes(t, f, number), bytes, size);
    r->highest = number >= r->highest ? number + 1 : r->highest;
    while (ll_arrived(t, f, r->next))
        r->next++;
    return true;
}

/* Messages before chunk `kept` are settled: they arrived, or the sender has given them up. */
static void settle_before(const ll_transport *t, ll_flow *f, int64_t kept)
{
    ll_receiver *r = &f->receiver;
    r->floor = kept > r->floor ? kept : r->floor;
    r->next = kept > r->next ? kept : r->next;
    r->highest = kept > r->highest ? kept : r->highest;
    while (ll_arrived(t, f, r->next))
        r->next++;
}

static void take_chunks(ll_transport *t, ll_flow *f, const arrival *packet, int at, bool gap, ll_time now)
{
    const ll_protocol *p = ll_protocol_of(t->kind);
    ll_receiver *r = &f->receiver;
    int64_t first = ll_number_near(r->next, packet->head.number);
    for (int i = 0; i < packet->head.chunks; i++) {
        ll_chunk_head head = ll_chunk_head_at(packet->bytes + at, p->adjacent);
        at += p->chunk_header;
        int64_t number = p->adjacent ? first + i : ll_number_near(r->next, head.number);
        gap |= !take_chunk(t, f, number, &head, packet->bytes + at, now); /* it came before */
        at += ll_chunk_bytes(&head);
    }
    LL_ASSERT(at == packet->size);
    gap |= !p->note_packet && r->next < r->highest;
    if (packet->head.flags & (LL_PACKET_REDUCED | LL_PACKET_MARKED))
        p->note_flags(r, packet->head.flags);
    r->unacked++;
    if (gap || r->unacked >= 2)
        r->ack_due = now;
    else if (r->ack_due == LL_NEVER)
        r->ack_due = now + p->ack_delay;
}

static void receive(ll_transport *t, const ll_transport_env *env, int side, const arrival *packet,
                    ll_time now)
{
    const ll_protocol *p = ll_protocol_of(t->kind);
    ll_flow *in = &t->flow[1 - side];
    int at = p->header;
    int64_t number = ll_number_near(in->receiver.range[0].last, packet->head.number);
    bool gap = false;
    if (p->note_packet && !p->note_packet(&in->receiver, number, &gap, now))
        return;
    if (packet->head.flags & LL_PACKET_ACK) {
        p->read_ack(t, env, side, &packet->head, packet->bytes + at, now);
        at += p->ack_size(&packet->head, packet->bytes + at);
    }
    settle_before(t, in, ll_number_near(in->receiver.next, packet->head.kept));
    if (packet->head.chunks > 0)
        take_chunks(t, in, packet, at, gap, now);
    ll_transport_push(t, env, side, false, now);
}

void ll_transport_arrive(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    arrival packet;
    ll_time sent, due;
    packet.size = ll_link_receive(env->link[1 - side], now, packet.bytes, sizeof packet.bytes, &sent, &due);
    LL_ASSERT(packet.size >= ll_protocol_of(t->kind)->header);
    memcpy(&packet.head, packet.bytes, sizeof packet.head);
    if (same_connection(t, env, side, &packet.head, now))
        receive(t, env, side, &packet, now);
    ll_transport_renew_due(t, env);
}

/* ---- messages are handed over ---- */

/* Past the last chunk of the message that begins with `first`; 0: it is not complete. */
static int64_t message_end(const ll_transport *t, const ll_flow *f, int64_t first)
{
    for (int64_t n = first; n < f->receiver.highest && ll_arrived(t, f, n); n++)
        if (ll_place_of(t, f, n)->flags & LL_CHUNK_LAST)
            return n + 1;
    return 0;
}

/* Copies out the message, and informs the observer, who knows when it was sent. */
static int hand_over(ll_transport *t, const ll_transport_env *env, int side, int64_t first, int64_t end,
                     char *bytes, ll_time now)
{
    ll_flow *f = &t->flow[1 - side];
    ll_transport_note note = {.event = LL_TRANSPORT_HANDED,
                              .side = 1 - side,
                              .type = ll_place_of(t, f, first)->type,
                              .number = first,
                              .complete = LL_LONG_AGO,
                              .bytes = bytes};
    for (int64_t n = first; n < end; n++) {
        ll_cell *cell = ll_place_of(t, f, n);
        memcpy(bytes + note.size, ll_received_bytes(t, f, n), cell->size);
        note.size += cell->size;
        note.complete = cell->arrived > note.complete ? cell->arrived : note.complete;
        cell->taken = 1;
    }
    bool known = first < f->sender.end && first >= f->sender.end - f->chunks;
    note.made = known ? ll_chunk_of(t, f, first)->made : note.complete;
    for (int64_t n = first; known && n < end; n++)
        note.resent |= ll_chunk_of(t, f, n)->sends > 1;
    ll_transport_watch(env, &note, now);
    return note.size;
}

/* Drops the message: a later one of its type has been handed over. */
static void pass_over(const ll_transport *t, const ll_flow *f, int64_t first, int64_t end)
{
    for (int64_t n = first; n < end; n++)
        ll_place_of(t, f, n)->taken = 1;
}

typedef enum turn { TURN_NOW, TURN_NOT_YET, TURN_OVER } turn;

static turn turn_of(const ll_delivery_class *class, const ll_receiver *r, const ll_cell *cell)
{
    int16_t ahead = (int16_t)(uint16_t)(cell->order - r->order[cell->type]);
    if (class->by_type)
        return ahead == 0 ? TURN_NOW : TURN_NOT_YET;
    return class->sequenced && ahead < 0 ? TURN_OVER : TURN_NOW;
}

int ll_transport_take(ll_transport *t, const ll_transport_env *env, int side, void *bytes, int capacity,
                      ll_time now)
{
    const ll_delivery_class *class = ll_delivery_of(t);
    ll_flow *f = &t->flow[1 - side];
    ll_receiver *r = &f->receiver;
    LL_ASSERT(capacity >= t->message_max);
    for (int64_t n = r->floor; n < r->highest; n++) {
        const ll_cell *cell = ll_place_of(t, f, n);
        if (cell->number == n && cell->taken) {
            r->floor += n == r->floor;
            continue;
        }
        if (class->ordered && cell->number != n)
            return -1;
        int64_t end = cell->number == n && (cell->flags & LL_CHUNK_FIRST) ? message_end(t, f, n) : 0;
        turn whose = end > 0 ? turn_of(class, r, cell) : TURN_NOT_YET;
        if (end == 0 && class->ordered)
            return -1;
        if (whose == TURN_OVER)
            pass_over(t, f, n, end);
        if (whose != TURN_NOW)
            continue;
        r->order[cell->type] = (uint16_t)(cell->order + 1);
        return hand_over(t, env, side, n, end, bytes, now);
    }
    return -1;
}

void ll_transport_settle(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    if (t->flow[1 - side].receiver.ack_due <= now)
        ll_transport_send_ack(t, env, side, 0, t->generation[side], now);
    ll_transport_renew_due(t, env);
}

/* ---- timers ---- */

static ll_time earlier(ll_time a, ll_time b)
{
    return a < b ? a : b;
}

static ll_time ends_at(const ll_transport_env *env, const ll_sender *s)
{
    bool waits = s->base < s->end || s->backoff > 0;
    return env->timeout == LL_NEVER || !waits ? LL_NEVER : s->progress + env->timeout;
}

static ll_time times_out_at(const ll_sender *s)
{
    return s->flying > 0 ? s->expires : LL_NEVER;
}

ll_time ll_transport_due(const ll_transport *t)
{
    return t->due;
}

void ll_transport_renew_due(ll_transport *t, const ll_transport_env *env)
{
    t->due = LL_NEVER;
    for (int side = 0; side < LL_SIDES; side++) {
        const ll_sender *s = &t->flow[side].sender;
        t->due = earlier(t->due, t->flow[1 - side].receiver.ack_due);
        t->due = earlier(t->due, earlier(ends_at(env, s), earlier(times_out_at(s), s->loss)));
    }
    LL_VALIDATE(ll_transport_valid(t));
}

void ll_transport_run_timers(ll_transport *t, const ll_transport_env *env, ll_time now)
{
    const ll_protocol *p = ll_protocol_of(t->kind);
    for (int side = 0; side < LL_SIDES; side++) {
        ll_sender *s = &t->flow[side].sender;
        if (ends_at(env, s) <= now) {
            end_connection(t, env, side, now);
        } else if (s->loss <= now) {
            p->find_losses(t, env, side, now);
            ll_transport_push(t, env, side, false, now);
        } else if (times_out_at(s) <= now) {
            ll_transport_watch(env, &(ll_transport_note){.event = LL_TRANSPORT_TIMED_OUT, .side = side}, now);
            p->time_out(t, env, side, now);
        }
        ll_transport_settle(t, env, side, now);
    }
}

int64_t ll_transport_next(const ll_transport *t, int side)
{
    return t->flow[side].sender.end;
}

bool ll_transport_reliable(const ll_transport *t)
{
    return ll_delivery_of(t)->reliable;
}

/* ---- validation ---- */

static bool sender_valid(const ll_transport *t, const ll_flow *f)
{
    const ll_sender *s = &f->sender;
    int32_t queued = 0, flying = 0, flight = 0;
    if (s->base > s->end || s->end - s->kept > f->chunks || s->kept > s->base || s->window.bytes < 1)
        return false;
    for (int64_t n = s->base; n < s->end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        queued += c->state == LL_CHUNK_QUEUED;
        flying += c->state == LL_CHUNK_FLYING;
        flight += c->state == LL_CHUNK_FLYING ? c->size : 0;
        if (c->state == LL_CHUNK_QUEUED && n < s->scan)
            return false;
    }
    return queued == s->queued && flying == s->flying && flight == s->flight &&
           (s->base == s->end || ll_chunk_of(t, f, s->base)->state != LL_CHUNK_DONE);
}

bool ll_transport_valid(const ll_transport *t)
{
    for (int side = 0; side < LL_SIDES; side++) {
        const ll_receiver *r = &t->flow[side].receiver;
        if (!sender_valid(t, &t->flow[side]) || r->floor > r->highest || r->next > r->highest)
            return false;
        for (int i = 0; i + 1 < r->ranges; i++)
            if (r->range[i].first <= r->range[i + 1].last + 1 || r->range[i].first > r->range[i].last)
                return false;
    }
    return true;
}

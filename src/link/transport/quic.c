/* QUIC: streams side by side; packets have numbers and are acknowledged by them, chunks are STREAM or
 * DATAGRAM frames (RFC 9000, RFC 9221). A packet has 22 bytes after UDP (flags, a connection ID of 4, a
 * packet number of 1, a tag of 16), an acknowledgement 10 and 4 for each gap, a frame 8. From the first mark
 * on an acknowledgement has 4 more, the counts of ECN.
 *
 * RFC 9002: a packet is lost when one that was sent three packets later is acknowledged, or a later one and
 * 9/8 of a round trip has passed. A probe time-out sends the oldest packet's frames once more, without taking
 * anything for lost; with the third in a row congestion counts as persistent. */
#include <string.h>

#include "base/assert.h"
#include "link/transport/core.h"

#define ACK 10
#define GAP 4
#define COUNTS 4 /* of ECN, from the first mark on: that of marks, and room for ECT's, which are not kept */
#define MAX_ACK_DELAY (25 * LL_MS)
#define DELAY_UNIT (8 * (LL_MS / 1000)) /* of the acknowledgement's delay: ack_delay_exponent 3 */
#define INITIAL_RTT (333 * LL_MS)
#define PERSISTENT 3 /* probe time-outs in a row */

/* ---- received packets ---- */

static void insert(ll_receiver *r, int at, int64_t number)
{
    int kept = r->ranges < LL_RANGES_MAX ? r->ranges : LL_RANGES_MAX - 1; /* the oldest is forgotten */
    if (at > kept)
        return;
    memmove(r->range + at + 1, r->range + at, (size_t)(kept - at) * sizeof r->range[0]);
    r->range[at] = (ll_range){number, number};
    r->ranges = (int16_t)(kept + 1);
}

/* Joins the range at `at` with the older one after it where they touch. */
static void join(ll_receiver *r, int at)
{
    if (at + 1 >= r->ranges || r->range[at].first != r->range[at + 1].last + 1)
        return;
    r->range[at].first = r->range[at + 1].first;
    memmove(r->range + at + 1, r->range + at + 2, (size_t)(r->ranges - at - 2) * sizeof r->range[0]);
    r->ranges--;
    r->range[r->ranges] = (ll_range){0, 0};
}

/* A packet older than all ranges is taken for one that came before: its frames come again. */
static bool note_packet(ll_receiver *r, int64_t number, bool *gap, ll_time now)
{
    int at = 0;
    *gap = r->ranges > 0 && number != r->range[0].last + 1;
    if (r->ranges == 0 || number > r->range[0].last)
        r->largest_at = now;
    while (at < r->ranges && number < r->range[at].first)
        at++;
    if (at < r->ranges && number <= r->range[at].last)
        return false;
    if (at == LL_RANGES_MAX)
        return false;
    if (at > 0 && r->range[at - 1].first == number + 1) {
        r->range[at - 1].first = number;
        join(r, at - 1);
    } else if (at < r->ranges && r->range[at].last == number - 1) {
        r->range[at].last = number;
    } else {
        insert(r, at, number);
    }
    return true;
}

/* ---- acknowledgements ---- */

typedef struct ack_frame {
    uint32_t largest;
    uint16_t delay, first, more;
} ack_frame;

static uint16_t short_of(int64_t value)
{
    return (uint16_t)(value < UINT16_MAX ? value : UINT16_MAX);
}

/* A range that is too long is cut to its end, and none beyond a gap that is too long. */
static int write_ack(const ll_transport *t, const ll_flow *f, ll_packet_head *head, char *to, ll_time now)
{
    const ll_receiver *r = &f->receiver;
    ack_frame ack = {.largest = (uint32_t)r->range[0].last,
                     .delay = short_of((now - r->largest_at) / DELAY_UNIT),
                     .first = short_of(r->range[0].last - r->range[0].first)};
    int64_t told = r->range[0].last - ack.first; /* the first of the last range */
    (void)t;
    while (ack.more + 1 < r->ranges && told - r->range[ack.more + 1].last <= UINT16_MAX) {
        const ll_range *range = &r->range[ack.more + 1];
        uint16_t gap[2] = {(uint16_t)(told - range->last), short_of(range->last - range->first)};
        memcpy(to + ACK + GAP * ack.more, gap, sizeof gap);
        told = range->last - gap[1];
        ack.more++;
    }
    memcpy(to, &ack.largest, 4);
    memcpy(to + 4, &ack.delay, 6);
    int size = ACK + GAP * ack.more;
    if (r->marks == 0)
        return size;
    const uint16_t counts[2] = {0, r->marks};
    memcpy(to + size, counts, sizeof counts);
    head->flags |= LL_PACKET_ECHO;
    return size + COUNTS;
}

static int ack_size(const ll_packet_head *head, const char *from)
{
    ack_frame ack;
    memcpy(&ack.delay, from + 4, 6);
    return ACK + GAP * ack.more + (head->flags & LL_PACKET_ECHO ? COUNTS : 0);
}

/* The ranges of a frame, the newest first. */
static void read_ranges(int64_t near, const char *from, ack_frame *ack, ll_range *range)
{
    memcpy(&ack->largest, from, 4);
    memcpy(&ack->delay, from + 4, 6);
    LL_ASSERT(ack->more < LL_RANGES_MAX);
    range[0].last = ll_number_near(near, ack->largest);
    range[0].first = range[0].last - ack->first;
    for (int i = 1; i <= ack->more; i++) {
        uint16_t gap[2];
        memcpy(gap, from + ACK + GAP * (i - 1), sizeof gap);
        range[i].last = range[i - 1].first - gap[0];
        range[i].first = range[i].last - gap[1];
    }
}

static bool acknowledges(const ll_range *range, int count, int64_t packet)
{
    for (int i = 0; i < count; i++)
        if (packet >= range[i].first && packet <= range[i].last)
            return true;
    return false;
}

/* RFC 9002, 7.1 and B.5: more marked packets than were known are a sign of congestion. */
static void read_marks(ll_transport *t, int side, const char *counts, int64_t newest, ll_time now)
{
    ll_sender *s = &t->flow[side].sender;
    uint16_t marks;
    memcpy(&marks, counts + 2, sizeof marks);
    if ((int16_t)(uint16_t)(marks - s->marks) <= 0)
        return; /* an acknowledgement that was overtaken */
    s->marks = marks;
    ll_window_marked(t, s, newest, now);
}

static void note_flags(ll_receiver *r, uint8_t flags)
{
    if (flags & LL_PACKET_MARKED)
        r->marks++;
}

static void read_ack(ll_transport *t, const ll_transport_env *env, int side, const ll_packet_head *head,
                     const char *from, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    ll_range range[LL_RANGES_MAX];
    ack_frame ack;
    read_ranges(s->packet, from, &ack, range);
    ll_acked all = ll_acked_begin(t, s);
    ll_time sent = LL_NEVER; /* of the largest packet */
    for (int64_t n = s->base; n < s->end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        if (c->state != LL_CHUNK_FLYING || !acknowledges(range, ack.more + 1, c->packet))
            continue;
        sent = c->packet == range[0].last ? c->sent : sent;
        ll_acked_chunk(t, f, n, &all);
    }
    s->largest = range[0].last > s->largest ? range[0].last : s->largest;
    if (sent != LL_NEVER) {
        ll_time held = ack.delay * DELAY_UNIT;
        ll_rtt_add(&s->rtt, now - sent, held < MAX_ACK_DELAY ? held : MAX_ACK_DELAY);
    }
    if (all.newest >= 0)
        s->backoff = 0;
    ll_acked_end(t, side, &all, now);
    ll_protocol_quic.find_losses(t, env, side, now);
    if (head->flags & LL_PACKET_ECHO)
        read_marks(t, side, from + ACK + GAP * ack.more, range[0].last, now);
}

/* ---- losses ---- */

static void find_losses(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    ll_time round_trip = s->rtt.latest > s->rtt.smoothed ? s->rtt.latest : s->rtt.smoothed;
    ll_time threshold = round_trip + round_trip / 8;
    threshold = threshold > LL_MS ? threshold : LL_MS;
    s->loss = LL_NEVER;
    for (int64_t n = s->base; n < s->end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        if (c->state != LL_CHUNK_FLYING || c->packet > s->largest)
            continue;
        if (c->packet <= s->largest - LL_LOSS_THRESHOLD || c->sent + threshold <= now)
            ll_chunk_lost(t, env, side, n, now);
        else if (c->sent + threshold < s->loss)
            s->loss = c->sent + threshold;
    }
}

static ll_time rto(const ll_sender *s)
{
    return ll_rto_of(s, 3 * INITIAL_RTT + MAX_ACK_DELAY, LL_MS, 0, MAX_ACK_DELAY);
}

/* A probe: what the oldest packet in flight holds is sent once more, at any window. An unreliable
 * stream has nothing to send again, and gives it up. */
static void time_out(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    bool reliable = ll_delivery_of(t)->reliable;
    int64_t oldest = INT64_MAX, end = s->end;
    for (int64_t n = s->base; n < end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        if (c->state == LL_CHUNK_FLYING && c->packet < oldest)
            oldest = c->packet;
    }
    int64_t spared = s->recovery;
    s->recovery = INT64_MAX; /* a probe is no sign of congestion */
    for (int64_t n = s->base; n < end; n++) {
        const ll_chunk *c = ll_chunk_of(t, f, n);
        if (c->state == LL_CHUNK_FLYING && (c->packet == oldest || !reliable))
            ll_chunk_lost(t, env, side, n, now);
    }
    s->recovery = spared;
    s->backoff++;
    if (s->backoff == PERSISTENT)
        ll_window_collapse(t, s, now);
    ll_timer_start(t, s, now, now);
    ll_transport_push(t, env, side, true, now);
}

enum { HEADER = 22, FRAME = 8, ACK_MAX = ACK + GAP * (LL_RANGES_MAX - 1) };

/* The mss is the same with the counts: the longest chunk leaves room for them, as it is rounded down. */
_Static_assert((LL_TRANSPORT_PACKET_MAX - HEADER - ACK_MAX - FRAME) % 8 >= COUNTS, "no room for counts");

const ll_protocol ll_protocol_quic = {.header = HEADER,
                                      .chunk_header = FRAME,
                                      .ack_max = ACK_MAX,
                                      .deliveries = (1 << LL_DELIVERY_CLASSES) - 1,
                                      .usual = LL_DELIVERY_BY_TYPE,
                                      .ecn = true,
                                      .ack_delay = MAX_ACK_DELAY,
                                      .rto_initial = 3 * INITIAL_RTT,
                                      .rto_min = LL_MS,
                                      .write_ack = write_ack,
                                      .read_ack = read_ack,
                                      .ack_size = ack_size,
                                      .rto = rto,
                                      .time_out = time_out,
                                      .find_losses = find_losses,
                                      .note_packet = note_packet,
                                      .note_flags = note_flags,
                                      .timer_by_packet = true};

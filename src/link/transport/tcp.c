/* TCP as games use it: one stream each way, selective acknowledgements, no delay of small segments unless
 * `nagle`. A packet holds consecutive chunks: 20 bytes of TCP and 12 of timestamps in place of UDP's 8, and 2
 * before each chunk, which is how a game finds its messages in the stream.
 *
 * RFC 9293, RFC 6298, RFC 2018, RFC 6675, RFC 3168; a chunk that was sent again is found lost like any other,
 * as RFC 8985 does. Linux acknowledges after 40 ms. */
#include <string.h>

#include "link/transport/core.h"

#define BLOCKS 3 /* next to timestamps */
#define OPTION 4 /* kind, length, padding */
#define BLOCK 8

static int write_ack(const ll_transport *t, const ll_flow *f, ll_packet_head *head, char *to, ll_time now)
{
    ll_range blocks[BLOCKS];
    int count = ll_blocks_of(t, f, blocks, BLOCKS);
    (void)now;
    head->next = (uint32_t)f->receiver.next;
    if (f->receiver.marks > 0)
        head->flags |= LL_PACKET_ECHO;
    if (count == 0)
        return 0;
    char option[OPTION] = {1, 1, 5, (char)(2 + BLOCK * count)};
    memcpy(to, option, sizeof option);
    for (int i = 0; i < count; i++) {
        uint32_t edges[2] = {(uint32_t)blocks[i].first, (uint32_t)blocks[i].last + 1};
        memcpy(to + OPTION + BLOCK * i, edges, sizeof edges);
    }
    head->flags |= LL_PACKET_BLOCKS;
    return OPTION + BLOCK * count;
}

static int blocks_in(const ll_packet_head *head, const char *from)
{
    return head->flags & LL_PACKET_BLOCKS ? (from[3] - 2) / BLOCK : 0;
}

static int ack_size(const ll_packet_head *head, const char *from)
{
    int count = blocks_in(head, from);
    return count > 0 ? OPTION + BLOCK * count : 0;
}

static void read_ack(ll_transport *t, const ll_transport_env *env, int side, const ll_packet_head *head,
                     const char *from, ll_time now)
{
    int64_t near = t->flow[side].sender.base;
    ll_range blocks[BLOCKS] = {0};
    int count = blocks_in(head, from);
    for (int i = 0; i < count; i++) {
        uint32_t edges[2];
        memcpy(edges, from + OPTION + BLOCK * i, sizeof edges);
        blocks[i] = (ll_range){ll_number_near(near, edges[0]), ll_number_near(near, edges[1]) - 1};
    }
    int64_t newest = ll_take_blocks(t, env, side, ll_number_near(near, head->next), blocks, count, now);
    ll_sender *s = &t->flow[side].sender;
    if (newest >= 0 && (head->flags & LL_PACKET_ECHO) && ll_window_marked(t, s, newest, now))
        s->answer = 1;
}

/* RFC 3168: every acknowledgement echoes a mark until the sender says that it has reduced its window. */
static void note_flags(ll_receiver *r, uint8_t flags)
{
    if (flags & LL_PACKET_REDUCED)
        r->marks = 0;
    if (flags & LL_PACKET_MARKED)
        r->marks = 1;
}

static ll_time rto(const ll_sender *s)
{
    return ll_rto_of(s, ll_protocol_tcp.rto_initial, LL_MS, ll_protocol_tcp.rto_min, 0);
}

const ll_protocol ll_protocol_tcp = {.header = 24,
                                     .chunk_header = 2,
                                     .ack_max = OPTION + BLOCK * BLOCKS,
                                     .deliveries = 1 << LL_DELIVERY_USUAL | 1 << LL_DELIVERY_ORDERED,
                                     .usual = LL_DELIVERY_ORDERED,
                                     .ecn = true,
                                     .adjacent = true,
                                     .always_acks = true,
                                     .ack_delay = 40 * LL_MS,
                                     .rto_initial = LL_SECOND,
                                     .rto_min = 200 * LL_MS,
                                     .write_ack = write_ack,
                                     .read_ack = read_ack,
                                     .ack_size = ack_size,
                                     .note_flags = note_flags,
                                     .rto = rto,
                                     .time_out = ll_time_out_all};

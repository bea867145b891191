/* A WebRTC data channel: SCTP (12 bytes, and 16 before each chunk) over DTLS 1.2 with AES-GCM (29 bytes) over
 * UDP. Acknowledgements are chunks of 16 bytes and 4 for each gap. RFC 8831, RFC 9260; timers of dcSCTP, the
 * implementation in Chromium: RTO at least 400 ms, 500 at first.
 *
 * Chunks that an unreliable channel gives up stand in the head of the next packet, where SCTP has a
 * FORWARD-TSN chunk of 8 bytes (RFC 3758). */
#include <string.h>

#include "link/transport/core.h"

#define BLOCKS 8
#define SACK 16
#define GAP 4

static int write_ack(const ll_transport *t, const ll_flow *f, ll_packet_head *head, char *to, ll_time now)
{
    ll_range blocks[BLOCKS];
    int count = ll_blocks_of(t, f, blocks, BLOCKS);
    uint32_t fixed[SACK / 4] = {(uint32_t)f->receiver.next, (uint32_t)count};
    (void)now;
    (void)head;
    memcpy(to, fixed, sizeof fixed);
    for (int i = 0; i < count; i++) {
        uint16_t gap[2] = {(uint16_t)(blocks[i].first - f->receiver.next),
                           (uint16_t)(blocks[i].last - f->receiver.next)};
        memcpy(to + SACK + GAP * i, gap, sizeof gap);
    }
    return SACK + GAP * count;
}

static int ack_size(const ll_packet_head *head, const char *from)
{
    uint32_t fixed[SACK / 4];
    (void)head;
    memcpy(fixed, from, sizeof fixed);
    return SACK + GAP * (int)fixed[1];
}

static void read_ack(ll_transport *t, const ll_transport_env *env, int side, const ll_packet_head *head,
                     const char *from, ll_time now)
{
    ll_range blocks[BLOCKS] = {0};
    uint32_t fixed[SACK / 4];
    (void)head;
    memcpy(fixed, from, sizeof fixed);
    int64_t next = ll_number_near(t->flow[side].sender.base, fixed[0]);
    int count = (int)fixed[1];
    for (int i = 0; i < count; i++) {
        uint16_t gap[2];
        memcpy(gap, from + SACK + GAP * i, sizeof gap);
        blocks[i] = (ll_range){next + gap[0], next + gap[1]};
    }
    ll_take_blocks(t, env, side, next, blocks, count, now);
}

static ll_time rto(const ll_sender *s)
{
    return ll_rto_of(s, ll_protocol_webrtc.rto_initial, LL_MS, ll_protocol_webrtc.rto_min, 0);
}

const ll_protocol ll_protocol_webrtc = {.header = 29 + 12,
                                        .chunk_header = 16,
                                        .ack_max = SACK + GAP * BLOCKS,
                                        .deliveries = (1 << LL_DELIVERY_CLASSES) - 1,
                                        .usual = LL_DELIVERY_UNRELIABLE,
                                        .ack_delay = 200 * LL_MS,
                                        .rto_initial = 500 * LL_MS,
                                        .rto_min = 400 * LL_MS,
                                        .write_ack = write_ack,
                                        .read_ack = read_ack,
                                        .ack_size = ack_size,
                                        .rto = rto,
                                        .time_out = ll_time_out_all};

#include "link/transport/segment.h"

#include "base/assert.h"
#include "link/transport/core.h"

/* Selective acknowledgements of tcp: an option of 4 bytes, then pairs of numbers. */
static void read_blocks(ll_segment *segment, const char *option, int size)
{
    segment->blocks = size > 0 ? (size - 4) / 8 : 0;
    LL_ASSERT(segment->blocks <= LL_SEGMENT_BLOCKS_MAX);
    for (int i = 0; i < segment->blocks; i++)
        memcpy(segment->block[i], option + 4 + 8 * i, 8);
}

ll_segment ll_segment_read(int kind, const void *bytes, int size)
{
    const ll_protocol *p = ll_protocol_of(kind);
    const char *packet = bytes;
    ll_packet_head head;
    LL_ASSERT(!ll_transport_plain(kind) && size >= p->header);
    memcpy(&head, packet, sizeof head);
    ll_segment segment = {.generation = head.generation,
                          .acknowledges = head.flags & LL_PACKET_ACK,
                          .reset = head.flags & LL_PACKET_RESET,
                          .echo = head.flags & LL_PACKET_ECHO,
                          .reduced = head.flags & LL_PACKET_REDUCED,
                          .chunks = head.chunks,
                          .number = head.number,
                          .next = head.next};
    int at = p->header;
    if (segment.acknowledges) {
        int ack = p->ack_size(&head, packet + at);
        if (p->adjacent)
            read_blocks(&segment, packet + at, ack);
        at += ack;
    }
    LL_ASSERT(at <= size);
    segment.payload = packet + at;
    segment.payload_size = size - at;
    return segment;
}

ll_segment_chunk ll_segment_chunk_at(int kind, const ll_segment *segment, int index, int *at)
{
    const ll_protocol *p = ll_protocol_of(kind);
    ll_chunk_head head = ll_chunk_head_at(segment->payload + *at, p->adjacent);
    ll_segment_chunk chunk = {.number = p->adjacent ? segment->number + (uint32_t)index : head.number,
                              .type = head.size >> 13,
                              .first = head.size >> 11 & LL_CHUNK_FIRST,
                              .bytes = segment->payload + *at + p->chunk_header,
                              .size = ll_chunk_bytes(&head)};
    chunk.whole = p->chunk_header + chunk.size;
    *at += chunk.whole;
    LL_ASSERT(*at <= segment->payload_size);
    return chunk;
}

#include "capture/format/tcp.h"

#include <string.h>

#include "base/assert.h"
#include "capture/format/internal.h"

enum { FIXED = 20, TIMESTAMPS = 12, BLOCKS = 4, BLOCK = 8 }; /* bytes; options with their padding */
enum { NO_OPERATION = 1, OPTION_BLOCKS = 5, OPTION_TIMESTAMPS = 8 };
enum { PSH = 8, RST = 4, ACK = 16, ECE = 64, CWR = 128, WINDOW = 65535, PROTOCOL_TCP = 6 };

static size_t tcp_size(const ll_tcp_segment *s)
{
    return FIXED + TIMESTAMPS + (s->blocks > 0 ? BLOCKS + BLOCK * (size_t)s->blocks : 0);
}

size_t ll_tcp_headers_size(const ll_tcp_segment *s)
{
    return LL_IP_HEADER + tcp_size(s);
}

static void write_options(uint8_t *at, const ll_tcp_segment *s)
{
    const uint8_t timestamps[] = {NO_OPERATION, NO_OPERATION, OPTION_TIMESTAMPS, 10};
    memcpy(at, timestamps, sizeof timestamps);
    ll_put32(at + 4, s->time_ms);
    ll_put32(at + 8, s->echo_ms);
    if (s->blocks == 0)
        return;
    at += TIMESTAMPS;
    const uint8_t blocks[] = {NO_OPERATION, NO_OPERATION, OPTION_BLOCKS, (uint8_t)(2 + BLOCK * s->blocks)};
    memcpy(at, blocks, sizeof blocks);
    for (int i = 0; i < s->blocks; i++) {
        ll_put32(at + BLOCKS + BLOCK * i, s->block[i][0]);
        ll_put32(at + BLOCKS + BLOCK * i + 4, s->block[i][1]);
    }
}

void ll_tcp_headers_write(uint8_t *packet, const ll_ip_end *from, const ll_ip_end *to, uint16_t id,
                          const ll_tcp_segment *s, size_t size)
{
    size_t header = tcp_size(s);
    uint8_t *tcp = packet + LL_IP_HEADER;
    LL_ASSERT(s->blocks >= 0 && s->blocks <= LL_TCP_BLOCKS_MAX);
    ll_ip_write(packet, from, to, id, PROTOCOL_TCP, header + size);
    memset(tcp, 0, header);
    ll_put16(tcp, from->port);
    ll_put16(tcp + 2, to->port);
    ll_put32(tcp + 4, s->sequence);
    ll_put32(tcp + 8, s->acknowledgement);
    tcp[12] = (uint8_t)(header / 4 << 4);
    tcp[13] = (uint8_t)(ACK | (s->push ? PSH : 0) | (s->reset ? RST : 0) | (s->echo ? ECE : 0) |
                        (s->reduced ? CWR : 0));
    ll_put16(tcp + 14, WINDOW);
    write_options(tcp + FIXED, s);
    ll_put16(tcp + 16, ll_ip_checksum(packet, PROTOCOL_TCP, header + size));
}

uint32_t ll_tcp_time_ms(const uint8_t *packet)
{
    const uint8_t *at = packet + LL_IP_HEADER + FIXED + 4;
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

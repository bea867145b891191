#include "capture/format/ip.h"

#include <string.h>

#include "base/assert.h"
#include "capture/format/internal.h"

enum { VERSION_AND_LENGTH = 0x45, DO_NOT_FRAGMENT = 0x4000, TIME_TO_LIVE = 64, PROTOCOL_UDP = 17 };

/* Sum of 16-bit words, the last one padded with a zero. */
static uint64_t sum_of(const uint8_t *bytes, size_t size)
{
    uint64_t sum = 0;
    for (size_t i = 0; i + 1 < size; i += 2)
        sum += (uint64_t)bytes[i] << 8 | bytes[i + 1];
    return size & 1 ? sum + ((uint64_t)bytes[size - 1] << 8) : sum;
}

/* The one's complement of the one's complement sum (RFC 1071). */
static uint16_t checksum(uint64_t sum)
{
    while (sum >> 16)
        sum = (sum & 0xFFFF) + (sum >> 16);
    return (uint16_t)~sum;
}

void ll_ip_write(uint8_t *packet, const ll_ip_end *from, const ll_ip_end *to, uint16_t id, uint8_t protocol,
                 size_t size)
{
    size_t total = LL_IP_HEADER + size;
    LL_ASSERT(total <= UINT16_MAX);
    memset(packet, 0, LL_IP_HEADER);
    packet[0] = VERSION_AND_LENGTH;
    ll_put16(packet + 2, (uint32_t)total);
    ll_put16(packet + 4, id);
    ll_put16(packet + 6, DO_NOT_FRAGMENT);
    packet[8] = TIME_TO_LIVE;
    packet[9] = protocol;
    ll_put32(packet + 12, from->address);
    ll_put32(packet + 16, to->address);
    ll_put16(packet + 10, checksum(sum_of(packet, LL_IP_HEADER)));
}

uint16_t ll_ip_checksum(const uint8_t *packet, uint8_t protocol, size_t size)
{
    /* the pseudo header: addresses, protocol and length */
    return checksum(sum_of(packet + 12, 8) + protocol + size + sum_of(packet + LL_IP_HEADER, size));
}

void ll_udp_headers_write(uint8_t *packet, const ll_ip_end *from, const ll_ip_end *to, uint16_t id,
                          size_t size)
{
    uint8_t *udp = packet + LL_IP_HEADER;
    size_t datagram = LL_UDP_HEADER + size;
    ll_ip_write(packet, from, to, id, PROTOCOL_UDP, datagram);
    ll_put16(udp, from->port);
    ll_put16(udp + 2, to->port);
    ll_put16(udp + 4, (uint32_t)datagram);
    ll_put16(udp + 6, 0);
    uint16_t sent = ll_ip_checksum(packet, PROTOCOL_UDP, datagram);
    ll_put16(udp + 6, sent ? sent : UINT16_MAX); /* 0 means: without a checksum */
}

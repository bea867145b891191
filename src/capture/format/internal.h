/* Shared by the protocols of this room: ip.c, tcp.c. Numbers are written with the highest byte first. */
#pragma once

#include "capture/format/ip.h"

static inline void ll_put16(uint8_t *at, uint32_t value)
{
    at[0] = (uint8_t)(value >> 8);
    at[1] = (uint8_t)value;
}

static inline void ll_put32(uint8_t *at, uint32_t value)
{
    ll_put16(at, value >> 16);
    ll_put16(at + 2, value & 0xFFFF);
}

/* The header of IPv4 before `size` bytes of `protocol`. */
void ll_ip_write(uint8_t *packet, const ll_ip_end *from, const ll_ip_end *to, uint16_t id, uint8_t protocol,
                 size_t size);

/* Checksum of `size` bytes behind that header, in which the checksum's own place is zero, with the pseudo
 * header (RFC 9293, 3.1). */
uint16_t ll_ip_checksum(const uint8_t *packet, uint8_t protocol, size_t size);

/* Headers of IPv4 (RFC 791) and UDP (RFC 768), with their checksums, as they are on a wire. */
#pragma once

#include <stddef.h>
#include <stdint.h>

enum { LL_IP_HEADER = 20, LL_UDP_HEADER = 8, LL_UDP_HEADERS = LL_IP_HEADER + LL_UDP_HEADER };

/* One end of a path. Numbers in the machine's order. */
typedef struct ll_ip_end {
    uint32_t address;
    uint16_t port;
} ll_ip_end;

/* Writes both headers to `packet`; `size` bytes of payload, at most 65,507, stand behind them. `id`: number
 * of the packet by its sender. */
void ll_udp_headers_write(uint8_t *packet, const ll_ip_end *from, const ll_ip_end *to, uint16_t id,
                          size_t size);

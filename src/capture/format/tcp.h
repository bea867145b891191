/* Headers of a TCP segment (RFC 9293) as Linux sends it: with timestamps (RFC 7323), and with selective
 * acknowledgements (RFC 2018) where there are some. */
#pragma once

#include <stdbool.h>

#include "capture/format/ip.h"

enum { LL_TCP_BLOCKS_MAX = 3 };

typedef struct ll_tcp_segment {
    uint32_t sequence, acknowledgement;
    bool push, reset;
    bool echo, reduced;        /* ECE and CWR (RFC 3168) */
    uint32_t time_ms, echo_ms; /* the sender's clock, and the newest that it has received */
    int blocks;
    uint32_t block[LL_TCP_BLOCKS_MAX][2]; /* first byte, and past the last */
} ll_tcp_segment;

size_t ll_tcp_headers_size(const ll_tcp_segment *segment); /* of IPv4 and TCP: 52, or 56 and 8 a block */

/* Writes both headers to `packet`; `size` bytes of payload stand behind them. */
void ll_tcp_headers_write(uint8_t *packet, const ll_ip_end *from, const ll_ip_end *to, uint16_t id,
                          const ll_tcp_segment *segment, size_t size);

/* The sender's clock in the headers at `packet`. */
uint32_t ll_tcp_time_ms(const uint8_t *packet);

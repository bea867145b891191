/* A link in a block of its own, and the packets that tests send: numbered, with a body that follows from the
 * number. */
#pragma once

#include <stdlib.h>
#include <string.h>

#include "link/link.h"

typedef struct packet {
    int64_t number;
    unsigned char body[120];
} packet;

static inline ll_link *link_open(int slots, int arena_bytes, uint64_t seed, uint64_t stream)
{
    ll_link *link = malloc(ll_link_size(slots, arena_bytes));
    assert_non_null(link);
    memset(link, 0xa5, ll_link_size(slots, arena_bytes)); /* init must not rely on zeros */
    ll_link_init(link, slots, arena_bytes, seed, stream);
    return link;
}

static inline int packet_size(int64_t number)
{
    return 8 + (int)(number * 7 % 113);
}

static inline packet packet_make(int64_t number)
{
    packet p = {.number = number};
    for (size_t i = 0; i < sizeof p.body; i++)
        p.body[i] = (unsigned char)(number * 31 + (int64_t)i);
    return p;
}

static inline ll_sending packet_send(ll_link *link, const ll_link_params *params, double lag_ms, ll_time now,
                                     int64_t number)
{
    packet p = packet_make(number);
    return ll_link_send(link, params, lag_ms, now, &p, packet_size(number));
}

/* Takes the next packet due; returns its number, or -1. Bytes and size must be those that were sent. */
static inline int64_t packet_receive(ll_link *link, ll_time now, ll_time *sent, ll_time *due)
{
    packet p;
    memset(&p, 0x5a, sizeof p);
    int size = ll_link_receive(link, now, &p, (int)sizeof p, sent, due);
    if (size < 0)
        return -1;
    packet want = packet_make(p.number);
    assert_int_equal(size, packet_size(p.number));
    assert_memory_equal(&p, &want, (size_t)size);
    return p.number;
}

/* A link in a block of its own, and the packets that tests send: numbered, with a body that follows from the
 * number. */
#pragma once

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/link.h"
#include "support/near.h"

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
    return link_send(link, params, lag_ms, now, &p, packet_size(number));
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

/* ---- many packets: short ones, a step apart ---- */

#define STEP (LL_SECOND / 60)

static inline void link_drain(ll_link *link, ll_time now)
{
    char bytes[256];
    ll_time sent, due;
    while (ll_link_receive(link, now, bytes, (int)sizeof bytes, &sent, &due) >= 0)
        ;
}

/* Sends `count` packets and returns the result of each; the caller frees. Each is taken out at once: packets
 * in flight do not matter here, and the whole-structure checks would walk them. */
static inline ll_sending *link_send_many(ll_link *link, const ll_link_params *params, double lag_ms,
                                         int64_t count)
{
    ll_sending *sendings = malloc((size_t)count * sizeof *sendings);
    assert_non_null(sendings);
    for (int64_t i = 0; i < count; i++) {
        sendings[i] = link_send(link, params, lag_ms, i * STEP, &i, (int)sizeof i);
        link_drain(link, LL_NEVER - 1);
    }
    return sendings;
}

static inline ll_link_params link_params(void)
{
    ll_link_params params;
    ll_param_defaults(&ll_link_table, &params);
    return params;
}

/* Mean of a series and its standard error. Successive values may be correlated, so the error is that of the
 * means of 100 batches, which are nearly independent where a batch is much longer than the correlation. */
#define BATCHES 100

typedef struct estimate {
    double mean, error;
} estimate;

static inline estimate estimate_of(const double *x, int64_t count)
{
    double sum = 0, squares = 0;
    int64_t length = count / BATCHES;
    for (int b = 0; b < BATCHES; b++) {
        double batch = 0;
        for (int64_t i = 0; i < length; i++)
            batch += x[b * length + i];
        sum += batch / (double)length;
        squares += batch / (double)length * (batch / (double)length);
    }
    double mean = sum / BATCHES;
    return (estimate){mean, sqrt((squares / BATCHES - mean * mean) / (BATCHES - 1))};
}

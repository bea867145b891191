/* Shared by the two files of a link: sending.c decides the fate of a message, line.c keeps those in flight,
 * and takes the usual message, whose fate is known. */
#pragma once

#include "link/line/link.h"
#include "link/stages/stage.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

struct ll_link {
    uint64_t seed, stream;
    int64_t number;     /* of the next message */
    int64_t delivered;  /* highest number delivered so far */
    ll_time latest;     /* latest due time so far: for fifo */
    int32_t slots;      /* limit of messages in flight */
    int32_t arena;      /* limit of their bytes */
    int32_t first, end; /* of the queue */
    int32_t bytes;      /* in flight or held */
    int32_t top;        /* end of the used part of the store */
    int32_t held;       /* held packets at the end of the queue */
    int32_t places;     /* of the ring */
    int64_t packet;     /* number of the next one; fragments count */
    ll_memory memory;
    int64_t delay_number; /* number of the last packet sent by a link with impairments */
    double delay_ms;      /* its delay: for the statistics */
    ll_link_stats stats;
};

#pragma GCC diagnostic pop

/* Whether a message of `size` bytes fits. */
static inline bool ll_link_has_room(const ll_link *l, int32_t size)
{
    return l->end - l->first < l->slots && l->bytes + size <= l->arena;
}

static inline void ll_link_count_delay(ll_link *l, double delay_ms)
{
    ll_link_stats *s = &l->stats;
    s->delay.min_ms = delay_ms < s->delay.min_ms ? delay_ms : s->delay.min_ms;
    s->delay.max_ms = delay_ms > s->delay.max_ms ? delay_ms : s->delay.max_ms;
    s->delay.sum_ms += delay_ms;
    s->delay.sum_squares += delay_ms * delay_ms;
}

/* Due time of a packet that passed all stages and would arrive at `due`, in the configured order. */
static inline ll_time ll_link_arrival(ll_link *l, ll_order order, ll_time now, ll_time due, double delay_ms)
{
    if (order == LL_ORDER_FIFO && due < l->latest) {
        due = l->latest;
        delay_ms = ll_to_ms(due - now);
    }
    l->latest = due > l->latest ? due : l->latest;
    ll_link_count_delay(l, delay_ms);
    return due;
}

/* Stores the message, or a copy of it, to be received at `due`. There must be room. */
void ll_link_put(ll_link *link, ll_time now, ll_time due, const void *bytes, int32_t size);

/* Marks the message stored last, in byte `at`. */
void ll_link_mark(ll_link *link, int32_t size, uint32_t at);

/* Ring of departures of the rate's queue, with `places` elements. */
uint32_t *ll_link_ring(const ll_link *link);

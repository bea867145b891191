/* What the two files of a link share: sending.c says what becomes of a message, line.c keeps those that are
 * on their way. */
#pragma once

#include "link/line/link.h"
#include "link/stages/stage.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

struct ll_link {
    uint64_t seed, stream;
    int64_t number;     /* of the next message */
    int64_t delivered;  /* the highest number delivered so far */
    ll_time latest;     /* due time of the packet due last so far: for fifo */
    int32_t slots;      /* limit of messages in flight */
    int32_t arena;      /* limit of their bytes */
    int32_t first, end; /* of the queue */
    int32_t bytes;      /* in flight or held */
    int32_t top;        /* the store is in use up to here */
    int32_t held;       /* packets at the queue's end that are */
    int32_t places;     /* of the ring */
    int64_t packet;     /* number of the next one: fragments count each */
    ll_memory memory;
    int64_t delay_number; /* of the last packet that was put on its way by a link with impairments */
    double delay_ms;      /* and its delay: for the statistics */
    ll_link_stats stats;
};

#pragma GCC diagnostic pop

/* Whether a message of `size` bytes may be put on its way. */
static inline bool ll_link_has_room(const ll_link *l, int32_t size)
{
    return l->end - l->first < l->slots && l->bytes + size <= l->arena;
}

/* There is room. Takes the message that is being sent, or a copy of it, to be received at `due`. */
void ll_link_put(ll_link *link, ll_time now, ll_time due, const void *bytes, int32_t size);

/* The departures of the rate's queue, of which `places` fit. */
uint32_t *ll_link_ring(const ll_link *link);

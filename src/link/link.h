/* One direction of an impaired network path, in netem's terms.
 *
 * Packets go in at a virtual time and come out at their due time, in an order fixed by (due time, order of
 * sending). Their fate is drawn when they are sent: one draw per packet and stage from a stream of its own,
 * also where a stage is off, so that switching one impairment on does not reshuffle the others. The stages,
 * in order: loss, duplicate, delay + jitter.
 *
 * A link is a relocatable part of a simulation's block: offsets, no pointers. It holds at most `slots`
 * packets and `arena` bytes in flight; a packet beyond is dropped and counted (netem's `limit`). No
 * allocation. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vtime.h"
#include "param/param.h"

typedef enum ll_distribution { LL_DISTRIBUTION_UNIFORM, LL_DISTRIBUTION_NORMAL } ll_distribution;
typedef enum ll_order { LL_ORDER_FREE, LL_ORDER_FIFO } ll_order;

/* Parameters of one direction; `ll_link_table` gives names, ranges and defaults. */
typedef struct ll_link_params {
    double delay_ms;      /* added to the player's lag_ms, 0 to 1000 */
    double jitter_ms;     /* uniform: half-width; normal: standard deviation; 0 to 500 */
    int32_t distribution; /* ll_distribution */
    int32_t order;        /* ll_order: free = sorted by due time; fifo = never before an earlier packet */
    double loss_pct;      /* 0 to 100 */
    double duplicate_pct; /* 0 to 100; the copy draws its own delay */
} ll_link_params;

extern const ll_param_table ll_link_table;

typedef enum ll_fate { LL_FATE_DELIVERED, LL_FATE_LOST, LL_FATE_OVERFLOW } ll_fate;

/* What became of one sending: known at once, since the link draws it at once. */
typedef struct ll_sending {
    ll_fate fate;
    ll_time due;     /* when delivered */
    bool duplicated; /* a copy is delivered at `copy_due` */
    ll_time copy_due;
} ll_sending;

/* Realised statistics, to stand next to the configured ones. sent - lost - overflowed + duplicated is what
 * was put on its way: the delays are those of it, as drawn or, in fifo order, as they became. */
typedef struct ll_link_stats {
    int64_t sent, lost;
    int64_t duplicated; /* copies drawn */
    int64_t overflowed; /* packets and copies beyond the limits */
    int64_t delivered;  /* copies too */
    int64_t reordered;  /* deliveries after that of a packet sent later */
    int64_t bytes;      /* of all sendings, without copies */
    double delay_sum_ms, delay_sum_squares;
    double delay_min_ms, delay_max_ms; /* the least is 1e9 before the first */
} ll_link_stats;

typedef struct ll_link ll_link; /* lives in a block; size from ll_link_size */

size_t ll_link_size(int slots, int arena_bytes); /* a multiple of 8 */
void ll_link_init(ll_link *link, int slots, int arena_bytes, uint64_t seed, uint64_t stream);

/* Sends `size` bytes (at most the arena) at `now` with `lag_ms` of base delay. A delay below zero (normal
 * jitter) counts as zero. */
ll_sending ll_link_send(ll_link *link, const ll_link_params *params, double lag_ms, ll_time now,
                        const void *bytes, int size);

ll_time ll_link_next_due(const ll_link *link); /* LL_NEVER when empty */

/* Takes the next packet due at or before `now`; copies it out. Returns its size, or -1 when none is due. */
int ll_link_receive(ll_link *link, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due);

void ll_link_clear(ll_link *link); /* drops what is in flight; fifo order starts anew */
int ll_link_in_flight(const ll_link *link);
const ll_link_stats *ll_link_get_stats(const ll_link *link);
bool ll_link_valid(const ll_link *link); /* whole-structure check for LL_VALIDATE */

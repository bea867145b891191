/* A de-jitter (playout) buffer: holds packets back so that they come out in the rhythm in which they were
 * sent.
 *
 * When a packet is due is decided as it arrives, by one of the policies in ll_dejitter_policies. Those that
 * go by send times measure them against the fastest packet of the last two seconds: sender's and receiver's
 * clock need not agree. A packet that comes after its time is late: it is due at once.
 *
 * The buffer holds ids and times; bytes are its user's to store. It is a relocatable part of a simulation's
 * block: fixed capacity, no pointers, no allocation. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vtime.h"

typedef enum ll_dejitter_choice {
    LL_DEJITTER_NONE,
    LL_DEJITTER_ARRIVAL,
    LL_DEJITTER_SEND_TIME,
    LL_DEJITTER_MIRROR,
    LL_DEJITTER_NFE
} ll_dejitter_choice;

typedef struct ll_dejitter_params {
    double delay_ms;    /* of `arrival` and `send_time`; the least of `nfe` */
    double interval_ms; /* between packets, as the receiver was told; above 0: `mirror` and `nfe` */
    int32_t policy;     /* ll_dejitter_choice */
    int32_t reserved;
} ll_dejitter_params;

extern const char *const ll_dejitter_names[]; /* by ll_dejitter_choice, NULL at the end */

typedef struct ll_dejitter_packet {
    int64_t id; /* its user's */
    ll_time sent, arrived, due;
} ll_dejitter_packet;

/* Counts of what was pushed, as it was decided then. */
typedef struct ll_dejitter_stats {
    int64_t pushed;
    int64_t overflowed;                /* came to a full buffer and were dropped */
    int64_t late;                      /* came after their time */
    int64_t underruns;                 /* of these, the first after the buffer had run empty */
    double added_sum_ms, added_max_ms; /* delay by the buffer, of all that were not dropped */
    int64_t depth_sum, depth_max;      /* packets in the buffer, after each that was not dropped */
} ll_dejitter_stats;

typedef struct ll_dejitter ll_dejitter; /* lives in a block; size from ll_dejitter_size */

size_t ll_dejitter_size(int capacity); /* a multiple of 8 */
void ll_dejitter_init(ll_dejitter *buffer, int capacity);

/* Takes in a packet that arrives now, not before any earlier one; `sent` is by the sender's clock. False when
 * the buffer is full. */
bool ll_dejitter_push(ll_dejitter *buffer, const ll_dejitter_params *params, int64_t id, ll_time sent,
                      ll_time arrived);

ll_time ll_dejitter_next_due(const ll_dejitter *buffer); /* LL_NEVER when empty */

/* Takes out the next packet due at or before `now`; false when none is. */
bool ll_dejitter_pop(ll_dejitter *buffer, ll_time now, ll_dejitter_packet *packet);

void ll_dejitter_clear(
    ll_dejitter *buffer); /* drops what is held and forgets what was learnt; statistics stay */

int ll_dejitter_depth(const ll_dejitter *buffer);
const ll_dejitter_packet *
ll_dejitter_packets(const ll_dejitter *buffer); /* so many, in the order of playing */
ll_time
ll_dejitter_delay(const ll_dejitter *buffer); /* in use: behind arrival, or behind the fastest packet */
const ll_dejitter_stats *ll_dejitter_get_stats(const ll_dejitter *buffer);
bool ll_dejitter_valid(const ll_dejitter *buffer); /* whole-structure check for LL_VALIDATE */

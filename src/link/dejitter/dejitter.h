/* De-jitter (play-out) buffer: holds packets back so that they leave in the rhythm in which they were sent.
 *
 * The due time of a packet is decided on arrival, by a policy of ll_dejitter_policies. Policies that use send
 * times measure them against the fastest packet of the last two seconds: the clocks of sender and receiver
 * may differ. A packet after its time is late: it is due at once.
 *
 * The buffer holds ids and times; its user stores the bytes. It is a relocatable part of a simulation's
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
    LL_DEJITTER_NFE,
    LL_DEJITTER_CHOICES
} ll_dejitter_choice;

typedef struct ll_dejitter_params {
    double delay_ms;    /* of `arrival` and `send_time`; minimum of `nfe` */
    double interval_ms; /* between packets, as the receiver knows it; above 0: `mirror` and `nfe` */
    int32_t policy;     /* ll_dejitter_choice */
    int32_t reserved;
} ll_dejitter_params;

extern const char *const ll_dejitter_names[]; /* in the order of ll_dejitter_choice, NULL-terminated */

typedef struct ll_dejitter_packet {
    int64_t id; /* chosen by the user */
    ll_time sent, arrived, due;
} ll_dejitter_packet;

/* Counters of pushed packets, decided on arrival. */
typedef struct ll_dejitter_stats {
    int64_t pushed;
    int64_t overflowed;                /* arrived at a full buffer and were dropped */
    int64_t late;                      /* arrived after their time */
    int64_t underruns;                 /* late packets that were the first after an empty buffer */
    double added_sum_ms, added_max_ms; /* delay added by the buffer, of all that were not dropped */
    int64_t depth_sum, depth_max;      /* packets in the buffer, after each that was not dropped */
} ll_dejitter_stats;

typedef struct ll_dejitter ll_dejitter; /* part of a block; size from ll_dejitter_size */

size_t ll_dejitter_size(int capacity); /* a multiple of 8 */
void ll_dejitter_init(ll_dejitter *buffer, int capacity);

/* Adds a packet that arrives now, not before any earlier one; `sent` is by the sender's clock. False if the
 * buffer is full. */
bool ll_dejitter_push(ll_dejitter *buffer, const ll_dejitter_params *params, int64_t id, ll_time sent,
                      ll_time arrived);

ll_time ll_dejitter_next_due(const ll_dejitter *buffer); /* LL_NEVER if empty */

/* Removes the next packet due at or before `now`; false if there is none. */
bool ll_dejitter_pop(ll_dejitter *buffer, ll_time now, ll_dejitter_packet *packet);

void ll_dejitter_clear(ll_dejitter *buffer); /* drops all packets and the history; keeps statistics */

int ll_dejitter_depth(const ll_dejitter *buffer);
const ll_dejitter_packet *
ll_dejitter_packets(const ll_dejitter *buffer); /* this many, in the order of play-out */
ll_time
ll_dejitter_delay(const ll_dejitter *buffer); /* current delay after arrival, or after the fastest packet */
const ll_dejitter_stats *ll_dejitter_get_stats(const ll_dejitter *buffer);
bool ll_dejitter_valid(const ll_dejitter *buffer); /* checks the whole structure, for LL_VALIDATE */

/* ---- policies, and what tests of them know; each costs a few multiplications per packet ---- */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* part of a block that is hashed */

/* History of the packets so far; each policy owns its estimates. */
typedef struct ll_dejitter_history {
    int64_t packets;                                /* before the current one */
    ll_time sent, arrived;                          /* of the last packet */
    ll_time delay;                                  /* current one */
    double gap_ms, spread_ms, arrivals_ms, late_ms; /* running averages */
} ll_dejitter_history;

#pragma GCC diagnostic pop

/* The current packet. */
typedef struct ll_dejitter_arrival {
    ll_time sent, arrived;
    double late_ms; /* relative to the fastest packet, at least 0 */
} ll_dejitter_arrival;

typedef struct ll_dejitter_policy {
    /* Due `delay` after sending, in the order of sending; else after arrival, in that order. */
    bool by_sending;
    ll_time (*delay)(ll_dejitter_history *history, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet);
} ll_dejitter_policy;

extern const ll_dejitter_policy ll_dejitter_policies[]; /* in the order of ll_dejitter_choice */

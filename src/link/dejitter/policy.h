/* Policies of a de-jitter buffer and their data. One file per policy; each costs a few multiplications per
 * packet. */
#pragma once

#include "link/dejitter/dejitter.h"

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
    const char *name;
    bool by_sending; /* due `delay` after sending, in the order of sending; else after arrival, in that order
                      */
    ll_time (*delay)(ll_dejitter_history *history, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet);
} ll_dejitter_policy;

extern const ll_dejitter_policy ll_dejitter_none, ll_dejitter_arrival_plus, ll_dejitter_send_time,
    ll_dejitter_mirror, ll_dejitter_nfe;
extern const ll_dejitter_policy
    *const ll_dejitter_policies[]; /* in the order of ll_dejitter_choice, NULL-terminated */

/* Updates a running average. */
static inline void ll_dejitter_average(double *average, double value, double weight)
{
    *average += weight * (value - *average);
}

/* Moves the current delay towards `want`: it grows by at most the fraction `up` of the time since the last
 * packet, which slows play-out by as much, and shrinks by at most the fraction `down`. */
ll_time ll_dejitter_approach(const ll_dejitter_history *history, const ll_dejitter_arrival *packet,
                             double want_ms, double up, double down);

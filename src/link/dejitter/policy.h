/* What a policy of a de-jitter buffer is and may know. One file per policy; each costs a few multiplications
 * a packet. */
#pragma once

#include "link/dejitter/dejitter.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* part of a block that is hashed */

/* What the buffer knows of the packets so far; the estimates are the policy's own. */
typedef struct ll_dejitter_history {
    int64_t packets;                                /* before the present one */
    ll_time sent, arrived;                          /* of the one that arrived before it */
    ll_time delay;                                  /* in use */
    double gap_ms, spread_ms, arrivals_ms, late_ms; /* running averages */
} ll_dejitter_history;

#pragma GCC diagnostic pop

/* The present packet beside it. */
typedef struct ll_dejitter_arrival {
    ll_time sent, arrived;
    double late_ms; /* behind the fastest packet, at least 0 */
} ll_dejitter_arrival;

typedef struct ll_dejitter_policy {
    const char *name;
    bool by_sending; /* due `delay` after sending, in the order of sending; otherwise after arrival, in that
                        order */
    ll_time (*delay)(ll_dejitter_history *history, const ll_dejitter_params *params,
                     const ll_dejitter_arrival *packet);
} ll_dejitter_policy;

extern const ll_dejitter_policy ll_dejitter_none, ll_dejitter_arrival_plus, ll_dejitter_send_time,
    ll_dejitter_mirror, ll_dejitter_nfe;
extern const ll_dejitter_policy *const ll_dejitter_policies[]; /* by ll_dejitter_choice, NULL at the end */

/* Moves an average towards a value. */
static inline void ll_dejitter_average(double *average, double value, double weight)
{
    *average += weight * (value - *average);
}

/* The delay in use, `want` but for its speed: it grows by at most the share `up` of the time since the packet
 * before, which slows playing down by as much, and shrinks by at most the share `down`. */
ll_time ll_dejitter_approach(const ll_dejitter_history *history, const ll_dejitter_arrival *packet,
                             double want_ms, double up, double down);

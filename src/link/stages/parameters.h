/* Impairments of one direction of a network path, the fate of a message on it, and its statistics. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vtime.h"
#include "link/profile/profile.h"
#include "param/param.h"

/* How a delay varies: delay + jitter * variate.
 * uniform: in [-1, 1), so that the jitter is the half-width (netem's default distribution).
 * The others have mean 0 and standard deviation 1, so that the jitter is the standard deviation:
 * normal: standard normal, cut off at 4 standard deviations and scaled by 1 / 0.9994645; at most 4.0021.
 * pareto: shape 3, minimum 1, cut off at 10, which 0.1 % exceed; minus its mean 55/37, over its
 *     standard deviation 0.7021828; from -0.6928 to 12.1244.
 * paretonormal: (normal + 3 pareto) / 4 at the same quantile, over 0.9579611; from -1.5869 to 10.5368.
 * Shapes and mixture are those of iproute2's netem/pareto.c and paretonormal.c, whose tables end at 4 and
 * have other variances than 1. A sum of lag, delay and jitter below zero counts as zero. */
/* clang-format off */
#define LL_DELAY_MODELS(ROW) \
    ROW(UNIFORM, uniform) \
    ROW(NORMAL, normal) \
    ROW(PARETO, pareto) \
    ROW(PARETONORMAL, paretonormal)
/* clang-format on */

#define LL_DELAY_KIND(KIND, NAME) LL_DISTRIBUTION_##KIND,
typedef enum ll_distribution { LL_DELAY_MODELS(LL_DELAY_KIND) LL_DISTRIBUTIONS } ll_distribution;
#undef LL_DELAY_KIND

typedef enum ll_order { LL_ORDER_FREE, LL_ORDER_FIFO } ll_order;

/* random: loss_pct, with loss_corr_pct. gemodel (Gilbert-Elliott): loss probability 1-h in the bad state, 1-k
 * in the good one; transition p from good to bad, r back.
 *     Each packet draws the transition, then the loss in the state before it.
 * state: netem's four states: 1 received and 4 isolated loss, within a gap; 3 lost and 2 received, within a
 * burst. The fate of a
 *     packet is that of its new state. 4 always leads to 1. */
/* clang-format off */
#define LL_LOSS_MODELS(ROW) \
    ROW(RANDOM, random) \
    ROW(GEMODEL, gemodel) \
    ROW(STATE, state)
/* clang-format on */

#define LL_LOSS_KIND(KIND, NAME) LL_LOSS_##KIND,
typedef enum ll_loss { LL_LOSS_MODELS(LL_LOSS_KIND) LL_LOSSES } ll_loss;
#undef LL_LOSS_KIND

/* Parameters of one direction; `ll_link_table` gives names, ranges and defaults.
 *
 * Correlations are those of successive packets and keep mean and variance; netem's (x' = rho x + (1 - rho) u)
 * reduce the variance, and with it rates. Delays follow a first-order autoregressive normal process, mapped
 * to their distribution (a Gaussian copula) so that their own correlation is the configured one. Loss,
 * duplicate, reorder and corrupt are two-state chains: after a packet to which it happened the probability is
 * p + corr (1 - p), otherwise p (1 - corr). */
typedef struct ll_link_params {
    double delay_ms; /* added to the player's lag_ms */
    double jitter_ms, delay_corr_pct;
    double loss_pct, loss_corr_pct;
    double ge_p_pct, ge_r_pct, ge_1h_pct, ge_1k_pct;
    double p13_pct, p31_pct, p32_pct, p23_pct, p14_pct;
    double blackout_at_ms, blackout_every_ms, blackout_length_ms; /* periods in which all packets are lost */
    double duplicate_pct, duplicate_corr_pct;
    double spike_at_ms, spike_every_ms, spike_length_ms, spike_add_ms; /* periods of longer delay */
    double rate_kbps, limit_ms;                                        /* rate 0: no queue */
    int64_t limit_packets, packet_overhead_bytes;
    int64_t mtu_bytes; /* longest message in one packet; 0: never split */
    double reorder_pct, reorder_corr_pct;
    int64_t reorder_gap;
    double corrupt_pct, corrupt_corr_pct;
    int32_t distribution; /* ll_distribution */
    int32_t order;        /* ll_order: free = sorted by due time; fifo = never before an earlier packet */
    int32_t loss_model;   /* ll_loss */
    int32_t profile;      /* 0: none, otherwise the number of the profile plus 1 */
} ll_link_params;

extern const ll_param_table ll_link_table;

/* Longest time that a packet can take with these parameters and `lag_ms` of base delay. (In fifo order it may
 * also wait for a packet that was sent with others.) */
double ll_link_delay_max_ms(const ll_link_params *params, double lag_ms);
/* The same with a profile; NULL: without. */
double ll_link_delay_max_with_ms(const ll_link_params *params, double lag_ms,
                                 const ll_profile_params *profile);

#define LL_MTU_MIN 64        /* minimum of mtu_bytes other than 0 */
#define LL_FRAGMENT_HEADER 4 /* bytes before a fragment: its index, their count and the message */

/* lost: by the loss model or in a blackout. overflow: beyond the limits of the queue or of the link.
 * corrupted: arrives when due, and the receiver's checksum drops it. */
typedef enum ll_fate { LL_FATE_DELIVERED, LL_FATE_LOST, LL_FATE_OVERFLOW, LL_FATE_CORRUPTED } ll_fate;

/* Fate of one message: known at once. Of a split message: fate of its first fragment that did not arrive,
 * `due` when the last one arrives, and no copy, queue or reordering. */
typedef struct ll_sending {
    ll_fate fate;
    ll_time due;       /* if delivered or corrupted; else when sent */
    ll_time queued;    /* of that: waiting and transmission in the rate's queue */
    int32_t fragments; /* packets; 1 if not split */
    bool reordered;    /* reordered ahead, without its delay */
    bool duplicated;
    bool rescued;      /* one of two copies was lost and the other went on; the copy is the lost one */
    bool marked;       /* by ECN */
    ll_fate copy_fate; /* of the copy */
    ll_time copy_due;  /* like `due` */
} ll_sending;

/* A packet of a message as it was put on the link: for captures. */
typedef struct ll_link_packet {
    const void *message;  /* whole, and valid during the call */
    int32_t size;         /* of the message */
    int64_t number;       /* of the message, from 0 */
    int32_t index, count; /* of the fragment; 0 and 1: the message is one packet */
    bool duplicated;
    ll_fate fate, copy_fate;
    ll_time due, copy_due; /* if delivered or corrupted */
} ll_link_packet;

/* Fragments of long messages. */
typedef struct ll_fragment_stats {
    int64_t split;      /* messages of more than one packet */
    int64_t split_lost; /* of these */
    int64_t count;      /* their packets */
    int64_t lost;       /* neither they nor their copies arrived */
} ll_fragment_stats;

/* Delays of packets that were stored, copies included: as drawn or, in fifo order, as they became. */
typedef struct ll_delay_stats {
    double sum_ms, sum_squares;
    double min_ms, max_ms; /* the minimum is 1e9 before the first */
    double step_squares;   /* of the differences of the delays of successive packets */
    int64_t pairs;         /* their number, on a link with impairments */
} ll_delay_stats;

/* Packets and copies that passed the rate's queue. */
typedef struct ll_queue_stats {
    int64_t count;
    double sum_ms, max_ms; /* waiting and transmission */
} ll_queue_stats;

/* Measured statistics, to compare with the configured ones; of packets unless they say messages. */
typedef struct ll_link_stats {
    int64_t carried;    /* messages in flight when counting began */
    int64_t sent, lost; /* lost: includes copies */
    int64_t lost_copies;
    int64_t lost_in_blackouts; /* includes copies */
    int64_t loss_bursts; /* runs of lost packets: their mean length is (lost - lost_copies) / loss_bursts */
    int64_t duplicated;  /* copies drawn */
    int64_t rescued;     /* losses of one of two copies; the other then had no draw */
    int64_t overflowed;  /* packets and copies beyond the link's slots and arena */
    int64_t queue_drops; /* packets and copies beyond limit_packets or limit_ms */
    int64_t corrupted;   /* includes copies */
    int64_t delivered;   /* messages, including copies */
    int64_t reordered;   /* deliveries after a message sent later */
    int64_t reordered_ahead; /* by the stage `reorder`; includes copies */
    int64_t bytes;           /* of all messages, without copies and headers */
    int64_t messages_lost;   /* not received, or not completely, for any reason */
    ll_fragment_stats fragments;
    ll_delay_stats delay;
    ll_queue_stats queue;
} ll_link_stats;

/* One direction of an impaired network path, in netem's terms. docs/links.md has every rule in full.
 *
 * Messages are sent at a virtual time and received at their due time, in an order fixed by (due time, order
 * of sending). A message longer than mtu_bytes travels as several packets (fragments), others as one.
 *
 * The fate of packets is drawn when they are sent, in stages: duplicate, loss, corrupt, limit of the queue,
 * delay + jitter or reorder, rate. Each stage draws once per packet, also for packets that an earlier stage
 * dropped, from its own stream by the number of the message and of the fragment: switching one impairment on
 * does not change the draws of the others. A copy has its own draws from the loss on.
 *
 * So the fate of a message is known when it is sent. It is stored once, due when its last fragment arrives,
 * or not at all; a duplicated message of one packet arrives twice.
 *
 * A link is a relocatable part of a simulation's block: offsets, no pointers. It holds at most `slots`
 * messages and `arena` bytes in flight; excess messages are dropped and counted. No allocation. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vtime.h"
#include "param/param.h"

/* How a delay varies: delay + jitter * variate.
 * uniform: in [-1, 1), so that the jitter is the half-width (netem's default distribution).
 * The others have mean 0 and standard deviation 1, so that the jitter is the standard deviation:
 * normal: standard normal, cut off at 4 standard deviations and scaled by 1 / 0.9994645; at most 4.0021.
 * pareto: shape 3, minimum 1, cut off at 10, which 0.1 % exceed; minus its mean 55/37, over its standard
 *     deviation 0.7021828; from -0.6928 to 12.1244.
 * paretonormal: (normal + 3 pareto) / 4 at the same quantile, over 0.9579611; from -1.5869 to 10.5368.
 * Shapes and mixture are those of iproute2's netem/pareto.c and paretonormal.c, whose tables end at 4 and
 * have other variances than 1. A sum of lag, delay and jitter below zero counts as zero. */
typedef enum ll_distribution {
    LL_DISTRIBUTION_UNIFORM,
    LL_DISTRIBUTION_NORMAL,
    LL_DISTRIBUTION_PARETO,
    LL_DISTRIBUTION_PARETONORMAL
} ll_distribution;

typedef enum ll_order { LL_ORDER_FREE, LL_ORDER_FIFO } ll_order;

/* random: loss_pct, with loss_corr_pct. gemodel (Gilbert-Elliott): loss probability 1-h in the bad state, 1-k
 * in the good one; transition p from good to bad, r back.
 *     Each packet draws the transition, then the loss in the state before it.
 * state: netem's four states: 1 received and 4 isolated loss, within a gap; 3 lost and 2 received, within a
 * burst. The fate of a
 *     packet is that of its new state. 4 always leads to 1. */
typedef enum ll_loss { LL_LOSS_RANDOM, LL_LOSS_GEMODEL, LL_LOSS_STATE } ll_loss;

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
    double blackout_at_ms, blackout_every_ms, blackout_length_ms; /* periods in which all is lost */
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
    int32_t reserved;
} ll_link_params;

extern const ll_param_table ll_link_table;

/* Longest time that a packet can take with these parameters and `lag_ms` of base delay. (In fifo order it may
 * also wait for a packet that was sent with others.) */
double ll_link_delay_max_ms(const ll_link_params *params, double lag_ms);

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
    ll_fate copy_fate; /* of the copy */
    ll_time copy_due;  /* like `due` */
} ll_sending;

/* Measured statistics, to compare with the configured ones; of packets unless they say messages. Delays are
 * those of packets that were stored, copies included: as drawn or, in fifo order, as they became. */
typedef struct ll_link_stats {
    int64_t carried;    /* messages in flight when counting began */
    int64_t sent, lost; /* lost: includes copies */
    int64_t lost_copies;
    int64_t lost_in_blackouts; /* includes copies */
    int64_t loss_bursts;   /* runs of lost packets: their mean length is (lost - lost_copies) / loss_bursts */
    int64_t duplicated;    /* copies drawn */
    int64_t rescued;       /* losses of one of two copies; the other then had no draw */
    int64_t overflowed;    /* packets and copies beyond the link's slots and arena */
    int64_t queue_drops;   /* packets and copies beyond limit_packets or limit_ms */
    int64_t corrupted;     /* includes copies */
    int64_t delivered;     /* messages, including copies */
    int64_t reordered;     /* deliveries after a message sent later */
    int64_t sent_ahead;    /* by the stage `reorder`; includes copies */
    int64_t bytes;         /* of all messages, without copies and headers */
    int64_t messages_lost; /* not received, or not completely, for any reason */
    int64_t split;         /* messages of more than one packet */
    int64_t split_lost;    /* of these */
    int64_t fragments;     /* their packets */
    int64_t fragments_lost; /* neither they nor their copies arrived */
    double delay_sum_ms, delay_sum_squares;
    double delay_min_ms, delay_max_ms; /* the minimum is 1e9 before the first */
    double delay_step_squares;         /* of the differences of the delays of successive packets */
    int64_t delay_pairs;               /* their number, on a link with impairments */
    int64_t queued;                    /* packets and copies that passed the rate's queue */
    double queue_sum_ms, queue_max_ms; /* waiting and transmission */
} ll_link_stats;

typedef struct ll_link ll_link; /* part of a block; size from ll_link_size */

size_t ll_link_size(int slots, int arena_bytes); /* a multiple of 8 */
void ll_link_init(ll_link *link, int slots, int arena_bytes, uint64_t seed, uint64_t stream);

/* Sends `size` bytes (at most the arena) at `now` with `lag_ms` of base delay. No message may take 2^32 ns or
 * more; see ll_link_delay_max_ms. */
ll_sending ll_link_send(ll_link *link, const ll_link_params *params, double lag_ms, ll_time now,
                        const void *bytes, int size);

ll_time ll_link_next_due(const ll_link *link); /* LL_NEVER if empty */

/* Removes the next message due at or before `now` and copies it out. Returns its size, or -1 if there is
 * none. */
int ll_link_receive(ll_link *link, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due);

/* Keeps a message just received for its receiver's de-jitter buffer, which holds times only: its place in the
 * link is still free. It is no longer in flight. */
void ll_link_hold(ll_link *link, uint32_t id, const void *bytes, int size);

/* Removes the first message held as `id` and copies it out; returns its size. It must exist. */
int ll_link_take_held(ll_link *link, uint32_t id, void *bytes, int capacity);

void ll_link_clear(ll_link *link); /* drops all messages; resets fifo order and the queue */
int ll_link_in_flight(const ll_link *link);
void ll_link_restart_stats(ll_link *link); /* counts from now on; messages in flight are still delivered */
const ll_link_stats *ll_link_get_stats(const ll_link *link);
int64_t ll_link_put_on_way(const ll_link_stats *stats); /* packets and copies */
int64_t ll_link_messages(const ll_link_stats *stats);   /* sent */
/* Fraction of loss draws with a loss, to compare with loss_pct: one draw per packet, and per copy unless both
 * were lost together. */
double ll_link_loss_pct(const ll_link_stats *stats);
/* Correlation of the delays of successive packets so far; 0 if they do not vary. */
double ll_link_delay_correlation(const ll_link_stats *stats);
bool ll_link_valid(const ll_link *link); /* checks the whole structure, for LL_VALIDATE */

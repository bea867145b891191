/* A queue that several links share: packets of all enter it in the order of time, among cross traffic, and
 * leave one by one at its rate. What a queue discipline drops is known when a packet enters: the queue is
 * first in, first out, and its past decides when the packet would be served.
 *
 * Cross traffic is a Poisson process of packets of one size: alone it is an M/D/1 queue, whose mean wait is
 * rho s / (2 (1 - rho)) at load rho and service time s. */
#pragma once

#include "base/vtime.h"
#include "param/param.h"

/* tail_drop: only the limit drops. codel: K. Nichols et al., RFC 8289, 2018. red: S. Floyd, V. Jacobson,
 * "Random early detection gateways for congestion avoidance", IEEE/ACM Trans. Networking 1(4), 1993. */
/* clang-format off */
#define LL_DISCIPLINES(ROW) \
    ROW(TAIL_DROP, tail_drop) \
    ROW(CODEL, codel) \
    ROW(RED, red)
/* clang-format on */

#define LL_DISCIPLINE_KIND(KIND, NAME) LL_DISCIPLINE_##KIND,
typedef enum ll_discipline { LL_DISCIPLINES(LL_DISCIPLINE_KIND) LL_DISCIPLINES_END } ll_discipline;
#undef LL_DISCIPLINE_KIND

typedef struct ll_bottleneck_params {
    double rate_kbps; /* 0: there is none */
    double limit_ms;  /* longest wait and transmission */
    double cross_load_pct;
    double codel_target_ms, codel_interval_ms;
    double red_min_ms, red_drop_pct; /* the upper threshold is three times the lower; the drops reach
                                        red_drop_pct there */
    int64_t cross_bytes;
    int32_t discipline; /* ll_discipline */
    bool ecn, reserved[3];
} ll_bottleneck_params;

extern const ll_param_table ll_bottleneck_table;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* part of a block, which is hashed */

typedef struct ll_bottleneck {
    ll_bottleneck_params params;
    uint64_t seed, stream; /* of gaps of cross traffic, and of the discipline: stream and stream + 1 */
    ll_time leaves;        /* the last packet in the queue */
    ll_time next_cross;    /* LL_NEVER before the first packet */
    int64_t crossed;       /* packets of cross traffic */
    int64_t arrivals;      /* all packets */
    double average_ms;     /* red */
    int64_t since_drop;
    ll_time first_above, drop_next; /* codel; LL_NEVER: not above */
    int64_t drop_count, count_before;
    int64_t dropping;
} ll_bottleneck;

#pragma GCC diagnostic pop

void ll_bottleneck_init(ll_bottleneck *queue, const ll_bottleneck_params *params, uint64_t seed,
                        uint64_t stream);

/* What becomes of a packet. */
typedef struct ll_bottleneck_fate {
    bool dropped;
    bool marked;            /* by ECN: the discipline would have dropped it */
    ll_time served, leaves; /* when its transmission would begin; when it ends */
} ll_bottleneck_fate;

/* A packet of `bytes` enters at `now`, which is not before the last one. `capable`: of ECN, so that it can be
 * marked. */
ll_bottleneck_fate ll_bottleneck_enter(ll_bottleneck *queue, ll_time now, int64_t bytes, bool capable);

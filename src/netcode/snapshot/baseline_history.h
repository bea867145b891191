/* Baseline history: the worlds that a server has recently sent, on the grid. Delta compression refers to
 * them, and rounding errors are measured on them.
 *
 * Part of a simulation's block: no pointers. One ring for all clients, since all are sent the same world:
 * clients differ only in which of these they have acknowledged. */
#pragma once

#include "base/histogram.h"
#include "netcode/protocol/quantization.h"

#define LL_BASELINES 32 /* 1.07 s at 30 updates per second; later acknowledgements get full snapshots */

/* in 64ths of a step: no position is further off than 1/sqrt(2) = 45.25 / 64 */
#define LL_ROUNDING_BUCKETS 46

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* |as sent - true| of positions. */
typedef struct ll_rounding {
    double sum, sum_squares, max; /* m */
    int64_t count;
    uint32_t bucket[LL_ROUNDING_BUCKETS];
} ll_rounding;

typedef struct ll_baseline_history {
    int32_t entities, tail;
    ll_quantization grid;
    int64_t count;         /* measured since the grid last changed */
    uint32_t tail_version; /* of the newest tail, which follows the ring */
    uint32_t replicated;   /* 1: the server also keeps replicas (netcode/snapshot/replica.h) */
    ll_rounding rounding;
    /* then LL_BASELINES records of {ll_baseline; ll_cell [entities]}, then the tail */
} ll_baseline_history;

typedef struct ll_baseline {
    int64_t tick;
    uint32_t tail_version; /* equal versions: the tails are the same bytes */
    uint32_t reserved;
    ll_cell cell[];
} ll_baseline;

#pragma GCC diagnostic pop

size_t ll_baseline_history_size(ll_extent extent); /* a multiple of 8 */
void ll_baseline_history_init(ll_baseline_history *b, ll_extent extent);
void ll_baseline_history_clear(ll_baseline_history *b);

/* Adds the world after step `tick` if it is not there, and returns it on the grid. Another grid clears the
 * ring. `counts`: rounding errors are measured. */
const ll_baseline *ll_baseline_history_take(ll_baseline_history *b, const ll_world *world, int64_t tick,
                                            const ll_quantization *grid, bool counts);
const ll_baseline *ll_baseline_history_find(const ll_baseline_history *b,
                                            int64_t tick); /* NULL: not there, or overwritten */

ll_summary
ll_rounding_summary(const ll_baseline_history *b); /* m; quantiles to a 64th of a step of the present grid */

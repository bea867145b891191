/* Shared by the files of this room: a packet's way through the stages of a link. Cost per packet: a disabled
 * stage costs a comparison or two, an enabled one a draw (a hash of three words) and its model. */
#pragma once

#include "base/rng.h"
#include "link/bottleneck/bottleneck.h"
#include "link/profile/profile.h"
#include "link/stages/parameters.h"

/* In the order of processing, which is netem's. */
typedef enum ll_stage {
    LL_STAGE_DUPLICATE,
    LL_STAGE_LOSS,
    LL_STAGE_TRACE, /* of a profile */
    LL_STAGE_CORRUPT,
    LL_STAGE_BOTTLENECK, /* shared with other links */
    LL_STAGE_CELLS,      /* of a profile */
    LL_STAGE_LIMIT,      /* of the rate's queue */
    LL_STAGE_DELAY,
    LL_STAGE_TABLE, /* of a profile, instead of the delay */
    LL_STAGE_REORDER,
    LL_STAGE_RATE,
    LL_STAGE_CAPACITY, /* of a profile, instead of the rate */
    LL_STAGE_SLOT,     /* of a profile */
    LL_STAGES
} ll_stage;

/* Streams of random numbers within a link. docs/links.md names them, so they must not change. */
typedef enum ll_stream {
    LL_STREAM_LOSS = 0,
    LL_STREAM_DUPLICATE = 1,
    LL_STREAM_DELAY = 2,
    LL_STREAM_REORDER = 4,
    LL_STREAM_CORRUPT = 5,
    LL_STREAM_TRANSITION = 6, /* of a loss model's state */
    LL_STREAM_SLOT = 7,
    LL_STREAMS = 8
} ll_stream;

#define LL_FRAGMENT_SHIFT 40 /* a fragment's draws: message + (fragment << 40) */
#define LL_QUEUE_MAX 1000    /* packets in a rate's queue; limit of limit_packets */

/* One packet, or its copy, in progress. */
typedef struct ll_passage {
    const ll_link_params *params;
    const ll_link_profile *profile; /* NULL: none */
    ll_profile_state *state;
    ll_bottleneck *bottleneck; /* NULL: none */
    uint64_t seed, stream;     /* of the link's draws */
    uint64_t counter;          /* of all draws */
    int64_t number;            /* of the packet, in the order of sending, for chains */
    ll_time now;
    double lag_ms;
    double delay_ms;      /* so far, including lag, without the queue */
    ll_time transmission; /* by the rate */
    ll_time queued;       /* in the rate's queue: waiting and transmission */
    ll_time due;
    uint32_t *departures; /* of that queue, for its limits: a ring of `places`, ns modulo 2^32 */
    int32_t places;
    int32_t size; /* in bytes, including a fragment's header */
    ll_fate fate;
    bool is_copy;
    bool duplicated; /* a copy exists */
    bool rescued;    /* a loss took the copy only */
    bool damaged, reordered;
    bool capable; /* of ECN: a queue may mark it instead of dropping it */
    bool marked;  /* by ECN */
} ll_passage;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded"

#define LL_NO_NUMBER (-2) /* of no packet, and not directly before the first one */

/* State of the stages between packets. Numbers are those of packets. */
typedef struct ll_memory {
    int64_t loss_number; /* `loss_state` is valid after this packet */
    int32_t loss_model, loss_state;
    int64_t lost;                             /* the last lost one */
    int64_t duplicated, reordered, corrupted; /* the last one to which it happened */
    int64_t since_reorder;                    /* packets since the last reordered one */
    int64_t deviate_number;
    double deviate;   /* normal, of the delay of that packet */
    ll_time entrance; /* time at which the rate would have sent all accepted packets, had they arrived without
                         delay */
    ll_time exit;     /* time at which the rate has sent the last one */
    int32_t queue_first, queue_count; /* of the ring of departures */
} ll_memory;

#pragma GCC diagnostic pop

/* Decides about one packet. If an earlier stage lost it, only the memory changes. */
typedef void ll_stage_pass(ll_passage *passage, ll_memory *memory, ll_link_stats *stats);
ll_stage_pass ll_stage_loss, ll_stage_limit, ll_stage_delay, ll_stage_rate;
ll_stage_pass ll_stage_trace, ll_stage_cells, ll_stage_table, ll_stage_capacity, ll_stage_slot,
    ll_stage_bottleneck;

/* Whether any stage is enabled: most links are plain, and pay only this check. */
static inline bool ll_stages_any(const ll_link_params *p)
{
    return p->loss_model != LL_LOSS_RANDOM ||
           ((p->loss_pct + p->blackout_length_ms) + (p->jitter_ms + p->spike_length_ms)) +
                   ((p->duplicate_pct + p->rate_kbps) + (p->reorder_pct + p->corrupt_pct)) >
               0;
}

/* Enabled stages: bit 1 << stage. */
uint32_t ll_stages_used(const ll_link_params *params);
uint32_t ll_stages_profiled(const ll_link_params *params, const ll_link_profile *profile);
void ll_stages_pass(uint32_t stages, ll_passage *passage, ll_memory *memory, ll_link_stats *stats);

/* Uniform in [0, 1). */
static inline double ll_draw(const ll_passage *p, ll_stream stream)
{
    return ll_rng_unit(p->seed, p->stream + (uint64_t)stream, p->counter);
}

/* Predecessor of this packet in a chain: a copy follows its original, and nothing follows a copy. */
static inline int64_t ll_draw_before(const ll_passage *p)
{
    return p->is_copy ? p->number : p->number - 1;
}

/* Probability of the next in a two-state chain with the stationary probability `percent` and the correlation
 * `corr_pct`. */
static inline double ll_chain_percent(double percent, double corr_pct, bool before)
{
    double corr = corr_pct / 100;
    return percent * (1 - corr) + (before ? corr_pct : 0);
}

/* Draws an event of `percent` by such a chain; `last`: the last packet to which it happened. */
static inline bool ll_chance(const ll_passage *p, ll_stream stream, double percent, double corr_pct,
                             int64_t *last)
{
    bool happens = 100 * ll_draw(p, stream) < ll_chain_percent(percent, corr_pct, *last == ll_draw_before(p));
    if (happens && !p->is_copy)
        *last = p->number;
    return happens;
}

void ll_mark(ll_passage *passage); /* by ECN; of the packet, of which a copy may exist */

/* Counts a packet as lost. */
void ll_count_loss(const ll_passage *passage, ll_memory *memory, ll_link_stats *stats);

/* Whether `now` is within a period of `length_ms`; the first starts at `at_ms`, then one every `every_ms` (0:
 * none). */
static inline bool ll_window_open(double at_ms, double every_ms, double length_ms, ll_time now)
{
    if (length_ms <= 0)
        return false;
    ll_time since = now - ll_ms(at_ms), every = ll_ms(every_ms);
    if (since < 0)
        return false;
    return (every > 0 ? since % every : since) < ll_ms(length_ms);
}

/* ---- distributions of delays ---- */

typedef struct ll_delay_model {
    double (*variate)(double u); /* quantile function, u in [0, 1] */
    /* Correlation of normal deviates whose variates have the correlation `corr`. */
    double (*deviate_corr)(double corr);
    double max; /* of the variate */
} ll_delay_model;

extern const ll_delay_model ll_delay_models[LL_DISTRIBUTIONS];

/* Limits that both server and clients keep. */
#pragma once

#include "netcode/protocol/clock_sync.h"

#define LL_BUDGET_TICKS 128 /* an input must be for a step less than this ahead of the server's, */
#define LL_BUDGET_HZ 64     /* or twice this where the step rate is higher */

static inline int64_t ll_budget_ticks(ll_freq client_freq)
{
    return client_freq > 1000 * LL_BUDGET_HZ ? 2 * LL_BUDGET_TICKS : LL_BUDGET_TICKS;
}

/* ---- a barrier: netcode/server/barrier.h ---- */

#define LL_BARRIER_GAP (60 * LL_MS)
/* shortest time between barriers: links may lose packets all the time */
#define LL_BARRIER_EVERY (5 * LL_SECOND)
#define LL_BARRIER_BLUR 1000 /* ns, rounding of clocks */

/* One-way delay of a packet: half the measured round trip. */
static inline ll_time ll_barrier_way(const ll_clock_sync *clock)
{
    return (ll_clock_sync_round_trip(clock) + 1) / 2;
}

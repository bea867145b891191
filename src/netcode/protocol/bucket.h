/* Bucket synchronisation: which step an input is for, when its interval and the playout delay are given.
 *
 * Time since the game began is divided into buckets of one interval, b = 1 / update_hz. An input made in
 * bucket n is applied at the bucket's end plus the playout delay D: (n + 1) b + D. The server makes step k at
 * k b + D mod b, so that is step n + 1 + floor(D / b). */
#pragma once

#include "base/vtime.h"

/* Whole buckets in the playout delay. */
static inline int64_t ll_bucket_steps(double delay_ms, ll_freq freq)
{
    return ll_tick_at(ll_ms(delay_ms), freq);
}

/* The rest of it, in [0, one bucket): so long after the multiples of an interval the server steps. */
static inline ll_time ll_bucket_phase(double delay_ms, ll_freq freq)
{
    return ll_ms(delay_ms) - ll_tick_time(ll_bucket_steps(delay_ms, freq), freq);
}

/* The step, counted from the game's begin, for an input made `since` the game began. */
static inline int64_t ll_bucket_step(ll_time since, double delay_ms, ll_freq freq)
{
    return ll_tick_at(since > 0 ? since : 0, freq) + 1 + ll_bucket_steps(delay_ms, freq);
}

/* Virtual time: int64 nanoseconds since the start of a session.
 *
 * Tick k of a clock of f Hz is at floor(k * 1e9 / f): ticks are computed, not accumulated, and so exact after
 * any time. Frequencies are integers in millihertz, which makes the floor exact. */
#pragma once

#include <stdint.h>

typedef int64_t ll_time; /* ns */

#define LL_MS ((ll_time)1000000)
#define LL_SECOND ((ll_time)1000000000)
#define LL_NEVER INT64_MAX
#define LL_LONG_AGO (-3600 * LL_SECOND) /* before every event */

typedef int64_t ll_freq; /* mHz, 1 to 1,000,000,000 */

/* A clock whose rate can change while it runs: tick `k0` was at `epoch`. */
typedef struct ll_clock {
    ll_time epoch;
    int64_t k0;
    ll_freq freq;
} ll_clock;

ll_freq ll_freq_from_hz(double hz); /* rounded to 1 mHz; at least 1 mHz */
ll_time ll_tick_time(int64_t k, ll_freq freq);
int64_t ll_tick_at(ll_time t, ll_freq freq); /* the last tick at or before t (t >= 0) */

static inline ll_time ll_clock_time(const ll_clock *c, int64_t k)
{
    return c->epoch + ll_tick_time(k - c->k0, c->freq);
}

static inline ll_time ll_ms(double ms) /* to the nearest ns */
{
    return (ll_time)(ms * 1e6 + __builtin_copysign(0.5, ms));
}

static inline double ll_to_ms(ll_time t)
{
    return (double)t / 1e6;
}

static inline double ll_to_s(ll_time t)
{
    return (double)t / 1e9;
}

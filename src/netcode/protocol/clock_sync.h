/* Clock synchronisation (NTP's four time stamps): how far the server's clock is ahead of the client's, and
 * the round trip.
 *
 * A request is sent at t0 by the client's clock and arrives at t1 by the server's. It is answered at once,
 * and the answer arrives at t3 by the client's clock: offset = t1 - (t0 + t3) / 2, round trip = t3 - t0. The
 * error of the offset is exactly half of (delay up - delay down): no filter removes it.
 *
 * The offset in use follows the filtered one by at most LL_CLOCK_SLEW of the elapsed time. A difference of
 * LL_CLOCK_SNAP or more is corrected at once. Part of a simulation's block. */
#pragma once

#include <stdbool.h>

#include "base/vtime.h"

#define LL_CLOCK_SAMPLES 8 /* number of samples that the filter uses */
#define LL_CLOCK_SNAP (100 * LL_MS)
#define LL_CLOCK_SLEW 0.05

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_clock_sample {
    ll_time offset, round_trip;
} ll_clock_sample;

typedef struct ll_clock_sync {
    ll_time offset; /* in use: the server's clock - the client's */
    ll_time at;     /* of the last sample, by the client's clock */
    int64_t count;  /* samples so far: the newest is at count - 1 modulo the ring */
    int64_t snaps;
    ll_clock_sample sample[LL_CLOCK_SAMPLES];
} ll_clock_sync;

#pragma GCC diagnostic pop

/* A filter that computes one offset from the last samples. */
typedef struct ll_clock_filter {
    ll_time (*offset)(const ll_clock_sample *samples, int count); /* count >= 1 */
} ll_clock_filter;

extern const ll_clock_filter
    *const ll_clock_filters[]; /* NULL-terminated; the index is the choice `clock_filter` */
extern const char *const ll_clock_filter_names[];

/* The answer to a request sent at `sent` arrived at `received`, by the client's clock. `snap`: the filtered
 * offset is used at once, however different it is. */
void ll_clock_sync_add(ll_clock_sync *sync, const ll_clock_filter *filter, ll_time sent, ll_time server,
                       ll_time received, bool snap);

/* The longest round trip of the last samples; 0: no samples. */
ll_time ll_clock_sync_round_trip(const ll_clock_sync *sync);

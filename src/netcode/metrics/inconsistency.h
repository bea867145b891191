/* Inconsistency: time-space inconsistency (Zhou, Cai, Lee, Turner, ACM TOMACS 14(1), 2004): how far off a
 * view is, and for how long.
 *
 * A divergence episode is a stretch of frames in which the distance d between two drawn positions of an
 * entity exceeds LL_DIVERGENCE_EPISODE_M. It counts if it lasts at least LL_DIVERGENCE_EPISODE, then from its
 * start, by the integral of d over time: so both a large short error and a small lasting one count. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/vtime.h"

#define LL_DIVERGENCE_EPISODE_M 0.1
#define LL_DIVERGENCE_EPISODE (100 * LL_MS)

typedef struct ll_inconsistency {
    double sum;   /* m s: integral of the distance over all episodes that count */
    ll_time time; /* duration of these episodes */
    int64_t episodes;
} ll_inconsistency;

/* The present divergence episode, until it is long enough to count. */
typedef struct ll_divergence_episode {
    double sum;   /* m s */
    ll_time time; /* once it counts, that of its start until then */
} ll_divergence_episode;

/* Length of a frame, in both units: one division for all of its entities. */
typedef struct ll_frame_length {
    ll_time ns;
    double s;
} ll_frame_length;

static inline ll_frame_length ll_frame_length_of(ll_time elapsed)
{
    return (ll_frame_length){elapsed, ll_to_s(elapsed)};
}

/* In a frame of this length the distance was `distance`. */
static inline void ll_inconsistency_in(ll_inconsistency *total, ll_divergence_episode *open, double distance,
                                       ll_frame_length frame)
{
    if (distance <= LL_DIVERGENCE_EPISODE_M) {
        *open = (ll_divergence_episode){0};
        return;
    }
    const double part = distance * frame.s;
    if (open->time >= LL_DIVERGENCE_EPISODE) {
        total->sum += part;
        total->time += frame.ns;
        return;
    }
    open->sum += part;
    open->time += frame.ns;
    if (open->time >= LL_DIVERGENCE_EPISODE) {
        total->sum += open->sum;
        total->time += open->time;
        total->episodes++;
    }
}

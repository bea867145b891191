/* M7: time-space inconsistency (Zhou, Cai, Lee, Turner, ACM TOMACS 14(1), 2004): how far off a picture is,
 * and for how long.
 *
 * An excursion is a stretch of frames in which the distance d between two pictures of an entity is above
 * LL_DIVERGENCE_EPISODE_M. It counts if it lasts LL_DIVERGENCE_EPISODE at least, then from its start, by the
 * integral of d over time: a large error that passes at once and a small one that stays are both told. */
#pragma once

#include <stdint.h>

#include "base/vtime.h"

#define LL_DIVERGENCE_EPISODE_M 0.1
#define LL_DIVERGENCE_EPISODE (100 * LL_MS)

typedef struct ll_inconsistency {
    double sum;   /* m s: integral of the distance over all excursions that count */
    ll_time time; /* in them */
    int64_t excursions;
} ll_inconsistency;

/* The excursion that is under way. */
typedef struct ll_divergence_episode {
    double sum; /* m s */
    ll_time time;
} ll_divergence_episode;

void ll_inconsistency_lasts(ll_inconsistency *total, ll_divergence_episode *open, double distance,
                            ll_time elapsed);

/* For `elapsed` the distance was `distance`. */
static inline void ll_inconsistency_add(ll_inconsistency *total, ll_divergence_episode *open, double distance,
                                        ll_time elapsed)
{
    if (distance <= LL_DIVERGENCE_EPISODE_M)
        *open = (ll_divergence_episode){0};
    else
        ll_inconsistency_lasts(total, open, distance, elapsed);
}

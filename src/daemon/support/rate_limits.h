/* Token buckets: limit how often something may happen, with a burst.
 *
 * ll_bucket is a single bucket, guarded by its owner. ll_rate_limits has one per name (an address) in a table
 * of fixed size; names with equal hashes share a bucket, so that clients cannot make it grow. Time is an
 * argument (monotonic ns). */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/vtime.h"

typedef struct ll_bucket {
    double tokens;
    ll_time filled; /* 0: never used, full */
} ll_bucket;

bool ll_bucket_take(ll_bucket *bucket, double per_s, double burst, ll_time now);

typedef struct ll_rate_limits ll_rate_limits;

ll_rate_limits *ll_rate_limits_new(double per_s, double burst); /* NULL without memory */
void ll_rate_limits_free(ll_rate_limits *rates);
/* Takes `many` tokens at once, at most the burst. Any thread. */
bool ll_rate_limits_take_many(ll_rate_limits *rates, const char *name, double many, ll_time now);
bool ll_rate_limits_take(ll_rate_limits *rates, const char *name, ll_time now); /* any thread */

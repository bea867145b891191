#include "daemon/support/rate_limits.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "base/hash.h"

enum { BUCKETS = 4096 };

struct ll_rate_limits {
    double per_s, burst;
    uint64_t seed; /* so that no client can choose a name that shares a bucket */
    pthread_mutex_t lock;
    ll_bucket bucket[BUCKETS];
};

static bool take_many(ll_bucket *bucket, double many, double per_s, double burst, ll_time now)
{
    if (bucket->filled == 0)
        bucket->tokens = burst;
    else if (now > bucket->filled)
        bucket->tokens += (double)(now - bucket->filled) * 1e-9 * per_s;
    if (bucket->tokens > burst)
        bucket->tokens = burst;
    if (now > bucket->filled)
        bucket->filled = now;
    if (many > burst)
        many = burst;
    if (bucket->tokens < many)
        return false;
    bucket->tokens -= many;
    return true;
}

bool ll_bucket_take(ll_bucket *bucket, double per_s, double burst, ll_time now)
{
    return take_many(bucket, 1, per_s, burst, now);
}

ll_rate_limits *ll_rate_limits_new(double per_s, double burst)
{
    ll_rate_limits *rates = calloc(1, sizeof *rates);
    if (!rates || getrandom(&rates->seed, sizeof rates->seed, 0) != (ssize_t)sizeof rates->seed) {
        free(rates);
        return NULL;
    }
    rates->per_s = per_s;
    rates->burst = burst;
    pthread_mutex_init(&rates->lock, NULL);
    return rates;
}

void ll_rate_limits_free(ll_rate_limits *rates)
{
    if (!rates)
        return;
    pthread_mutex_destroy(&rates->lock);
    free(rates);
}

bool ll_rate_limits_take(ll_rate_limits *rates, const char *name, ll_time now)
{
    return ll_rate_limits_take_many(rates, name, 1, now);
}

bool ll_rate_limits_take_many(ll_rate_limits *rates, const char *name, double many, ll_time now)
{
    uint64_t hash = ll_hash(rates->seed, name, strlen(name));
    pthread_mutex_lock(&rates->lock);
    bool taken = take_many(&rates->bucket[hash % BUCKETS], many, rates->per_s, rates->burst, now);
    pthread_mutex_unlock(&rates->lock);
    return taken;
}

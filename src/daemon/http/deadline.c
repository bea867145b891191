#include <time.h>

#include "daemon/http/internal.h"

int64_t ll_http_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

void ll_http_set_deadline(http_connection *connection, double seconds)
{
    atomic_store_explicit(&connection->deadline_ns,
                          seconds > 0 ? ll_http_now() + (int64_t)(seconds * 1e9) : 0, memory_order_relaxed);
}

void ll_http_deadline(http_exchange *exchange, double seconds)
{
    if (exchange->watched != NULL) {
        ll_http_set_deadline(exchange->watched, seconds);
    }
}

#include "daemon/http/internal.h"

void ll_http_set_deadline(http_connection *connection, double seconds)
{
    atomic_store_explicit(&connection->deadline_ns, seconds > 0 ? ll_now_ns() + (int64_t)(seconds * 1e9) : 0,
                          memory_order_relaxed);
}

void ll_http_deadline(http_exchange *exchange, double seconds)
{
    if (exchange->watched != NULL)
        ll_http_set_deadline(exchange->watched, seconds);
}

/* Counts open connections, in total and by address, of acceptor, HTTP and streams.
 *
 * A connection is admitted with a pass. The owner of the socket returns the pass by
 * ll_connection_limiter_leave when it closes the socket. Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct sockaddr;
typedef struct ll_connection_limiter ll_connection_limiter;

/* An IPv6 address; IPv4 as a mapped one. IPv6 clients are counted by their /64, which is what one customer
 * gets. */
typedef struct ll_connection_limiter_pass {
    uint8_t address[16];
    bool valid; /* false: not counted */
    bool many;  /* of a trusted proxy: counted in total only */
} ll_connection_limiter_pass;

typedef enum ll_connection_limiter_answer {
    LL_CONNECTION_LIMITER_OPEN,
    LL_CONNECTION_LIMITER_FULL,
    LL_CONNECTION_LIMITER_FULL_FOR_IP
} ll_connection_limiter_answer;

ll_connection_limiter *ll_connection_limiter_new(int max_total, int max_per_ip); /* NULL without memory */
void ll_connection_limiter_free(ll_connection_limiter *connection_limiter);

ll_connection_limiter_pass ll_connection_limiter_pass_of(const struct sockaddr *address);
ll_connection_limiter_answer ll_connection_limiter_enter(ll_connection_limiter *connection_limiter,
                                                         const ll_connection_limiter_pass *pass);
void ll_connection_limiter_leave(ll_connection_limiter *connection_limiter,
                                 const ll_connection_limiter_pass *pass);
int ll_connection_limiter_count(ll_connection_limiter *connection_limiter);

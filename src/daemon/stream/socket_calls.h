/* Sends and receives on many sockets at once.
 *
 * Entering the kernel costs as much as a third of a small send. Where the kernel has io_uring and lets this
 * process use it, a list of calls enters it once; otherwise they are made one after the other, with the same
 * results. No call waits: each is made as by MSG_DONTWAIT, and all are done when ll_socket_calls_make
 * returns. One thread at a time. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

typedef struct ll_socket_call {
    int fd;
    bool receives;
    void *bytes; /* to send, or room for what is received */
    size_t size;
    long result; /* bytes; 0 of a receive: the end of the stream; negative: -errno */
} ll_socket_call;

enum { LL_SOCKET_CALLS_MAX = 64 }; /* of one list */

typedef struct ll_socket_calls ll_socket_calls;

/* NULL without memory. `io_uring` false: never by io_uring. */
ll_socket_calls *ll_socket_calls_new(bool io_uring);
void ll_socket_calls_free(ll_socket_calls *calls); /* NULL: no effect */
bool ll_socket_calls_use_io_uring(const ll_socket_calls *calls);

/* Makes the calls in their order; of one socket there may be several. Sets each result. */
void ll_socket_calls_make(ll_socket_calls *calls, ll_socket_call *call, int count);

/* The rings are used as a list of calls and no more: MSG_DONTWAIT makes each complete while it is submitted,
 * so that nothing is in flight between two lists, and no buffer or descriptor is registered. */
#include "daemon/stream/socket_calls.h"

#include <errno.h>
#include <linux/io_uring.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/assert.h"

/* Both rings share one mapping since Linux 5.4; sends and receives are there since 5.6, and 5.7 is the first
 * with a feature flag after them. Without both features io_uring is not used. */
enum { FEATURES = IORING_FEAT_SINGLE_MMAP | IORING_FEAT_FAST_POLL };

struct ll_socket_calls {
    int ring; /* -1: without io_uring */
    char *rings;
    size_t rings_size, entries_size;
    struct io_uring_sqe *entries;
    struct io_uring_cqe *completions;
    _Atomic unsigned *submit_tail, *complete_head, *complete_tail;
    unsigned *submit_index;
    unsigned submit_mask, complete_mask;
};

static void close_ring(ll_socket_calls *calls)
{
    if (calls->entries != NULL)
        munmap(calls->entries, calls->entries_size);
    if (calls->rings != NULL)
        munmap(calls->rings, calls->rings_size);
    if (calls->ring >= 0)
        close(calls->ring);
    *calls = (ll_socket_calls){.ring = -1};
}

static void *map(int ring, size_t size, off_t offset)
{
    void *at = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, ring, offset);
    return at == MAP_FAILED ? NULL : at;
}

static bool map_rings(ll_socket_calls *calls, const struct io_uring_params *p)
{
    size_t submit_size = p->sq_off.array + p->sq_entries * sizeof(unsigned),
           complete_size = p->cq_off.cqes + p->cq_entries * sizeof(struct io_uring_cqe);
    if ((p->features & FEATURES) != FEATURES)
        return false;
    calls->rings_size = submit_size > complete_size ? submit_size : complete_size;
    calls->entries_size = p->sq_entries * sizeof(struct io_uring_sqe);
    calls->rings = map(calls->ring, calls->rings_size, IORING_OFF_SQ_RING);
    calls->entries = map(calls->ring, calls->entries_size, IORING_OFF_SQES);
    if (calls->rings == NULL || calls->entries == NULL)
        return false;
    calls->submit_tail = (_Atomic unsigned *)(void *)(calls->rings + p->sq_off.tail);
    calls->submit_index = (unsigned *)(void *)(calls->rings + p->sq_off.array);
    calls->submit_mask = *(unsigned *)(void *)(calls->rings + p->sq_off.ring_mask);
    calls->complete_head = (_Atomic unsigned *)(void *)(calls->rings + p->cq_off.head);
    calls->complete_tail = (_Atomic unsigned *)(void *)(calls->rings + p->cq_off.tail);
    calls->complete_mask = *(unsigned *)(void *)(calls->rings + p->cq_off.ring_mask);
    calls->completions = (struct io_uring_cqe *)(void *)(calls->rings + p->cq_off.cqes);
    return true;
}

static void open_ring(ll_socket_calls *calls)
{
    struct io_uring_params p = {0};
    calls->ring = (int)syscall(SYS_io_uring_setup, LL_SOCKET_CALLS_MAX, &p);
    if (calls->ring < 0 || !map_rings(calls, &p))
        close_ring(calls);
}

ll_socket_calls *ll_socket_calls_new(bool io_uring)
{
    ll_socket_calls *calls = calloc(1, sizeof *calls);
    if (calls == NULL)
        return NULL;
    calls->ring = -1;
    if (io_uring)
        open_ring(calls);
    return calls;
}

void ll_socket_calls_free(ll_socket_calls *calls)
{
    if (calls != NULL)
        close_ring(calls);
    free(calls);
}

bool ll_socket_calls_use_io_uring(const ll_socket_calls *calls)
{
    return calls->ring >= 0;
}

static void make_one(ll_socket_call *call)
{
    ssize_t n;
    do {
        n = call->receives ? recv(call->fd, call->bytes, call->size, MSG_DONTWAIT)
                           : send(call->fd, call->bytes, call->size, MSG_DONTWAIT | MSG_NOSIGNAL);
    } while (n < 0 && errno == EINTR);
    call->result = n < 0 ? -(long)errno : (long)n;
}

static void queue_call(ll_socket_calls *calls, const ll_socket_call *call, int number)
{
    unsigned tail = atomic_load_explicit(calls->submit_tail, memory_order_relaxed),
             place = tail & calls->submit_mask;
    calls->entries[place] =
        (struct io_uring_sqe){.opcode = call->receives ? IORING_OP_RECV : IORING_OP_SEND,
                              .fd = call->fd,
                              .addr = (uint64_t)(uintptr_t)call->bytes,
                              .len = (uint32_t)call->size,
                              .msg_flags = MSG_DONTWAIT | (call->receives ? 0 : MSG_NOSIGNAL),
                              .user_data = (unsigned)number};
    calls->submit_index[place] = place;
    atomic_store_explicit(calls->submit_tail, tail + 1, memory_order_release);
}

/* Returns how many completions were there. */
static int take_completions(ll_socket_calls *calls, ll_socket_call *call, int count)
{
    unsigned head = atomic_load_explicit(calls->complete_head, memory_order_relaxed),
             tail = atomic_load_explicit(calls->complete_tail, memory_order_acquire);
    int taken = (int)(tail - head);
    for (; head != tail; head++) {
        const struct io_uring_cqe *done = &calls->completions[head & calls->complete_mask];
        LL_ASSERT(done->user_data < (uint64_t)count);
        call[done->user_data].result = done->res;
    }
    atomic_store_explicit(calls->complete_head, head, memory_order_release);
    return taken;
}

/* Returns how many of the calls were made. */
static int submit(ll_socket_calls *calls, ll_socket_call *call, int count)
{
    int submitted = 0, done = 0;
    for (int i = 0; i < count; i++)
        queue_call(calls, &call[i], i);
    while (done < count) {
        unsigned wanted = (unsigned)(submitted < count ? 0 : count - done);
        long n = syscall(SYS_io_uring_enter, calls->ring, count - submitted, wanted, IORING_ENTER_GETEVENTS,
                         NULL, 0);
        if (n < 0 && errno != EINTR && submitted == done)
            return done; /* nothing is in flight: the others can be made without it */
        submitted += n > 0 ? (int)n : 0;
        done += take_completions(calls, call, count);
    }
    return done;
}

void ll_socket_calls_make(ll_socket_calls *calls, ll_socket_call *call, int count)
{
    int made = 0;
    LL_ASSERT(count <= LL_SOCKET_CALLS_MAX);
    if (calls->ring >= 0 && count > 1) {
        made = submit(calls, call, count);
        if (made < count)
            close_ring(calls); /* with what it did not take */
    }
    for (int i = made; i < count; i++)
        make_one(&call[i]);
    for (int i = 0; i < made; i++)
        if (call[i].result == -EINTR)
            make_one(&call[i]);
}

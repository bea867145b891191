/* Lists of sends and receives: by io_uring and one after the other they do the same, and neither waits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/rng.h"
#include "daemon/stream/socket_calls.h"

enum { PAIRS = 40, BYTES = 3000 };

typedef struct pair {
    int here, there;
} pair;

static void open_pairs(pair *p)
{
    for (int i = 0; i < PAIRS; i++) {
        int fd[2];
        assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, fd), 0);
        p[i] = (pair){fd[0], fd[1]};
    }
}

static void close_pairs(pair *p)
{
    for (int i = 0; i < PAIRS; i++) {
        close(p[i].here);
        if (p[i].there >= 0)
            close(p[i].there);
    }
}

/* Several calls of one socket, in order, of lists of every length. */
static void bytes_arrive_in_order(bool io_uring)
{
    pair p[PAIRS];
    static unsigned char out[LL_SOCKET_CALLS_MAX][BYTES], in[BYTES * LL_SOCKET_CALLS_MAX];
    ll_socket_calls *calls = ll_socket_calls_new(io_uring);
    open_pairs(p);
    for (uint64_t round = 1; round <= LL_SOCKET_CALLS_MAX; round++) {
        ll_socket_call call[LL_SOCKET_CALLS_MAX];
        for (uint64_t i = 0; i < round; i++) {
            memset(out[i], (int)(ll_rng_u64(5, round, 2 * i) & 255), BYTES);
            call[i] = (ll_socket_call){
                .fd = p[i / 3].here, .bytes = out[i], .size = 1 + ll_rng_u64(5, round, 2 * i + 1) % BYTES};
        }
        ll_socket_calls_make(calls, call, (int)round);
        for (uint64_t i = 0; i < round; i++)
            assert_int_equal(call[i].result, call[i].size);
        ll_socket_call back[LL_SOCKET_CALLS_MAX];
        int sockets = (int)(round + 2) / 3;
        for (int s = 0; s < sockets; s++)
            back[s] = (ll_socket_call){.fd = p[s].there,
                                       .receives = true,
                                       .bytes = in + (size_t)s * 3 * BYTES,
                                       .size = (size_t)3 * BYTES};
        ll_socket_calls_make(calls, back, sockets);
        for (int s = 0; s < sockets; s++) {
            size_t at = 0;
            for (uint64_t i = (uint64_t)s * 3; i < round && i < (uint64_t)s * 3 + 3; i++) {
                assert_memory_equal(in + (size_t)s * 3 * BYTES + at, out[i], call[i].size);
                at += call[i].size;
            }
            assert_int_equal(back[s].result, at);
        }
    }
    close_pairs(p);
    ll_socket_calls_free(calls);
}

/* A full socket, one without data, one that was closed and one that is none: between them the others work. */
static void nothing_waits(bool io_uring)
{
    pair p[PAIRS];
    static char much[1 << 22];
    char in[16];
    ll_socket_calls *calls = ll_socket_calls_new(io_uring);
    open_pairs(p);
    close(p[2].there);
    p[2].there = -1;
    ll_socket_call call[] = {{.fd = p[0].here, .bytes = much, .size = sizeof much},
                             {.fd = p[1].here, .receives = true, .bytes = in, .size = sizeof in},
                             {.fd = p[2].here, .bytes = much, .size = 10},
                             {.fd = p[2].here, .receives = true, .bytes = in, .size = sizeof in},
                             {.fd = -1, .bytes = much, .size = 10},
                             {.fd = p[3].here, .bytes = much, .size = 10}};
    ll_socket_calls_make(calls, call, 6);
    assert_in_range(call[0].result, 1, sizeof much - 1); /* as much as it has room for */
    assert_int_equal(call[1].result, -EAGAIN);
    assert_int_equal(call[2].result, -EPIPE); /* and no SIGPIPE */
    assert_int_equal(call[3].result, 0);
    assert_int_equal(call[4].result, -EBADF);
    assert_int_equal(call[5].result, 10);
    ll_socket_calls_make(calls, call, 1);
    assert_int_equal(call[0].result, -EAGAIN);
    ll_socket_calls_make(calls, call, 2);
    assert_int_equal(call[0].result, -EAGAIN);
    close_pairs(p);
    ll_socket_calls_free(calls);
}

static void test_one_by_one(void **state)
{
    (void)state;
    ll_socket_calls *calls = ll_socket_calls_new(false);
    assert_false(ll_socket_calls_use_io_uring(calls));
    ll_socket_calls_free(calls);
    bytes_arrive_in_order(false);
    nothing_waits(false);
}

static void test_io_uring(void **state)
{
    (void)state;
    ll_socket_calls *calls = ll_socket_calls_new(true);
    if (!ll_socket_calls_use_io_uring(calls))
        print_message("this system has no io_uring: the same as one by one\n");
    ll_socket_calls_free(calls);
    bytes_arrive_in_order(true);
    nothing_waits(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_one_by_one), cmocka_unit_test(test_io_uring)};
    return cmocka_run_group_tests_name("socket calls", tests, NULL, NULL);
}

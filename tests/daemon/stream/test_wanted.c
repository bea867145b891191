/* Frames of a stream that publishes only when it is asked, as that of a paused session. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <unistd.h>

#include "support/server_fixture.h"

#define BIN "laglab.v2.bin"

static test_server f;
static viewer_frame frame;

static int set_up(void **state)
{
    (void)state;
    test_server_prepare(&f);
    test_server_open(&f);
    atomic_store(&f.publishing, false);
    test_sleep(0.1); /* the publisher has ended its turn */
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    test_server_close(&f);
    return 0;
}

static int open_with_hello(const char *session)
{
    int fd = viewer_open(f.port, session, BIN);
    assert_true(fd >= 0);
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_string_equal((char *)frame.bytes, "{\"type\":\"hello\"}");
    return fd;
}

static void wait_for_calls(unsigned more)
{
    unsigned from = atomic_load(&f.wanted);
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    while (atomic_load(&f.wanted) - from < more && test_now() < until) {
        test_sleep(0.001);
    }
    assert_true(atomic_load(&f.wanted) - from >= more);
}

/* A publisher that is woken must see at once what it was woken for: it does not look again. */
static void test_seen_at_once(void **state)
{
    (void)state;
    for (int i = 0; i < 50; i++) {
        int fd = open_with_hello("s0");
        wait_for_calls(1);
        close(fd);
    }
    assert_int_equal(atomic_load(&f.wanted_nothing), 0);
}

/* A call that led to no publication (its viewer left first; memory lacked) is no reason not to call for the
 * next. */
static void test_called_again(void **state)
{
    (void)state;
    int fd = open_with_hello("s1");
    wait_for_calls(3);
    close(fd);
    fd = open_with_hello("s1");
    wait_for_calls(1);
    atomic_store(&f.publishing, true);
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_int_equal(frame.opcode, 2);
    assert_true(viewer_is_whole(&frame));
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_seen_at_once, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_called_again, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

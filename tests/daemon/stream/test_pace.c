/* The rate of a viewer that draws a limited number of frames a second: it gets nearly what it can draw, and
 * the rate changes seldom. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "daemon/stream/pace.h"

enum { HZ = 60, WINDOW = 4 /* frames on their way */ };

typedef struct viewer {
    ll_ws_pace pace;
    double waiting; /* frames that are not drawn yet */
    int drawn, changes, missed, due;
} viewer;

/* From one time to another, s, while the viewer draws `draws_hz` frames a second. */
static void watch(viewer *v, int from_s, int to_s, double draws_hz)
{
    for (int frame = from_s * HZ; frame < to_s * HZ; frame++) {
        v->waiting = v->waiting > draws_hz / HZ ? v->waiting - draws_hz / HZ : 0;
        if (frame % ll_ws_pace_divisor(&v->pace) != 0) {
            continue;
        }
        bool misses = v->waiting + 1 > WINDOW;
        v->waiting += !misses;
        v->drawn += !misses;
        v->missed += misses;
        v->due++;
        v->changes += ll_ws_pace_count(&v->pace, misses, 1 + INT64_C(1000000000) * frame / HZ);
    }
}

static void test_gets_what_it_draws(void **state)
{
    (void)state;
    for (int hz = 5; hz <= 80; hz++) {
        viewer v = {.drawn = 0};
        watch(&v, 0, 20, hz);
        v.drawn = v.missed = v.due = v.changes = 0;
        watch(&v, 20, 140, hz);
        int can = hz < HZ ? hz : HZ;
        /* Nothing between two divisors: 1 and 2 are the farthest apart, so that 60 a second with a fifth
         * missed, or 30. */
        assert_true(v.drawn >= 120 * can * 60 / 100);
        assert_true(v.drawn <= 120 * can + WINDOW);
        assert_true(v.missed * 100 <= v.due * 20);
        assert_true(v.changes <= 12);
    }
}

static void test_fast_viewer_is_left_alone(void **state)
{
    (void)state;
    viewer v = {.drawn = 0};
    watch(&v, 0, 60, 60);
    assert_int_equal(v.missed, 0);
    assert_int_equal(v.changes, 0);
    assert_int_equal(ll_ws_pace_divisor(&v.pace), 1);
}

/* A page that still loads for three seconds has all frames 17 s after it can draw them. */
static void test_slow_start(void **state)
{
    (void)state;
    viewer v = {.drawn = 0};
    watch(&v, 0, 3, 2);
    watch(&v, 3, 20, 60);
    assert_int_equal(ll_ws_pace_divisor(&v.pace), 1);
}

/* A stop of a second costs at most half of the rate. */
static void test_hiccup(void **state)
{
    (void)state;
    viewer v = {.drawn = 0};
    watch(&v, 0, 11, 60);
    watch(&v, 11, 12, 0);
    watch(&v, 12, 15, 60);
    assert_true(ll_ws_pace_divisor(&v.pace) <= 2);
    watch(&v, 15, 20, 60);
    assert_int_equal(ll_ws_pace_divisor(&v.pace), 1);
}

/* A viewer at its limit is disturbed ever more seldom: half a minute between two attempts in the end. */
static void test_attempts_become_seldom(void **state)
{
    (void)state;
    viewer v = {.drawn = 0};
    watch(&v, 0, 120, 21); /* 20 a second are no trouble, 30 are */
    v.changes = 0;
    watch(&v, 120, 420, 21);
    assert_in_range(v.changes, 2, 2 * 300 / 30 + 2);
}

/* Of a viewer that was slow: known for 20 s after it has all of its frames again. */
static void test_memory(void **state)
{
    (void)state;
    viewer v = {.drawn = 0};
    watch(&v, 0, 8, 5);
    watch(&v, 8, 12, 60);
    int worst = ll_ws_pace_worst_divisor(&v.pace);
    assert_true(worst >= 8);
    watch(&v, 12, 22, 60);
    assert_true(ll_ws_pace_divisor(&v.pace) < worst);
    assert_int_equal(ll_ws_pace_worst_divisor(&v.pace), worst);
    watch(&v, 22, 100, 60);
    assert_int_equal(ll_ws_pace_worst_divisor(&v.pace), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gets_what_it_draws),
        cmocka_unit_test(test_fast_viewer_is_left_alone),
        cmocka_unit_test(test_slow_start),
        cmocka_unit_test(test_hiccup),
        cmocka_unit_test(test_attempts_become_seldom),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

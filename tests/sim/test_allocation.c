/* No allocation in a step: counted by standing in for the C library's functions. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/scene.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define COUNTS 0 /* the sanitizers stand in for these functions themselves */
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define COUNTS 0
#endif
#endif
#ifndef COUNTS
#define COUNTS 1
#endif

static long calls;

#if COUNTS
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *malloc(size_t size);
void *calloc(size_t count, size_t size);
void *realloc(void *old, size_t size);

void *malloc(size_t size)
{
    calls++;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    calls++;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    calls++;
    return __libc_realloc(old, size);
}
#endif

static void steps_do_not_allocate(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"race",
                                            "contact",
                                            "eight",
                                            "cannon",
                                            "gambetta",
                                            "paper/fig09",
                                            "paper/fig11",
                                            "desync_float",
                                            "rollback_loss",
                                            "desync_fma",
                                            "sync_test",
                                            "dejitter",
                                            "extrapolation_silence"};
    for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i++) {
        scene s = scene_open(scenarios[i], NULL);
        long before = calls;
        scene_run(&s, 10, NULL);
        assert_int_equal(calls - before, 0);
        scene_close(&s);
    }
    assert_true(calls > 0 || !COUNTS); /* the count does count */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_do_not_allocate)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

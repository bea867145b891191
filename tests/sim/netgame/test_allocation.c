/* No allocation in a step: counted by replacing the C library's functions. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/allocations.h"
#include "support/scene.h"

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
        long before = allocations();
        scene_run(&s, 10, NULL);
        assert_int_equal(allocations() - before, 0);
        scene_close(&s);
    }
    assert_true(allocations() != 0); /* the counter works */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_do_not_allocate)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

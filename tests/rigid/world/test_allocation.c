/* A step allocates nothing, and a world has no memory for features that it does not use. */
#include "rigid/harness.h"
#include "support/allocations.h"

static void steps_do_not_allocate(void **state)
{
    (void)state;
    for (int solver = 0; solver < LL_SOLVERS; solver++)
        for (int broad = 0; broad < LL_BROADS; broad++) {
            ll_rigid_params p = scene_params("rain", (ll_scene_args){.size = 3});
            p.solver = solver;
            p.continuous = LL_CONTINUOUS_SWEPT;
            lab l = lab_open("rain", (ll_scene_args){.size = 3}, &p, broad);
            long before = allocations();
            lab_run(&l, 100); /* ragdolls are added and removed in it */
            assert_int_equal(allocations() - before, 0);
            assert_true(before != 0); /* checks that the counter works */
            lab_close(&l);
        }
}

static void what_is_not_used_has_no_bytes(void **state)
{
    (void)state;
    ll_rigid_limits balls = {.bodies = 1000, .shapes = 1000, .contacts = 4000, .broad = LL_BROAD_GRID};
    size_t bare = ll_rigid_size(&balls);
    ll_rigid_limits more = balls;
    more.hulls = 1000;
    assert_true(ll_rigid_size(&more) >= bare + 1000 * sizeof(ll_geometry));
    more = balls;
    more.joints = 1000;
    assert_true(ll_rigid_size(&more) > bare + 1000 * 300);
    more = balls;
    more.volumes = 1;
    assert_true(ll_rigid_size(&more) >= bare + 1000 * sizeof(ll_geometry));
    assert_true(bare < 1000 * 700 + 4000 * 900);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_do_not_allocate),
        cmocka_unit_test(what_is_not_used_has_no_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* No allocation in a step of rigid bodies, also while some are added and removed, a person drags and solvers
 * change. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/scenario.h"
#include "sim/rigid/rigid.h"
#include "support/allocations.h"

static void run(const ll_sim_kind *kind, void *block, ll_rigid_config *config)
{
    ll_action press = {.buttons = LL_BUTTON_FIRE}, leave = {0};
    for (int k = 0; k < 8; k++) {
        config->setup.broad_phase = k % LL_BROADS;
        config->setup.solver.solver = k % LL_SOLVERS;
        kind->change(block, config, ll_ms(125.0 * k));
        kind->input(block, 0, k % 2 == 0 ? &press : &leave);
        ll_status status = kind->advance(block, ll_ms(125.0 * (k + 1)), NULL, NULL, NULL, NULL);
        assert_false(ll_failed(&status));
    }
}

static void steps_do_not_allocate(void **state)
{
    (void)state;
    static const char *const ids[] = {"rigid/pyramid",     "rigid/rain",    "rigid/bullets",
                                      "rigid/joint_grid",  "rigid/tumbler", "rigid/confined",
                                      "rigid/rugged_wall", "paper/fig05"};
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        cJSON *json;
        ll_scenario scenario = {0};
        ll_status status = ll_scenario_load("scenarios", ids[i], &json);
        assert_false(ll_failed(&status));
        status = ll_scenario_parse(json, &scenario);
        assert_false(ll_failed(&status));
        void *block = malloc(scenario.kind->size(scenario.config));
        status = scenario.kind->init(block, scenario.config);
        assert_false(ll_failed(&status));
        long before = allocations();
        run(scenario.kind, block, scenario.config);
        assert_int_equal(allocations() - before, 0);
        free(block);
        ll_scenario_free(&scenario);
        cJSON_Delete(json);
    }
    assert_true(allocations() != 0); /* the counter works */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_do_not_allocate)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

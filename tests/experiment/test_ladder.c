/* Ladders of whole scenarios, where the order of a scheme is known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <cjson/cJSON.h>

#include "experiment/ladder.h"
#include "session/scenario.h"

static int64_t ticks;

static int64_t counting_clock(void)
{
    return ++ticks * 1000000;
}

typedef struct notes {
    ll_rung rungs[64];
    int count;
} notes;

static ll_status climb(const ll_ladder *ladder, const char *methods, const char *set, const char *duration,
                       notes *n)
{
    cJSON *json = NULL;
    ll_status status = ll_scenario_load("scenarios", ladder->scenario, &json);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    ll_ladder_order order = {.scenario = json,
                             .sets = &set,
                             .set_count = set != NULL,
                             .duration = duration,
                             .methods = methods,
                             .now_ns = counting_clock};
    *n = (notes){0};
    for (ll_climb c = ll_ladder_start(ladder, &order); ll_ladder_next(&c, &status);) {
        assert_true(n->count < 64);
        n->rungs[n->count++] = c.rung;
    }
    cJSON_Delete(json);
    return status;
}

static const ll_ladder vortices = {"fluid/taylor_green", "duration_s=1,params.viscosity_m2ps=0.01",
                                   "solver.advection",   "maccormack,central",
                                   "params.n",           "16,32,64",
                                   "error_l2",           "visits"};

static void central_differences_are_of_order_two(void **state)
{
    (void)state;
    notes n;
    ll_status status = climb(&vortices, "central", NULL, NULL, &n);
    assert_false(ll_failed(&status));
    assert_int_equal(n.count, 3);
    assert_true(isnan(n.rungs[0].order));
    for (int i = 0; i < 3; i++) {
        assert_string_equal(n.rungs[i].series, "central");
        assert_true(n.rungs[i].cpu_min_s == 0.001 && !n.rungs[i].diverged);
        assert_true(i == 0 || fabs(n.rungs[i].order - 2) < 0.1);
        assert_true(i == 0 || n.rungs[i].counter > 3.9 * n.rungs[i - 1].counter); /* four times the cells */
    }
}

static void what_is_set_goes_before_the_ladders_own(void **state)
{
    (void)state;
    notes plain, other, brief;
    climb(&vortices, "central", NULL, NULL, &plain);
    climb(&vortices, "central", "params.viscosity_m2ps=0.1", NULL, &other);
    climb(&vortices, "central", NULL, "0.5", &brief);
    assert_true(other.rungs[0].error != plain.rungs[0].error);
    assert_true(brief.rungs[0].error < plain.rungs[0].error);
    notes n;
    ll_status status = climb(&vortices, NULL, "params.viscosity_m2ps", NULL, &n);
    assert_int_equal(status.code, LL_BAD_INPUT);
    status = climb(&vortices, NULL, "params.nothing=1", NULL, &n);
    assert_int_equal(status.code, LL_BAD_INPUT);
}

static void runs_that_diverge_are_rungs(void **state)
{
    (void)state;
    static const ll_ladder ladder = {"fluid/cavity",    "params.n=16,solver.tolerance=0",
                                     "solver.pressure", "sor",
                                     "solver.sweeps",   "1,32",
                                     "divergence_max",  "visits"};
    notes n;
    ll_status status = climb(&ladder, NULL, NULL, NULL, &n);
    assert_false(ll_failed(&status));
    assert_int_equal(n.count, 2);
    assert_true(n.rungs[0].diverged && isnan(n.rungs[0].error));
    assert_true(!n.rungs[1].diverged && isnan(n.rungs[1].order));
}

/* Every value is one of its scenario's, and what it is held by is told. */
static void every_ladder_can_be_climbed(void **state)
{
    (void)state;
    for (const ll_ladder *l = ll_ladders; l->scenario; l++) {
        notes n;
        ll_status status = climb(l, NULL, NULL, "0.04", &n);
        if (ll_failed(&status))
            fail_msg("%s by %s: %s", l->scenario, l->setting, status.text);
        assert_true(n.count >= 6);
        for (int i = 0; i < n.count; i++)
            if (!n.rungs[i].diverged && !(n.rungs[i].error >= 0 && n.rungs[i].counter >= 0))
                fail_msg("%s by %s: no %s or %s", l->scenario, l->setting, l->error, l->counter);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(central_differences_are_of_order_two),
        cmocka_unit_test(what_is_set_goes_before_the_ladders_own),
        cmocka_unit_test(runs_that_diverge_are_rungs),
        cmocka_unit_test(every_ladder_can_be_climbed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

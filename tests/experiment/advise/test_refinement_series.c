/* Refinement series of whole scenarios, for schemes of known order. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/advise/refinement_series.h"
#include "experiment/spec/metric_path.h"
#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"
#include "support/near.h"

static int64_t ticks;

static int64_t counting_clock(void)
{
    return ++ticks * 1000000;
}

typedef struct notes {
    ll_refinement_level refinement_levels[64];
    int count;
} notes;

static ll_status refinement_run(const ll_refinement_series *refinement_series, const char *methods,
                                const char *set, const char *duration, notes *n)
{
    cJSON *json = NULL;
    ll_status status = ll_scenario_load("scenarios", refinement_series->scenario, &json);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    ll_refinement_request order = {.scenario = json,
                                   .sets = &set,
                                   .set_count = set != NULL,
                                   .duration = duration,
                                   .methods = methods,
                                   .now_ns = counting_clock};
    *n = (notes){0};
    for (ll_refinement_run c = ll_refinement_series_start(refinement_series, &order);
         ll_refinement_series_next(&c, &status);) {
        assert_true(n->count < 64);
        n->refinement_levels[n->count++] = c.refinement_level;
    }
    cJSON_Delete(json);
    return status;
}

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* Error of A as others see it, in a run of 6 s with jitter, by the engine alone. */
static double error_of(const char *id, int seed, const char *update_hz)
{
    cJSON *json = NULL;
    ll_session *session = NULL;
    must(ll_scenario_load("scenarios", id, &json));
    cJSON_GetObjectItem(json, "duration_s")->valuedouble = 6;
    cJSON_GetObjectItem(cJSON_GetObjectItem(json, "server"), "update_hz")->valuedouble = atof(update_hz);
    cJSON *a = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "players"), 0);
    cJSON_AddItemToObject(a, "link", cJSON_Parse("{\"up\":{\"jitter_ms\":30}}"));
    must(ll_session_create(json, cJSON_GetObjectItem(json, "seed")->valueint + seed, NULL, NULL, &session));
    must(ll_session_run_to(session, ll_session_get_info(session).end_tick));
    cJSON *report = ll_session_metrics(session);
    double error = ll_metric_value(cJSON_GetObjectItem(report, "metrics"), "players.0.remote_error_m.mean");
    cJSON_Delete(report);
    cJSON_Delete(json);
    ll_session_destroy(session);
    return error;
}

static const ll_refinement_series vortices = {"fluid/taylor_green",
                                              "duration_s=1,params.viscosity_m2ps=0.01",
                                              "solver.advection",
                                              "maccormack,central",
                                              "params.n",
                                              "16,32,64",
                                              "error_l2",
                                              "cell_visits",
                                              0};

static void central_differences_are_of_order_two(void **state)
{
    (void)state;
    notes n;
    ll_status status = refinement_run(&vortices, "central", NULL, NULL, &n);
    assert_false(ll_failed(&status));
    assert_int_equal(n.count, 3);
    assert_true(isnan(n.refinement_levels[0].order));
    for (int i = 0; i < 3; i++) {
        assert_string_equal(n.refinement_levels[i].series, "central");
        assert_true(n.refinement_levels[i].cpu_min_s == 0.001 && !n.refinement_levels[i].diverged);
        assert_true(i == 0 || fabs(n.refinement_levels[i].order - 2) < 0.1);
        assert_true(i == 0 || n.refinement_levels[i].counter >
                                  3.9 * n.refinement_levels[i - 1].counter); /* four times the cells */
    }
}

static void set_values_override_the_series(void **state)
{
    (void)state;
    notes plain, other, brief;
    refinement_run(&vortices, "central", NULL, NULL, &plain);
    refinement_run(&vortices, "central", "params.viscosity_m2ps=0.1", NULL, &other);
    refinement_run(&vortices, "central", NULL, "0.5", &brief);
    assert_true(other.refinement_levels[0].error != plain.refinement_levels[0].error);
    assert_true(brief.refinement_levels[0].error < plain.refinement_levels[0].error);
    notes n;
    ll_status status = refinement_run(&vortices, NULL, "params.viscosity_m2ps", NULL, &n);
    assert_int_equal(status.code, LL_BAD_INPUT);
    status = refinement_run(&vortices, NULL, "params.nothing=1", NULL, &n);
    assert_int_equal(status.code, LL_BAD_INPUT);
}

static void diverging_runs_make_levels(void **state)
{
    (void)state;
    static const ll_refinement_series refinement_series = {"fluid/cavity",
                                                           "params.n=16,solver.tolerance=0",
                                                           "solver.pressure",
                                                           "sor",
                                                           "solver.sweeps",
                                                           "1,32",
                                                           "divergence_max",
                                                           "cell_visits",
                                                           0};
    notes n;
    ll_status status = refinement_run(&refinement_series, NULL, NULL, NULL, &n);
    assert_false(ll_failed(&status));
    assert_int_equal(n.count, 2);
    assert_true(n.refinement_levels[0].diverged && isnan(n.refinement_levels[0].error));
    assert_true(!n.refinement_levels[1].diverged && isnan(n.refinement_levels[1].order));
}

/* Every value is valid for its scenario, and error and counter are metrics of it. */
static void every_refinement_series_can_be_run(void **state)
{
    (void)state;
    for (const ll_refinement_series *l = ll_refinement_series_table; l->scenario; l++) {
        notes n;
        ll_refinement_series brief = *l;
        brief.seeds = l->seeds > 0 ? 2 : 0;
        bool fluid = strncmp(l->scenario, "fluid/", 6) == 0,
             swarm = strcmp(l->scenario, "swarm_interest") == 0,
             cars = strcmp(l->scenario, "deterministic") == 0;
        const char *duration = l->seeds == 0 || fluid ? "0.04" : swarm ? "3" : cars ? "20" : "10";
        ll_status status = refinement_run(&brief, NULL, NULL, duration, &n);
        if (ll_failed(&status))
            fail_msg("%s by %s: %s", l->scenario, l->setting, status.text);
        assert_true(n.count >= 4);
        for (int i = 0; i < n.count; i++)
            if (!n.refinement_levels[i].diverged &&
                !(n.refinement_levels[i].error >= 0 && fabs(n.refinement_levels[i].counter) >= 0))
                fail_msg("%s by %s: no %s or %s", l->scenario, l->setting, l->error, l->counter);
    }
}

/* Levels with randomness are run with several seeds, each once: mean and interval equal those of single
 * runs. */
static void levels_of_netgames_are_means_over_seeds(void **state)
{
    (void)state;
    enum { SEEDS = 11 };
    static const ll_refinement_series refinement_series = {"contact",
                                                           "duration_s=6,players.0.link.up.jitter_ms=30",
                                                           "players.0.prediction",
                                                           "false,true",
                                                           "server.update_hz",
                                                           "10,30",
                                                           "players.0.remote_error_m.mean",
                                                           "players.0.bandwidth.down_bytes_per_s",
                                                           SEEDS};
    notes n;
    must(refinement_run(&refinement_series, "true", NULL, NULL, &n));
    assert_int_equal(n.count, 2);
    assert_true(n.refinement_levels[1].error < n.refinement_levels[0].error &&
                n.refinement_levels[1].counter > n.refinement_levels[0].counter);
    for (int i = 0; i < 2; i++) {
        double values[SEEDS], sum = 0;
        for (int k = 0; k < SEEDS; k++)
            sum += values[k] = error_of("contact", k, i ? "30" : "10");
        const ll_refinement_level *r = &n.refinement_levels[i];
        assert_int_equal(r->seeds, SEEDS);
        assert_near(r->error, sum / SEEDS, 1e-12 * sum);
        ll_resampler resampler = {0};
        ll_interval_request order = {.values = values, .n = SEEDS, .scale = LL_SCALE_AMOUNT, .error = 0.05};
        ll_interval interval = ll_interval_of(&order, &resampler);
        ll_resampler_free(&resampler);
        assert_true(r->error_low == interval.low && r->error_high == interval.high);
        assert_true(r->error_low < r->error && r->error < r->error_high);
    }
}

/* Between snapshots T apart, linear interpolation has an error of order T^2, a cubic with both velocities T^4
 * where the motion is smooth; braking cars reduce the order. */
static void curves_between_states_gain_more_by_updates_than_lines(void **state)
{
    (void)state;
    notes linear, hermite;
    const ll_refinement_series *l = ll_refinement_series_table;
    while (strcmp(l->scenario, "hermite") != 0)
        l++;
    must(refinement_run(l, "linear", NULL, NULL, &linear));
    must(refinement_run(l, "hermite", NULL, NULL, &hermite));
    assert_int_equal(linear.count, 5);
    for (int i = 1; i < 4; i++) {
        assert_true(linear.refinement_levels[i].order > 1.5 && linear.refinement_levels[i].order < 2.5);
        assert_true(hermite.refinement_levels[i].error < linear.refinement_levels[i].error / 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(central_differences_are_of_order_two),
        cmocka_unit_test(set_values_override_the_series),
        cmocka_unit_test(diverging_runs_make_levels),
        cmocka_unit_test(every_refinement_series_can_be_run),
        cmocka_unit_test(levels_of_netgames_are_means_over_seeds),
        cmocka_unit_test(curves_between_states_gain_more_by_updates_than_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

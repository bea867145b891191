/* Simulations of fluids: reports, live changes, the pointer, and errors. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "session/kinds.h"
#include "session/scenario.h"
#include "session/session.h"
#include "sim/fluid/fluid.h"
#include "support/near.h"

/* ---- helpers ---- */

static void ok(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static ll_status try_session(const char *text, ll_session **out)
{
    cJSON *json;
    ok(ll_json_parse(text, strlen(text), &json));
    ll_status status = ll_session_create(json, -1, NULL, NULL, out);
    cJSON_Delete(json);
    return status;
}

static ll_session *session_of(const char *text)
{
    ll_session *s;
    ok(try_session(text, &s));
    return s;
}

static void patch(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    ok(ll_session_patch(s, 0, json));
    cJSON_Delete(json);
}

static double metric(ll_session *s, const char *path)
{
    char full[96];
    snprintf(full, sizeof full, "metrics.%s", path);
    cJSON *report = ll_session_metrics(s);
    const cJSON *found = ll_param_number_at(report, full);
    if (found == NULL)
        fail_msg("%s is missing", path);
    double value = found->valuedouble;
    cJSON_Delete(report);
    return value;
}

/* ---- tests ---- */

static void a_cavity_reports_profiles_of_pairs(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"fluid\",\"scene\":\"cavity\",\"params\":{\"re\":100,\"n\":16},"
                               "\"duration_s\":12}");
    ok(ll_session_run_to(s, 720));
    assert_between("u at the lid", metric(s, "profiles.u.128.1"), 1, 1);
    assert_between("the middle", metric(s, "profiles.u.64.0"), 0.5, 0.5);
    assert_between("u in the middle", metric(s, "profiles.u.64.1"), -0.209149 - 0.02, -0.209149 + 0.02);
    assert_between("v next to the left wall", metric(s, "profiles.v.30.1"), 0.179559 - 0.02, 0.179559 + 0.02);
    assert_between("error_max", metric(s, "error_max"), 0.001, 0.03);
    ll_session_destroy(s);
}

static void solver_advection_and_viscosity_change_while_it_runs(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"fluid\",\"scene\":\"taylor_green\",\"duration_s\":10,"
                               "\"params\":{\"n\":16,\"viscosity_m2ps\":0.01}}");
    ok(ll_session_run_to(s, 10));
    double before = metric(s, "divergence_max");
    assert_between("divergence by the direct solver", before, 0, 1e-12);
    patch(s, "{\"solver\":{\"pressure\":\"jacobi\",\"sweeps\":3,\"tolerance\":0,\"advection\":\"bfecc\"}}");
    ok(ll_session_run_to(s, 20));
    assert_between("sweeps", metric(s, "sweeps"), 3, 3);
    assert_between("divergence by three sweeps", metric(s, "divergence_max"), 1e-6, 10);
    double energy = metric(s, "energy");
    patch(s, "{\"solver.viscosity_scale\":50,\"solver.pressure\":\"multigrid\",\"shown\":2}");
    ok(ll_session_run_to(s, 80));
    assert_between("energy of vortices in honey", metric(s, "energy"), 0.5 * energy, 0.9 * energy);
    ll_session_destroy(s);
}

/* A change that needs another block is rejected; so is a solver that the scene cannot have. */
static void unchangeable_parameters_are_rejected(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"fluid\",\"scene\":\"cylinder\",\"params\":{\"n\":16},"
                               "\"duration_s\":1}");
    cJSON *size = cJSON_Parse("{\"params\":{\"n\":32}}");
    cJSON *solver = cJSON_Parse("{\"solver\":{\"pressure\":\"direct\"}}");
    assert_int_equal(ll_session_patch(s, 0, size).code, LL_CONFLICT);
    ll_status status = ll_session_patch(s, 0, solver);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_non_null(strstr(status.text, "solver.pressure"));
    cJSON_Delete(size);
    cJSON_Delete(solver);
    ll_session_destroy(s);
}

static void sizes_are_refused_with_their_memory(void **state)
{
    (void)state;
    ll_session *s;
    ll_status status = try_session("{\"kind\":\"fluid\",\"scene\":\"cylinder\",\"params\":{\"n\":4096}}", &s);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "params.n");
    assert_non_null(strstr(status.text, "4096 x 4096 cells would take"));
    status = try_session("{\"kind\":\"fluid\",\"scene\":\"cavity\",\"solver\":{\"backtrace\":4}}", &s);
    assert_string_equal(status.field, "solver.backtrace");
    status = try_session("{\"kind\":\"fluid\"}", &s);
    assert_string_equal(status.field, "scene");
}

static void a_broken_limit_names_tick_cell_and_reason(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"fluid\",\"scene\":\"taylor_green\",\"params\":{\"n\":32},"
                               "\"solver\":{\"substeps\":1},\"hz\":2,\"duration_s\":5}");
    ll_status status = ll_session_run_to(s, 4);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "tick 1: "));
    assert_non_null(strstr(status.text, "cell ("));
    assert_non_null(strstr(status.text, "CFL"));
    ll_session_destroy(s);
}

/* The pointer moves to the right with the button held: so does the fluid under it. */
static void a_person_drags_the_fluid(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"fluid\",\"scene\":\"cavity\",\"params\":{\"n\":32},"
                               "\"duration_s\":5}");
    double still = metric(s, "momentum_x");
    for (int tick = 0; tick < 20; tick++) {
        ll_action action = {.axis = {-0.5f + 0.05f * (float)tick, -0.4f}, .buttons = LL_BUTTON_FIRE};
        ok(ll_session_input(s, 0, 0, &action));
        ok(ll_session_run_to(s, tick + 1));
    }
    assert_between("energy", metric(s, "energy"), 0.01, 1);
    assert_between("momentum before", still, 0, 0);
    ll_action away = {.axis = {2, 0}};
    assert_int_equal(ll_session_input(s, 0, 0, &away).code, LL_BAD_INPUT);
    away.axis[0] = 0;
    assert_int_equal(ll_session_input(s, 0, 1, &away).code, LL_BAD_INPUT);
    ll_session_destroy(s);
}

/* ---- side by side ---- */

#define VORTICES                                                                                             \
    "{\"kind\":\"fluid\",\"scene\":\"taylor_green\",\"duration_s\":10,"                                      \
    "\"params\":{\"n\":16,\"viscosity_m2ps\":0.01}"

/* Parameters that are not given are the first one's, also where those differ from the defaults. */
static void fluids_side_by_side_begin_as_the_first(void **state)
{
    (void)state;
    ll_session *s =
        session_of(VORTICES ",\"side_by_side\":[{},{\"solver\":{\"advection\":\"semi_lagrangian\"}}]}");
    ll_session *alone = session_of(VORTICES "}");
    ok(ll_session_run_to(s, 60));
    ok(ll_session_run_to(alone, 60));
    double energy = metric(alone, "energy");
    assert_between("energy of the first", metric(s, "energy"), energy, energy);
    assert_between("energy of its like", metric(s, "side_by_side.0.energy"), energy, energy);
    assert_between("energy of the other", metric(s, "side_by_side.1.energy"), 0.5 * energy, 0.999 * energy);
    ll_session_destroy(s);
    ll_session_destroy(alone);
}

static void each_fluid_changes_alone_and_all_are_dragged(void **state)
{
    (void)state;
    ll_session *s =
        session_of("{\"kind\":\"fluid\",\"scene\":\"cavity\",\"params\":{\"n\":16},\"duration_s\":5,"
                   "\"side_by_side\":[{\"params\":{\"n\":32}},{\"scene\":\"pool\"}]}");
    ll_session *still = session_of("{\"kind\":\"fluid\",\"scene\":\"pool\",\"duration_s\":5}");
    patch(s, "{\"side_by_side.0.solver.pressure\":\"jacobi\",\"side_by_side.0.solver.sweeps\":30,\"side_by_"
             "side.0.solver."
             "tolerance\":0}");
    for (int tick = 0; tick < 20; tick++) {
        ll_action action = {.axis = {-0.5f + 0.05f * (float)tick, -0.4f}, .buttons = LL_BUTTON_FIRE};
        ok(ll_session_input(s, 0, 0, &action));
        ok(ll_session_run_to(s, tick + 1));
    }
    ok(ll_session_run_to(still, 20));
    assert_between("sweeps of the second", metric(s, "side_by_side.0.sweeps"), 30, 30);
    assert_between("energy of the first", metric(s, "energy"), 0.01, 1);
    assert_between("energy of the second", metric(s, "side_by_side.0.energy"), 0.01, 1);
    assert_true(metric(s, "side_by_side.1.momentum_x") > 1.1 * metric(still, "momentum_x"));
    cJSON *size = cJSON_Parse("{\"side_by_side.0.params.n\":64}");
    assert_int_equal(ll_session_patch(s, 0, size).code, LL_CONFLICT);
    cJSON_Delete(size);
    ll_session_destroy(s);
    ll_session_destroy(still);
}

/* It stops alone; the session continues. */
static void a_second_fluid_that_fails_stops_alone(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"fluid\",\"scene\":\"taylor_green\",\"params\":{\"n\":32},"
                               "\"hz\":2,\"duration_s\":5,\"side_by_side\":[{\"solver\":{\"substeps\":1}}]}");
    ok(ll_session_run_to(s, 4));
    assert_between("time of the first", metric(s, "t_s"), 2, 2);
    cJSON *report = ll_session_metrics(s), *first = cJSON_GetObjectItem(report, "metrics");
    const cJSON *second = cJSON_GetArrayItem(cJSON_GetObjectItem(first, "side_by_side"), 0);
    assert_between("time of the second", cJSON_GetObjectItem(second, "t_s")->valuedouble, 0, 0);
    assert_string_equal(cJSON_GetObjectItem(second, "status")->valuestring, "diverged");
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(second, "error_l2")));
    assert_true(cJSON_IsNumber(cJSON_GetObjectItem(first, "error_l2")) ||
                cJSON_IsRaw(cJSON_GetObjectItem(first, "error_l2")));
    cJSON_Delete(report);
    ll_session_destroy(s);
}

static void errors_side_by_side_name_their_index(void **state)
{
    (void)state;
    ll_session *s;
    ll_status status = try_session(
        "{\"kind\":\"fluid\",\"scene\":\"cavity\",\"side_by_side\":[{},{\"params\":{\"n\":4096}}]}", &s);
    assert_string_equal(status.field, "side_by_side.1.params.n");
    assert_non_null(strstr(status.text, "side_by_side.1.params.n"));
    status = try_session("{\"kind\":\"fluid\",\"scene\":\"cavity\",\"side_by_side\":[{},{},{}]}", &s);
    assert_string_equal(status.field, "side_by_side");
    status = try_session(
        "{\"kind\":\"fluid\",\"scene\":\"cavity\",\"params\":{\"n\":3000},\"side_by_side\":[{},{}]}", &s);
    assert_string_equal(status.field, "side_by_side");
    assert_non_null(strstr(status.text, "3 fluids side by side would take"));
}

static int64_t counted_ns(void)
{
    static int64_t reads;
    return 1000 * ++reads;
}

/* The clock is the caller's, read twice for each fluid and tick; its readings enter no state. */
static void parts_are_metered_by_the_callers_clock(void **state)
{
    (void)state;
    ll_session *s = session_of(VORTICES ",\"side_by_side\":[{}]}"),
               *plain = session_of(VORTICES ",\"side_by_side\":[{}]}");
    cJSON *before = ll_session_cost(s);
    assert_null(cJSON_GetObjectItem(before, "parts"));
    ll_session_step_profiler(s, counted_ns);
    ok(ll_session_run_to(s, 60));
    ll_session_step_profiler(s, NULL);
    ok(ll_session_run_to(s, 120));
    ok(ll_session_run_to(plain, 120));
    cJSON *cost = ll_session_cost(s);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(cost, "parts")), 2);
    assert_between("metered_s", ll_param_number_at(cost, "metered_s")->valuedouble, 1, 1);
    assert_between("cost of the second", ll_param_number_at(cost, "parts.1.all.ns_per_sim_s")->valuedouble,
                   60 * 1000, 60 * 1000);
    assert_true(ll_session_hash(s) == ll_session_hash(plain));
    cJSON_Delete(before);
    cJSON_Delete(cost);
    ll_session_destroy(s);
    ll_session_destroy(plain);
}

/* The layout names as many numbers as a frame has, and the trace as many columns as values. */
static void names_match_the_values(void **state)
{
    (void)state;
    for (int i = 0; ll_fluid_scenes[i]; i++) {
        ll_trace_line trace = {0};
        ll_fluid_number numbers[LL_FLUID_NUMBERS_MAX];
        ll_fluid_config config;
        ll_param_defaults(&ll_fluid_scenario_table, &config);
        ok(ll_param_set(&ll_fluid_scenario_table, &config, "scene", ll_fluid_scenes[i]->name, false));
        ll_fluid_sim *sim = malloc(ll_sim_fluid.size(&config));
        ok(ll_sim_fluid.init(sim, &config));
        cJSON *layout = ll_fluid_sim_layout(&config);
        const cJSON *fluid = cJSON_GetObjectItem(layout, "fluid");
        assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(fluid, "numbers")),
                         ll_fluid_sim_numbers(sim, numbers));
        ll_fluid_sim_trace(sim, &trace);
        const ll_fluid_scene *scene = ll_fluid_scenes[i];
        assert_int_equal(
            trace.count,
            scene->method->traced->count +
                (scene->numbers ? ll_fluid_sim_numbers(sim, numbers) - scene->method->metrics->count : 0));
        cJSON_Delete(layout);
        free(sim);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cavity_reports_profiles_of_pairs),
        cmocka_unit_test(solver_advection_and_viscosity_change_while_it_runs),
        cmocka_unit_test(unchangeable_parameters_are_rejected),
        cmocka_unit_test(sizes_are_refused_with_their_memory),
        cmocka_unit_test(a_broken_limit_names_tick_cell_and_reason),
        cmocka_unit_test(a_person_drags_the_fluid),
        cmocka_unit_test(fluids_side_by_side_begin_as_the_first),
        cmocka_unit_test(each_fluid_changes_alone_and_all_are_dragged),
        cmocka_unit_test(a_second_fluid_that_fails_stops_alone),
        cmocka_unit_test(errors_side_by_side_name_their_index),
        cmocka_unit_test(parts_are_metered_by_the_callers_clock),
        cmocka_unit_test(names_match_the_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

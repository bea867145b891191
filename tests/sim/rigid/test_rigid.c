/* Simulations of rigid bodies: closed forms, live changes, the pointer, and errors. */
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

#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"
#include "sim/rigid/records.h"
#include "support/near.h"

/* ---- helpers ---- */

static void ok(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static ll_session *session_of(const char *text)
{
    cJSON *json;
    ll_session *s;
    ok(ll_json_parse(text, strlen(text), &json));
    ok(ll_session_create(json, -1, NULL, NULL, &s));
    cJSON_Delete(json);
    return s;
}

static ll_session *library(const char *id)
{
    cJSON *json;
    ll_session *s;
    ok(ll_scenario_load("scenarios", id, &json));
    ok(ll_session_create(json, -1, NULL, NULL, &s));
    cJSON_Delete(json);
    return s;
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

static void patch(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    ok(ll_session_patch(s, 0, json));
    cJSON_Delete(json);
}

static void run_to(ll_session *s, int64_t tick)
{
    ok(ll_session_run_to(s, tick));
}

/* ---- closed forms ---- */

/* A step adds a dt to the velocity first: after n steps x = v n dt, y = -g dt^2 n (n + 1) / 2. */
static void a_body_falls_as_its_steps_say(void **state)
{
    (void)state;
    ll_session *s =
        session_of("{\"kind\":\"rigid\",\"duration_s\":1,\"gravity\":[0,-10],"
                   "\"solver\":{\"substeps\":1},\"bodies\":[{\"velocity\":[3,0],\"angular_velocity\":2}]}");
    run_to(s, 60);
    assert_near(metric(s, "bodies.0.position.0"), 3, 1e-12);
    assert_near(metric(s, "bodies.0.position.1"), -10.0 / 3600 * 60 * 61 / 2, 1e-12);
    assert_near(metric(s, "bodies.0.velocity.1"), -10, 1e-12);
    assert_near(metric(s, "bodies.0.angle"), 2, 1e-12);
    assert_near(metric(s, "momentum_error_kgmps"), 0, 1e-12);
    ll_session_destroy(s);
}

/* Equal balls swap their velocities; unequal ones follow the formula of elastic impact. */
static void elastic_impacts_keep_momentum_and_energy(void **state)
{
    (void)state;
    ll_session *s = session_of(
        "{\"kind\":\"rigid\",\"duration_s\":2,\"gravity\":[0,0],\"bodies\":["
        "{\"shape\":\"circle\",\"position\":[-2,0],\"velocity\":[4,0],\"density\":3,\"restitution\":1},"
        "{\"shape\":\"circle\",\"position\":[2,0],\"velocity\":[-2,0],\"density\":1,\"restitution\":1}]}");
    double before = metric(s, "kinetic_j");
    run_to(s, 120);
    assert_near(metric(s, "bodies.0.velocity.0"), (3.0 * 4 + 1 * -2 + 1 * (-2.0 - 4)) / 4, 1e-12);
    assert_near(metric(s, "bodies.1.velocity.0"), (3.0 * 4 + 1 * -2 + 3 * (4.0 + 2)) / 4, 1e-12);
    assert_near(metric(s, "kinetic_j") / before, 1, 1e-12);
    assert_near(metric(s, "momentum_error_kgmps"), 0, 1e-12);
    ll_session_destroy(s);
}

/* A rod on a distance joint without a given length keeps its initial length, in rotated frames too. */
static void a_distance_joint_keeps_the_distance_of_its_anchors(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"rigid\",\"duration_s\":3,\"bodies\":["
                               "{\"type\":\"static\",\"position\":[0,5],\"angle\":1.5707963267948966},"
                               "{\"position\":[3,1],\"angle\":0.5}],"
                               "\"joints\":[{\"type\":\"distance\",\"a\":0,\"b\":1,\"anchor_a\":[0,0]}]}");
    run_to(s, 180);
    double x = metric(s, "bodies.1.position.0"), y = metric(s, "bodies.1.position.1") - 5;
    assert_near(sqrt(x * x + y * y), 5, 0.002);
    assert_true(metric(s, "joint_error_worst") < 0.01);
    ll_session_destroy(s);
}

/* ---- bounding volumes ---- */

/* Two boxes rotated by 45 degrees, 1.2 m apart corner to corner on the diagonal: only their AABBs and circles
 * overlap. The AABB of such a square has twice its area; the circle around it pi / 2 times. */
static void volumes_are_judged_against_the_shapes(void **state)
{
    (void)state;
    ll_session *s = session_of(
        "{\"kind\":\"rigid\",\"duration_s\":1,\"gravity\":[0,0],\"compare_volumes\":true,\"bodies\":["
        "{\"angle\":0.7853981633974483},{\"angle\":0.7853981633974483,\"position\":[0.9,0.9]}]}");
    run_to(s, 10);
    assert_near(metric(s, "volumes.aabb.area_overestimated_pct"), 100, 1e-9);
    assert_near(metric(s, "volumes.sphere.area_overestimated_pct"), 100 * (3.14159265358979 / 2 - 1), 1e-6);
    assert_near(metric(s, "volumes.obb.area_overestimated_pct"), 0, 1e-9);
    assert_near(metric(s, "volumes.aabb.false_hits"), 10, 0);
    assert_near(metric(s, "volumes.aabb.gap_max_m"), 0.9 * sqrt(2) - 1, 1e-12);
    assert_near(metric(s, "volumes.sphere.false_hits"), 10, 0);
    assert_near(metric(s, "volumes.obb.false_hits"), 0, 0);
    for (int v = 0; v < LL_VOLUMES; v++) {
        char path[64];
        snprintf(path, sizeof path, "volumes.%s.missed_hits", ll_volume_names[v]);
        assert_near(metric(s, path), 0, 0);
    }
    ll_session_destroy(s);
}

/* ---- live parameters ---- */

static uint64_t pile(const char *change)
{
    ll_session *s = session_of("{\"kind\":\"rigid\",\"scene\":\"tilted_stack\",\"params\":{\"size\":4},"
                               "\"duration_s\":2,\"solver\":{\"sleep\":false}}");
    run_to(s, 20);
    if (change != NULL)
        patch(s, change);
    run_to(s, 120);
    uint64_t hash = ll_session_hash(s);
    ll_session_destroy(s);
    return hash;
}

static void broad_phase_and_simd_change_nothing_else_does(void **state)
{
    (void)state;
    static const char *const same[] = {"{\"broad_phase\":\"brute\"}", "{\"broad_phase\":\"sap\"}",
                                       "{\"broad_phase\":\"tree\"}",  "{\"solver.simd\":\"scalar\"}",
                                       "{\"solver.simd\":\"sse2\"}",  "{\"solver\":{\"simd\":\"avx2\"}}"};
    static const char *const other[] = {
        "{\"solver.method\":\"pgs\"}",   "{\"solver.method\":\"avbd\"}",
        "{\"solver.substeps\":4}",       "{\"solver.bounding_volume\":\"sphere\"}",
        "{\"solver.warm_start\":false}", "{\"gravity\":[0,-5]}",
        "{\"solver.recycle\":false}"};
    uint64_t want = pile(NULL);
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++)
        if (pile(same[i]) != want)
            fail_msg("%s changed the result", same[i]);
    for (size_t i = 0; i < sizeof other / sizeof other[0]; i++)
        if (pile(other[i]) == want)
            fail_msg("%s changed nothing", other[i]);
}

static void what_is_no_setting_cannot_change(void **state)
{
    (void)state;
    ll_session *s = library("rigid/pyramid");
    cJSON *json = cJSON_Parse("{\"params\":{\"size\":11}}");
    ll_status status = ll_session_patch(s, 0, json);
    assert_int_equal(status.code, LL_CONFLICT);
    cJSON_Delete(json);
    ll_session_destroy(s);
}

/* Two balls that would have passed each other at the end of the first step. */
static void a_bullet_does_not_pass_another_body(void **state)
{
    (void)state;
    for (int bullet = 0; bullet < 2; bullet++) {
        char text[512];
        snprintf(
            text, sizeof text,
            "{\"kind\":\"rigid\",\"duration_s\":1,\"gravity\":[0,0],\"solver\":{\"continuous\":\"swept\"},"
            "\"bodies\":[{\"shape\":\"circle\",\"radius\":0.05,\"position\":[-5,0],\"velocity\":[500,0],"
            "\"bullet\":%s},{\"shape\":\"circle\",\"radius\":0.05,\"position\":[5,0],\"velocity\":[-500,0]}]"
            "}",
            bullet ? "true" : "false");
        ll_session *s = session_of(text);
        run_to(s, 10);
        double left = metric(s, "bodies.0.position.0"), right = metric(s, "bodies.1.position.0");
        assert_true(bullet ? left < right && right - left < 0.11 : left > right);
        ll_session_destroy(s);
    }
}

/* ---- worlds side by side ---- */

static void worlds_with_the_same_solver_stay_the_same(void **state)
{
    (void)state;
    ll_session *s =
        session_of("{\"kind\":\"rigid\",\"scene\":\"rugged_wall\",\"duration_s\":3,"
                   "\"side_by_side\":[{},{\"solver\":{\"method\":\"xpbd\"}}],\"solver\":{\"substeps\":8}}");
    run_to(s, 180);
    assert_near(metric(s, "energy_j"), metric(s, "side_by_side.0.energy_j"),
                0); /* with the first's substeps */
    assert_true(metric(s, "energy_j") != metric(s, "side_by_side.1.energy_j"));
    assert_near(metric(s, "side_by_side.1.passes_per_s"), 60 * 8 * 3, 0);
    patch(s, "{\"side_by_side.0.solver.method\":\"pgs\"}");
    patch(s, "{\"gravity\":[1,-10]}"); /* which wakes all */
    run_to(s, 170);
    run_to(s, 180);
    ll_session_destroy(s);
}

/* ---- pointer drag ---- */

static ll_action point_at(const double view[4], double x, double y, bool held)
{
    ll_action a = {.buttons = held ? LL_BUTTON_FIRE : 0};
    a.axis[0] = (float)((2 * x - view[0] - view[1]) / (view[1] - view[0]));
    a.axis[1] = (float)((2 * y - view[2] - view[3]) / (view[3] - view[2]));
    return a;
}

static void view_of(const ll_rigid_config *config, double view[4])
{
    cJSON *layout = ll_rigid_sim_layout(config);
    for (int i = 0; i < 4; i++)
        view[i] = cJSON_GetArrayItem(cJSON_GetObjectItem(cJSON_GetObjectItem(layout, "rigid"), "view"), i)
                      ->valuedouble;
    cJSON_Delete(layout);
}

#define BOX_ON_GROUND                                                                                        \
    "{\"kind\":\"rigid\",\"duration_s\":10,\"side_by_side\":[{\"solver\":{\"method\":\"avbd\"}}],"           \
    "\"bodies\":["                                                                                           \
    "{\"type\":\"static\",\"size\":[20,1],\"position\":[0,-0.5]},{\"position\":[0,0.5]}]}"

static void box_view(double view[4])
{
    cJSON *json = cJSON_Parse(BOX_ON_GROUND);
    ll_scenario scenario = {0};
    ok(ll_scenario_parse(json, &scenario));
    view_of(scenario.config, view);
    ll_scenario_free(&scenario);
    cJSON_Delete(json);
}

static void a_dragged_body_comes_to_the_pointer_in_both_worlds(void **state)
{
    (void)state;
    double view[4];
    box_view(view);
    ll_session *s = session_of(BOX_ON_GROUND);
    run_to(s, 60);
    ll_action press = point_at(view, 0, 0.5, true), pull = point_at(view, 1, 2, true),
              leave = point_at(view, 1, 2, false);
    ok(ll_session_input(s, 0, 0, &press));
    run_to(s, 61);
    ok(ll_session_input(s, 0, 0, &pull));
    run_to(s, 240);
    double hang = 10 / (31.41592653589793 * 31.41592653589793); /* by a spring of 5 Hz */
    assert_near(metric(s, "bodies.1.position.0"), 1, 2e-4);
    assert_near(metric(s, "bodies.1.position.1"), 2 - hang, 2e-4);
    assert_near(metric(s, "side_by_side.0.bodies.1.position.1"), 2 - hang, 2e-4);
    ok(ll_session_input(s, 0, 0, &leave));
    run_to(s, 400);
    assert_near(metric(s, "bodies.1.position.1"), 0.5, 0.01);
    uint64_t hash = ll_session_hash(s);

    ok(ll_session_run_to(s, 100)); /* a replay of the log, from a checkpoint and from the start */
    ok(ll_session_run_to(s, 400));
    assert_true(ll_session_hash(s) == hash);
    ll_session *copy;
    ok(ll_session_fork(s, NULL, NULL, &copy));
    ok(ll_session_run_to(copy, 100));
    ok(ll_session_run_to(copy, 400));
    assert_true(ll_session_hash(copy) == hash);
    ll_session_destroy(copy);
    ll_session_destroy(s);
}

static void an_input_for_an_unknown_player_is_rejected(void **state)
{
    (void)state;
    ll_session *s = library("rigid/pyramid");
    ll_action far = {.axis = {1.5F, 0}}, none = {0};
    ll_status status = ll_session_input(s, 0, 0, &far);
    assert_int_equal(status.code, LL_BAD_INPUT);
    status = ll_session_input(s, 0, 1, &none);
    assert_int_equal(status.code, LL_BAD_INPUT);
    ll_session_destroy(s);
}

/* ---- copies ---- */

static void a_copy_of_the_block_goes_on_as_the_block(void **state)
{
    (void)state;
    cJSON *json;
    ll_scenario scenario = {0};
    ok(ll_scenario_load("scenarios", "rigid/pyramid", &json));
    ok(ll_scenario_parse(json, &scenario));
    const ll_sim_kind *kind = scenario.kind;
    size_t size = kind->size(scenario.config);
    char *block = malloc(size), *copy = malloc(size);
    ok(kind->init(block, scenario.config));
    ok(kind->advance(block, LL_SECOND, NULL, NULL, NULL, NULL));
    memcpy(copy, block, size);
    uint64_t then = kind->hash(block);
    ok(kind->advance(block, 2 * LL_SECOND, NULL, NULL, NULL, NULL));
    assert_true(kind->hash(copy) == then);
    ok(kind->advance(copy, 2 * LL_SECOND, NULL, NULL, NULL, NULL));
    assert_true(kind->hash(copy) == kind->hash(block) && kind->hash(copy) != then);
    free(block);
    free(copy);
    ll_scenario_free(&scenario);
    cJSON_Delete(json);
}

/* Its size is known before it is made, and it stays within. */
static void a_block_stays_within_its_announced_size(void **state)
{
    (void)state;
    static const char *const ids[] = {"rigid/rain", "rigid/bullets", "rigid/rugged_wall", "rigid/spinner"};
    enum { BEYOND = 4096 };
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        cJSON *json;
        ll_scenario scenario = {0};
        ok(ll_scenario_load("scenarios", ids[i], &json));
        ok(ll_scenario_parse(json, &scenario));
        size_t size = scenario.kind->size(scenario.config);
        char *block = malloc(size + BEYOND), *wanted = malloc(BEYOND);
        memset(block + size, 0xa5, BEYOND);
        memset(wanted, 0xa5, BEYOND);
        ok(scenario.kind->init(block, scenario.config));
        ok(scenario.kind->advance(block, LL_SECOND, NULL, NULL, NULL, NULL));
        assert_memory_equal(block + size, wanted, BEYOND);
        free(block);
        free(wanted);
        ll_scenario_free(&scenario);
        cJSON_Delete(json);
    }
}

/* ---- bad input ---- */

static void refused(const char *body, const char *field, const char *word)
{
    char text[1024];
    cJSON *json;
    ll_scenario scenario = {0};
    snprintf(text, sizeof text, "{\"kind\":\"rigid\",%s}", body);
    ok(ll_json_parse(text, strlen(text), &json));
    ll_status status = ll_scenario_parse(json, &scenario);
    cJSON_Delete(json);
    if (!ll_failed(&status))
        fail_msg("%s was accepted", body);
    if (strstr(status.field, field) == NULL || strstr(status.text, field) == NULL ||
        strstr(status.text, word) == NULL)
        fail_msg("%s: %s (%s)", body, status.text, status.field);
}

static void bad_input_is_refused_with_field_range_and_value(void **state)
{
    (void)state;
    refused("\"side_by_side\":{\"method\":\"avbd\"}", "side_by_side", "an array");
    refused("\"side_by_side\":[{},{},{}]", "side_by_side", "at most 2 elements; got 3");
    refused("\"side_by_side\":[{\"method\":\"avbd\"}]", "side_by_side.0.method", "solver");
    refused("\"bodies\":[{\"density\":0}]", "bodies.0.density", "1e-06 to 1000000000 kg/m^2; got 0");
    refused("\"bodies\":[{\"density\":-1}]", "bodies.0.density", "got -1");
    refused("\"bodies\":[{\"density\":1e999}]", "bodies.0.density", "1e-06 to");
    refused("\"bodies\":[{\"position\":[1,2,3]}]", "bodies.0.position", "a pair [x, y] of numbers");
    refused("\"bodies\":[{\"position\":[2e9,0]}]", "bodies.0.position", "-1000000000 to 1000000000 m");
    refused("\"bodies\":[{\"velocity\":[0,null]}]", "bodies.0.velocity", "-1000000 to 1000000 m/s");
    refused("\"bodies\":[{},{\"size\":[1,0]}]", "bodies.1", "0");
    refused("\"bodies\":[{\"shape\":\"circle\",\"radius\":-1}]", "bodies.0.radius", "got -1");
    refused("\"bodies\":[{\"shape\":\"polygon\",\"points\":[[0,0],[1,0],[2,0]]}]", "bodies.0", "degenerate");
    refused("\"bodies\":[{\"shape\":\"polygon\",\"points\":[[0,0],[2,0],[1,0.5],[1,2]]}]", "bodies.0",
            "not convex");
    refused("\"bodies\":[{\"shape\":\"polygon\",\"points\":[[0,0],[1,0]]}]", "bodies.0", "3 to 8");
    refused("\"bodies\":[{\"type\":\"static\",\"shape\":\"chain\",\"points\":[[0,0],[1,0]]}]", "bodies.0",
            "at least 4; got 2");
    refused("\"bodies\":[{\"shape\":\"segment\",\"points\":[[0,0],[1,0]]}]", "bodies.0", "no mass");
    refused("\"gravity\":[0,-1e9]", "gravity", "-1000 to 1000 m/s^2");
    refused("\"solver\":{\"substeps\":0}", "solver.substeps", "1 to 64; got 0");
    refused("\"solver\":{\"method\":\"magic\"}", "solver.method", "soft_step");
    refused("\"bodies\":[{}],\"joints\":[{\"a\":0,\"b\":1}]", "joints.0.b", "1 bodies; got 1");
    refused("\"bodies\":[{},{}],\"joints\":[{\"a\":1,\"b\":1}]", "joints.0.b", "another body");
    refused("\"bodies\":[{},{}],\"joints\":[{\"a\":0,\"b\":1,\"limited\":true,\"lower\":2}]",
            "joints.0.lower", "got 2");
    refused("\"scene\":\"pyramid\",\"bodies\":[{}]", "bodies", "where a scene is named");
    refused("\"scene\":\"pyramid\",\"params\":{\"size\":100000}", "params.size", "1048576");
    refused("\"scene\":\"pyramid\",\"params\":{\"size\":1400}", "params.size", "MB");
    refused("\"hz\":0", "hz", "1 to 1000 Hz; got 0");
}

/* A solver that loses a body stops its session, and the message names the body. */
static void a_lost_body_stops_the_session(void **state)
{
    (void)state;
    ll_session *s = session_of("{\"kind\":\"rigid\",\"duration_s\":20,\"gravity\":[0,0],\"bodies\":["
                               "{},{\"velocity\":[1000000,0],\"position\":[990000000,10]}]}");
    ll_status status = ll_session_run_to(s, 1200);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "soft_step diverged in step 601: body 2 is at"));
    assert_int_equal(ll_session_get_info(s).status, LL_SESSION_FAILED);
    ll_session_destroy(s);
}

/* Joints of an arm that turns by half a radian per step: with one substep XPBD puts each body back along a
 * straight line, which gives it speed, again and again. Nothing is driven, so the solver creates that energy.
 */
#define ARM(methods)                                                                                         \
    "{\"kind\":\"rigid\",\"duration_s\":4,\"gravity\":[0,0],\"hz\":50," methods ",\"bodies\":["              \
    "{\"type\":\"static\",\"size\":[0.2,0.2]},{\"size\":[0.2,0.2],\"position\":[1,0],\"velocity\":[0,25],"   \
    "\"angular_velocity\":25},{\"size\":[0.2,0.2],\"position\":[2,0],\"velocity\":[0,25],\"angular_"         \
    "velocity\":25}],\"joints\":["                                                                           \
    "{\"type\":\"revolute\",\"a\":0,\"b\":1,\"anchor_a\":[0,0],\"anchor_b\":[-1,0]},"                        \
    "{\"type\":\"revolute\",\"a\":1,\"b\":2,\"anchor_a\":[0,0],\"anchor_b\":[-1,0]}]}"
static void created_energy_is_a_failure(void **state)
{
    (void)state;
    ll_session *s = session_of(ARM("\"solver\":{\"method\":\"xpbd\",\"substeps\":1}"));
    ll_status status = ll_session_run_to(s, 200);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "xpbd blew up in step"));
    ll_session_destroy(s);
    s = session_of(ARM("\"solver\":{\"method\":\"avbd\",\"substeps\":1},"
                       "\"side_by_side\":[{\"solver\":{\"method\":\"xpbd\",\"substeps\":1}}]"));
    ok(ll_session_run_to(s, 200));
    cJSON *report = ll_session_metrics(s), *first = cJSON_GetObjectItem(report, "metrics");
    const cJSON *beside = cJSON_GetArrayItem(cJSON_GetObjectItem(first, "side_by_side"), 0);
    assert_string_equal(cJSON_GetObjectItem(first, "status")->valuestring, "ok");
    assert_string_equal(cJSON_GetObjectItem(beside, "status")->valuestring, "diverged");
    assert_non_null(strstr(cJSON_GetObjectItem(beside, "reason")->valuestring, "blew up"));
    static const char *const told[] = {"energy_change_j", "energy_added_j", "drift_worst_m", "joint_error"};
    for (size_t i = 0; i < sizeof told / sizeof told[0]; i++) {
        assert_true(cJSON_IsNull(cJSON_GetObjectItem(beside, told[i])));
        assert_false(cJSON_IsNull(cJSON_GetObjectItem(first, told[i])));
    }
    cJSON_Delete(report);
    ll_session_destroy(s);
}

/* A chain with an initial error stores energy: releasing it is no failure. */
static void a_drawn_chain_may_spring(void **state)
{
    (void)state;
    ll_session *s = library("rigid/stretched_chain");
    ok(ll_session_run_to(s, 120));
    assert_true(metric(s, "energy_added_j") > 1e5);
    ll_session_destroy(s);
}

/* ---- measures of a world, by its bodies ---- */

static double number_in(const cJSON *metrics, const char *path)
{
    const cJSON *found = ll_param_number_at(metrics, path);
    if (found == NULL)
        fail_msg("%s is missing", path);
    return found->valuedouble;
}

typedef struct sums {
    double momentum[2], spin, kinetic, potential, speed, drift, sag, tilt;
} sums;

enum { DISCS = 3 };
static const double radius[DISCS] = {0.5, 0.25, 0.75}, density[DISCS] = {2, 5, 1},
                    start[DISCS][2] = {{-4, 1}, {0, 2}, {5, -1}};

static sums sums_of(const cJSON *metrics)
{
    sums r = {0};
    for (int i = 0; i < DISCS; i++) {
        const cJSON *body = cJSON_GetArrayItem(cJSON_GetObjectItem(metrics, "bodies"), i);
        double x = number_in(body, "position.0"), y = number_in(body, "position.1"),
               vx = number_in(body, "velocity.0"), vy = number_in(body, "velocity.1"),
               w = number_in(body, "angular_velocity"), m = density[i] * M_PI * radius[i] * radius[i],
               inertia = m * radius[i] * radius[i] / 2;
        r.momentum[0] += m * vx;
        r.momentum[1] += m * vy;
        r.spin += inertia * w + m * (x * vy - y * vx);
        r.kinetic += m * (vx * vx + vy * vy) / 2 + inertia * w * w / 2;
        r.potential += m * 10 * y;
        r.speed = larger(r.speed, hypot(vx, vy));
        r.drift = larger(r.drift, fabs(x - start[i][0]));
        r.sag = larger(r.sag, start[i][1] - y);
        r.tilt = larger(r.tilt, fabs(number_in(body, "angle")));
    }
    return r;
}

/* Discs that are thrown and meet nothing. */
static void measures_are_sums_over_the_bodies(void **state)
{
    (void)state;
    ll_session *s = session_of(
        "{\"kind\":\"rigid\",\"duration_s\":3,\"gravity\":[0,-10],\"bodies\":["
        "{\"shape\":\"circle\",\"position\":[-4,1],\"density\":2,\"velocity\":[-1,6],\"angular_velocity\":3},"
        "{\"shape\":\"circle\",\"radius\":0.25,\"position\":[0,2],\"density\":5,\"velocity\":[0.5,9]},"
        "{\"shape\":\"circle\",\"radius\":0.75,\"position\":[5,-1],\"velocity\":[2,-1],\"angular_velocity\":-"
        "4}]}");
    sums worst = {0}, first = {0};
    for (int64_t tick = 0; tick <= 90; tick++) {
        run_to(s, tick);
        cJSON *report = ll_session_metrics(s), *metrics = cJSON_GetObjectItem(report, "metrics");
        sums r = sums_of(metrics);
        first = tick == 0 ? r : first;
        worst.drift = larger(worst.drift, r.drift);
        worst.sag = larger(worst.sag, r.sag);
        worst.tilt = larger(worst.tilt, r.tilt);
        const struct {
            const char *path;
            double want;
        } rows[] = {{"momentum_kgmps.0", r.momentum[0]},
                    {"momentum_kgmps.1", r.momentum[1]},
                    {"spin_momentum_kgm2ps", r.spin},
                    {"kinetic_j", r.kinetic},
                    {"energy_j", r.kinetic + r.potential},
                    {"energy_change_j", r.kinetic + r.potential - first.kinetic - first.potential},
                    {"speed_max_mps", r.speed},
                    {"drift_m", r.drift},
                    {"drift_worst_m", worst.drift},
                    {"sag_m", r.sag},
                    {"sag_worst_m", worst.sag},
                    {"tilt_rad", r.tilt},
                    {"tilt_worst_rad", worst.tilt},
                    {"penetration_max_m", 0},
                    {"penetration_mean_m", 0},
                    {"penetration_worst_m", 0},
                    {"over_limit_steps", 0},
                    {"awake", DISCS},
                    {"steps_asleep", 0}};
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
            if (!is_near(number_in(metrics, rows[i].path), rows[i].want, 1e-6 + 1e-6 * fabs(rows[i].want)))
                fail_msg("tick %lld: %s is %.9g, of the bodies %.9g", (long long)tick, rows[i].path,
                         number_in(metrics, rows[i].path), rows[i].want);
        cJSON_Delete(report);
    }
    ll_session_destroy(s);
}

/* What swings comes back, so that now and the worst are not the same. */
static void the_worst_is_that_of_all_steps(void **state)
{
    (void)state;
    static const char *const names[][2] = {
        {"drift_m", "drift_worst_m"},
        {"sag_m", "sag_worst_m"},
        {"tilt_rad", "tilt_worst_rad"},
        {"joint_error", "joint_error_worst"},
    };
    enum { NAMES = sizeof names / sizeof names[0] };
    ll_session *s =
        session_of("{\"kind\":\"rigid\",\"duration_s\":5,\"gravity\":[0,-10],\"bodies\":["
                   "{\"type\":\"static\",\"size\":[0.1,0.1]},{\"size\":[0.2,0.2],\"position\":[2,0]}],"
                   "\"joints\":[{\"type\":\"revolute\",\"a\":0,\"b\":1,\"anchor_b\":[-2,0]}]}");
    double worst[NAMES] = {0};
    int below[NAMES] = {0};
    for (int64_t tick = 1; tick <= 240; tick++) {
        run_to(s, tick);
        cJSON *report = ll_session_metrics(s), *metrics = cJSON_GetObjectItem(report, "metrics");
        for (int i = 0; i < NAMES; i++) {
            double now = number_in(metrics, names[i][0]);
            worst[i] = larger(worst[i], now);
            below[i] += now < worst[i] / 2;
            assert_near(number_in(metrics, names[i][1]), worst[i], 1e-6 * worst[i] + 1e-15);
        }
        cJSON_Delete(report);
    }
    for (int i = 0; i < NAMES; i++)
        if (below[i] <= 10)
            fail_msg("%s: %g at worst, and seldom below half of it", names[i][0], worst[i]);
    ll_session_destroy(s);
}

/* Counted by looking after each step; and the depths of a pyramid that sinks and sleeps. */
static void sleep_and_depth_are_those_of_the_steps(void **state)
{
    (void)state;
    ll_session *s = library("rigid/pyramid");
    double worst = 0, seen = 0, asleep = 0, since = -1;
    for (int64_t tick = 1; tick <= 600 && asleep < 20; tick++) {
        run_to(s, tick);
        cJSON *report = ll_session_metrics(s), *metrics = cJSON_GetObjectItem(report, "metrics");
        double most = number_in(metrics, "penetration_max_m"),
               mean = number_in(metrics, "penetration_mean_m");
        bool sleeps = number_in(metrics, "awake") == 0;
        worst = larger(worst, most);
        seen += mean > 0;
        asleep += sleeps;
        since = !sleeps ? -1 : since < 0 ? (double)tick : since;
        assert_true(mean <= most && most <= worst);
        assert_near(number_in(metrics, "penetration_worst_m"), worst, 1e-6 * worst);
        assert_near(number_in(metrics, "steps_asleep"), asleep, 0);
        if (sleeps)
            assert_near(number_in(metrics, "asleep_at_step"), since, 0);
        else
            assert_true(cJSON_IsNull(cJSON_GetObjectItem(metrics, "asleep_at_step")));
        cJSON_Delete(report);
    }
    assert_true(seen > 50 && worst > 1e-4 && asleep == 20);
    ll_session_destroy(s);
}

/* What a page draws of each body, and what it counts. */
static void the_bodies_that_are_awake_are_those_counted(void **state)
{
    (void)state;
    ll_session *s = library("rigid/domino"); /* stones wake one after the other */
    int most_awake = 0;
    for (int64_t tick = 0; tick <= 300; tick += 30) {
        run_to(s, tick);
        cJSON *report = ll_session_metrics(s), *metrics = cJSON_GetObjectItem(report, "metrics"), *body;
        int bodies = 0, awake = 0;
        cJSON_ArrayForEach(body, cJSON_GetObjectItem(metrics, "bodies"))
        {
            bodies++;
            awake += cJSON_IsTrue(cJSON_GetObjectItem(body, "awake"));
        }
        assert_true(awake < bodies); /* the floor never is */
        assert_int_equal(awake, (int)cJSON_GetObjectItem(metrics, "awake")->valuedouble);
        most_awake = awake > most_awake ? awake : most_awake;
        cJSON_Delete(report);
    }
    assert_true(most_awake >= 10);
    ll_session_destroy(s);
}

/* ---- what the page draws ---- */

static double value(const ll_rows *rows, int row, const char *name)
{
    for (int i = 0; i < rows->record->count; i++)
        if (strcmp(rows->record->fields[i].name, name) == 0)
            return ll_field_value(&rows->record->fields[i], ll_rows_at(rows, row)[i]);
    fail_msg("%s has no %s", rows->record->name, name);
    return 0;
}

/* Row of a shape of the body that has the point in its box, but for rounding. */
static int shape_around(const ll_rows *shapes, double world, double body, double x, double y)
{
    const double grid = 0.01;
    for (int i = 0; i < shapes->count; i++) {
        double dx = x - value(shapes, i, "x"), dy = y - value(shapes, i, "y");
        if (value(shapes, i, "world") == world && value(shapes, i, "body") == body &&
            dx >= value(shapes, i, "left") - grid && dx <= value(shapes, i, "right") + grid &&
            dy >= value(shapes, i, "bottom") - grid && dy <= value(shapes, i, "top") + grid)
            return i;
    }
    fail_msg("no shape of body %g of world %g is around (%g, %g)", body, world, x, y);
    return -1;
}

/* Returns its points, each of which lies on both bodies. */
static int check_contact(const ll_rows *contacts, int row, const ll_rows *shapes)
{
    const int count = (int)value(contacts, row, "count");
    double world = value(contacts, row, "world"), island[2];
    if (count > 0)
        assert_near(hypot(value(contacts, row, "nx"), value(contacts, row, "ny")), 1, 2e-3);
    for (int k = 0; k < 2; k++) {
        double x = value(contacts, row, k ? "x1" : "x0"), y = value(contacts, row, k ? "y1" : "y0");
        assert_int_equal(isnan(x), k >= count);
        for (int side = 0; side < 2 && k < count; side++)
            island[side] = value(
                shapes, shape_around(shapes, world, value(contacts, row, side ? "b" : "a"), x, y), "island");
    }
    if (count > 0 && island[0] > 0 && island[1] > 0)
        assert_true(island[0] == island[1]);
    return count;
}

static void check_rows(const char *scene)
{
    char text[160];
    ll_scenario scenario = {0};
    ll_row_set set = {0};
    int all = 0;
    snprintf(text, sizeof text,
             "{\"kind\":\"rigid\",\"scene\":\"%s\",\"duration_s\":9,\"solver\":{\"sleep\":false},"
             "\"side_by_side\":[{\"solver\":{\"method\":\"pgs\"}}]}",
             scene);
    cJSON *json = cJSON_Parse(text);
    ok(ll_scenario_parse(json, &scenario));
    void *block = malloc(scenario.kind->size(scenario.config));
    ok(scenario.kind->init(block, scenario.config));
    for (int i = 1; i <= 5; i++) {
        ok(scenario.kind->advance(block, i * LL_SECOND / 4, NULL, NULL, NULL, NULL));
        ll_row_set_clear(&set);
        const int at[] = {ll_row_set_add(&set, &ll_rigid_world_record, true),
                          ll_row_set_add(&set, &ll_rigid_shape_record, true),
                          ll_row_set_add(&set, &ll_rigid_contact_record, true),
                          ll_row_set_add(&set, &ll_rigid_joint_record, true)};
        ll_row_set_add(&set, &ll_rigid_geometry_record, false);
        ll_row_set_add(&set, &ll_rigid_vertex_record, false);
        ll_row_set_add(&set, &ll_rigid_volume_record, false);
        scenario.kind->fill(block, &set);
        const ll_rows *worlds = set.rows[at[0]], *contacts = set.rows[at[2]], *joints = set.rows[at[3]];
        assert_int_equal(worlds->count, 2);
        for (int world = 0; world < worlds->count; world++) {
            int pairs = 0, touching = 0, points = 0;
            for (int k = 0; k < contacts->count; k++) {
                if (value(contacts, k, "world") != world)
                    continue;
                int count = check_contact(contacts, k, set.rows[at[1]]);
                pairs++;
                touching += count > 0;
                points += count;
            }
            assert_int_equal(pairs, (int)value(worlds, world, "pairs"));
            assert_int_equal(touching, (int)value(worlds, world, "touching"));
            assert_int_equal(points, (int)value(worlds, world, "points"));
            all += points;
        }
        assert_int_equal(joints->count, (int)(value(worlds, 0, "joints") + value(worlds, 1, "joints")));
    }
    assert_true(all > 10);
    ll_row_set_free(&set);
    free(block);
    ll_scenario_free(&scenario);
    cJSON_Delete(json);
}

/* Bodies with contacts, or with joints too, each in two worlds. Only contacts that are solved are counted, so
 * that none sleeps. */
static void contacts_that_are_drawn_are_those_counted(void **state)
{
    (void)state;
    static const char *const scenes[] = {"card_house", "cart", "ramps", "domino"};
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++)
        check_rows(scenes[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_body_falls_as_its_steps_say),
        cmocka_unit_test(elastic_impacts_keep_momentum_and_energy),
        cmocka_unit_test(a_distance_joint_keeps_the_distance_of_its_anchors),
        cmocka_unit_test(volumes_are_judged_against_the_shapes),
        cmocka_unit_test(broad_phase_and_simd_change_nothing_else_does),
        cmocka_unit_test(what_is_no_setting_cannot_change),
        cmocka_unit_test(a_bullet_does_not_pass_another_body),
        cmocka_unit_test(worlds_with_the_same_solver_stay_the_same),
        cmocka_unit_test(a_dragged_body_comes_to_the_pointer_in_both_worlds),
        cmocka_unit_test(an_input_for_an_unknown_player_is_rejected),
        cmocka_unit_test(a_copy_of_the_block_goes_on_as_the_block),
        cmocka_unit_test(a_block_stays_within_its_announced_size),
        cmocka_unit_test(bad_input_is_refused_with_field_range_and_value),
        cmocka_unit_test(created_energy_is_a_failure),
        cmocka_unit_test(a_drawn_chain_may_spring),
        cmocka_unit_test(a_lost_body_stops_the_session),
        cmocka_unit_test(the_bodies_that_are_awake_are_those_counted),
        cmocka_unit_test(contacts_that_are_drawn_are_those_counted),
        cmocka_unit_test(measures_are_sums_over_the_bodies),
        cmocka_unit_test(the_worst_is_that_of_all_steps),
        cmocka_unit_test(sleep_and_depth_are_those_of_the_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

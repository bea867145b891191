/* Every scene can be built within its limits and runs; the hard ones stay within the bounds given here. */
#include "rigid/harness.h"

typedef struct bound { /* after 10 s without sleeping; 0: not checked */
    const char *scene;
    ll_scene_args args;
    int steps;
    double sag, drift, tilt, penetration, speed;
} bound;

static const bound bounds[] = {
    {"column", {.size = 80}, 600, .sag = 0.15, .drift = 0.01, .tilt = 0.001, .penetration = 0.005},
    {"inverse_pyramid", {0}, 600, .sag = 0.06, .drift = 0.03, .tilt = 0.002, .penetration = 0.05},
    {"tiny_pyramid", {0}, 300, .sag = 0.01, .drift = 0.005, .tilt = 0.01, .penetration = 0.001},
    {"heavy_on_two", {.offset = 4}, 600, .sag = 0.02, .drift = 1, .tilt = 0.02, .penetration = 0.02},
    {"heavy_on_triangles", {0}, 600, .sag = 0.02, .drift = 0.01, .tilt = 0.01, .penetration = 0.01},
    {"heavy_tops", {0}, 600, .sag = 0.1, .drift = 1, .tilt = 0.1, .penetration = 0.02, .speed = 0.05},
    {"overlap",
     {.size = 3},
     600,
     .sag = 0.001,
     .drift = 1,
     .tilt = 0.001,
     .penetration = 0.005,
     .speed = 0.01},
    {"overlap", {0}, 600, .penetration = 0.005, .speed = 0.01}, /* where the top comes to rest is random */
    {"total_overlap", {.size = 8}, 600, .penetration = 0.01, .speed = 0.01},
    {"card_house", {0}, 600, .sag = 0.005, .drift = 0.01, .tilt = 0.05, .penetration = 0.001, .speed = 0.001},
    {"arch", {0}, 600, .sag = 0.01, .drift = 0.005, .tilt = 0.002, .penetration = 0.001, .speed = 0.001},
    {"far_pyramid", {.offset = 1e5}, 300, .sag = 0.002, .drift = 0.002, .tilt = 0.001, .penetration = 0.001},
    {"far_pyramid", {.offset = 1e7}, 300, .sag = 0.002, .drift = 0.002, .tilt = 0.001, .penetration = 0.001},
    {"tilted_stack",
     {.size = 4, .offset = 0.1},
     300,
     .sag = 0.01,
     .drift = 0.01,
     .tilt = 0.01,
     .penetration = 0.002},
    {"circle_stack", {0}, 600, .drift = 0.001, .penetration = 0.01, .speed = 0.02},
};

static void hard_cases_keep_their_bounds(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++) {
        const bound *b = &bounds[i];
        lab l = lab_standard(b->scene, b->args);
        lab_run(&l, b->steps);
        ll_rigid_metrics m = lab_measure(&l);
        char what[64];
        const char *const names[] = {"sag", "drift", "tilt", "penetration", "speed"};
        const double values[] = {m.sag_max, m.drift_max, m.tilt_max, m.penetration_max, m.speed_max};
        const double most[] = {b->sag, b->drift, b->tilt, b->penetration, b->speed};
        for (int k = 0; k < 5; k++) {
            snprintf(what, sizeof what, "%s of %s", names[k], b->scene);
            if (most[k] > 0)
                assert_at_most(what, values[k], most[k]);
        }
        lab_close(&l);
    }
}

/* More balls than fit: compression energy does not become velocity, and all stay inside. */
static void confined_balls_come_to_rest(void **state)
{
    (void)state;
    lab l = lab_standard("confined", (ll_scene_args){0});
    lab_run(&l, 600);
    assert_at_most("mean speed^2", 2 * lab_measure(&l).kinetic_energy / (0.785 * 625), 1e-4);
    for (int32_t i = 1; i < l.count; i++) {
        ll_vec2 at = body(l.world, ll_rigid_body_at(l.world, i)).position;
        assert_at_most("place", larger(fabs(at.x), fabs(at.y)), 10);
    }
    lab_close(&l);
}

static int64_t small_size(const ll_scene *scene)
{
    int64_t size = scene->default_value.size;
    return size > 64 ? 16 : size;
}

static void every_scene_runs(void **state)
{
    (void)state;
    for (int i = 0; i < ll_scene_count; i++) {
        const ll_scene *scene = ll_scenes[i];
        assert_ptr_equal(ll_scene_named(scene->name), scene);
        assert_true(strlen(scene->title) > 0 && strlen(scene->help) > 20);
        lab l = lab_standard(scene->name, (ll_scene_args){.size = small_size(scene)});
        assert_true(l.count > 0);
        for (int step = 0; step < 120; step += 20) {
            lab_run(&l, 20);
            if (!ll_rigid_valid(l.world))
                fail_msg("%s is not valid", scene->name);
        }
        lab_close(&l);
    }
    assert_null(ll_scene_named("no such"));
}

/* A few steps of a scene that may be refused, or diverge. Whether it was run. */
static bool runs_or_is_refused(const ll_scene *scene, ll_scene_args given)
{
    enum { most_bytes = 4000000, steps = 10 };
    ll_rigid_params p = scene_params(scene->name, given);
    ll_scene_args args = scene_args(scene, given);
    ll_rigid_limits limits = {.broad = LL_BROAD_TREE};
    scene->limits(&args, &limits);
    ll_status status = ll_rigid_check(&limits);
    if (ll_failed(&status) || ll_rigid_size(&limits) > most_bytes)
        return false;
    ll_rigid *w = world_of(&limits, &p);
    status = scene->build(w, &args);
    for (int step = 0; step < steps && !ll_failed(&status); step++) {
        if (scene->drive != NULL)
            status = scene->drive(w, &args, step);
        if (!ll_failed(&status))
            status = ll_rigid_step(w, 1.0 / 60, NULL);
    }
    free(w);
    return true;
}

/* Every argument at both ends of its range: a pusher so fast that it turns in each step was a division by 0.
 */
static void every_scene_takes_the_ends_of_its_arguments(void **state)
{
    (void)state;
    static const ll_scene_args ends[] = {
        {.size = 1},       {.size = 2},    {.size = 3},          {.size = 100000},
        {.ratio = 1e-300}, {.ratio = 1e6}, {.offset = 1e-300},   {.offset = 1e7},
        {.speed = 1e-300}, {.speed = 1e5}, {.friction = 1e-300}, {.friction = 10},
    };
    int run = 0;
    for (int i = 0; i < ll_scene_count; i++)
        for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++) {
            ll_scene_args args = ends[k];
            if (args.size == 0)
                args.size = small_size(ll_scenes[i]);
            run += runs_or_is_refused(ll_scenes[i], args);
        }
    assert_true(run > 10 * ll_scene_count);
}

/* Bodies are added and removed: the world stays valid, and the joints of ragdolls hold. */
static void rain_comes_and_goes(void **state)
{
    (void)state;
    lab l = lab_standard("rain", (ll_scene_args){.size = 10});
    for (int i = 0; i < 30; i++) {
        lab_run(&l, 20);
        assert_true(ll_rigid_valid(l.world));
    }
    ll_rigid_stats s = ll_rigid_get_stats(l.world);
    assert_int_equal(s.bodies, 1 + 11 * 10);
    assert_int_equal(s.joints, 10 * 10);
    lab_close(&l);
}

/* The paper's wall, exact and with bounding volumes: larger shapes are hit earlier. */
static void volumes_change_while_it_runs(void **state)
{
    (void)state;
    const ll_scene *scene = ll_scene_named("rugged_wall");
    ll_scene_args args = scene_args(scene, (ll_scene_args){0});
    int touching[LL_VOLUMES];
    for (int v = 0; v < LL_VOLUMES; v++) {
        ll_rigid_params p = scene_params("rugged_wall", (ll_scene_args){0});
        ll_rigid_limits limits = {.broad = LL_BROAD_GRID, .volumes = 1};
        scene->limits(&args, &limits);
        ll_rigid *w = world_of(&limits, &p);
        ok(scene->build(w, &args));
        for (int i = 0; i < 20; i++)
            ok(ll_rigid_step(w, 1.0 / 60, NULL));
        p.bounding_volume = v;
        ok(ll_rigid_set_params(w, &p));
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
        touching[v] = ll_rigid_get_stats(w).touching;
        for (int i = 0; i < 100; i++)
            ok(ll_rigid_step(w, 1.0 / 60, NULL));
        assert_true(ll_rigid_valid(w));
        free(w);
    }
    assert_true(touching[LL_VOLUME_AABB] >= touching[LL_VOLUME_EXACT]);
    assert_true(touching[LL_VOLUME_SPHERE] > touching[LL_VOLUME_EXACT]);

    ll_rigid_params p = standard_params();
    ll_rigid_limits limits = small_limits(2);
    ll_rigid *w = world_of(&limits, &p);
    p.bounding_volume = LL_VOLUME_OBB;
    assert_int_equal(ll_rigid_set_params(w, &p).code, LL_CONFLICT);
    free(w);
}

static void the_tables_are_sound(void **state)
{
    (void)state;
    ok(ll_param_table_valid(&ll_rigid_table));
    ok(ll_param_table_valid(&ll_scene_args_table));
    for (int i = 0; i < LL_SOLVERS; i++)
        assert_true(strlen(ll_rigid_solver_help((ll_rigid_solver_kind)i)) > 20);
    for (int i = 0; i < LL_BROADS; i++)
        assert_string_equal(ll_broad_phases[i]->name, ll_broad_names[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hard_cases_keep_their_bounds),
        cmocka_unit_test(confined_balls_come_to_rest),
        cmocka_unit_test(every_scene_runs),
        cmocka_unit_test(every_scene_takes_the_ends_of_its_arguments),
        cmocka_unit_test(rain_comes_and_goes),
        cmocka_unit_test(volumes_change_while_it_runs),
        cmocka_unit_test(the_tables_are_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

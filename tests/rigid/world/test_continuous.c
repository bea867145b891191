/* Bullets of 5 cm radius against walls of 5 cm, each from 200 phases of a step: how many tunnel. */
#include "rigid/harness.h"

typedef struct outcome {
    int passed;
    double depth;   /* largest depth of a ball in its wall after a step */
    double fastest; /* measured at the start: no hidden speed limit */
} outcome;

static outcome shoot(const char *scene, double speed, int32_t continuous, const char *solver)
{
    ll_scene_args args = {.speed = speed};
    ll_rigid_params p = scene_params(scene, args);
    p.continuous = continuous;
    ok(ll_param_set(&ll_rigid_table, &p, "method", solver, false));
    lab l = lab_open(scene, args, &p, LL_BROAD_GRID);
    outcome o = {0};
    lab_run(&l, 1);
    o.fastest = lab_measure(&l).speed_max;
    for (int i = 0; i < 20; i++) {
        lab_run(&l, 1);
        o.depth = larger(o.depth, lab_measure(&l).penetration_max);
    }
    for (int32_t i = 0; i + 1 < l.count; i += 2) {
        ll_body_state wall = body(l.world, ll_rigid_body_at(l.world, i)),
                      ball = body(l.world, ll_rigid_body_at(l.world, i + 1));
        o.passed += ball.position.x > wall.position.x;
    }
    lab_close(&l);
    return o;
}

static const double speeds[] = {20, 100, 500, 2000};
static const char *const walls[] = {"bullets", "bullets_moving", "bullets_loose"};

static void swept_detection_lets_none_pass(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++) {
            outcome o = shoot(walls[k], speeds[i], LL_CONTINUOUS_SWEPT, "soft_step");
            assert_int_equal(o.passed, 0);
            assert_near(o.fastest, speeds[i], 1e-9 * speeds[i]);
            assert_at_most("depth", o.depth, 0.005);
        }
}

static void whatever_the_solver(void **state)
{
    (void)state;
    for (int i = 0; i < LL_SOLVERS; i++)
        for (int k = 0; k < 3; k++)
            assert_int_equal(shoot(walls[k], 500, LL_CONTINUOUS_SWEPT, ll_rigid_solver_names[i]).passed, 0);
}

static void speculative_contacts_let_none_pass(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            assert_int_equal(shoot(walls[k], speeds[i], LL_CONTINUOUS_SPECULATIVE, "soft_step").passed, 0);
}

/* A ball is caught if a step ends with it in the wall and not yet past its middle: within the wall's
 * thickness plus the ball's radius, up to the contact margin. */
static void without_it_as_many_pass_as_theory_says(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        double way = speeds[i] / 60, share = 1 - (0.05 + 0.05) / way, error = sqrt(200 * share * (1 - share));
        outcome o = shoot("bullets", speeds[i], LL_CONTINUOUS_OFF, "soft_step");
        assert_near(o.passed, 200 * share, 3 * error);
        assert_true(o.passed > 100);
    }
}

/* A ball against a movable wall of `masses` times its mass, at 8.3 m per step from 40 phases: how many
 * tunnel. */
static int pass_a_wall_of(double masses, bool bullet)
{
    ll_rigid_limits limits = small_limits(80);
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.continuous = LL_CONTINUOUS_SWEPT;
    ll_rigid *w = world_of(&limits, &p);
    ll_material m = ll_material_defaults();
    ll_body_id wall[40], ball[40];
    int passed = 0;
    for (int i = 0; i < 40; i++) {
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec(0, i);
        wall[i] = add_box(w, def, 0.05, 0.8, m);
        ok(ll_rigid_set_mass(w, wall[i], masses, 1));
        def.bullet = bullet;
        def.position.x = -(10 + 500.0 / 60 * (i + 0.5) / 40);
        def.velocity = ll_vec(500, 0);
        ball[i] = add_ball(w, def, 0.05, m);
        ok(ll_rigid_set_mass(w, ball[i], 1, 1));
    }
    for (int k = 0; k < 4; k++)
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
    for (int i = 0; i < 40; i++)
        passed += body(w, ball[i]).position.x > body(w, wall[i]).position.x;
    free(w);
    return passed;
}

/* A body that is not much heavier does not stop a fast one: similar masses are left to their contacts. */
static void the_heavier_stops_the_lighter(void **state)
{
    (void)state;
    assert_int_equal(pass_a_wall_of(4, false), 0);
    assert_int_equal(pass_a_wall_of(1000, false), 0);
    assert_at_least("tunnelled", pass_a_wall_of(3.9, false), 30);
}

static void a_bullet_is_stopped_by_any_mass(void **state)
{
    (void)state;
    const double masses[] = {1000, 4, 3.9, 1, 0.01};
    for (int i = 0; i < 5; i++)
        assert_int_equal(pass_a_wall_of(masses[i], true), 0);
}

/* 200 pairs of balls of equal mass and 5 cm radius that approach at `speed` each, spread evenly over the
 * phases of a step: how many pass through each other. */
static int pass_each_other(double speed, bool left, bool right, const char *solver)
{
    ll_rigid_limits limits = small_limits(400);
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.continuous = LL_CONTINUOUS_SWEPT;
    ok(ll_param_set(&ll_rigid_table, &p, "method", solver, false));
    ll_rigid *w = world_of(&limits, &p);
    ll_body_id ball[200][2];
    int passed = 0;
    for (int i = 0; i < 200; i++)
        for (int side = 0; side < 2; side++) {
            ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
            double sign = side == 0 ? 1 : -1;
            def.position = ll_vec(-sign * speed / 60 * (1 + (i + 0.5) / 200), i);
            def.velocity = ll_vec(sign * speed, 0);
            def.bullet = side == 0 ? left : right;
            ball[i][side] = add_ball(w, def, 0.05, ll_material_defaults());
        }
    for (int k = 0; k < 6; k++)
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
    for (int i = 0; i < 200; i++)
        passed += body(w, ball[i][0]).position.x > body(w, ball[i][1]).position.x;
    free(w);
    return passed;
}

static void bullets_do_not_pass_each_other(void **state)
{
    (void)state;
    for (int i = 1; i < 4; i++) {
        assert_int_equal(pass_each_other(speeds[i], true, true, "soft_step"), 0);
        assert_int_equal(pass_each_other(speeds[i], true, false, "soft_step"), 0);
        assert_int_equal(pass_each_other(speeds[i], false, true, "soft_step"), 0);
    }
    for (int i = 0; i < LL_SOLVERS; i++)
        assert_int_equal(pass_each_other(500, true, true, ll_rigid_solver_names[i]), 0);
}

/* They are caught if a step ends with them nearer than both radii plus both contact margins, 1 cm each, and
 * not yet past each other. With evenly spread phases this is exact to one pair. */
static void without_the_flag_as_many_pass_each_other_as_theory_says(void **state)
{
    (void)state;
    for (int i = 1; i < 4; i++) {
        double way = 2 * speeds[i] / 60, share = 1 - (0.05 + 0.05 + 0.01 + 0.01) / way;
        assert_near(pass_each_other(speeds[i], false, false, "soft_step"), 200 * share, 1);
    }
}

/* A row of bullets of equal speed; the first hits a wall. */
static ll_rigid *train(int32_t broad, ll_body_id ball[20])
{
    ll_rigid_limits limits = small_limits(21);
    limits.broad = broad;
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.continuous = LL_CONTINUOUS_SWEPT;
    ll_rigid *w = world_of(&limits, &p);
    add_box(w, ll_body_defaults(LL_BODY_STATIC), 0.05, 1, ll_material_defaults());
    for (int i = 0; i < 20; i++) {
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec(-1 - 0.3 * i, 0);
        def.velocity = ll_vec(500, 0);
        def.bullet = 1;
        ball[i] = add_ball(w, def, 0.05, ll_material_defaults());
    }
    return w;
}

/* Each comes to rest at the one before it, though none of them moves relative to its neighbours until
 * then. */
static void who_stops_is_met_where_it_stopped(void **state)
{
    (void)state;
    uint64_t hash = 0;
    for (int32_t broad = 0; broad < LL_BROADS; broad++) {
        ll_body_id ball[20];
        ll_rigid *w = train(broad, ball);
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
        assert_int_equal(ll_rigid_get_stats(w).stopped, 20);
        for (int i = 0; i < 20; i++) {
            double x = body(w, ball[i]).position.x, before = i == 0 ? 0.025 : body(w, ball[i - 1]).position.x;
            assert_near(before - x, 0.1, 0.0015); /* an impact leaves a quarter of the slop */
        }
        assert_true(broad == 0 || hash == ll_rigid_hash(w));
        hash = ll_rigid_hash(w);
        free(w);
    }
}

static int below_floor(const lab *l)
{
    int count = 0;
    for (int32_t i = 1; i < l->count; i++) {
        ll_body_state s = body(l->world, ll_rigid_body_at(l->world, i));
        count += s.position.y < -0.05 && fabs(s.position.x) < 19;
    }
    return count;
}

/* A floor without thickness, hit by spinning rods of 1 cm and by small bodies at 200 m/s. */
static void thin_things_stay_above_a_floor(void **state)
{
    (void)state;
    const char *const names[] = {"skinny_box", "drop"};
    for (int i = 0; i < 2; i++) {
        lab l = lab_standard(names[i], (ll_scene_args){0});
        for (int step = 0; step < 240; step++) {
            lab_run(&l, 1);
            assert_int_equal(below_floor(&l), 0);
        }
        assert_true(ll_rigid_get_stats(l.world).step == 240);
        lab_close(&l);

        ll_rigid_params p = scene_params(names[i], (ll_scene_args){0});
        p.continuous = LL_CONTINUOUS_OFF; /* checks that the test can fail */
        l = lab_open(names[i], (ll_scene_args){0}, &p, LL_BROAD_GRID);
        lab_run(&l, 20);
        assert_true(below_floor(&l) > 0);
        lab_close(&l);
    }
}

static void a_wedge_and_a_shaft_hold(void **state)
{
    (void)state;
    lab l = lab_standard("wedge", (ll_scene_args){0});
    for (int i = 0; i < 12; i++) { /* they may now leave over the rim */
        lab_run(&l, 1);
        /* Due to the solver: a ball moves 21 cm in a substep of 1/960 s, and one presses on the other. */
        assert_at_most("overlap", lab_measure(&l).penetration_max, 0.1 * 200 / 960);
    }
    for (int32_t i = 1; i < l.count; i++) {
        ll_body_state s = body(l.world, ll_rigid_body_at(l.world, i));
        assert_true(s.position.x < 0 && s.position.y > -2 * s.position.x - 0.01); /* above the left wall */
    }
    lab_close(&l);
    l = lab_standard("pixel_imperfect", (ll_scene_args){0});
    lab_run(&l, 120);
    assert_near(body(l.world, ll_rigid_body_at(l.world, 1)).position.y, 0.5, 0.001); /* at the bottom */
    lab_close(&l);
}

/* A body that slides over the seams of a chain keeps its height and speed. */
static void seams_are_not_felt(void **state)
{
    (void)state;
    lab l = lab_standard("ghost_bumps", (ll_scene_args){0});
    for (int i = 0; i < 240; i++) {
        lab_run(&l, 1);
        for (int32_t k = 1; k < l.count; k++) {
            ll_body_state s = body(l.world, ll_rigid_body_at(l.world, k));
            assert_near(s.velocity.x, 10, 1e-6);
            assert_near(s.position.y, l.first[k].position.y, 0.001);
        }
    }
    lab_close(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(swept_detection_lets_none_pass),
        cmocka_unit_test(whatever_the_solver),
        cmocka_unit_test(speculative_contacts_let_none_pass),
        cmocka_unit_test(without_it_as_many_pass_as_theory_says),
        cmocka_unit_test(the_heavier_stops_the_lighter),
        cmocka_unit_test(a_bullet_is_stopped_by_any_mass),
        cmocka_unit_test(bullets_do_not_pass_each_other),
        cmocka_unit_test(without_the_flag_as_many_pass_each_other_as_theory_says),
        cmocka_unit_test(who_stops_is_met_where_it_stopped),
        cmocka_unit_test(thin_things_stay_above_a_floor),
        cmocka_unit_test(a_wedge_and_a_shaft_hold),
        cmocka_unit_test(seams_are_not_felt),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

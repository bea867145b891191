/* Each joint type works under every solver; heavy loads on long chains. */
#include "rigid/harness.h"

static const double pi = 3.14159265358979323846;

typedef struct pair {
    ll_rigid *world;
    ll_body_id fixed, free;
} pair;

/* A static body at the origin and a box of 1 m at (x, y). */
static pair two_bodies(int32_t solver, double x, double y, double gravity)
{
    ll_rigid_limits limits = small_limits(4);
    ll_rigid_params p = standard_params();
    p.sleep = false;
    p.solver = solver;
    p.gravity_y = gravity;
    pair t = {.world = world_of(&limits, &p)};
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    ok(ll_rigid_add_body(t.world, &def, &t.fixed));
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.position = ll_vec(x, y);
    t.free = add_box(t.world, def, 1, 1, ll_material_defaults());
    return t;
}

static ll_joint_id join(const pair *t, const ll_joint_def *def)
{
    ll_joint_id id;
    ok(ll_rigid_add_joint(t->world, def, &id));
    return id;
}

static void run(const pair *t, int steps)
{
    for (int i = 0; i < steps; i++)
        ok(ll_rigid_step(t->world, 1.0 / 60, NULL));
}

/* Largest errors after hanging for 5 s; impulse and pgs correct a fifth of an error per step. */
static const double slack[LL_SOLVERS] = {0.1, 0.05, 0.05, 0.002, 0.01, 0.002, 0.03};

static void hinges_and_welds_hold(void **state)
{
    (void)state;
    const ll_joint_type types[] = {LL_JOINT_REVOLUTE, LL_JOINT_WELD, LL_JOINT_PRISMATIC};
    for (int solver = 0; solver < LL_SOLVERS; solver++)
        for (int i = 0; i < 3; i++) {
            pair t = two_bodies(solver, 1, 0, -10);
            ll_joint_def def = ll_joint_defaults(t.world, types[i], t.fixed, t.free, ll_vec(0, 0));
            def.axis = ll_vec(1, 0);
            join(&t, &def);
            run(&t, 300);
            ll_rigid_metrics m = ll_rigid_measure(t.world, NULL, 0, INFINITY);
            assert_at_most(ll_rigid_solver_names[solver], m.joint_error, slack[solver]);
            free(t.world);
        }
}

static void a_rod_keeps_its_length_and_a_rope_only_pulls(void **state)
{
    (void)state;
    for (int rope = 0; rope < 2; rope++) {
        pair t = two_bodies(LL_SOLVER_SOFT_STEP, 0.5, -1, -10);
        ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_DISTANCE, t.fixed, t.free, ll_vec(0, 0));
        def.anchor_b = ll_vec(0, 0);
        def.length = rope ? 2 : sqrt(1.25);
        def.rope = rope;
        join(&t, &def);
        double longest = 0, shortest = 10;
        for (int i = 0; i < 300; i++) {
            run(&t, 1);
            double length = ll_length(body(t.world, t.free).position);
            longest = larger(longest, length);
            shortest = smaller(shortest, length);
        }
        assert_at_most("longest", longest, def.length + 0.005);
        if (rope)
            assert_at_most("shortest", shortest, 1.5); /* it was in free fall at first */
        else
            assert_at_least("shortest", shortest, def.length - 0.005);
        free(t.world);
    }
}

/* A weight on a spring of f Hz rests g / (2 pi f)^2 below. */
static void a_spring_is_as_stiff_as_it_says(void **state)
{
    (void)state;
    for (int solver = 0; solver < LL_SOLVERS; solver++) {
        pair t = two_bodies(solver, 0, -1, -10);
        ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_DISTANCE, t.fixed, t.free, ll_vec(0, 0));
        def.anchor_b = ll_vec(0, 0);
        def.length = 1;
        def.hertz = 2;
        def.damping = 0.5;
        join(&t, &def);
        run(&t, 600);
        double sag = 10 / (4 * pi * 4 * pi);
        ll_body_state s = body(t.world, t.free);
        if (!(fabs(-1 - s.position.y - sag) <= 1e-9 * sag && fabs(s.velocity.y) < 1e-9))
            fail_msg("%s: %g m instead of %g, and %g m/s", ll_rigid_solver_names[solver], -1 - s.position.y,
                     sag, s.velocity.y);
        free(t.world);
    }
}

/* In a period an amplitude decreases to exp(-2 pi zeta / sqrt(1 - zeta^2)) of it. Implicit steps of h add
 * omega h / 2 to the damping ratio, and omega h if the spring is solved again after bodies moved. */
static void a_spring_swings_out_as_its_damping_says(void **state)
{
    (void)state;
    const double zeta = 0.1, omega = 2 * pi;
    for (int solver = 0; solver < LL_SOLVERS; solver++) {
        bool substeps =
            solver == LL_SOLVER_SOFT_STEP || solver == LL_SOLVER_TGS_STICKY || solver == LL_SOLVER_XPBD;
        double h = substeps ? 1.0 / 60 / 16 : 1.0 / 60, most = zeta + omega * h;
        pair t = two_bodies(solver, 0, -1.5, 0);
        ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_DISTANCE, t.fixed, t.free, ll_vec(0, 0));
        def.anchor_b = ll_vec(0, 0);
        def.length = 1;
        def.hertz = 1;
        def.damping = zeta;
        join(&t, &def);
        run(&t, 45);
        double back = 0; /* the largest about one period after the start */
        for (int i = 0; i < 30; i++) {
            run(&t, 1);
            back = larger(back, -1 - body(t.world, t.free).position.y);
        }
        double slow = 0.5 * exp(-2 * pi * zeta / sqrt(1 - zeta * zeta));
        double fast = 0.5 * exp(-2 * pi * most / sqrt(1 - most * most));
        if (!(back <= 1.01 * slow && back >= 0.99 * fast))
            fail_msg("%s: %g m instead of %g to %g", ll_rigid_solver_names[solver], back, fast, slow);
        free(t.world);
    }
}

/* A largest torque accelerates equally in every solver: T / I per second. */
static void a_motor_has_the_torque_that_it_says(void **state)
{
    (void)state;
    const ll_joint_type types[] = {LL_JOINT_REVOLUTE, LL_JOINT_MOTOR};
    for (int solver = 0; solver < LL_SOLVERS; solver++)
        for (int i = 0; i < 2; i++) {
            pair t = two_bodies(solver, 0, 0, 0);
            ll_joint_def def = ll_joint_defaults(t.world, types[i], t.fixed, t.free, ll_vec(0, 0));
            def.motored = 1;
            def.motor_speed = 3;
            def.max_force = 10;
            def.max_torque = 0.5; /* the box has 1/6 kg m^2: 3 rad/s^2 */
            join(&t, &def);
            run(&t, 30);
            double half = body(t.world, t.free).angular_velocity;
            run(&t, 60);
            double full = body(t.world, t.free).angular_velocity;
            if (!(fabs(half - 1.5) < 1e-9 && fabs(full - 3) < 1e-9))
                fail_msg("%s, %s: %g and %g rad/s", ll_rigid_solver_names[solver],
                         ll_joint_type_names[types[i]], half, full);
            free(t.world);
        }
}

/* A box on a revolute joint with distant limits rotates as without them. */
static void a_far_limit_is_not_felt(void **state)
{
    (void)state;
    for (int solver = 0; solver < LL_SOLVERS; solver++) {
        double angle[2];
        for (int limited = 0; limited < 2; limited++) {
            pair t = two_bodies(solver, 1, 0, -10);
            ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_REVOLUTE, t.fixed, t.free, ll_vec(0, 0));
            def.limited = limited;
            def.lower = -3;
            def.upper = 3;
            join(&t, &def);
            run(&t, 30);
            angle[limited] = body(t.world, t.free).angle;
            free(t.world);
        }
        assert_at_most("angle", angle[0], -0.5);
        if (!(fabs(angle[0] - angle[1]) < 1e-9))
            fail_msg("%s: %g instead of %g rad", ll_rigid_solver_names[solver], angle[1], angle[0]);
    }
}

static void limits_stop_and_motors_drive(void **state)
{
    (void)state;
    pair t = two_bodies(LL_SOLVER_SOFT_STEP, 1, 0, -10);
    ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_REVOLUTE, t.fixed, t.free, ll_vec(0, 0));
    def.limited = 1;
    def.lower = -0.5;
    def.upper = 0.5;
    join(&t, &def);
    run(&t, 300);
    assert_near(body(t.world, t.free).angle, -0.5, 0.005);
    free(t.world);

    t = two_bodies(LL_SOLVER_SOFT_STEP, 0, 0, 0);
    def = ll_joint_defaults(t.world, LL_JOINT_REVOLUTE, t.fixed, t.free, ll_vec(0, 0));
    def.motored = 1;
    def.motor_speed = 3;
    def.max_torque = 0.5; /* the box has 1/6 kg m^2: 3 rad/s^2 */
    join(&t, &def);
    run(&t, 30);
    assert_near(body(t.world, t.free).angular_velocity, 1.5, 0.01);
    run(&t, 60);
    assert_near(body(t.world, t.free).angular_velocity, 3, 1e-9);
    free(t.world);

    t = two_bodies(LL_SOLVER_SOFT_STEP, 0, 0, -10);
    def = ll_joint_defaults(t.world, LL_JOINT_PRISMATIC, t.fixed, t.free, ll_vec(0, 0));
    def.axis = ll_vec(0, 1);
    def.limited = def.motored = 1;
    def.lower = -1;
    def.upper = 0.5;
    def.max_force = 100;
    def.motor_speed = 1;
    join(&t, &def);
    run(&t, 120);
    assert_near(body(t.world, t.free).position.y, 0.5, 0.01);
    free(t.world);
}

static void a_mouse_draws_and_a_motor_holds(void **state)
{
    (void)state;
    pair t = two_bodies(LL_SOLVER_SOFT_STEP, 0, 0, 0);
    ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_MOUSE, t.fixed, t.free, ll_vec(0, 0));
    def.max_force = 100;
    ll_joint_id id = join(&t, &def);
    ok(ll_rigid_set_target(t.world, id, ll_vec(2, 1)));
    run(&t, 120);
    assert_near(body(t.world, t.free).position.x, 2, 0.001);
    assert_near(body(t.world, t.free).position.y, 1, 0.001);
    free(t.world);

    t = two_bodies(LL_SOLVER_SOFT_STEP, 0, 0, -10);
    def = ll_joint_defaults(t.world, LL_JOINT_MOTOR, t.fixed, t.free, ll_vec(0, 0));
    def.max_force = 20; /* more than the weight */
    def.max_torque = 5;
    def.motor_speed = 2;
    join(&t, &def);
    run(&t, 120);
    assert_near(body(t.world, t.free).position.y, 0, 0.005);
    assert_near(body(t.world, t.free).angular_velocity, 2, 1e-6);
    free(t.world);
}

/* Coulomb friction: v decreases by F / m per second along itself and w by T / I, both to 0 and no further; a
 * body on a moving ground takes on its speed. */
static void friction_holds_in_every_direction(void **state)
{
    (void)state;
    const ll_rigid_solver_kind kinds[] = {LL_SOLVER_SOFT_STEP, LL_SOLVER_TGS_STICKY, LL_SOLVER_PGS,
                                          LL_SOLVER_PGS_NGS};
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        pair t = two_bodies(kinds[k], 0, 0, 0);
        ll_body_state s = body(t.world, t.free);
        ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_FRICTION, t.fixed, t.free, s.centre);
        def.max_force = 3 * s.mass;
        def.max_torque = 2 * s.inertia;
        join(&t, &def);
        ok(ll_rigid_set_velocity(t.world, t.free, ll_vec(3, -4), 2.5));
        run(&t, 60);
        s = body(t.world, t.free);
        assert_near(s.velocity.x, 3 - 0.6 * 3, 1e-9);
        assert_near(s.velocity.y, -4 + 0.8 * 3, 1e-9);
        assert_near(s.angular_velocity, 0.5, 1e-9);
        run(&t, 60);
        s = body(t.world, t.free);
        assert_near(s.velocity.x, 0, 1e-12);
        assert_near(s.velocity.y, 0, 1e-12);
        assert_near(s.angular_velocity, 0, 1e-12);
        free(t.world);
    }
}

static void bad_joints_are_told(void **state)
{
    (void)state;
    pair t = two_bodies(LL_SOLVER_SOFT_STEP, 0, 0, 0);
    ll_joint_def def = ll_joint_defaults(t.world, LL_JOINT_REVOLUTE, t.fixed, t.fixed, ll_vec(0, 0));
    ll_joint_id id;
    assert_int_equal(ll_rigid_add_joint(t.world, &def, &id).code, LL_BAD_INPUT);
    def.b = (ll_body_id){3, 1};
    assert_int_equal(ll_rigid_add_joint(t.world, &def, &id).code, LL_NOT_FOUND);
    def.b = t.free;
    def.hertz = NAN;
    assert_int_equal(ll_rigid_add_joint(t.world, &def, &id).code, LL_BAD_INPUT);
    def.hertz = 0;
    def.limited = 1;
    def.lower = 1;
    assert_int_equal(ll_rigid_add_joint(t.world, &def, &id).code, LL_BAD_INPUT);
    def.upper = 2;
    ok(ll_rigid_add_joint(t.world, &def, &id));
    ok(ll_rigid_remove_joint(t.world, id));
    assert_int_equal(ll_rigid_remove_joint(t.world, id).code, LL_NOT_FOUND);
    free(t.world);
}

/* A ball of 670 times the mass of a link, at the end of 40 links: the chain keeps its length. */
static void a_chain_bears_a_heavy_ball(void **state)
{
    (void)state;
    lab l = lab_standard("ball_chain", (ll_scene_args){0});
    double worst = 0;
    for (int i = 0; i < 600; i++) {
        lab_run(&l, 1);
        worst = larger(worst, lab_measure(&l).joint_error);
    }
    assert_at_most("joint error", worst, 0.15);
    lab_close(&l);

    l = lab_standard("stretched_chain", (ll_scene_args){0});
    lab_run(&l, 300);
    assert_at_most("joint error", lab_measure(&l).joint_error, 0.02);
    lab_close(&l);
}

static void loops_of_joints_stay_closed(void **state)
{
    (void)state;
    const char *const names[] = {"bridge", "scissor_lift", "cantilever", "unstable_prismatic", "cart"};
    const double bounds[] = {0.05, 0.06, 0.03, 0.02, 0.02};
    for (int i = 0; i < 5; i++) {
        lab l = lab_standard(names[i], (ll_scene_args){0});
        lab_run(&l, 300);
        assert_at_most(names[i], lab_measure(&l).joint_error, bounds[i]);
        lab_close(&l);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hinges_and_welds_hold),
        cmocka_unit_test(a_rod_keeps_its_length_and_a_rope_only_pulls),
        cmocka_unit_test(a_spring_is_as_stiff_as_it_says),
        cmocka_unit_test(a_spring_swings_out_as_its_damping_says),
        cmocka_unit_test(a_motor_has_the_torque_that_it_says),
        cmocka_unit_test(a_far_limit_is_not_felt),
        cmocka_unit_test(limits_stop_and_motors_drive),
        cmocka_unit_test(a_mouse_draws_and_a_motor_holds),
        cmocka_unit_test(friction_holds_in_every_direction),
        cmocka_unit_test(bad_joints_are_told),
        cmocka_unit_test(a_chain_bears_a_heavy_ball),
        cmocka_unit_test(loops_of_joints_stay_closed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Two bodies, a slope and a pendulum against closed forms. */
#include "rigid/harness.h"

#include "ode/core/problem.h"

static ll_rigid_params weightless(void)
{
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.sleep = false;
    p.restitution_threshold = 0;
    return p;
}

/* Two balls collide off centre: momentum is conserved to rounding, and normal velocities are reversed by
 * e. */
static void impacts_keep_momentum_and_turn_speeds_by_restitution(void **state)
{
    (void)state;
    for (int k = 0; k <= 4; k++) {
        double e = 0.25 * k;
        ll_rigid_limits limits = small_limits(2);
        ll_rigid_params p = weightless();
        ll_rigid *w = world_of(&limits, &p);
        ll_material m = ll_material_defaults();
        m.restitution = e;
        m.friction = 0;
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec(-2, 0.13);
        def.velocity = ll_vec(7.3, 0.1);
        ll_body_id a = add_ball(w, def, 0.5, m);
        def.position = ll_vec(2, -0.21);
        def.velocity = ll_vec(-3.1, 0.2);
        m.density = 3.7;
        ll_body_id b = add_ball(w, def, 0.4, m);
        ll_rigid_metrics before = ll_rigid_measure(w, NULL, 0, INFINITY), after;
        ll_body_state a0 = body(w, a), b0 = body(w, b);
        do /* until they touch: with e = 0 they go on to slide round each other */
            ok(ll_rigid_step(w, 1.0 / 60, NULL));
        while (body(w, b).velocity.x == b0.velocity.x);
        after = ll_rigid_measure(w, NULL, 0, INFINITY);
        ll_body_state a1 = body(w, a), b1 = body(w, b);
        double scale = a0.mass * 7.3 + b0.mass * 3.1;
        assert_near(after.momentum.x, before.momentum.x, 1e-12 * scale);
        assert_near(after.momentum.y, before.momentum.y, 1e-12 * scale);
        /* The impulse is along the normal at the moment of contact. */
        ll_vec2 n = ll_normalised(ll_sub(b1.velocity, b0.velocity));
        double in = ll_dot(ll_sub(b0.velocity, a0.velocity), n),
               out = ll_dot(ll_sub(b1.velocity, a1.velocity), n);
        assert_near(out, -e * in, 1e-12 * fabs(in));
        double reduced = a0.mass * b0.mass / (a0.mass + b0.mass);
        /* The balls go on moving in the step whose beginning gave the normal: this is the error of the
         * lever. */
        assert_near(after.spin_momentum, before.spin_momentum, reduced * (1 + e) * fabs(in) * 10.4 / 60);
        assert_near(after.kinetic_energy, before.kinetic_energy - 0.5 * reduced * (1 - e * e) * in * in,
                    1e-11 * before.kinetic_energy);
        free(w);
    }
}

/* Balls fly at a larger one from all sides, more than there are colours of contacts: what one contact gives,
 * no other takes away. AVBD moves one body after the other, not by pairs of equal impulses. */
static void many_contacts_of_one_body_keep_momentum(void **state)
{
    (void)state;
    enum { around = 90 };
    for (int solver = 0; solver < LL_SOLVERS; solver++) {
        ll_rigid_limits limits = small_limits(around + 1);
        ll_rigid_params p = weightless();
        p.solver = solver;
        ll_rigid *w = world_of(&limits, &p);
        ll_material m = ll_material_defaults();
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        ll_body_id middle = add_ball(w, def, 5, m);
        for (int i = 0; i < around; i++) {
            ll_vec2 out = {cos(2 * 3.14159265358979323846 * i / around),
                           sin(2 * 3.14159265358979323846 * i / around)};
            def.position = ll_scale(5.15 + 0.001 * (i % 7), out);
            def.velocity = ll_madd(ll_vec(-1.7, 0.4), -3 - 0.1 * (i % 5), out);
            add_ball(w, def, 0.12, m);
        }
        ll_rigid_metrics before = ll_rigid_measure(w, NULL, 0, INFINITY);
        int overflow = 0;
        double scale = ll_length(before.momentum), error = 0;
        for (int i = 0; i < 30; i++) {
            ok(ll_rigid_step(w, 1.0 / 60, NULL));
            overflow = ll_rigid_get_stats(w).overflow > overflow ? ll_rigid_get_stats(w).overflow : overflow;
            ll_rigid_metrics after = ll_rigid_measure(w, NULL, 0, INFINITY);
            error = larger(error, ll_length(ll_sub(after.momentum, before.momentum)) / scale);
        }
        assert_at_least("contacts without a colour", overflow, around / 3);
        assert_true(ll_length(body(w, middle).velocity) > 0.01);
        if (solver != LL_SOLVER_AVBD)
            assert_at_most(ll_rigid_solver_names[solver], error, 1e-12);
        free(w);
    }
}

/* A box on a slope: below atan(mu) it rests, above it slides with g (sin - mu cos). */
static double slid(double angle, double friction, double seconds)
{
    ll_rigid_limits limits = small_limits(2);
    ll_rigid_params p = standard_params();
    p.sleep = false;
    ll_rigid *w = world_of(&limits, &p);
    ll_material m = ll_material_defaults();
    m.friction = friction;
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    def.angle = angle;
    add_box(w, def, 200, 2, m);
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.angle = angle;
    def.position = ll_vec(-1.5 * sin(angle), 1.5 * cos(angle));
    ll_body_id box = add_box(w, def, 1, 1, m);
    for (int i = 0; i < (int)(seconds * 60); i++)
        ok(ll_rigid_step(w, 1.0 / 60, NULL));
    double distance = ll_length(ll_sub(body(w, box).position, def.position));
    free(w);
    return distance;
}

static void friction_holds_up_to_its_angle(void **state)
{
    (void)state;
    const double half_degree = 0.5 * 3.14159265358979323846 / 180;
    for (int i = 1; i <= 4; i++) {
        double mu = 0.2 * i, angle = atan(mu);
        assert_at_most("creep", slid(angle - half_degree, mu, 5), 0.01);
        assert_at_least("slide", slid(angle + half_degree, mu, 5), 0.5);
        double steep = angle + 0.2, expected = 0.5 * 10 * (sin(steep) - mu * cos(steep)) * 9;
        assert_near(slid(steep, mu, 3), expected, 0.02 * expected);
    }
}

/* A rod of 1 m on a revolute joint: period of a physical pendulum of large amplitude, by the
 * arithmetic-geometric mean. */
static void a_pendulum_keeps_its_period_and_energy(void **state)
{
    (void)state;
    ll_rigid_limits limits = small_limits(2);
    ll_rigid_params p = standard_params();
    p.sleep = false;
    ll_rigid *w = world_of(&limits, &p);
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    ll_body_id anchor, rod;
    ok(ll_rigid_add_body(w, &def, &anchor));
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.position = ll_vec(0.5, 0); /* level: a swing of 90 degrees */
    rod = add_box(w, def, 1, 0.1, ll_material_defaults());
    ll_joint_def joint = ll_joint_defaults(w, LL_JOINT_REVOLUTE, anchor, rod, ll_vec(0, 0));
    ll_joint_id id;
    ok(ll_rigid_add_joint(w, &joint, &id));
    double inertia = body(w, rod).inertia + body(w, rod).mass * 0.25;
    double omega = sqrt(body(w, rod).mass * 10 * 0.5 / inertia), a = 1, g = cos(3.14159265358979323846 / 4);
    for (int i = 0; i < 6; i++) {
        double mean = 0.5 * (a + g);
        g = sqrt(a * g);
        a = mean;
    }
    double period = 2 * 3.14159265358979323846 / (omega * a), last = 0, hz = 240;
    int turns = 0;
    ll_rigid_metrics first = ll_rigid_measure(w, NULL, 0, INFINITY);
    double lowest = 0;
    for (int i = 1; turns < 10 && i < 10000; i++) {
        double before = body(w, rod).angular_velocity;
        ok(ll_rigid_step(w, 1 / hz, NULL));
        double after = body(w, rod).angular_velocity;
        lowest = smaller(lowest, body(w, rod).position.y);
        if (before > 0 && after <= 0) { /* back at the right */
            turns++;
            last = (i - 1 + before / (before - after)) / hz;
        }
    }
    assert_int_equal(turns, 10);
    assert_near(last / 10, period, 0.002 * period);
    assert_near(lowest, -0.5, 0.001);
    ll_rigid_metrics m = ll_rigid_measure(w, NULL, 0, INFINITY);
    assert_near(m.kinetic_energy + m.potential_energy, first.potential_energy,
                0.01 * body(w, rod).mass * 10 * 0.5);
    free(w);
}

/* The same rod and the motion lab's pendulum of its reduced length, I / (m d), over five swings: the largest
 * difference of the angle. */
static double apart_from_the_motion_lab(double hz)
{
    ll_rigid_limits limits = small_limits(2);
    ll_rigid_params p = standard_params();
    p.sleep = false;
    ll_rigid *w = world_of(&limits, &p);
    ll_body_def def = ll_body_defaults(LL_BODY_STATIC);
    ll_body_id anchor, rod;
    ll_joint_id id;
    ok(ll_rigid_add_body(w, &def, &anchor));
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.position = ll_vec(0.5, 0); /* horizontal */
    rod = add_box(w, def, 1, 0.1, ll_material_defaults());
    ll_joint_def joint = ll_joint_defaults(w, LL_JOINT_REVOLUTE, anchor, rod, ll_vec(0, 0));
    ok(ll_rigid_add_joint(w, &joint, &id));

    const double quarter = 0.5 * 3.14159265358979323846;
    const ll_ode_problem *pendulum = ll_ode_problem_find("pendulum");
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    char text[32];
    ll_param_defaults(pendulum->params, params);
    ll_body_state s = body(w, rod);
    snprintf(text, sizeof text, "%.17g", (s.inertia + 0.25 * s.mass) / (0.5 * s.mass));
    ok(ll_param_set(pendulum->params, params, "length", text, false));
    snprintf(text, sizeof text, "%.17g", quarter);
    ok(ll_param_set(pendulum->params, params, "theta0", text, false));

    double worst = 0, y[2];
    for (int i = 1; i <= (int)(10 * hz); i++) {
        ok(ll_rigid_step(w, 1 / hz, NULL));
        assert_true(pendulum->exact(params, i / hz, y));
        worst = larger(worst, fabs(body(w, rod).angle + quarter - y[0]));
    }
    free(w);
    return worst;
}

static void a_pendulum_agrees_with_the_motion_lab(void **state)
{
    (void)state;
    double coarse = apart_from_the_motion_lab(60), fine = apart_from_the_motion_lab(240);
    assert_at_most("apart at 240 Hz", fine, 0.001);
    assert_at_least("gain from 60 Hz", coarse / fine, 3.5); /* of first order: 4 */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impacts_keep_momentum_and_turn_speeds_by_restitution),
        cmocka_unit_test(many_contacts_of_one_body_keep_momentum),
        cmocka_unit_test(friction_holds_up_to_its_angle),
        cmocka_unit_test(a_pendulum_keeps_its_period_and_energy),
        cmocka_unit_test(a_pendulum_agrees_with_the_motion_lab),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

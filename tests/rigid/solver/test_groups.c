/* Solving a world group by group gives the same bits as solving it as a whole. */
#include "rigid/harness.h"

enum { pits = 80, in_a_pit = 30, thrown = pits * in_a_pit };

/* Immovable pits, of one kinematic body each, or all of one body, which makes one island of all their
 * contents. */
static void add_pits(ll_rigid *w, bool one_body)
{
    ll_body_def def = ll_body_defaults(LL_BODY_KINEMATIC);
    ll_material m = ll_material_defaults();
    ll_body_id pit;
    ll_geometry g;
    for (int k = 0; k < pits; k++) {
        if (k == 0 || !one_body)
            ok(ll_rigid_add_body(w, &def, &pit));
        const ll_vec2 centre[3] = {{10 * k, 10}, {10 * k + 9, 10}, {10 * k + 4.5, 0}};
        for (int i = 0; i < 3; i++) {
            ok(ll_shape_box(i < 2 ? 1 : 10, i < 2 ? 20 : 1, centre[i], 0, &g));
            ok(ll_rigid_add_shape(w, pit, &g, &m));
        }
    }
}

static void throw_in(ll_rigid *w, ll_body_id thing[thrown])
{
    for (int i = 0; i < thrown; i++) {
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        ll_material m = ll_material_defaults();
        int pit = i % pits, n = i / pits; /* islands are mixed in the order of bodies */
        def.position = ll_vec(10 * pit + 2 + n % 5 * 1.4, 1 + n / 5 * 1.3);
        def.velocity = ll_vec(3 * cos(2.4 * i), 3 * sin(2.4 * i));
        m.restitution = n % 4 == 0 ? 0.5 : 0;
        thing[i] = n % 2 == 0 ? add_ball(w, def, 0.5, m) : add_box(w, def, 1, 0.8, m);
    }
}

static void revolute(ll_rigid *w, ll_body_id a, ll_body_id b, int type)
{
    ll_joint_id id;
    ll_joint_def def = ll_joint_defaults(w, (ll_joint_type)type, a, b, body(w, a).position);
    def.length = 1.4;
    ok(ll_rigid_add_joint(w, &def, &id));
}

static ll_rigid *pit_world(bool one_body, bool joints, ll_body_id thing[thrown])
{
    ll_rigid_limits limits = small_limits(thrown + 3 * pits);
    ll_rigid_params p = standard_params();
    p.sleep = false;
    p.substeps = 4;
    p.continuous = LL_CONTINUOUS_OFF;
    ll_rigid *w = world_of(&limits, &p);
    add_pits(w, one_body);
    throw_in(w, thing);
    for (int k = 0; joints && k < pits; k++) {
        revolute(w, thing[k], thing[k + pits], LL_JOINT_REVOLUTE);
        revolute(w, thing[k + 6 * pits], thing[k + 7 * pits], LL_JOINT_DISTANCE);
    }
    return w;
}

static void assert_same_motion(ll_body_state a, ll_body_state b)
{
    assert_memory_equal(&a.position, &b.position, sizeof a.position);
    assert_memory_equal(&a.velocity, &b.velocity, sizeof a.velocity);
    assert_memory_equal(&a.angle, &b.angle, sizeof a.angle);
    assert_memory_equal(&a.angular_velocity, &b.angular_velocity, sizeof a.angular_velocity);
}

static void groups_move_as_the_whole_does(void **state)
{
    (void)state;
    for (int joints = 0; joints < 2; joints++) {
        ll_body_id parted[thrown], joined[thrown];
        ll_rigid *a = pit_world(false, joints, parted);
        ll_rigid *b = pit_world(true, joints, joined);
        for (int i = 0; i < 120; i++) {
            ok(ll_rigid_step(a, 1.0 / 60, NULL));
            ok(ll_rigid_step(b, 1.0 / 60, NULL));
        }
        for (int i = 0; i < thrown; i++)
            assert_same_motion(body(a, parted[i]), body(b, joined[i]));
        ll_rigid_stats sa = ll_rigid_get_stats(a), sb = ll_rigid_get_stats(b);
        assert_true(sa.touching > thrown);
        assert_int_equal(sa.touching, sb.touching);
        assert_int_equal(sa.points, sb.points);
        assert_int_equal(sa.colours, sb.colours);
        assert_int_equal(sa.overflow, sb.overflow);
        free(a);
        free(b);
    }
}

/* Boxes on a floor that moves up and sideways: each as if it were alone. */
static ll_rigid *lift(int first, int boxes, ll_body_id box[])
{
    ll_rigid_limits limits = small_limits(boxes + 1);
    ll_rigid_params p = standard_params();
    p.sleep = false;
    ll_rigid *w = world_of(&limits, &p);
    ll_body_def def = ll_body_defaults(LL_BODY_KINEMATIC);
    def.velocity = ll_vec(1, 2);
    add_box(w, def, 10000, 1, ll_material_defaults());
    for (int i = 0; i < boxes; i++) {
        def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec(2 * (first + i), 1);
        box[i] = add_box(w, def, 1, 1, ll_material_defaults());
    }
    return w;
}

static void a_moving_floor_is_of_one_group_with_all_on_it(void **state)
{
    (void)state;
    enum { few = 10, many = 2400 };
    ll_body_id alone[few], among[many];
    ll_rigid *a = lift(many - few, few, alone), *b = lift(0, many, among);
    for (int i = 0; i < 60; i++) {
        ok(ll_rigid_step(a, 1.0 / 60, NULL));
        ok(ll_rigid_step(b, 1.0 / 60, NULL));
    }
    assert_near(body(a, alone[0]).velocity.y, 2, 1e-3);
    for (int i = 0; i < few; i++)
        assert_same_motion(body(a, alone[i]), body(b, among[many - few + i]));
    free(a);
    free(b);
}

/* ---- a crowd: more impacts at once than are followed through rows ---- */

enum { pairs = 1300 };

/* Pairs of balls that fly against each other, far from the other pairs: each is an island. */
static ll_rigid *flying_pairs(double e, ll_body_id ball[2 * pairs])
{
    ll_rigid_limits limits = small_limits(2 * pairs);
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.sleep = false;
    ll_rigid *w = world_of(&limits, &p);
    ll_material m = ll_material_defaults();
    m.restitution = e;
    m.friction = 0;
    for (int i = 0; i < 2 * pairs; i++) {
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        def.position = ll_vec(i % 2 == 0 ? -0.6 : 0.6, 5 * (i / 2));
        def.velocity = ll_vec(i % 2 == 0 ? 4 : -2, 0);
        ball[i] = add_ball(w, def, 0.5, m);
    }
    return w;
}

static void many_pairs_bounce_as_one_does(void **state)
{
    (void)state;
    for (int k = 0; k <= 2; k++) {
        static ll_body_id ball[2 * pairs];
        double e = 0.5 * k;
        ll_rigid *w = flying_pairs(e, ball);
        for (int i = 0; i < 10; i++)
            ok(ll_rigid_step(w, 1.0 / 60, NULL));
        for (int i = 0; i < pairs; i++) {
            double left = body(w, ball[2 * i]).velocity.x, right = body(w, ball[2 * i + 1]).velocity.x;
            assert_near(right - left, 6 * e, 1e-9);
            assert_near(right + left, 2, 1e-9);
        }
        free(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_move_as_the_whole_does),
        cmocka_unit_test(a_moving_floor_is_of_one_group_with_all_on_it),
        cmocka_unit_test(many_pairs_bounce_as_one_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

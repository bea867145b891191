/* The block: the same bits everywhere, copies that continue equally, stale ids, limits, and sleep that costs
 * nothing. */
#include "rigid/harness.h"

/* A scene with everything that a step can do: impacts, sliding, sleeping, added and removed bodies. */
static lab busy(const ll_rigid_params *params, int32_t broad)
{
    lab l = lab_open("heavy_tops", (ll_scene_args){.size = 6}, params, broad);
    return l;
}

static uint64_t run_busy(const ll_rigid_params *params, int32_t broad, int steps)
{
    lab l = busy(params, broad);
    lab_run(&l, steps);
    assert_true(ll_rigid_valid(l.world));
    uint64_t hash = ll_rigid_hash(l.world);
    lab_close(&l);
    return hash;
}

static void every_width_of_simd_is_one_result(void **state)
{
    (void)state;
    uint64_t hash[LL_SIMDS];
    for (int i = 0; i < LL_SIMDS; i++) {
        ll_rigid_params p = standard_params();
        p.simd = i;
        hash[i] = run_busy(&p, LL_BROAD_GRID, 200);
        assert_int_equal(hash[i], hash[0]);
    }
}

static void every_broad_phase_is_one_result(void **state)
{
    (void)state;
    ll_rigid_params p = standard_params();
    uint64_t hash = run_busy(&p, LL_BROAD_BRUTE, 200);
    for (int i = 0; i < LL_BROADS; i++)
        assert_int_equal(run_busy(&p, i, 200), hash);
}

static void a_copy_of_the_state_goes_on_alike(void **state)
{
    (void)state;
    ll_rigid_params p = standard_params();
    lab l = busy(&p, LL_BROAD_TREE);
    lab_run(&l, 50);
    size_t kept = ll_rigid_state_size(l.world);
    assert_true(kept < l.size);
    char *snapshot = malloc(kept);
    memcpy(snapshot, l.world, kept);
    lab_run(&l, 100);
    uint64_t hash = ll_rigid_hash(l.world);

    /* Roll back in place; the scratch part may hold anything. */
    memcpy(l.world, snapshot, kept);
    memset((char *)l.world + kept, 0x5a, l.size - kept);
    lab_run(&l, 100);
    assert_int_equal(ll_rigid_hash(l.world), hash);

    /* Fork to another address. */
    lab fork = l;
    fork.world = malloc(l.size);
    memcpy(fork.world, snapshot, kept);
    lab_run(&fork, 100);
    assert_int_equal(ll_rigid_hash(fork.world), hash);
    free(fork.world);
    free(snapshot);
    lab_close(&l);
}

static void a_removed_body_is_known_to_be_gone(void **state)
{
    (void)state;
    ll_rigid_limits limits = small_limits(4);
    ll_rigid_params p = standard_params();
    ll_rigid *w = world_of(&limits, &p);
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    ll_body_id a = add_box(w, def, 1, 1, ll_material_defaults());
    def.position.y = 1;
    add_box(w, def, 1, 1, ll_material_defaults());
    ok(ll_rigid_step(w, 1.0 / 60, NULL));
    assert_int_equal(ll_rigid_get_stats(w).pairs, 1);
    ok(ll_rigid_remove_body(w, a));
    assert_int_equal(ll_rigid_get_stats(w).pairs, 0);
    assert_true(ll_rigid_valid(w));
    ll_body_id c = add_box(w, def, 1, 1, ll_material_defaults());
    assert_int_equal(c.index, a.index);
    assert_int_equal(ll_rigid_remove_body(w, a).code, LL_NOT_FOUND);
    ok(ll_rigid_step(w, 1.0 / 60, NULL));
    assert_true(ll_rigid_valid(w));
    free(w);
}

static void refused(ll_status status, ll_code code, const char *word)
{
    assert_int_equal(status.code, code);
    if (strstr(status.text, word) == NULL)
        fail_msg("`%s` does not say `%s`", status.text, word);
}

static void bad_input_is_told(void **state)
{
    (void)state;
    ll_rigid_limits limits = small_limits(2);
    ll_rigid_params p = standard_params();
    ll_rigid *w = world_of(&limits, &p);
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    ll_body_id id;
    ll_geometry g;
    def.position.x = 1e10;
    refused(ll_rigid_add_body(w, &def, &id), LL_BAD_INPUT, "position.x");
    def.position.x = NAN;
    refused(ll_rigid_add_body(w, &def, &id), LL_BAD_INPUT, "nan");
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    def.velocity.y = INFINITY;
    refused(ll_rigid_add_body(w, &def, &id), LL_BAD_INPUT, "velocity.y");
    def = ll_body_defaults(LL_BODY_DYNAMIC);
    ok(ll_rigid_add_body(w, &def, &id));
    ok(ll_shape_box(1, 1, ll_vec(0, 0), 0, &g));
    ll_material m = ll_material_defaults();
    const double bad[] = {0, -1, INFINITY, NAN};
    for (int i = 0; i < 4; i++) {
        m.density = bad[i];
        refused(ll_rigid_add_shape(w, id, &g, &m), LL_BAD_INPUT, "density");
        refused(ll_rigid_set_mass(w, id, bad[i], 1), LL_BAD_INPUT, "mass");
        refused(ll_rigid_set_mass(w, id, 1, bad[i]), LL_BAD_INPUT, "inertia");
    }
    m = ll_material_defaults();
    m.restitution = 1.5;
    refused(ll_rigid_add_shape(w, id, &g, &m), LL_BAD_INPUT, "restitution");
    refused(ll_rigid_step(w, NAN, NULL), LL_BAD_INPUT, "dt");
    ok(ll_rigid_add_body(w, &def, &id));
    refused(ll_rigid_add_body(w, &def, &id), LL_LIMIT, "limit is 2 bodies");
    limits.contacts = 0;
    refused(ll_rigid_check(&limits), LL_BAD_INPUT, "contacts");
    free(w);
}

static void more_contacts_than_the_limit_are_told(void **state)
{
    (void)state;
    ll_rigid_limits limits = small_limits(8);
    limits.contacts = 3;
    ll_rigid_params p = standard_params();
    ll_rigid *w = world_of(&limits, &p);
    for (int i = 0; i < 8; i++)
        add_ball(w, ll_body_defaults(LL_BODY_DYNAMIC), 0.5, ll_material_defaults());
    refused(ll_rigid_step(w, 1.0 / 60, NULL), LL_LIMIT, "limit of 3");
    assert_true(ll_rigid_valid(w));
    free(w);
}

static void divergence_names_the_step_and_the_body(void **state)
{
    (void)state;
    ll_rigid_limits limits = small_limits(4);
    ll_rigid_params p = standard_params();
    ll_rigid *w = world_of(&limits, &p);
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    add_ball(w, def, 0.5, ll_material_defaults());
    def.position = ll_vec(1e9, 0);
    def.velocity = ll_vec(1e6, 0);
    add_ball(w, def, 0.5, ll_material_defaults());
    ll_status status = ll_rigid_step(w, 1.0 / 60, NULL);
    refused(status, LL_DIVERGED, "step 1: body 2");
    free(w);
}

/* All asleep: a step visits nothing, and a touch wakes one island only. */
static void islands_sleep_and_wake(void **state)
{
    (void)state;
    ll_rigid_params p = standard_params();
    lab l = lab_open("many_pyramids", (ll_scene_args){.size = 3}, &p, LL_BROAD_GRID);
    int step = 0;
    for (; ll_rigid_get_stats(l.world).awake > 0 && step < 600; step++)
        lab_run(&l, 1);
    assert_in_range(step, 30, 300);
    assert_true(ll_rigid_valid(l.world));
    uint64_t hash = ll_rigid_hash(l.world);
    ll_body_state first;
    ok(ll_rigid_get_body(l.world, ll_rigid_body_at(l.world, 1), &first));
    ok(ll_rigid_step(l.world, 1.0 / 60, NULL));
    assert_int_not_equal(ll_rigid_hash(l.world), hash); /* the step is counted */
    ok(ll_rigid_apply_impulse(l.world, ll_rigid_body_at(l.world, 1), ll_vec(0.1, 0), first.position));
    assert_int_equal(ll_rigid_get_stats(l.world).awake, 55);
    lab_run(&l, 300);
    assert_int_equal(ll_rigid_get_stats(l.world).awake, 0);
    assert_true(ll_rigid_valid(l.world));
    lab_close(&l);
}

/* A moved box is there at once: it falls from its new position, and so does what it supported. */
static void who_is_put_elsewhere_is_there(void **state)
{
    (void)state;
    lab l = lab_standard("column", (ll_scene_args){.size = 2});
    lab_run(&l, 60);
    ll_body_id low = ll_rigid_body_at(l.world, l.count - 2), high = ll_rigid_body_at(l.world, l.count - 1);
    ll_body_state s;
    ok(ll_rigid_set_pose(l.world, low, ll_vec(10, 5), 0.25));
    ok(ll_rigid_get_body(l.world, low, &s));
    assert_near(s.position.x, 10, 1e-12);
    assert_near(s.position.y, 5, 1e-12);
    assert_near(s.angle, 0.25, 1e-12);
    assert_true(ll_rigid_valid(l.world));
    lab_run(&l, 12);
    ok(ll_rigid_get_body(l.world, low, &s));
    assert_near(s.position.x, 10, 1e-3);
    assert_near(s.position.y, 5 - 10 * 0.2 * 0.2 / 2, 0.03); /* g t^2 / 2 after 0.2 s, by steps of 1/60 s */
    ok(ll_rigid_get_body(l.world, high, &s));
    assert_near(s.position.y, 1.5 - 10 * 0.2 * 0.2 / 2, 0.05);
    ll_status status = ll_rigid_set_pose(l.world, low, ll_vec(NAN, 0), 0);
    assert_string_equal(status.field, "position.x");
    lab_close(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_width_of_simd_is_one_result),
        cmocka_unit_test(every_broad_phase_is_one_result),
        cmocka_unit_test(a_copy_of_the_state_goes_on_alike),
        cmocka_unit_test(who_is_put_elsewhere_is_there),
        cmocka_unit_test(a_removed_body_is_known_to_be_gone),
        cmocka_unit_test(bad_input_is_told),
        cmocka_unit_test(more_contacts_than_the_limit_are_told),
        cmocka_unit_test(divergence_names_the_step_and_the_body),
        cmocka_unit_test(islands_sleep_and_wake),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* A world stepped by several threads has the bits of one stepped alone, for any number of threads. */
#include "rigid/harness.h"

#include <inttypes.h>

#include "support/many.h"
#include "threads/team.h"

enum { FEW_STEPS = 6 };

static int share = 3; /* of the steps, but at least FEW_STEPS; `test_rigid team many`: all */

typedef struct trial {
    const char *scene;
    ll_scene_args args;
    int steps;
} trial;

/* Large enough that the parts are done by different threads: a pile; islands that one thread solves in
 * groups; impacts; a rod with a motor; chains; bodies that overlap at first, with restitution and CCD. */
static const trial trials[] = {
    {"pyramid", {.size = 45}, 20},
    {"many_pyramids", {.size = 60}, 10},
    {"smash", {0}, 6},
    {"washer", {0}, 6},
    {"spinner", {.size = 1500}, 6},
    {"rain", {.size = 60}, 60},
    {"tumbler", {0}, 40},
    {"joint_grid", {.size = 30}, 15},
};

static void step_by(lab *shared, ll_team *team)
{
    if (shared->scene->drive != NULL)
        ok(shared->scene->drive(shared->world, &shared->args, ll_rigid_get_stats(shared->world).step));
    ok(ll_rigid_step_by_team(shared->world, 1.0 / 60, NULL, team));
}

enum { TEAMS_MAX = 4 };

/* The same world alone and by a team of each number of threads; 0 ends the list. */
static void compare(const trial *t, const int threads[TEAMS_MAX])
{
    lab alone = lab_standard(t->scene, t->args), shared[TEAMS_MAX];
    ll_team *team[TEAMS_MAX];
    int teams = 0;
    for (; teams < TEAMS_MAX && threads[teams] > 0; teams++) {
        shared[teams] = lab_standard(t->scene, t->args);
        ok(ll_team_make(threads[teams], &team[teams]));
    }
    int steps = t->steps / share > FEW_STEPS ? t->steps / share : FEW_STEPS;
    for (int i = 0; i < steps; i++) {
        lab_run(&alone, 1);
        uint64_t expected = ll_rigid_hash(alone.world);
        ll_rigid_stats a = ll_rigid_get_stats(alone.world);
        for (int k = 0; k < teams; k++) {
            step_by(&shared[k], team[k]);
            uint64_t hash = ll_rigid_hash(shared[k].world);
            ll_rigid_stats b = ll_rigid_get_stats(shared[k].world);
            if (hash != expected || memcmp(&a, &b, sizeof a) != 0)
                fail_msg("%s, step %d by %d threads: %016" PRIx64 " instead of %016" PRIx64, t->scene, i,
                         threads[k], hash, expected);
        }
    }
    for (int k = 0; k < teams; k++) {
        ll_team_free(team[k]);
        lab_close(&shared[k]);
    }
    lab_close(&alone);
}

static void the_same_bits_by_any_number(void **state)
{
    (void)state;
    compare(&trials[0], (int[TEAMS_MAX]){2, 5});
    compare(&trials[1], (int[TEAMS_MAX]){2, 3, 4}); /* islands that threads share, in as many parts */
    for (size_t i = 2; i < sizeof trials / sizeof *trials; i++)
        compare(&trials[i], (int[TEAMS_MAX]){2, i % 2 == 0 ? 5 : 0});
}

/* Sleep changes the lists of awake bodies and contacts between the steps. */
static void the_same_bits_while_bodies_fall_asleep(void **state)
{
    (void)state;
    ll_scene_args args = {.size = 45};
    ll_rigid_params p = scene_params("pyramid", args);
    p.sleep = true;
    lab alone = lab_open("pyramid", args, &p, LL_BROAD_GRID),
        shared = lab_open("pyramid", args, &p, LL_BROAD_GRID);
    ll_team *team;
    ok(ll_team_make(3, &team));
    for (int i = 0; i < 900 && ll_rigid_get_stats(alone.world).awake > 0; i++) {
        lab_run(&alone, 1);
        step_by(&shared, team);
    }
    assert_int_equal(ll_rigid_get_stats(alone.world).awake, 0);
    assert_true(ll_rigid_hash(alone.world) == ll_rigid_hash(shared.world));
    ll_team_free(team);
    lab_close(&alone);
    lab_close(&shared);
}

/* The named body does not depend on which thread finds it. */
static void a_world_that_diverges_says_the_same(void **state)
{
    (void)state;
    ll_scene_args args = {.size = 45};
    lab alone = lab_standard("pyramid", args), shared = lab_standard("pyramid", args);
    ll_team *team;
    ok(ll_team_make(4, &team));
    lab *const both[] = {&alone, &shared};
    for (int k = 0; k < 2; k++)
        for (int i = 900; i > 600; i -= 100)
            ok(ll_rigid_apply_force(both[k]->world, ll_rigid_body_at(both[k]->world, i), ll_vec(1e12, 0), 0));
    ll_status first = ll_rigid_step(alone.world, 1.0 / 60, NULL);
    ll_status second = ll_rigid_step_by_team(shared.world, 1.0 / 60, NULL, team);
    assert_int_equal(first.code, LL_DIVERGED);
    assert_string_equal(second.text, first.text);
    ll_team_free(team);
    lab_close(&alone);
    lab_close(&shared);
}

enum { rows = 700, in_a_row = 4 };

/* Rows of balls that touch, the outer ones on their way to each other: more impacts than are followed through
 * rows in all, and few of them in each group of islands that one thread solves at a time. */
static ll_rigid *rows_of_balls(void)
{
    ll_rigid_limits limits = small_limits(rows * in_a_row);
    ll_rigid_params p = standard_params();
    p.gravity_y = 0;
    p.sleep = false;
    ll_rigid *w = world_of(&limits, &p);
    ll_material m = ll_material_defaults();
    m.restitution = 0.7;
    for (int i = 0; i < rows * in_a_row; i++) {
        ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
        int k = i % in_a_row;
        def.position = ll_vec(1.001 * k, 5 * (i / in_a_row));
        def.velocity = ll_vec(k == 0 ? 5 : k == in_a_row - 1 ? -4 : 0, 0);
        add_ball(w, def, 0.5, m);
    }
    return w;
}

static void the_same_bits_where_many_bounce_at_once(void **state)
{
    (void)state;
    ll_rigid *alone = rows_of_balls(), *shared = rows_of_balls();
    ll_team *team;
    ok(ll_team_make(2, &team));
    for (int i = 0; i < 10; i++) {
        ok(ll_rigid_step(alone, 1.0 / 60, NULL));
        ok(ll_rigid_step_by_team(shared, 1.0 / 60, NULL, team));
        assert_true(ll_rigid_hash(alone) == ll_rigid_hash(shared));
    }
    ll_team_free(team);
    free(alone);
    free(shared);
}

int main(int count, char **arguments)
{
    if (ll_test_many(count, arguments))
        share = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_bits_by_any_number),
        cmocka_unit_test(the_same_bits_where_many_bounce_at_once),
        cmocka_unit_test(the_same_bits_while_bodies_fall_asleep),
        cmocka_unit_test(a_world_that_diverges_says_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

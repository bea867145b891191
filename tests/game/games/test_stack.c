/* The stack's rules: state that a step does not keep has no effect, balls push, and machines agree
 * bitwise. */
#include <math.h>

#include <cjson/cJSON.h>

#include "base/rng.h"
#include "game/harness.h"
#include "support/near.h"

typedef struct params {
    int64_t size, substeps;
    double friction, radius, mass, speed, acceleration;
    int32_t scene, reserved;
} params;

typedef struct site {
    params params;
    ll_game_env env;
    ll_world *world;
} site;

enum { PYRAMID, COLUMN, CARD_HOUSE, DOMINO };

#define HZ 60

static params usual(int32_t scene, int64_t size)
{
    params p;
    ll_param_defaults(&ll_stack_table, &p);
    p.scene = scene;
    p.size = size;
    return p;
}

static site open_site(params p, int players)
{
    site s = {.params = p};
    s.world = world_open(&ll_game_stack, &p, players, 1.0 / HZ, &s.env);
    return s;
}

static site copy_of(const site *s)
{
    site other = *s;
    other.world = world_copy(s->world);
    return other;
}

static void step(site *s, const ll_action *actions)
{
    ll_game_stack.step(s->world, &s->env, actions, 0, NULL);
}

static const ll_action nothing[LL_PLAYERS_MAX];

static void too_large_scenes_are_refused(void **state)
{
    (void)state;
    params p;
    cJSON *json = cJSON_Parse("{\"scene\":\"card_house\",\"size\":20}");
    ll_param_defaults(&ll_stack_table, &p);
    ll_status status = ll_param_parse(&ll_stack_table, json, &p);
    cJSON_Delete(json);
    assert_int_equal(status.code, LL_LIMIT);
    assert_string_equal(status.field, "size");
}

/* A small push wakes everything for ten seconds of steps that each start without impulses; all bodies but the
 * pushed one stand where they stood: within a centimetre horizontally, three millimetres vertically, and one
 * degree. */
static void stacks_stand_without_warm_starting(void **state)
{
    (void)state;
    const params scenes[] = {usual(PYRAMID, 8), usual(COLUMN, 5), usual(CARD_HOUSE, 3)};
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; i++) {
        params p = scenes[i];
        p.friction = p.scene == CARD_HOUSE ? 0.7 : 0.6;
        p.radius = 0.1;
        site s = open_site(p, 1), first = copy_of(&s);
        for (int k = 0; k < 10 * HZ; k++) { /* the ball goes up and down, so the world is stepped */
            const ll_action sway = {.axis = {0, k % 20 < 10 ? 0.2f : -0.2f}};
            step(&s, &sway);
        }
        for (int k = 1; k < s.world->entities; k++) {
            const ll_entity *a = &first.world->entity[k], *b = &s.world->entity[k];
            assert_near(b->x, a->x, 0.01);
            assert_near(b->y, a->y, 0.003);
            assert_near(b->angle, a->angle, 0.0175);
        }
        free(s.world);
        free(first.world);
    }
}

/* Dominoes fall, one after the other, and come to rest, after which nothing changes any more. */
static void dominoes_fall_and_rest(void **state)
{
    (void)state;
    site s = open_site(usual(DOMINO, 10), 1);
    for (int k = 0; k < 20 * HZ; k++)
        step(&s, nothing);
    double values[LL_GAME_VALUES];
    ll_game_stack.describe(s.world, &s.env, 0, values);
    assert_true(values[2] == 0);
    for (int k = 1; k < s.world->entities; k++)
        assert_true(fabs(s.world->entity[k].angle) > 0.8);
    site later = copy_of(&s);
    step(&later, nothing);
    assert_memory_equal(later.world, s.world, ll_world_size(s.world));
    free(s.world);
    free(later.world);
}

/* A ball through the foot of a pyramid: boxes give way, nothing sinks into the ground, and a second
 * computation of the world is bitwise equal. */
static void a_ball_pushes_what_stands(void **state)
{
    (void)state;
    site s = open_site(usual(PYRAMID, 5), 2), again = copy_of(&s);
    ll_entity first[LL_ENTITIES_MAX];
    memcpy(first, s.world->entity, (size_t)s.world->entities * sizeof first[0]);
    const ll_action go[2] = {{.axis = {1, 0}}, {.axis = {-1, 0.3f}}};
    double most = 0;
    for (int k = 0; k < 4 * HZ; k++) {
        step(&s, go);
        step(&again, go);
        assert_memory_equal(again.world, s.world, ll_world_size(s.world));
    }
    for (int k = 2; k < s.world->entities; k++) {
        most = larger(most, fabs(s.world->entity[k].x - first[k].x));
        assert_true(s.world->entity[k].y > 0.5 - 0.05); /* half a box, minus its compression */
    }
    assert_true(most > 1);
    free(s.world);
    free(again.world);
}

/* Where nothing touches, a client's prediction of its ball equals the server's step except for the last bits:
 * the server's ball is stepped by the rigid room. */
static void a_ball_alone_goes_as_on_the_server(void **state)
{
    (void)state;
    site s = open_site(usual(PYRAMID, 3), 1), own = copy_of(&s);
    int met = 0;
    for (int k = 0; k < 600; k++) {
        uint64_t turn = (uint64_t)k / 40;
        const ll_action up = {.axis = {0, (float)(2 * ll_rng_unit(3, 1, turn) - 1)}};
        step(&s, &up);
        ll_game_stack.step_own(own.world, &own.env, 0, &up);
        const ll_entity *a = &s.world->entity[0], *b = &own.world->entity[0];
        bool free_of_ground = a->y > s.params.radius + 0.1;
        met += free_of_ground;
        assert_true(!free_of_ground || (fabs(a->x - b->x) < 1e-12 && fabs(a->y - b->y) < 1e-12));
        memcpy(own.world, s.world, ll_world_size(s.world));
    }
    assert_true(met > 100);
    free(s.world);
    free(own.world);
}

static void shapes_are_of_the_scene(void **state)
{
    (void)state;
    site s = open_site(usual(CARD_HOUSE, 2), 2);
    ll_game_shape shape;
    int cards = 0;
    for (int i = 0; ll_game_stack.shape(&s.env, 2, i, &shape); i++) {
        assert_string_equal(shape.kind, i < 2 ? "player" : "crate");
        cards += i >= 2 && fabs(larger(shape.width, shape.height) - 0.4) < 1e-12 &&
                 fabs(smaller(shape.width, shape.height) - 0.002) < 1e-12;
    }
    assert_int_equal(cards, 7); /* two leaning pairs, one on them, and one lying between */
    assert_int_equal(s.world->entities, 9);
    free(s.world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(too_large_scenes_are_refused),
        cmocka_unit_test(stacks_stand_without_warm_starting),
        cmocka_unit_test(dominoes_fall_and_rest),
        cmocka_unit_test(a_ball_pushes_what_stands),
        cmocka_unit_test(a_ball_alone_goes_as_on_the_server),
        cmocka_unit_test(shapes_are_of_the_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

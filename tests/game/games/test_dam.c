/* The dam's rules: water stays in its tank and keeps its volume, falls no faster than it can, and paddles
 * drag it. */
#include <math.h>

#include <cjson/cJSON.h>

#include "base/rng.h"
#include "game/harness.h"
#include "support/near.h"

typedef struct params {
    int64_t across, iterations;
    double side, width, height, radius, speed, acceleration;
} params;

typedef struct tank {
    params params;
    ll_game_env env;
    ll_world *world;
} tank;

#define HZ 60

static params usual(void)
{
    params p;
    ll_param_defaults(&ll_dam_table, &p);
    return p;
}

static tank open_tank(params p, int players)
{
    tank t = {.params = p};
    t.world = world_open(&ll_game_dam, &p, players, 1.0 / HZ, &t.env);
    return t;
}

static void step(tank *t, const ll_action *actions)
{
    ll_game_dam.step(t->world, &t->env, actions, 0, NULL);
}

static const ll_action nothing[LL_PLAYERS_MAX];

static void bad_tanks_are_refused(void **state)
{
    (void)state;
    const char *const texts[] = {"{\"width_m\":0.8}", "{\"height_m\":0.9}",
                                 "{\"width_m\":50,\"height_m\":50,\"side_m\":1}"};
    const char *const messages[] = {"width_m: must be at least 1 m", "height_m: must be at least 1 m",
                                    "the walls need 7800 particles"};
    for (size_t i = 0; i < 3; i++) {
        params p;
        cJSON *json = cJSON_Parse(texts[i]);
        ll_param_defaults(&ll_dam_table, &p);
        ll_status status = ll_param_parse(&ll_dam_table, json, &p);
        cJSON_Delete(json);
        assert_true(ll_failed(&status));
        assert_non_null(strstr(status.text, messages[i]));
    }
}

/* The front is never ahead of Ritter's, side + 2 sqrt(g side) t, and reaches the far wall; in the end the
 * water is level: the mean height of its particles is half of that of the same water as a rectangle. */
static void water_breaks_and_comes_to_lie_level(void **state)
{
    (void)state;
    tank t = open_tank(usual(), 1);
    const params *p = &t.params;
    double spacing = p->side / (double)p->across, worst = 0, values[LL_GAME_VALUES];
    for (int k = 1; k <= 30 * HZ; k++) {
        step(&t, nothing);
        ll_game_dam.describe(t.world, &t.env, 0, values);
        assert_true(values[0] < p->side + 2 * sqrt(9.81 * p->side) * k / HZ + spacing / 2);
        for (int i = 1; i < t.world->entities; i++) {
            const ll_entity *e = &t.world->entity[i];
            worst = larger(worst, larger(larger(-e->x, e->x - p->width), larger(-e->y, e->y - p->height)));
        }
        if (k == HZ)
            assert_true(values[0] > p->width - spacing && values[2] > 0.5);
    }
    double sum = 0;
    for (int i = 1; i < t.world->entities; i++)
        sum += t.world->entity[i].y;
    double mean = sum / (t.world->entities - 1), level = p->side * p->side / p->width / 2;
    assert_true(worst <= 0); /* no particle is past a wall */
    assert_true(values[2] < 0.1);
    assert_near(mean, level, 0.25 * spacing);
    free(t.world);
}

/* Water within a paddle moves with it, and other water keeps its place. */
static void a_paddle_draws_water_along(void **state)
{
    (void)state;
    tank still = open_tank(usual(), 1), stirred = still;
    for (int k = 0; k < 10 * HZ; k++)
        step(&still, nothing);
    still.world->entity[0].x = 1.5;
    still.world->entity[0].y = 0.15;
    stirred.world = malloc(ll_world_size(still.world));
    memcpy(stirred.world, still.world, ll_world_size(still.world));
    const ll_action go = {.axis = {1, 0}};
    double still_flow = 0, stirred_flow = 0;
    for (int k = 0; k < 20; k++) {
        step(&still, nothing);
        step(&stirred, &go);
    }
    for (int i = 1; i < still.world->entities; i++) {
        still_flow += still.world->entity[i].vx;
        stirred_flow += stirred.world->entity[i].vx;
    }
    assert_true(stirred_flow - still_flow > 3);
    free(still.world);
    free(stirred.world);
}

/* A client's prediction of its paddle equals bitwise the server's step, and it stays in the tank. */
static void a_paddle_moves_as_on_the_server(void **state)
{
    (void)state;
    params p = usual();
    p.across = 4;
    tank t = open_tank(p, 2), own = t;
    own.world = malloc(ll_world_size(t.world));
    memcpy(own.world, t.world, ll_world_size(t.world));
    for (int k = 0; k < 1200; k++) {
        ll_action actions[2] = {{.buttons = 0}};
        uint64_t turn = (uint64_t)k / 60;
        actions[1] = (ll_action){
            .axis = {(float)(2 * ll_rng_unit(5, 1, turn) - 1), (float)(2 * ll_rng_unit(5, 2, turn) - 1)}};
        step(&t, actions);
        ll_game_dam.step_own(own.world, &own.env, 1, &actions[1]);
        const ll_entity *e = &t.world->entity[1];
        assert_memory_equal(&own.world->entity[1], e, sizeof *e);
        assert_true(e->x >= p.radius && e->x <= p.width - p.radius && e->y >= p.radius &&
                    e->y <= p.height - p.radius);
    }
    free(t.world);
    free(own.world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_tanks_are_refused),
        cmocka_unit_test(water_breaks_and_comes_to_lie_level),
        cmocka_unit_test(a_paddle_draws_water_along),
        cmocka_unit_test(a_paddle_moves_as_on_the_server),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The sea's rules: its water is the ocean's, its boats float by closed forms, and a client predicts its own.
 */
#include <math.h>

#include "base/rng.h"
#include "fluid/ocean/ocean.h"
#include "game/harness.h"
#include "support/near.h"

typedef struct params {
    int64_t points, waves, seed;
    double length, wind, choppiness, boat, draught, damping, speed, acceleration;
} params;

typedef struct coast {
    params params;
    ll_game_env env;
    ll_world *world;
} coast;

#define HZ 60

static params usual(void)
{
    params p;
    ll_param_defaults(&ll_sea_table, &p);
    return p;
}

static coast open_coast(params p, int players)
{
    coast c = {.params = p};
    c.world = world_open(&ll_game_sea, &p, players, 1.0 / HZ, &c.env);
    return c;
}

static void step(coast *c, const ll_action *actions)
{
    ll_game_sea.step(c->world, &c->env, actions, 0, NULL);
}

static const ll_action nothing[LL_PLAYERS_MAX];

/* A point that moves at its own speed for a short time is where the water has it then: central differences of
 * two steps are off by h^2 / 6 of the third derivative, w^3 A. */
static void points_move_at_their_velocity(void **state)
{
    (void)state;
    coast c = open_coast(usual(), 1);
    int points = c.world->entities - 1;
    ll_entity past[LL_ENTITIES_MAX], now[LL_ENTITIES_MAX];
    for (int k = 0; k < 300; k++) {
        memcpy(past, now, sizeof past);
        memcpy(now, &c.world->entity[1], (size_t)points * sizeof now[0]);
        step(&c, nothing);
        const ll_entity *next = &c.world->entity[1];
        for (int i = 0; i < points && k > 0; i++) {
            assert_near((next[i].x - past[i].x) * HZ / 2, now[i].vx, 2e-3);
            assert_near((next[i].y - past[i].y) * HZ / 2, now[i].vy, 2e-3);
        }
    }
    free(c.world);
}

/* Without wind there are no waves: a boat that was lifted by a decimetre heaves about 0 with the frequency
 * sqrt(g / draught - (damping / 2)^2) and by a share of exp(-damping T / 2) a period. */
static void a_boat_heaves_by_its_draught(void **state)
{
    (void)state;
    params p = usual();
    p.wind = 0;
    p.damping = 0.5;
    coast c = open_coast(p, 2);
    c.world->entity[0].y = 0.1;
    double crossed[2] = {0}, last = 0.1;
    int count = 0;
    for (int k = 1; k < 600 && count < 2; k++) {
        step(&c, nothing);
        double y = c.world->entity[0].y;
        if (last > 0 && y <= 0)
            crossed[count++] = k - y / (y - last);
        last = y;
        assert_true(c.world->entity[1].y == 0 && c.world->entity[1].angle == 0); /* a boat at rest stays */
    }
    double period = 6.283185307179586 / sqrt(9.81 / p.draught - p.damping * p.damping / 4);
    assert_int_equal(count, 2);
    assert_near((crossed[1] - crossed[0]) / HZ, period, 0.01 * period);
    free(c.world);
}

/* On waves much longer than it a boat lies on the water with the water's slope. */
static void a_boat_lies_on_long_waves(void **state)
{
    (void)state;
    params p = usual();
    p.waves = 1;
    p.length = 400;
    p.boat = 2;
    p.draught = 0.2;
    coast c = open_coast(p, 3);
    double most = 0, low = 0, high = 0;
    for (int k = 0; k < 40 * HZ; k++) {
        step(&c, nothing);
        for (int i = 0; i < 3 && k > 10 * HZ; i++) {
            double values[LL_GAME_VALUES];
            ll_game_sea.describe(c.world, &c.env, i, values);
            most = larger(most, fabs(values[0] - values[1]));
            low = smaller(low, values[0]);
            high = larger(high, values[0]);
        }
    }
    assert_true(high - low > 0.3 && most < 0.05 * (high - low));
    free(c.world);
}

/* A client's prediction of its boat equals bitwise the server's step. */
static void a_boat_alone_sails_as_on_the_server(void **state)
{
    (void)state;
    coast c = open_coast(usual(), 3), own = c;
    own.world = malloc(ll_world_size(c.world));
    memcpy(own.world, c.world, ll_world_size(c.world));
    for (int k = 0; k < 1200; k++) {
        ll_action actions[3];
        for (uint64_t i = 0; i < 3; i++)
            actions[i] = (ll_action){.axis = {(float)(2 * ll_rng_unit(5, i, (uint64_t)k / 50) - 1)}};
        step(&c, actions);
        ll_game_sea.step_own(own.world, &own.env, 1, &actions[1]);
        assert_memory_equal(&own.world->entity[1], &c.world->entity[1], sizeof(ll_entity));
    }
    assert_true(fabs(c.world->entity[1].x - c.params.length / 2) > 1);
    for (int k = 0; k < 3000; k++) { /* and not over the edge */
        const ll_action away[3] = {{.axis = {-1}}, {.axis = {1}}, {.axis = {1}}};
        step(&c, away);
    }
    assert_true(c.world->entity[0].x == c.params.boat / 2);
    assert_true(c.world->entity[2].x == c.params.length - c.params.boat / 2);
    free(c.world);
    free(own.world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_move_at_their_velocity),
        cmocka_unit_test(a_boat_heaves_by_its_draught),
        cmocka_unit_test(a_boat_lies_on_long_waves),
        cmocka_unit_test(a_boat_alone_sails_as_on_the_server),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

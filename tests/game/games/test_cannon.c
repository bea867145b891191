#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "game/games/games.h"
#include "support/near.h"

typedef struct field {
    ll_game_env env;
    _Alignas(8) char bytes[1024];
    ll_world *world;
} field;

/* gravity, drag, muzzle speed, target, target radius, pause */
static field *make(double drag, double target, double pause)
{
    const double params[] = {9.81, drag, 30, target, 2, pause};
    const int32_t lanes[] = {0, 1};
    field *f = calloc(1, sizeof *f);
    f->env.dt = 1.0 / 60;
    f->env.dt_ns = ll_tick_time(1, 60000);
    f->world = (ll_world *)f->bytes;
    f->world->players = f->world->entities = 2;
    f->world->tail = ll_game_cannon.extent(params, 2).tail;
    assert_true(ll_world_size(f->world) <= sizeof f->bytes);
    ll_game_cannon.prepare(&f->env, params);
    ll_game_cannon.init(f->world, &f->env, lanes);
    return f;
}

static void step(field *f, float angle, float speed, unsigned buttons)
{
    const ll_action action = {.axis = {angle, speed}, .buttons = buttons}, actions[2] = {action, action};
    ll_game_cannon.step(f->world, &f->env, actions, 0, NULL);
}

/* vx = vx0 e^-ct, x = vx0 (1 - e^-ct) / c; vy = (vy0 + g/c) e^-ct - g/c, y by its integral; c = 0 is the
 * parabola. */
static void flight_follows_the_closed_form(void **state)
{
    (void)state;
    const double drags[] = {0, 0.2, 1};
    for (size_t k = 0; k < sizeof drags / sizeof drags[0]; k++) {
        field *f = make(drags[k], 5000, 0);
        double c = drags[k], g = 9.81, v = 30 * sqrt(0.5);
        step(f, 0.5f, 1, LL_BUTTON_FIRE);
        for (int i = 1; i <= 60; i++) {
            double t = i / 60.0, e = exp(-c * t);
            double x = c > 0 ? v * (1 - e) / c : v * t;
            double y = c > 0 ? (v + g / c) * (1 - e) / c - g / c * t : v * t - g / 2 * t * t;
            step(f, 0.5f, 1, 0);
            assert_near(f->world->entity[0].x, x, 1e-9);
            assert_near(f->world->entity[0].y, y, 1e-9);
        }
        free(f);
    }
}

static void shot_lands_at_its_range_and_the_turn_passes(void **state)
{
    (void)state;
    double values[LL_GAME_VALUES], range = 30 * 30 / 9.81;
    field *f = make(0, 1000, 0.5);
    for (int i = 0; i < 31; i++)
        step(f, 0.5f, 1, 0); /* the pause before the first shot */
    step(f, 0.5f, 1, LL_BUTTON_FIRE);
    assert_true(f->world->entity[0].flags & LL_ENTITY_ACTIVE);
    for (int i = 0; i < 300 && (f->world->entity[0].flags & LL_ENTITY_ACTIVE); i++)
        step(f, 0.5f, 1, LL_BUTTON_FIRE);
    assert_near(f->world->entity[0].x, range, 0.01);
    ll_game_cannon.describe(f->world, &f->env, 0, values);
    assert_true(values[0] == 0 && values[1] == 1 && values[2] == 0);
    assert_near(values[3], (range - 1000), 0.01);
    step(f, 0.5f, 1, LL_BUTTON_FIRE); /* too early: the pause of the next player */
    assert_false(f->world->entity[1].flags & LL_ENTITY_ACTIVE);
    for (int i = 0; i < 31; i++)
        step(f, 0.5f, 1, LL_BUTTON_FIRE);
    assert_true(f->world->entity[1].flags & LL_ENTITY_ACTIVE);
    assert_false(f->world->entity[0].flags & LL_ENTITY_ACTIVE);
    free(f);
}

static void target_is_hit_by_the_shot_that_reaches_it(void **state)
{
    (void)state;
    double values[LL_GAME_VALUES];
    for (int near = 0; near < 2; near++) {
        field *f = make(0, 30 * 30 / 9.81 + (near ? 1 : 5), 0);
        step(f, 0.5f, 1, LL_BUTTON_FIRE);
        for (int i = 0; i < 300 && (f->world->entity[0].flags & LL_ENTITY_ACTIVE); i++)
            step(f, 0.5f, 1, 0);
        ll_game_cannon.describe(f->world, &f->env, 0, values);
        assert_true(values[1] == 1 && values[2] == near);
        free(f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flight_follows_the_closed_form),
        cmocka_unit_test(shot_lands_at_its_range_and_the_turn_passes),
        cmocka_unit_test(target_is_hit_by_the_shot_that_reaches_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "game/games/games.h"
#include "support/near.h"

/* acceleration, brake, drag, top speed, lap, laps, car length, lane width, restitution */
static const double usual[] = {6, 9, 0.3, 1000, 100, 6, 4, 3, 0.3};

typedef struct field {
    ll_game_env env;
    _Alignas(8) char bytes[2048];
    ll_world *world;
} field;

static field *make(const double *params, int players, const int32_t *lanes, double dt)
{
    field *f = calloc(1, sizeof *f);
    f->env.dt = dt;
    f->env.dt_ns = (ll_time)(dt * 1e9);
    f->world = (ll_world *)f->bytes;
    f->world->players = f->world->entities = players;
    f->world->tail = ll_game_race.extent(params, players).tail;
    assert_true(ll_world_size(f->world) <= sizeof f->bytes);
    ll_game_race.prepare(&f->env, params);
    ll_game_race.init(f->world, &f->env, lanes);
    return f;
}

/* From rest at full throttle: v = (a/c)(1 - e^-ct), x = (a/c) t - v / c, for any step. */
static void throttle_follows_the_closed_form(void **state)
{
    (void)state;
    const int32_t lanes[] = {0};
    const double dts[] = {1.0 / 3, 1.0 / 30, 1.0 / 60, 1.0 / 240};
    const ll_action full = {.axis = {1, 0}};
    for (size_t k = 0; k < sizeof dts / sizeof dts[0]; k++) {
        field *f = make(usual, 1, lanes, dts[k]);
        int steps = (int)lround(10 / dts[k]);
        for (int i = 0; i < steps; i++)
            ll_game_race.step(f->world, &f->env, &full, (ll_time)((i + 1) * dts[k] * 1e9), NULL);
        double a = 6, c = 0.3, v = a / c * (1 - exp(-c * 10)), x = a / c * 10 - v / c;
        assert_near(f->world->entity[0].vx, v, 1e-10 * v);
        assert_near(f->world->entity[0].x, x, 1e-10 * x);
        free(f);
    }
}

/* Another machine's arithmetic: each product is rounded with its sum. */
static void fused_motion_rounds_once(void **state)
{
    (void)state;
    ll_game_env env = {.dt = 1.0 / 60};
    ll_drag d = ll_drag_over(0.3, env.dt);
    int differ = 0;
    for (int k = 1; k < 1000; k++) {
        double x = k / 7.0, v = k / 11.0, a = k / 13.0, fx = x, fv = v, x0 = x, v0 = v;
        env.fused = 0;
        ll_drag_move(&env, &d, a, &x, &v);
        env.fused = 1;
        ll_drag_move(&env, &d, a, &fx, &fv);
        assert_true(x == x0 + (v0 * d.f + a * d.g) && v == v0 * d.e + a * d.f);
        assert_true(fx == x0 + fma(v0, d.f, a * d.g) && fv == fma(v0, d.e, a * d.f));
        differ += x != fx || v != fv;
    }
    assert_true(differ > 100);
}

static void drag_factors_are_right_for_any_drag(void **state)
{
    (void)state;
    const double drags[] = {0, 1e-9, 1e-4, 0.3, 6, 10, 59.9, 60.1, 100, 1000};
    for (size_t k = 0; k < sizeof drags / sizeof drags[0]; k++) {
        double dt = 1.0 / 60, c = drags[k];
        ll_drag d = ll_drag_over(c, dt);
        long double z = (long double)c * dt;
        long double f = c > 0 ? -expm1l(-z) / c : (long double)dt;
        assert_true(fabsl(d.f - f) <= 1e-15L * f);
        /* g = (dt - f) / c cancels in long double too, so for small c it is compared with its series */
        long double g = z > 1e-2L ? ((long double)dt - f) / c
                                  : (long double)dt * dt *
                                        (0.5L - z / 6 + z * z / 24 - z * z * z / 120 + z * z * z * z / 720 -
                                         z * z * z * z * z / 5040);
        assert_true(fabsl(d.g - g) <= 1e-14L * g);
    }
}

static void top_speed_is_kept(void **state)
{
    (void)state;
    double params[9];
    memcpy(params, usual, sizeof params);
    params[3] = 16;
    const int32_t lanes[] = {0};
    const ll_action full = {.axis = {1, 0}};
    field *f = make(params, 1, lanes, 1.0 / 60);
    for (int i = 0; i < 600; i++) {
        ll_game_race.step(f->world, &f->env, &full, 0, NULL);
        assert_true(f->world->entity[0].vx <= 16);
    }
    assert_true(f->world->entity[0].vx == 16);
    free(f);
}

static void brakes_stop_and_do_not_reverse(void **state)
{
    (void)state;
    const int32_t lanes[] = {0};
    const ll_action brake = {.axis = {-1, 0}};
    field *f = make(usual, 1, lanes, 1.0 / 60);
    f->world->entity[0].vx = 20;
    double last = 0;
    for (int i = 0; i < 600; i++) {
        ll_game_race.step(f->world, &f->env, &brake, 0, NULL);
        assert_true(f->world->entity[0].x >= last);
        last = f->world->entity[0].x;
    }
    /* v = (v0 + b/c) e^-ct - b/c is 0 at t = ln(1 + c v0 / b) / c; x = v0 / c - b t / c */
    double b = 9, c = 0.3, t = log(1 + c * 20 / b) / c, x = 20 / c - b * t / c;
    assert_true(f->world->entity[0].vx == 0);
    assert_near(last, x, 2e-3); /* the step in which it stops neglects drag */
    free(f);
}

static void contact_keeps_momentum_and_takes_energy(void **state)
{
    (void)state;
    const int32_t same[] = {0, 0}, apart[] = {0, 1};
    double params[9];
    memcpy(params, usual, sizeof params);
    params[2] = 0; /* no drag */
    const ll_action coast[2] = {{.buttons = 0}};
    for (int lane = 0; lane < 2; lane++) {
        field *f = make(params, 2, lane == 0 ? same : apart, 1.0 / 60);
        ll_entity *front = &f->world->entity[0], *rear = &f->world->entity[1];
        rear->x = -10;
        rear->vx = 12;
        front->vx = 2;
        for (int i = 0; i < 120; i++) {
            ll_game_race.step(f->world, &f->env, coast, 0, NULL);
            if (lane == 0)
                assert_true(front->x - rear->x >= 4 - 1e-9);
        }
        assert_near(front->vx + rear->vx, 14, 1e-12);
        double closing = rear->vx - front->vx;
        assert_near(closing, (lane == 0 ? -0.3 * 10 : 10), 1e-12);
        free(f);
    }
}

static void finish_time_lies_between_ticks(void **state)
{
    (void)state;
    const int32_t lanes[] = {0};
    const ll_action coast = {.axis = {0, 0}};
    double params[9], values[LL_GAME_VALUES];
    memcpy(params, usual, sizeof params);
    params[2] = 0;
    field *f = make(params, 1, lanes, 1.0 / 60);
    f->world->entity[0].vx = 70;
    for (int64_t i = 1; i <= 600; i++)
        ll_game_race.step(f->world, &f->env, &coast, ll_tick_time(i, 60000), NULL);
    ll_game_race.describe(f->world, &f->env, 0, values);
    assert_near(values[0], 600.0 / 70, 1e-6);
    assert_true(f->world->entity[0].flags & LL_ENTITY_FINISHED);
    free(f);
}

/* A client's own prediction equals bitwise the server's step while no cars touch. */
static void own_step_is_the_server_step(void **state)
{
    (void)state;
    const int32_t lanes[] = {0, 1, 2};
    field *server = make(usual, 3, lanes, 1.0 / 60), *client = make(usual, 3, lanes, 1.0 / 60);
    for (int i = 0; i < 3600; i++) {
        ll_action actions[3];
        for (int p = 0; p < 3; p++) {
            actions[p] = ll_game_race.drive(server->world, &server->env, 1, p, LL_SCRIPT_VARIED,
                                            ll_tick_time(i, 60000));
            ll_game_race.step_own(client->world, &client->env, p, &actions[p]);
        }
        ll_game_race.step(server->world, &server->env, actions, ll_tick_time(i + 1, 60000), NULL);
        for (int p = 0; p < 3; p++)
            assert_memory_equal(&server->world->entity[p], &client->world->entity[p],
                                offsetof(ll_entity, flags));
        for (int p = 0; p < 3; p++)
            client->world->entity[p].flags = server->world->entity[p].flags;
    }
    assert_true(server->world->entity[0].x > 300); /* they did drive */
    free(server);
    free(client);
}

/* The farthest distance is that of full throttle; no other controls come as far. */
static void no_player_comes_farther_than_the_farthest(void **state)
{
    (void)state;
    const int32_t lanes[] = {0};
    const double drags[] = {0, 0.3, 2}, tops[] = {2, 16, 1000};
    for (int i = 0; i < 9; i++) {
        double params[9];
        memcpy(params, usual, sizeof params);
        params[2] = drags[i / 3];
        params[3] = tops[i % 3];
        field *full = make(params, 1, lanes, 1.0 / 60), *other = make(params, 1, lanes, 1.0 / 60);
        for (int k = 1; k <= 1200; k++) {
            const ll_action throttle = {.axis = {1, 0}},
                            any = {.axis = {(float)(2 * ll_rng_unit(9, 0, (uint64_t)k) - 1), 0}};
            double before = other->world->entity[0].x;
            ll_game_race.step(full->world, &full->env, &throttle, 0, NULL);
            ll_game_race.step(other->world, &other->env, &any, 0, NULL);
            double far = ll_game_race.farthest(&full->env, k / 60.0, true);
            /* the step in which the top speed is reached is taken as even */
            assert_true(full->world->entity[0].x <= far + 1e-9 * far);
            assert_true(full->world->entity[0].x >= far - 1e-9 * far - 6.0 / 60 / 60);
            assert_true(other->world->entity[0].x <= far + 1e-9);
            assert_true(other->world->entity[0].x - before <=
                        ll_game_race.farthest(&full->env, 1.0 / 60, false) + 1e-12);
        }
        free(full);
        free(other);
    }
}

static field *crowd(int players, uint64_t seed)
{
    int32_t lanes[LL_PLAYERS_MAX];
    double params[9];
    memcpy(params, usual, sizeof params);
    params[3] = 16;
    for (int i = 0; i < players; i++)
        lanes[i] = (int32_t)(ll_rng_u64(seed, 0, (uint64_t)i) % 4);
    field *f = make(params, players, lanes, 1.0 / 60);
    for (int i = 0; i < players; i++) {
        f->world->entity[i].x = 100 * ll_rng_unit(seed, 1, (uint64_t)i);
        f->world->entity[i].vx = 16 * ll_rng_unit(seed, 2, (uint64_t)i);
    }
    return f;
}

static void any_actions(ll_action *actions, int players, uint64_t seed, int step)
{
    for (int i = 0; i < players; i++)
        actions[i].axis[0] = (float)(2 * ll_rng_unit(seed, 3 + (uint64_t)i, (uint64_t)step / 10) - 1);
}

/* Cars beyond each other's reach may be stepped apart: each group alone gives bitwise the same as with all
 * the others, for any controls within the horizon. */
static void groups_out_of_reach_may_be_stepped_alone(void **state)
{
    (void)state;
    int split = 0;
    for (uint64_t seed = 1; seed <= 200; seed++) {
        const int players = 2 + (int)(seed % 15), steps = 5 + (int)(seed % 60);
        field *whole = crowd(players, seed), *part = crowd(players, seed);
        ll_entity_set set = {{0}};
        int self = (int)(seed % (uint64_t)players), members = 0;
        ll_entity_set_add(&set, self);
        ll_game_race.reach(whole->world, &whole->env, steps / 60.0, &set);
        for (int k = 0; k < steps; k++) {
            ll_action actions[LL_PLAYERS_MAX] = {{.buttons = 0}};
            any_actions(actions, players, seed, k);
            ll_game_race.step(whole->world, &whole->env, actions, ll_tick_time(k + 1, 60000), NULL);
            ll_game_race.step_some(part->world, &part->env, actions, ll_tick_time(k + 1, 60000), &set);
        }
        field *start = crowd(players, seed);
        for (int i = 0; i < players; i++) {
            bool in = ll_entity_set_has(&set, i);
            assert_memory_equal(&part->world->entity[i], &(in ? whole : start)->world->entity[i],
                                sizeof(ll_entity));
            assert_true(!in || part->world->entity[i].y == part->world->entity[self].y);
            members += in;
        }
        split += members > 1 && members < players;
        free(whole);
        free(part);
        free(start);
    }
    assert_true(split > 50);
}

static void stepping_all_as_a_subset_is_a_step(void **state)
{
    (void)state;
    field *whole = crowd(16, 7), *some = crowd(16, 7);
    ll_entity_set set = {{0xffff}};
    for (int k = 0; k < 3600; k++) {
        ll_action actions[LL_PLAYERS_MAX] = {{.buttons = 0}};
        any_actions(actions, 16, 7, k);
        ll_game_race.step(whole->world, &whole->env, actions, ll_tick_time(k + 1, 60000), NULL);
        ll_game_race.step_some(some->world, &some->env, actions, ll_tick_time(k + 1, 60000), &set);
    }
    assert_memory_equal(whole->bytes, some->bytes, sizeof whole->bytes);
    free(whole);
    free(some);
}

/* A snapshot rounds a lane's middle to its grid: players who share a lane still do, and no others. */
static void lanes_survive_a_grid(void **state)
{
    (void)state;
    const int32_t lanes[] = {1, 1, 2};
    const float steps[] = {0.002f, 0.007f, 0.1f, 0.9f};
    const ll_action still[3] = {{.axis = {0, 0}}};
    for (size_t k = 0; k < sizeof steps / sizeof steps[0]; k++) {
        field *f = make(usual, 3, lanes, 1.0 / 60);
        ll_entity *e = f->world->entity;
        ll_entity_set set = {{1}};
        e[1].y = (double)steps[k] * round(e[1].y / (double)steps[k]);
        assert_true(e[1].y != e[0].y);
        e[0].x = 1, e[1].x = 0, e[2].x = 2;
        e[1].vx = 3;
        ll_game_race.reach(f->world, &f->env, 0.1, &set);
        assert_int_equal(set.bits[0], 3);
        ll_game_race.step(f->world, &f->env, still, LL_SECOND, NULL);
        assert_true(e[0].x - e[1].x >= 4 - 1e-12 && e[0].vx > 0 && e[2].vx == 0 && e[2].x == 2);
        free(f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(throttle_follows_the_closed_form),
        cmocka_unit_test(fused_motion_rounds_once),
        cmocka_unit_test(drag_factors_are_right_for_any_drag),
        cmocka_unit_test(top_speed_is_kept),
        cmocka_unit_test(brakes_stop_and_do_not_reverse),
        cmocka_unit_test(contact_keeps_momentum_and_takes_energy),
        cmocka_unit_test(finish_time_lies_between_ticks),
        cmocka_unit_test(own_step_is_the_server_step),
        cmocka_unit_test(no_player_comes_farther_than_the_farthest),
        cmocka_unit_test(groups_out_of_reach_may_be_stepped_alone),
        cmocka_unit_test(stepping_all_as_a_subset_is_a_step),
        cmocka_unit_test(lanes_survive_a_grid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The shooter's rules and scripts, without a network: all players act on the truth. */
#include <math.h>

#include "game/games/shooter.h"
#include "game/harness.h"
#include "support/near.h"

#define HZ 60000

typedef struct yard {
    ll_game_env env;
    ll_shooter_params params;
    ll_world *world;
    ll_arena arena;
    int64_t k;
} yard;

static yard *open_yard(int players, void (*set)(ll_shooter_params *))
{
    yard *y = calloc(1, sizeof *y);
    ll_param_defaults(&ll_shooter_table, &y->params);
    if (set)
        set(&y->params);
    y->world = world_open(&ll_game_shooter, &y->params, players, 1.0 / 60, &y->env);
    ll_shooter_arena(&y->env, players, &y->arena);
    return y;
}

static void close_yard(yard *y)
{
    free(y->world);
    free(y);
}

static void step(yard *y, const ll_action *actions)
{
    y->k++;
    ll_game_shooter.step(y->world, &y->env, actions, ll_tick_time(y->k, HZ), NULL);
}

static void play(yard *y, int steps, const ll_script *scripts)
{
    for (int i = 0; i < steps; i++) {
        ll_action actions[LL_PLAYERS_MAX];
        for (int p = 0; p < y->world->players; p++) {
            actions[p] = ll_game_shooter.drive(y->world, &y->env, 1, p, scripts[p], ll_tick_time(y->k, HZ));
        }
        step(y, actions);
    }
}

static void a_lift_goes_at_its_speed_between_its_ends(void **state)
{
    (void)state;
    yard *y = open_yard(2, NULL), *own = open_yard(2, NULL);
    const ll_action ride[2] = {{.axis = {0.5f, 0.25f}}, {.axis = {-1, 0.25f}}};
    for (int i = 1; i <= 600; i++) {
        step(y, ride);
        ll_game_shooter.step_own(own->world, &own->env, 0, &ride[0]); /* what a client predicts, bitwise */
        assert_memory_equal(&own->world->entity[0], &y->world->entity[0], sizeof(ll_entity));
        double up = 7.5 + 2.5 * i / 60, down = 7.5 - 5.0 * i / 60;
        assert_near(y->world->entity[0].y, smaller(up, LL_SHOOTER_LIFT_HIGH), 1e-12);
        assert_near(y->world->entity[1].y, larger(down, LL_SHOOTER_LIFT_LOW), 1e-12);
    }
    assert_true(y->world->entity[0].vy == 0);
    assert_near(y->world->entity[0].angle, M_PI / 8, 1e-15); /* half of a quarter's half */
    assert_near(y->world->entity[1].angle, M_PI * 7 / 8, 1e-15);
    close_yard(y);
    close_yard(own);
}

static void most_targets(ll_shooter_params *p)
{
    p->targets = 16;
}

static void targets_fly_straight_and_turn(void **state)
{
    (void)state;
    yard *y = open_yard(1, most_targets);
    const ll_action still = {0};
    int turns[16] = {0};
    for (int i = 0; i < 3600; i++) {
        ll_entity before[16];
        memcpy(before, &y->world->entity[1], sizeof before);
        step(y, &still);
        for (int t = 0; t < 16; t++) {
            const ll_entity *a = &before[t], *b = &y->world->entity[1 + t];
            assert_true(hypot(b->vx, b->vy) == 6);
            assert_near(b->x, (a->x + b->vx / 60), 1e-12);
            assert_near(b->y, (a->y + b->vy / 60), 1e-12);
            assert_true(b->y > 1 && b->y < LL_SHOOTER_HEIGHT && b->x > 15 && b->x < LL_SHOOTER_WIDTH - 15);
            turns[t] += a->vx * b->vx + a->vy * b->vy < 0;
        }
    }
    for (int t = 0; t < 16; t++)
        assert_true(turns[t] > 20 && turns[t] < 120); /* 60 s: 40 by chance, and those at the ends */
    close_yard(y);
}

static void rifle_only(ll_shooter_params *p)
{
    p->weapons = LL_SHOOTER_RIFLE;
}

static void cannon_only(ll_shooter_params *p)
{
    p->weapons = LL_SHOOTER_CANNON;
    p->turn = 3600;
}

/* A player who sees the truth and aims at the middle hits with every shot. */
static void a_rifle_that_is_aimed_at_the_middle_hits(void **state)
{
    (void)state;
    yard *y = open_yard(2, rifle_only);
    const ll_script scripts[] = {LL_SCRIPT_STEADY, LL_SCRIPT_VARIED};
    double steady[LL_GAME_VALUES], varied[LL_GAME_VALUES];
    play(y, 3600, scripts);
    ll_game_shooter.describe(y->world, &y->env, 0, steady);
    ll_game_shooter.describe(y->world, &y->env, 1, varied);
    assert_true(steady[0] > 200 && steady[1] == steady[0]);
    assert_true(varied[1] > 0.5 * varied[0] &&
                varied[1] < 0.9 * varied[0]); /* within a radius, of one and a half */
    assert_true(steady[2] == 0 && steady[3] == 0);
    close_yard(y);
}

/* A led projectile misses only targets that have turned at an end, or flies behind cover. */
static void a_cannon_is_led(void **state)
{
    (void)state;
    yard *y = open_yard(1, cannon_only);
    const ll_script script = LL_SCRIPT_STEADY;
    double values[LL_GAME_VALUES];
    play(y, 3 * 3600, &script);
    ll_game_shooter.describe(y->world, &y->env, 0, values);
    assert_true(values[2] > 80 && values[3] > 0.5 * values[2]);
    close_yard(y);
}

/* The peeking player is in sight of the holding one for a part of the time, and shots are exchanged. */
static void peeking_opens_and_closes_the_line(void **state)
{
    (void)state;
    yard *y = open_yard(2, rifle_only);
    const ll_script scripts[] = {LL_SCRIPT_PEEK, LL_SCRIPT_HOLD};
    double a[LL_GAME_VALUES], b[LL_GAME_VALUES];
    int open = 0, changes = 0;
    bool last = true;
    for (int i = 0; i < 3600; i++) {
        play(y, 1, scripts);
        const ll_entity *e = y->world->entity;
        bool sees = ll_arena_sees(&y->arena, (ll_point){e[0].x, e[0].y}, (ll_point){e[1].x, e[1].y});
        open += sees;
        changes += sees != last;
        last = sees;
    }
    ll_game_shooter.describe(y->world, &y->env, 0, a);
    ll_game_shooter.describe(y->world, &y->env, 1, b);
    assert_true(open > 900 && open < 2700);
    assert_true(changes >= 40);
    assert_true(a[1] > 20 && b[1] > 20);
    close_yard(y);
}

static void shapes_are_those_of_the_arena(void **state)
{
    (void)state;
    yard *y = open_yard(3, NULL);
    ll_game_shape s;
    int n = 0;
    for (; ll_game_shooter.shape(&y->env, 3, n, &s); n++) {
        assert_string_equal(s.kind, n < 3 ? "player" : n < 9 ? "target" : "cover");
        assert_true(s.round == (n < 9) && s.width > 0);
        if (n >= 9) {
            const ll_box *b = &y->arena.cover[n - 9];
            assert_true(s.x - s.width / 2 == b->x_min && s.y + s.height / 2 == b->y_max);
        }
    }
    assert_int_equal(n, 9 + y->arena.covers);
    assert_true(ll_arena_enemies(&y->arena, 0, 1) && !ll_arena_enemies(&y->arena, 0, 2));
    close_yard(y);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lift_goes_at_its_speed_between_its_ends),
        cmocka_unit_test(targets_fly_straight_and_turn),
        cmocka_unit_test(a_rifle_that_is_aimed_at_the_middle_hits),
        cmocka_unit_test(a_cannon_is_led),
        cmocka_unit_test(peeking_opens_and_closes_the_line),
        cmocka_unit_test(shapes_are_those_of_the_arena),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

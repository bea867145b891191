/* The crates' rules: the start, pushing, and what a client may predict of it. */
#include <math.h>

#include <cjson/cJSON.h>

#include "base/rng.h"
#include "game/harness.h"
#include "rigid/shape/manifold.h"
#include "support/near.h"

typedef struct params {
    int64_t count;
    double size, mass, friction, width, depth, radius, player_mass, speed, acceleration;
} params;

typedef struct yard {
    params params;
    ll_game_env env;
    ll_world *world;
} yard;

static params usual(int count)
{
    params p;
    ll_param_defaults(&ll_crates_table, &p);
    p.count = count;
    p.width = p.depth = 20;
    return p;
}

static yard open_yard(params p, int players, double dt)
{
    yard y = {.params = p};
    y.world = world_open(&ll_game_crates, &p, players, dt, &y.env);
    return y;
}

static yard copy_of(const yard *y)
{
    yard other = *y;
    other.world = world_copy(y->world);
    return other;
}

static void step(yard *y, const ll_action *actions)
{
    ll_game_crates.step(y->world, &y->env, actions, 0, NULL);
}

static bool at_rest(const ll_entity *e)
{
    return e->vx == 0 && e->vy == 0 && e->angular_velocity == 0;
}

static double value(const yard *y, int player, int which)
{
    double values[LL_GAME_VALUES];
    ll_game_crates.describe(y->world, &y->env, player, values);
    return values[which];
}

enum { PUSHED, PRESSING, SPEED, MOVING };

static const ll_action nothing[LL_PLAYERS_MAX];

/* ---- the start ---- */

static ll_status parsed(const char *text)
{
    params p;
    cJSON *json = cJSON_Parse(text);
    ll_param_defaults(&ll_crates_table, &p);
    ll_status status = ll_param_parse(&ll_crates_table, json, &p);
    cJSON_Delete(json);
    return status;
}

static void an_arena_too_small_is_refused(void **state)
{
    (void)state;
    /* 1.2 diagonals of 0.5 m are 0.8485 m: 11 rows in 10 m, so 19 columns, and four radii of 0.25 m at either
     * side */
    ll_status
        small = parsed(
            "{\"count\":200,\"size_m\":0.5,\"radius_m\":0.25,\"arena_width_m\":18,\"arena_depth_m\":10}"),
        enough = parsed(
            "{\"count\":200,\"size_m\":0.5,\"radius_m\":0.25,\"arena_width_m\":18.13,\"arena_depth_m\":10}"),
        players = parsed("{\"count\":1,\"radius_m\":1.5,\"arena_depth_m\":29}");
    assert_false(ll_failed(&enough));
    assert_string_equal(small.field, "arena_width_m");
    assert_string_equal(
        small.text, "arena_width_m: must be at least 18.122 m for 200 crates of 0.5 m in a depth of 10 m; "
                    "got 18");
    assert_string_equal(players.field, "arena_depth_m");
    assert_non_null(strstr(players.text, "at least 30 m"));
}

static ll_geometry outline(const yard *y, int i)
{
    ll_geometry g;
    ll_status status = i < y->world->players
                           ? ll_shape_circle(ll_vec(0, 0), y->params.radius, &g)
                           : ll_shape_box(y->params.size, y->params.size, ll_vec(0, 0), 0, &g);
    assert_false(ll_failed(&status));
    return g;
}

static ll_pose pose(const ll_entity *e)
{
    return (ll_pose){{e->x, e->y}, {cos(e->angle), sin(e->angle)}};
}

static double overlap(const yard *y, int i, int j)
{
    ll_geometry a = outline(y, i), b = outline(y, j);
    ll_manifold m =
        ll_collide(&a, &b, ll_pose_between(pose(&y->world->entity[i]), pose(&y->world->entity[j])), 0);
    double most = 0;
    for (int n = m.count; n-- > 0;)
        most = larger(most, -m.at[n].separation);
    return most;
}

static double deepest(const yard *y)
{
    double most = 0;
    for (int i = 0; i < y->world->entities; i++)
        for (int j = i + 1; j < y->world->entities; j++)
            most = larger(most, overlap(y, i, j));
    return most;
}

/* The largest number of bodies connected by contacts. */
static int largest_heap(const yard *y)
{
    int heap[LL_ENTITIES_MAX], size[LL_ENTITIES_MAX] = {0}, most = 0;
    for (int i = 0; i < y->world->entities; i++)
        heap[i] = i;
    for (int i = 0; i < y->world->entities; i++)
        for (int j = i + 1; j < y->world->entities; j++) {
            int from = heap[i], to = heap[j];
            bool touch = overlap(y, i, j) > 0;
            for (int k = 0; k < y->world->entities && touch; k++)
                heap[k] = heap[k] == from ? to : heap[k];
        }
    for (int i = 0; i < y->world->entities; i++)
        most = ++size[heap[i]] > most ? size[heap[i]] : most;
    return most;
}

static void at_the_start_no_bodies_touch(void **state)
{
    (void)state;
    for (int count = 1; count <= 239; count += 17)
        for (int players = 1; players <= LL_PEERS_MAX; players += 5) {
            params p = usual(count);
            p.width = p.depth = 25.8; /* 19 columns of 1.2 diagonals of 0.8 m, and eight radii */
            yard y = open_yard(p, players, 1.0 / 60), before = copy_of(&y);
            assert_true(deepest(&y) == 0);
            for (int i = 0; i < y.world->entities; i++) {
                const ll_entity *e = &y.world->entity[i];
                assert_true(e->x > p.radius && e->x < p.width - p.radius && e->y > p.radius &&
                            e->y < p.depth - p.radius);
            }
            for (int k = 0; k < 10; k++)
                step(&y, nothing);
            assert_memory_equal(y.world, before.world,
                                ll_world_size(y.world)); /* and nothing happens by itself */
            free(y.world);
            free(before.world);
        }
}

/* ---- pushing ---- */

/* One player runs into one crate and stops: the crate slides on and comes to rest; its distance counts while
 * it was pressed. */
static void a_crate_is_pushed_and_rests(void **state)
{
    (void)state;
    yard y = open_yard(usual(1), 1, 1.0 / 60);
    ll_entity *own = &y.world->entity[0], *crate = &y.world->entity[1];
    *own = (ll_entity){.x = 5, .y = 10};
    *crate = (ll_entity){.x = 8, .y = 10};
    const ll_action go = {.axis = {1, 0}};
    bool pressed = false;
    for (int k = 0; k < 90; k++) {
        step(&y, &go);
        assert_true(crate->x - own->x > 0.8 - 0.005);
        pressed = pressed || value(&y, 0, PRESSING) == 1;
    }
    double at = crate->x;
    assert_true(pressed);
    assert_near(own->vx, 4, 0.1);
    assert_near(crate->vx, own->vx, 0.1);
    assert_near(value(&y, 0, PUSHED), (at - 8), 0.1); /* except for the steps before it is pressed */
    assert_true(value(&y, 0, MOVING) == 1);
    for (int k = 0; k < 120; k++)
        step(&y, nothing);
    assert_true(at_rest(crate) && at_rest(own) && value(&y, 0, MOVING) == 0 && value(&y, 0, PRESSING) == 0);
    double v = 4, way = v * v / (2 * 0.4 * 9.81); /* Coulomb */
    assert_true(crate->x - at > 0.9 * way && crate->x - at < 1.1 * way);
    free(y.world);
}

/* A heavy crate is not moved by a weak player; no diagonal makes a player faster. */
static void limits_hold(void **state)
{
    (void)state;
    params p = usual(1);
    p.mass = 1000;
    p.friction = 1;
    yard y = open_yard(p, 1, 1.0 / 60);
    y.world->entity[0] = (ll_entity){.x = 7, .y = 10};
    y.world->entity[1] = (ll_entity){.x = 8, .y = 10};
    const ll_action go = {.axis = {1, 0}}, across = {.axis = {-1, -1}};
    for (int k = 0; k < 120; k++)
        step(&y, &go);
    assert_true(y.world->entity[1].x < 8.01 && y.world->entity[0].x < 7.3);
    for (int k = 0; k < 60; k++)
        step(&y, &across);
    assert_near(value(&y, 0, SPEED), 4, 1e-12);
    free(y.world);
}

/* Two hundred crates, pushed by eight players for a minute: everything stays in, nothing penetrates, and when
 * the players stand still everything comes to rest. */
static void two_hundred_crates_are_pushed_about(void **state)
{
    (void)state;
    params p = usual(200);
    p.width = p.depth = 26;
    yard y = open_yard(p, 8, 1.0 / 60);
    double pushed = 0;
    for (int k = 0; k < 3600; k++) {
        ll_action actions[8];
        for (int i = 0; i < 8; i++)
            actions[i] = ll_game_crates.drive(
                y.world, &y.env, 1, i, i % 2 ? LL_SCRIPT_STEADY : LL_SCRIPT_VARIED, ll_tick_time(k, 60000));
        step(&y, actions);
        if (k % 100 == 0)
            assert_true(deepest(&y) < 0.1); /* while pressed; crates are 0.8 m wide */
    }
    for (int i = 0; i < 8; i++) {
        assert_true(value(&y, i, PUSHED) > 10);
        pushed += value(&y, i, PUSHED);
    }
    assert_true(pushed > 500);
    for (int k = 0; k < 300; k++)
        step(&y, nothing);
    assert_true(value(&y, 0, MOVING) == 0);
    /* A body stays when a step moves it by less than 1e-6 m in x and in y. The four passes of a step remove 1
     * - 0.8^4 of an overlap beyond the slop, and a player next to a crate, four times as heavy, takes a fifth
     * of that. The pressures on its two sides may differ by that amount; from the edge of a heap the
     * differences add up. */
    double step_over = sqrt(2) * 1e-6 / (0.2 * (1 - 0.8 * 0.8 * 0.8 * 0.8));
    assert_true(deepest(&y) < LL_LINEAR_SLOP + largest_heap(&y) * step_over);
    for (int i = 0; i < y.world->entities; i++) {
        const ll_entity *e = &y.world->entity[i];
        assert_true(at_rest(e) && e->flags == 0);
        assert_true(e->x > 0.39 && e->x < p.width - 0.39 && e->y > 0.39 && e->y < p.depth - 0.39);
    }
    free(y.world);
}

/* ---- prediction ---- */

/* Where nothing is near, a client's prediction of its player alone equals bitwise the server's step, along
 * walls and in corners too. */
static void alone_a_player_moves_as_on_the_server(void **state)
{
    (void)state;
    const double dts[] = {1.0 / 60, 1.0 / 10};
    for (size_t d = 0; d < 2; d++) {
        yard server = open_yard(usual(1), 2, dts[d]), client = copy_of(&server);
        server.world->entity[2] = (ll_entity){.x = 10, .y = 10};
        int corners = 0;
        for (int k = 0; k < 3000; k++) {
            ll_action actions[2];
            for (int i = 0; i < 2; i++) { /* each at its own wall, and mostly towards it */
                uint64_t turn = (uint64_t)(k * dts[d] / 1.5), stream = (uint64_t)i;
                float out = i == 0 ? -1.0f : 1.0f;
                actions[i] = (ll_action){.axis = {out * (float)(ll_rng_unit(3, stream, turn) - 0.2),
                                                  (float)(2 * ll_rng_unit(4, stream, turn) - 1)}};
            }
            memcpy(client.world, server.world, ll_world_size(server.world));
            step(&server, actions);
            for (int i = 0; i < 2; i++) {
                yard own = copy_of(&client);
                ll_game_crates.step_own(own.world, &own.env, i, &actions[i]);
                assert_memory_equal(&own.world->entity[i], &server.world->entity[i], sizeof(ll_entity));
                free(own.world);
            }
            corners += server.world->entity[0].x < 0.41 && fabs(server.world->entity[0].y - 10) > 9.59;
        }
        assert_true(corners > 0);
        assert_true(at_rest(&server.world->entity[2]));
        free(server.world);
        free(client.world);
    }
}

/* A crate in the way stops the prediction, which does not move it. */
static void other_bodies_are_obstacles(void **state)
{
    (void)state;
    yard y = open_yard(usual(1), 2, 1.0 / 60);
    y.world->entity[0] = (ll_entity){.x = 5, .y = 10};
    y.world->entity[1] = (ll_entity){.x = 5, .y = 15, .vx = 1};
    y.world->entity[2] = (ll_entity){.x = 8, .y = 10, .vx = 2};
    ll_entity player = y.world->entity[1], crate = y.world->entity[2];
    const ll_action go = {.axis = {1, 0}};
    for (int k = 0; k < 120; k++)
        ll_game_crates.step_own(y.world, &y.env, 0, &go);
    assert_near(y.world->entity[0].x, 7.2, 0.003);
    assert_near(y.world->entity[0].vx, 0, 1e-9);
    assert_memory_equal(&y.world->entity[1], &player, sizeof player);
    assert_memory_equal(&y.world->entity[2], &crate, sizeof crate);
    free(y.world);
}

/* At random, or straight at player `prey`. */
static ll_action hunt(const ll_world *world, int player, int prey, int k, uint64_t seed)
{
    uint64_t stream = seed * 100 + (uint64_t)player;
    const ll_entity *own = &world->entity[player], *other = &world->entity[prey];
    double dx = other->x - own->x, dy = other->y - own->y, far = sqrt(dx * dx + dy * dy);
    if (seed % 2 == 0 || player == prey)
        return (ll_action){.axis = {(float)(2 * ll_rng_unit(8, stream, (uint64_t)k / 7) - 1),
                                    (float)(2 * ll_rng_unit(9, stream, (uint64_t)k / 7) - 1)}};
    return (ll_action){.axis = {(float)(dx / far), (float)(dy / far)}};
}

/* Entities outside of reach do not matter: over the horizon, for any actions of the others, stepping the set
 * alone gives bitwise the set's part of the whole. And reach leaves out a good part. */
static void reach_is_never_too_little(void **state)
{
    (void)state;
    const int steps = 20;
    int64_t chosen = 0, all = 0, shared = 0;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        params p = usual(120);
        p.width = p.depth = 30;
        p.speed = 3;
        yard whole = open_yard(p, 6, 1.0 / 60);
        for (int k = 0; k < 200; k++) { /* somewhere in the middle of a game */
            ll_action actions[6];
            for (int i = 0; i < 6; i++)
                actions[i] = ll_game_crates.drive(whole.world, &whole.env, seed, i, LL_SCRIPT_VARIED,
                                                  (ll_time)seed * LL_SECOND + ll_tick_time(k, 60000));
            step(&whole, actions);
        }
        yard part = copy_of(&whole);
        ll_entity_set set = {{0}};
        int self = (int)(seed % 6);
        ll_entity_set_add(&set, self);
        ll_game_crates.reach(whole.world, &whole.env, steps / 60.0, &set);
        for (int k = 0; k < steps; k++) {
            ll_action actions[6];
            for (int i = 0; i < 6; i++)
                actions[i] = hunt(whole.world, i, self, k, seed);
            ll_game_crates.step(whole.world, &whole.env, actions, 0, NULL);
            ll_game_crates.step_some(part.world, &part.env, actions, 0, &set);
        }
        for (int i = 0; i < whole.world->entities; i++) {
            if (!ll_entity_set_has(&set, i))
                continue;
            assert_memory_equal(&whole.world->entity[i], &part.world->entity[i], sizeof(ll_entity));
            chosen++;
            shared += i >= 6 && !at_rest(&part.world->entity[i]);
        }
        all += whole.world->entities;
        free(whole.world);
        free(part.world);
    }
    assert_true(shared > 20 && chosen < all / 2);
}

/* Two players at full speed, with or without a crate between them: players who may meet are in reach, and
 * players slightly too far are not, beyond the additional half of the speed that the rules allow for. */
static void players_that_may_meet_are_in_reach(void **state)
{
    (void)state;
    const double horizon = 0.5, speed = 4;
    for (int crate = 0; crate < 2; crate++)
        for (double gap = 0.05; gap < 8; gap += 0.05) {
            params p = usual(1);
            p.acceleration = 100;
            yard y = open_yard(p, 2, 1.0 / 60);
            double between = crate ? p.size : 0;
            y.world->entity[0] = (ll_entity){.x = 3, .y = 10, .vx = speed};
            y.world->entity[1] = (ll_entity){.x = 3 + 2 * p.radius + between + gap, .y = 10, .vx = -speed};
            y.world->entity[2] = (ll_entity){.x = 3 + p.radius + between / 2 + gap / 2, .y = crate ? 10 : 19};
            yard alone = copy_of(&y);
            ll_entity_set set = {{0}}, own = {{0}};
            ll_entity_set_add(&set, 0);
            ll_entity_set_add(&own, 0);
            ll_game_crates.reach(y.world, &y.env, horizon, &set);
            const ll_action both[2] = {{.axis = {1, 0}}, {.axis = {-1, 0}}};
            for (int k = 0; k < 30; k++) {
                step(&y, both);
                ll_game_crates.step_some(alone.world, &alone.env, both, 0, &own);
            }
            bool met = memcmp(&y.world->entity[0], &alone.world->entity[0], sizeof(ll_entity)) != 0;
            assert_true(!met || ll_entity_set_has(&set, crate ? 2 : 1));
            assert_true(!met || !crate || gap > 1 || ll_entity_set_has(&set, 1));
            double most = crate ? 4 * 1.5 * speed * horizon : 2 * 1.5 * speed * horizon;
            assert_true(gap < most + 1 || !ll_entity_set_has(&set, 1));
            free(y.world);
            free(alone.world);
        }
}

/* ---- drawing ---- */

static void shapes_are_of_the_rules(void **state)
{
    (void)state;
    yard y = open_yard(usual(3), 2, 1.0 / 60);
    ll_game_shape s;
    for (int i = 0; i < 5; i++) {
        assert_true(ll_game_crates.shape(&y.env, 2, i, &s));
        assert_string_equal(s.kind, i < 2 ? "player" : "crate");
        assert_true(s.round == (i < 2) && s.width == 0.8 && s.height == 0.8);
    }
    assert_false(ll_game_crates.shape(&y.env, 2, 5, &s));
    ll_game_scene scene = ll_game_crates.scene(&y.env, 2);
    assert_true(scene.x_max == 20 && scene.y_max == 20 && !scene.wraps);
    free(y.world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_arena_too_small_is_refused),
        cmocka_unit_test(at_the_start_no_bodies_touch),
        cmocka_unit_test(a_crate_is_pushed_and_rests),
        cmocka_unit_test(limits_hold),
        cmocka_unit_test(two_hundred_crates_are_pushed_about),
        cmocka_unit_test(alone_a_player_moves_as_on_the_server),
        cmocka_unit_test(other_bodies_are_obstacles),
        cmocka_unit_test(reach_is_never_too_little),
        cmocka_unit_test(players_that_may_meet_are_in_reach),
        cmocka_unit_test(shapes_are_of_the_rules),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

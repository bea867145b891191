/* Discs and boxes on a floor: conservation, friction and rest by closed forms, and that nothing passes
 * through. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "game/games/floor.h"
#include "rigid/shape/manifold.h"
#include "support/near.h"

#define DT (1.0 / 60)
#define MAX 120

static const ll_game_env env = {.dt = DT};

static ll_floor_body disc(double x, double y, double radius, double mass)
{
    return (ll_floor_body){.x = x, .y = y, .half = radius, .inverse_mass = 1 / mass, .round = true};
}

static ll_floor_body box(double x, double y, double angle, double side, double mass)
{
    return (ll_floor_body){.x = x,
                           .y = y,
                           .angle = angle,
                           .half = side / 2,
                           .inverse_mass = 1 / mass,
                           .inverse_inertia = 6 / (mass * side * side)};
}

static ll_floor floor_for(double side, double top, double half_min, double half_max)
{
    return (ll_floor){.width = side,
                      .depth = side,
                      .top_speed = top,
                      .half_max = half_max,
                      .substeps = ll_floor_substeps(DT, top, half_min)};
}

static double energy(const ll_floor_body *b, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        sum += (b[i].vx * b[i].vx + b[i].vy * b[i].vy) / (2 * b[i].inverse_mass);
        if (b[i].inverse_inertia > 0)
            sum += b[i].angular_velocity * b[i].angular_velocity / (2 * b[i].inverse_inertia);
    }
    return sum;
}

static double unit(uint64_t stream, uint64_t counter)
{
    return 2 * ll_rng_unit(17, stream, counter) - 1;
}

/* Discs and boxes of all sizes, thrown together: they overlap at first. */
static int thrown(ll_floor_body *b, uint64_t seed, double side, double reach)
{
    int count = 2 + (int)(seed * 7 % (MAX - 2));
    for (int i = 0; i < count; i++) {
        uint64_t k = seed * 1000 + (uint64_t)i;
        double x = side / 2 + reach * unit(1, k), y = side / 2 + reach * unit(2, k),
               mass = 1 + 40 * fabs(unit(3, k));
        double half = 0.2 + 0.3 * fabs(unit(4, k));
        b[i] = i % 3 == 0 ? disc(x, y, half, mass) : box(x, y, 3 * unit(5, k), 2 * half, mass);
        b[i].vx = 4 * unit(6, k);
        b[i].vy = 4 * unit(7, k);
        b[i].angular_velocity = i % 3 == 0 ? 0 : 5 * unit(8, k);
    }
    return count;
}

/* ---- conservation ---- */

/* Without grip of the floor and far from the walls, momentum stays and energy never grows: within rounding,
 * of about a hundred terms per step. The speed limit would take momentum away, so it is set out of reach. */
static void momentum_stays_and_energy_does_not_grow(void **state)
{
    (void)state;
    int met = 0;
    for (uint64_t seed = 1; seed <= 30; seed++) {
        ll_floor_body b[MAX];
        int count = thrown(b, seed, 1000, 3);
        ll_floor floor = floor_for(1000, 200, 0.2, 0.5);
        double last = energy(b, count), all = last, speed = 0;
        double px = 0, py = 0;
        for (int i = 0; i < count; i++) {
            px += b[i].vx / b[i].inverse_mass;
            py += b[i].vy / b[i].inverse_mass;
            speed += 4 / b[i].inverse_mass;
        }
        for (int k = 0; k < 120; k++) {
            double qx = 0, qy = 0;
            ll_floor_step(&env, &floor, b, count);
            for (int i = 0; i < count; i++) {
                qx += b[i].vx / b[i].inverse_mass;
                qy += b[i].vy / b[i].inverse_mass;
            }
            assert_near(qx, px, 1e-12 * speed);
            assert_near(qy, py, 1e-12 * speed);
            double now = energy(b, count);
            assert_true(now <= last + 1e-12 * all);
            last = now;
        }
        met += last < 0.9 * all;
    }
    assert_true(met > 24);
}

/* The same with walls and a floor that holds: then energy falls to nothing, exactly. */
static void everything_comes_to_rest(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 15; seed++) {
        ll_floor_body b[MAX], rest[MAX];
        int count = thrown(b, seed, 12, 5), k = 0;
        ll_floor floor = floor_for(12, 30, 0.2, 0.5);
        for (int i = 0; i < count; i++) {
            b[i].grip = 2 + fabs(unit(9, (uint64_t)i));
            b[i].grip_spin = 8;
        }
        for (double last = energy(b, count); last > 0 && k < 600; k++) {
            ll_floor_step(&env, &floor, b, count);
            double now = energy(b, count);
            assert_true(now <= last * (1 + 1e-12));
            last = now;
        }
        assert_true(k < 60 * 6); /* 4 m/s at 2 m/s2, and what a push may give */
        memcpy(rest, b, sizeof rest);
        for (int i = 0; i < 60; i++)
            ll_floor_step(&env, &floor, b, count);
        for (int i = 0; i < count; i++) {
            assert_true(b[i].vx == 0 && b[i].vy == 0 && b[i].angular_velocity == 0);
            assert_true(b[i].x == rest[i].x && b[i].y == rest[i].y && b[i].angle == rest[i].angle);
        }
    }
}

/* A disc meets a box off its centre. The impulse along the normal n at arm r = (b - centre) x n is
 * J = v / (1/m + 1/M + r^2 / I); the approach at the point ends, momentum and its moment stay. */
static void a_push_off_the_centre_turns(void **state)
{
    (void)state;
    const double m = 80, M = 20, side = 0.8, r = 0.3, v = 3, I = M * side * side / 6;
    ll_floor_body b[2] = {disc(49.2, 50 + r, 0.4, m), box(50, 50, 0, side, M)};
    ll_floor floor = floor_for(100, 6, 0.4, 0.4);
    b[0].vx = v;
    ll_floor_step(&env, &floor, b, 2);
    double J = v / (1 / m + 1 / M + r * r / I);
    assert_near(b[0].vx, (v - J / m), 1e-12);
    assert_near(b[1].vx, J / M, 1e-12);
    assert_near(b[1].angular_velocity + J * r / I, 0,
                1e-12); /* pushed above its centre along x, it turns clockwise */
    assert_true(b[0].vy == 0 && b[1].vy == 0);
}

/* Two discs head on go on together, at the speed of their centre of mass, and just touch. */
static void discs_go_on_together(void **state)
{
    (void)state;
    ll_floor_body b[2] = {disc(45, 50, 0.5, 3), disc(47.3, 50, 0.3, 1)};
    ll_floor floor = floor_for(100, 6, 0.3, 0.5);
    b[0].vx = 2;
    b[1].vx = -1;
    for (int k = 0; k < 120; k++)
        ll_floor_step(&env, &floor, b, 2);
    assert_near(b[0].vx, 1.25, 1e-12);
    assert_near(b[1].vx, 1.25, 1e-12);
    assert_near(b[1].x - b[0].x, 0.8, 1e-12);
}

/* ---- the floor ---- */

/* Sliding: v_k = v - k g h until it would pass 0, then exactly 0; x = sum of v_k h. Turning is the same. */
static void sliding_ends_where_coulomb_says(void **state)
{
    (void)state;
    ll_floor floor = floor_for(100, 12, 0.4, 0.4);
    ll_floor_body b = box(20, 20, 0.1, 0.8, 20);
    const double grip = 3.7, turn = 9.1, v = 5, w = 4;
    b.grip = grip;
    b.grip_spin = turn;
    b.vx = 0.6 * v;
    b.vy = -0.8 * v;
    b.angular_velocity = w;
    for (int k = 0; k < 120; k++)
        ll_floor_step(&env, &floor, &b, 1);
    double h = DT / floor.substeps, n = floor.substeps >= 1 ? ceil(v / (grip * h)) - 1 : 0,
           m = ceil(w / (turn * h)) - 1;
    double way = h * (n * v - grip * h * n * (n + 1) / 2), angle = h * (m * w - turn * h * m * (m + 1) / 2);
    assert_true(b.vx == 0 && b.vy == 0 && b.angular_velocity == 0);
    assert_near(b.x, (20 + 0.6 * way), 1e-11);
    assert_near(b.y, (20 - 0.8 * way), 1e-11);
    assert_near(b.angle, (0.1 + angle), 1e-11);
}

/* A body with a wanted velocity accelerates with its grip up to that velocity. */
static void a_wanted_velocity_is_reached(void **state)
{
    (void)state;
    ll_floor floor = floor_for(100, 6, 0.4, 0.4);
    ll_floor_body b = disc(20, 20, 0.4, 80);
    b.grip = 12;
    b.wanted_vx = 4;
    for (int k = 1; k <= 30; k++) {
        ll_floor_step(&env, &floor, &b, 1);
        double t = k * DT, v = 12 * t < 4 ? 12 * t : 4;
        assert_near(b.vx, v, 1e-12);
    }
    assert_true(b.vx == 4);
    b.wanted_vx = 0;
    for (int k = 1; k <= 30; k++)
        ll_floor_step(&env, &floor, &b, 1);
    assert_true(b.vx == 0);
}

/* A player pushes a row of three crates with force F = mass * grip against friction: together they accelerate
 * by (F - 3 mu m g) / (M + 3 m). Sixteen sweeps leave an error of 2 %. */
static void a_row_is_pushed_by_what_is_left_of_the_force(void **state)
{
    (void)state;
    const double M = 80, m = 20, grip = 12, mu_g = 4, side = 0.8;
    ll_floor floor = floor_for(100, 6, 0.4, 0.4);
    ll_floor_body b[4] = {disc(20, 20, 0.4, M)};
    for (int i = 1; i < 4; i++) {
        b[i] = box(20.4 + side * (i - 0.5), 20, 0, side, m);
        b[i].grip = mu_g;
        b[i].grip_spin = 10;
    }
    b[0].grip = grip;
    b[0].wanted_vx = 4;
    for (int k = 0; k < 20; k++)
        ll_floor_step(&env, &floor, b, 4);
    double a = (M * grip - 3 * m * mu_g) / (M + 3 * m), v = a * 20 * DT;
    for (int i = 0; i < 4; i++) {
        assert_near(b[i].vx, v, 0.02 * v);
        assert_near(b[i].vy, 0, 2e-4 * v); /* sixteen sweeps leave the boxes turning ever so little */
    }
}

/* Too weak to move the crate: player and crate stay, except for the error of sixteen sweeps. */
static void a_player_too_weak_to_push_stays(void **state)
{
    (void)state;
    ll_floor floor = floor_for(100, 6, 0.4, 0.4);
    ll_floor_body b[2] = {disc(20, 20, 0.4, 20), box(20.8, 20, 0, 0.8, 200)};
    b[0].grip = 10;
    b[0].wanted_vx = 4;
    b[1].grip = 4; /* 800 N against 200 N */
    for (int k = 0; k < 60; k++)
        ll_floor_step(&env, &floor, b, 2);
    assert_true(b[1].x - 20.8 < 0.001 && b[1].vx == 0);
    assert_true(b[0].vx < 1e-6 * 10 * DT);
}

/* ---- nothing passes ---- */

static ll_geometry outline(const ll_floor_body *b)
{
    ll_geometry g;
    ll_status status = b->round ? ll_shape_circle(ll_vec(0, 0), b->half, &g)
                                : ll_shape_box(2 * b->half, 2 * b->half, ll_vec(0, 0), 0, &g);
    assert_false(ll_failed(&status));
    return g;
}

static ll_pose pose(const ll_floor_body *b)
{
    return (ll_pose){{b->x, b->y}, {cos(b->angle), sin(b->angle)}};
}

/* Largest overlap of two bodies, and of a body with a wall. */
static double deepest(const ll_floor_body *b, int count, double side)
{
    double most = 0;
    for (int i = 0; i < count; i++) {
        ll_geometry g = outline(&b[i]);
        ll_aabb box = ll_shape_aabb(&g, pose(&b[i]));
        most =
            larger(most, larger(-smaller(box.lower.x, box.lower.y), larger(box.upper.x, box.upper.y) - side));
        for (int j = i + 1; j < count; j++) {
            ll_geometry other = outline(&b[j]);
            ll_manifold m = ll_collide(&g, &other, ll_pose_between(pose(&b[i]), pose(&b[j])), 0);
            for (int n = m.count; n-- > 0;)
                most = larger(most, -m.at[n].separation);
        }
    }
    return most;
}

/* The fastest and strongest player rams a wall of small light crates that stand against the arena's wall. */
static void nothing_passes_through_anything(void **state)
{
    (void)state;
    const double sides[] = {0.2, 0.5};
    for (size_t s = 0; s < 2; s++) {
        double side = sides[s];
        ll_floor_body b[MAX] = {disc(1, 5, 0.3, 1000)};
        int count = 1;
        for (int row = 0; row < 2; row++)
            for (double y = side / 2; y < 10 && count < MAX; y += side) {
                b[count] = box(10 - side * (row + 0.5), y, 0, side, 1);
                b[count].grip = 4;
                b[count++].grip_spin = 20;
            }
        ll_floor floor = floor_for(10, 30, side / 2, side > 0.6 ? side / 2 : 0.3);
        b[0].grip = 100;
        b[0].wanted_vx = 20;
        for (int k = 0; k < 240; k++) {
            ll_floor_step(&env, &floor, b, count);
            assert_true(b[0].x < 10 - 0.3 + 0.01);
            for (int i = 1; i < count; i++)
                assert_true(b[i].x > 0 && b[i].x < 10 && b[i].y > 0 && b[i].y < 10);
        }
        assert_true(b[0].x > 9); /* it has come through to the wall, between the crates */
        b[0].wanted_vx = 0;
        for (int k = 0; k < 120; k++)
            ll_floor_step(&env, &floor, b, count);
        assert_true(deepest(b, count, 10) < LL_LINEAR_SLOP + 1e-5);
    }
}

/* A step that is long for the speed is cut, so that a body cannot be beyond another at its end. */
static void long_steps_are_cut(void **state)
{
    (void)state;
    const ll_game_env slow = {.dt = 0.5};
    ll_floor_body b[2] = {disc(2, 10, 0.2, 80), box(9, 10, 0.4, 0.4, 80)};
    ll_floor floor = {.width = 20,
                      .depth = 20,
                      .top_speed = 20,
                      .half_max = 0.2,
                      .substeps = ll_floor_substeps(0.5, 20, 0.2)};
    b[0].grip = 100;
    b[0].wanted_vx = 15;
    for (int k = 0; k < 8; k++) {
        ll_floor_step(&slow, &floor, b, 2);
        assert_true(b[0].x < b[1].x || fabs(b[0].y - b[1].y) > 0.1);
    }
    assert_true(b[1].x > 12);
}

/* ---- the same again ---- */

static void steps_are_repeatable_and_local(void **state)
{
    (void)state;
    ll_floor_body a[MAX], b[MAX];
    int count = thrown(a, 7, 12, 5);
    ll_floor floor = floor_for(40, 30, 0.2, 0.5);
    memcpy(b, a, sizeof a);
    for (int k = 0; k < 100; k++) {
        ll_floor_step(&env, &floor, a, count);
        ll_floor_step(&env, &floor, b, count);
    }
    assert_memory_equal(a, b, (size_t)count * sizeof a[0]);
    /* with others far away among them, the first heap does what it did */
    ll_floor_body apart[MAX], alone[MAX / 2];
    int half = thrown(apart, 7, 12, 5) / 2;
    for (int i = 0; i < half; i++) {
        alone[i] = apart[i];
        apart[i + half] = apart[i];
        apart[i + half].x += 25;
        apart[i + half].vx += 1;
    }
    ll_floor_body mixed[MAX];
    for (int i = 0; i < half; i++) {
        mixed[2 * i] = apart[i + half];
        mixed[2 * i + 1] = apart[i];
    }
    for (int k = 0; k < 100; k++) {
        ll_floor_step(&env, &floor, alone, half);
        ll_floor_step(&env, &floor, mixed, 2 * half);
    }
    for (int i = 0; i < half; i++)
        assert_memory_equal(&alone[i], &mixed[2 * i + 1], offsetof(ll_floor_body, pressed_by));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(momentum_stays_and_energy_does_not_grow),
        cmocka_unit_test(everything_comes_to_rest),
        cmocka_unit_test(a_push_off_the_centre_turns),
        cmocka_unit_test(discs_go_on_together),
        cmocka_unit_test(sliding_ends_where_coulomb_says),
        cmocka_unit_test(a_wanted_velocity_is_reached),
        cmocka_unit_test(a_row_is_pushed_by_what_is_left_of_the_force),
        cmocka_unit_test(a_player_too_weak_to_push_stays),
        cmocka_unit_test(nothing_passes_through_anything),
        cmocka_unit_test(long_steps_are_cut),
        cmocka_unit_test(steps_are_repeatable_and_local),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

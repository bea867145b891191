/* How others are drawn: methods, delays, time scales and extrapolation, compared with closed forms. */
#include "netcode/drawn.h"

#include "game/games/games.h"
#include "netcode/view/view.h"
#include "support/near.h"

/* ---- methods ---- */

/* p0 + p1 t + p2 t^2 + p3 t^3, and its derivative. */
static void polynomial(const double p[4], double t, double *place, double *speed)
{
    *place = p[0] + t * (p[1] + t * (p[2] + t * p[3]));
    *speed = p[1] + t * (2 * p[2] + t * 3 * p[3]);
}

static ll_entity on_polynomials(const double p[3][4], double t)
{
    ll_entity e = {0};
    polynomial(p[0], t, &e.x, &e.vx);
    polynomial(p[1], t, &e.y, &e.vy);
    polynomial(p[2], t, &e.angle, &e.angular_velocity);
    return e;
}

static bool same(const ll_entity *a, const ll_entity *b, double tolerance)
{
    const double d[] = {a->x - b->x,   a->y - b->y,         a->vx - b->vx,
                        a->vy - b->vy, a->angle - b->angle, a->angular_velocity - b->angular_velocity};
    for (int i = 0; i < 6; i++)
        if (!(fabs(d[i]) <= tolerance))
            return false;
    return true;
}

/* Hermite interpolation reproduces every cubic, and so constant acceleration, to rounding. */
static void hermite_is_exact_for_cubics(void **state)
{
    (void)state;
    const double cubics[3][4] = {{3, -20, 4, 7}, {-1, 5, -9.81 / 2, 0}, {0.5, 2, 0, -3}};
    const double spans[] = {1.0 / 120, 1.0 / 30, 0.25, 1};
    for (size_t i = 0; i < sizeof spans / sizeof spans[0]; i++)
        for (int k = 0; k <= 16; k++) {
            double t0 = 0.3, alpha = k / 16.0;
            ll_entity a = on_polynomials(cubics, t0), b = on_polynomials(cubics, t0 + spans[i]), out = a;
            ll_entity want = on_polynomials(cubics, t0 + alpha * spans[i]);
            ll_interpolation_hermite.between(&a, &b, alpha, spans[i], &out);
            /* Positions have rounding errors of 1e-15; speeds divide their differences by the span. */
            assert_true(same(&out, &want, 1e-14 / spans[i]));
        }
}

/* sin t has a fourth derivative of at most 1: the error is at most dt^4 / 384. */
static void hermite_keeps_its_bound(void **state)
{
    (void)state;
    double worst = 0, dt = 0.5;
    for (double t0 = 0; t0 < 6.3; t0 += 0.1)
        for (int k = 0; k <= 16; k++) {
            ll_entity a = {.x = sin(t0), .vx = cos(t0)}, b = {.x = sin(t0 + dt), .vx = cos(t0 + dt)}, out = a;
            ll_interpolation_hermite.between(&a, &b, k / 16.0, dt, &out);
            worst = larger(worst, fabs(out.x - sin(t0 + k / 16.0 * dt)));
        }
    assert_true(worst <= dt * dt * dt * dt / 384);
    assert_true(worst > 0.95 * dt * dt * dt * dt / 384); /* the bound is nearly reached */
}

/* Under constant acceleration a the chord is off by a dt^2 / 8 in its middle, and by less elsewhere. */
static void linear_is_off_by_its_bound(void **state)
{
    (void)state;
    const double a = 6, dt = 1.0 / 30, fall[3][4] = {{1, 16, a / 2, 0}, {0}, {0}};
    ll_entity p = on_polynomials(fall, 0.2), q = on_polynomials(fall, 0.2 + dt), out = p;
    for (int k = 0; k <= 16; k++) {
        double s = k / 16.0;
        ll_entity truth = on_polynomials(fall, 0.2 + s * dt);
        ll_interpolation_linear.between(&p, &q, s, dt, &out);
        assert_near(out.x - truth.x, a * dt * dt / 2 * s * (1 - s), 1e-14);
        assert_near(out.vx, truth.vx, 1e-13); /* the speed is linear, and so is its chord */
    }
    ll_interpolation_linear.between(&p, &q, 0.5, dt, &out);
    assert_near(out.x - on_polynomials(fall, 0.2 + dt / 2).x, a * dt * dt / 8, 1e-14);
}

static double swing(ll_time t)
{
    return 10 * sin(3 * ll_to_s(t));
}

static void swinging(int64_t k, ll_time time, ll_entity *other)
{
    (void)k;
    other->x = swing(time);
    other->vx = 30 * cos(3 * ll_to_s(time));
}

static double worst_off;

static void look_off(view *v)
{
    if (v->now > LL_SECOND / 2)
        worst_off = larger(worst_off, fabs(other(v)->x - swing(shown_time(v))));
}

/* As a client draws it: |a| <= 90 m/s2, |x''''| <= 810 m/s4, snapshots 1/30 s apart. */
static void methods_keep_their_bounds_in_a_view(void **state)
{
    (void)state;
    const double dt = 1.0 / RATE, bounds[] = {90 * dt * dt / 8, 810 * dt * dt * dt * dt / 384};
    for (int method = 0; method < 2; method++) {
        view *v = new_view(&ll_sync_free);
        v->path = swinging;
        v->l->config.interpolation_method = method;
        v->l->config.jitter_margin_ms = 3.7; /* so that frames fall at all positions between snapshots */
        worst_off = 0;
        run(v, 20 * LL_SECOND, lag_50, look_off);
        assert_true(worst_off <= bounds[method] * (1 + 1e-6) && worst_off > bounds[method] * 0.9);
        free_view(v);
    }
}

/* ---- extrapolation ---- */

static void steady(int64_t k, ll_time time, ll_entity *other)
{
    (void)k;
    other->x = 20 * ll_to_s(time);
    other->y = -3 * ll_to_s(time);
    other->vx = 20;
    other->vy = -3;
    other->angle = ll_to_s(time);
    other->angular_velocity = 1;
}

static ll_time silent_from_2s(int64_t k)
{
    return k > 60 ? LL_NEVER : 50 * LL_MS;
}

static double cap_ms;
static int extrapolated, held;

static void look_silent(view *v)
{
    if (v->now < LL_SECOND)
        return;
    ll_time last = 2 * LL_SECOND, due = v->now - 50 * LL_MS - DELAY, reach = last + ll_ms(cap_ms);
    ll_time want = due < reach ? due : reach;
    uint32_t flags = due <= last    ? LL_RENDERED_INTERPOLATED
                     : due <= reach ? LL_RENDERED_EXTRAPOLATED
                     : cap_ms > 0   ? LL_RENDERED_EXTRAPOLATED | LL_RENDERED_HELD
                                    : LL_RENDERED_INTERPOLATED | LL_RENDERED_HELD;
    if (due - last <= 2 && last - due <= 2)
        return; /* to a nanosecond */
    assert_true(about(shown_time(v), want));
    assert_near(other(v)->x, 20 * ll_to_s(want), 1e-6);
    assert_near(other(v)->y + 3 * ll_to_s(want), 0, 1e-6);
    assert_near(other(v)->angle, ll_to_s(want), 1e-7);
    assert_int_equal(shown_flags(v), flags);
    extrapolated += v->l->client->view.state == LL_VIEW_EXTRAPOLATING;
    held += v->l->client->view.state == LL_VIEW_STARVED;
}

/* The server falls silent: others continue at their velocity up to the limit, exact to the frame, and are
 * held there. */
static void extrapolation_ends_at_its_cap(void **state)
{
    (void)state;
    const double caps[] = {0, 100, 250, 1000};
    for (size_t i = 0; i < sizeof caps / sizeof caps[0]; i++) {
        view *v = new_view(&ll_sync_free);
        v->path = steady;
        v->l->config.extrapolation_ms = cap_ms = caps[i];
        extrapolated = held = 0;
        run(v, 5 * LL_SECOND, silent_from_2s, look_silent);
        assert_near(extrapolated, cap_ms * 0.06, 1); /* 60 frames per second */
        assert_true(held > 60);
        assert_int_equal(v->l->client_metrics->buffer.underruns,
                         1); /* one, whether extrapolation goes on or not */
        free_view(v);
    }
}

/* Without interpolation there is no delay: others are drawn at the server's present by the measured clock, or
 * at the time of the fastest snapshot. Both extrapolate all the time (dead reckoning). */
static void without_interpolation_others_are_drawn_at_present(void **state)
{
    (void)state;
    const ll_time late[] = {[LL_CLOCK_MEASURED] = 0, [LL_CLOCK_ARRIVAL] = 50 * LL_MS};
    for (int32_t clock = LL_CLOCK_MEASURED; clock <= LL_CLOCK_ARRIVAL; clock++) {
        view *v = new_view(&ll_sync_free);
        v->path = steady;
        v->l->config.interpolation = false;
        v->l->config.extrapolation_clock = clock;
        v->l->config.extrapolation_ms = 250;
        run(v, 3 * LL_SECOND, lag_50, NULL);
        assert_true(about(shown_time(v), v->now - late[clock]));
        assert_near(other(v)->x, 20 * ll_to_s(v->now - late[clock]), 1e-6);
        assert_int_equal(v->l->client_metrics->buffer.underruns,
                         0); /* there is no buffer that could run empty */
        v->l->config.extrapolation_ms = 0;
        run(v, 4 * LL_SECOND, lag_50, NULL);
        assert_true(shown_time(v) == newest_time(v));
        assert_int_equal(v->l->client->view.state, LL_VIEW_NEWEST);
        free_view(v);
    }
}

/* The demo's rules have no extrapolation. */
static void demo_does_not_extrapolate(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_gambetta);
    v->path = steady;
    v->l->config.extrapolation_ms = 1000;
    for (int interpolation = 0; interpolation < 2; interpolation++) {
        v->l->config.interpolation = interpolation;
        run(v, (3 + interpolation) * LL_SECOND, silent_from_2s, NULL);
        assert_true(other(v)->x <= 40);
        assert_int_equal(shown_flags(v) & LL_RENDERED_EXTRAPOLATED, 0);
    }
    free_view(v);
}

/* A projectile continues under gravity and drag as the game itself moves it, for any step, and stays above
 * ground. */
static void projectiles_coast_as_they_fly(void **state)
{
    (void)state;
    double params[16];
    ll_game_env env = {.dt = 1.0 / 60};
    ll_param_defaults(ll_game_cannon.params, params);
    ll_game_cannon.prepare(&env, params);
    ll_extent extent = ll_game_cannon.extent(params, 1);
    ll_world *world = calloc(1, ll_extent_size(extent));
    *world = (ll_world){1, 1, extent.tail, 0};
    world->entity[0] = (ll_entity){.vx = 40, .vy = 30, .flags = LL_ENTITY_ACTIVE};
    ll_entity start = world->entity[0], coasted = start;
    for (int i = 0; i < 30; i++)
        ll_game_cannon.step_own(world, &env, 0, &(ll_action){0});
    ll_game_cannon.coast(&env, &coasted, 0.5);
    assert_true(coasted.x > 10 && coasted.y > 5);
    assert_true(same(&coasted, &world->entity[0], 1e-12 * 100));
    coasted = start;
    ll_game_cannon.coast(&env, &coasted, 100);
    assert_true(coasted.y == 0 && coasted.vx == 0);
    start.flags = 0; /* at rest */
    coasted = start;
    ll_game_cannon.coast(&env, &coasted, 1);
    assert_memory_equal(&coasted, &start, sizeof start);
    free(world);
}

/* ---- the adaptive delay ---- */

/* Under a link without jitter the delay comes down to one interval and the margin, by at most a tenth of a
 * frame per frame: 33 ms take 20 frames. */
static void adaptive_delay_converges(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    v->l->config.interpolation_delay = 1;
    run(v, 60 * LL_MS, lag_50, NULL);
    ll_time before = DELAY;
    for (int f = 0; f < 60; f++) {
        run(v, ll_tick_time(v->frames + 1, HZ(60)), lag_50, NULL);
        ll_time fall = before - v->l->client->view.delay;
        assert_true(fall >= -1 && fall <= LL_SECOND / 600 + 1);
        before = v->l->client->view.delay;
    }
    assert_true(about(before, LL_SECOND / RATE + 10 * LL_MS));
    run(v, 10 * LL_SECOND, lag_50, NULL);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - LL_SECOND / RATE - 10 * LL_MS));
    assert_int_equal(v->l->client_metrics->buffer.underruns, 0);
    free_view(v);
}

#define JITTER 15 /* ms to either side: below half an interval, so that no snapshot overtakes another */

static ll_time jittered(int64_t k)
{
    return 100 * LL_MS + (ll_time)((2 * ll_rng_unit(5, 0, (uint64_t)k) - 1) * JITTER * 1e6);
}

static double gap_sum, deviation_sum, late_sum, delay_sum;
static int64_t delay_frames, delay_states, delay_taken;

static void look_delay(view *v)
{
    if (v->now < 5 * LL_SECOND)
        return;
    delay_sum += ll_to_ms(v->l->client->view.delay);
    delay_frames++;
    if (v->taken == delay_taken)
        return;
    delay_taken = v->taken;
    delay_states++;
    gap_sum += v->l->client->arrivals.gap / 1e6;
    deviation_sum += v->l->client->arrivals.gap_deviation / 1e6;
    late_sum += v->l->client->arrivals.late / 1e6;
}

/* Uniform jitter of +-J. A gap is an interval on average. It is compared with an average of gain g = 1/4 that
 * itself varies: gap - average = j_k - (1 + g) j_(k-1) + terms of g^2, whose mean magnitude is J ((1 + g) / 2
 * + 1 / (6 (1 + g))) = 0.758 J without these terms. Relative to the fastest of the last 2 s, 50 to 60
 * snapshots, a snapshot is late by J (1 - 2 / 57) on average. The delay moves too slowly to follow every peak
 * of these, and peaks are higher than valleys are deep: it is a little less than their sum on average. */
static void adaptive_delay_follows_jitter(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    v->l->config.interpolation_delay = 1;
    gap_sum = deviation_sum = late_sum = delay_sum = delay_frames = delay_states = 0;
    run(v, 120 * LL_SECOND, jittered, look_delay);
    double n = (double)delay_states, interval = 1000.0 / RATE, deviation = JITTER * (1.25 / 2 + 1 / 7.5);
    double late = JITTER * (1 - 2.0 / 57), want = interval + 1.25 * deviation + late + 10;
    /* Within four times the standard error of 3450 snapshots. */
    assert_near(gap_sum / n, interval, 0.02 * JITTER);
    assert_near(deviation_sum / n, deviation, 0.04 * JITTER);
    assert_near(late_sum / n, late, 0.04 * JITTER);
    double mean = delay_sum / (double)delay_frames;
    assert_true(mean < want && mean > want - 2);
    assert_true(v->l->client_metrics->buffer.underruns <
                20); /* the worst case would need an interval + 2 J + margin */
    free_view(v);
}

static ll_time mostly_lost(int64_t k)
{
    return k > 90 && k % 12 != 0 ? LL_NEVER : 50 * LL_MS; /* gaps of 400 ms: twelve intervals */
}

static void adaptive_delay_is_capped(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    v->l->config.interpolation_delay = 1;
    run(v, 60 * LL_SECOND, mostly_lost, NULL);
    assert_true(about(v->l->client->view.delay, 6 * LL_SECOND / RATE + 10 * LL_MS));
    free_view(v);
}

/* ---- the time scale catch_up ---- */

static ll_time falls_by_70(int64_t k)
{
    return (k < 90 ? 120 : 50) * LL_MS;
}

static ll_time rises_by_60(int64_t k)
{
    return (k < 90 ? 50 : 110) * LL_MS;
}

static int faster, slower, even;

static void look_scale(view *v)
{
    double scale = v->l->client->drawing.time_scale;
    if (v->now < LL_SECOND || shown_flags(v) & LL_RENDERED_HELD)
        return;
    assert_true(fabs(scale - 1) < 1e-6 || fabs(scale - 1.02) < 1e-6 || fabs(scale - 0.96) < 1e-6);
    faster += scale > 1.01;
    slower += scale < 0.99;
    even += scale > 0.99 && scale < 1.01;
    assert_int_equal(v->l->client->view.state, scale > 1.01   ? LL_VIEW_CATCHING_UP
                                               : scale < 0.99 ? LL_VIEW_SLOWING
                                                              : LL_VIEW_NORMAL);
}

/* A link that gets faster by 70 ms: render time runs 2 % faster from where the error averaged over a second
 * exceeds one interval until it has come down to it. A link that gets slower by 60 ms, which the buffer
 * covers: when the fast packets are forgotten it runs 4 % slower. */
static void catch_up_has_three_speeds(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    v->l->config.time_scale = 1;
    faster = slower = even = 0;
    run(v, 30 * LL_SECOND, falls_by_70, look_scale);
    double behind = 70, average = 0;
    int frames = 0;
    for (int f = 0; f < 27 * 60; f++) {
        average += (behind - average) / 60;
        if (average > 1000.0 / RATE) {
            behind -= 0.02 * 1000 / 60;
            frames++;
        }
    }
    assert_in_range(faster, frames - 2, frames + 2);
    assert_true(slower == 0 && even > 1200);
    ll_time error = v->now - 50 * LL_MS - DELAY - shown_time(v);
    assert_in_range(error, 0, LL_SECOND / RATE);
    assert_int_equal(v->l->client_metrics->buffer.overruns, 0);
    free_view(v);
    v = new_view(&ll_sync_free);
    v->l->config.time_scale = 1;
    faster = slower = even = 0;
    run(v, 30 * LL_SECOND, rises_by_60, look_scale);
    assert_true(slower > 5 && faster == 0);
    error = shown_time(v) - (v->now - 110 * LL_MS - DELAY);
    assert_in_range(error, 0, LL_SECOND / RATE);
    free_view(v);
}

static ll_time falls_by_120(int64_t k)
{
    return (k < 90 ? 170 : 50) * LL_MS;
}

/* Further behind than one delay it jumps, once. */
static void catch_up_jumps_beyond_a_delay(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    v->l->config.time_scale = 1;
    run(v, 6 * LL_SECOND, falls_by_120, NULL);
    assert_int_equal(v->l->client_metrics->buffer.overruns, 1);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - DELAY));
    free_view(v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hermite_is_exact_for_cubics),
        cmocka_unit_test(hermite_keeps_its_bound),
        cmocka_unit_test(linear_is_off_by_its_bound),
        cmocka_unit_test(methods_keep_their_bounds_in_a_view),
        cmocka_unit_test(extrapolation_ends_at_its_cap),
        cmocka_unit_test(without_interpolation_others_are_drawn_at_present),
        cmocka_unit_test(demo_does_not_extrapolate),
        cmocka_unit_test(projectiles_coast_as_they_fly),
        cmocka_unit_test(adaptive_delay_converges),
        cmocka_unit_test(adaptive_delay_follows_jitter),
        cmocka_unit_test(adaptive_delay_is_capped),
        cmocka_unit_test(catch_up_has_three_speeds),
        cmocka_unit_test(catch_up_jumps_beyond_a_delay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

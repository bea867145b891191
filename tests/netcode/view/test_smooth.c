/* Prediction smoothing: in the view, by half-lives, at any frame rate; never in the state. */
#include "netcode/drawn.h"
#include "support/near.h"

#define HALF_LIFE 80 /* ms */

/* A predicting client at rest at x = 0 whom the server puts elsewhere at 100 ms. */
static lone *corrected(double hz, int correction, double to)
{
    lone *l = new_lone(1, &toy, &ll_sync_free);
    packet p = state_of(1, 50 * LL_MS, 0, 1, (double[]){to});
    p.entity[0].y = -to / 4;
    p.entity[0].angle = to / 8;
    l->config.prediction = l->config.reconciliation = true;
    l->config.correction = correction;
    l->config.correction_half_life_ms = HALF_LIFE;
    start_lone(l, hz, 0, 0);
    for (int64_t f = 0; ll_tick_time(f, ll_freq_from_hz(hz)) < 100 * LL_MS; f++)
        frame(l, ll_tick_time(f, ll_freq_from_hz(hz)), NULL);
    give(l, &p, 99 * LL_MS);
    return l;
}

static double drawn(const lone *l)
{
    return ll_client_rendered(l->client)->entity[0].x;
}

/* The error in the last frame before the snapshot decays to 2^(-t / half-life) of it after t, with any frames
 * in between. */
static void errors_halve_in_a_half_life(void **state)
{
    (void)state;
    const double rates[] = {10, 20, 40, 60, 64};
    for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++) {
        ll_freq freq = ll_freq_from_hz(rates[i]);
        lone *l = corrected(rates[i], LL_CORRECTION_SMOOTH, 2);
        int64_t first = ll_tick_at(100 * LL_MS - 1, freq) + 1;
        double last_ms = ll_to_ms(ll_tick_time(first - 1, freq));
        for (int64_t f = first; ll_tick_time(f, freq) <= 700 * LL_MS; f++) {
            ll_time now = ll_tick_time(f, freq);
            frame(l, now, NULL);
            double want = 2 - 2 * exp2(-(ll_to_ms(now) - last_ms) / HALF_LIFE);
            const ll_entity *e = &ll_client_rendered(l->client)->entity[0];
            assert_near(e->x, want, 1e-12);
            assert_near(e->y + want / 4, 0, 1e-12);
            assert_near(e->angle, want / 8, 1e-12);
            assert_true(ll_client_predicted(l->client)->entity[0].x == 2); /* the state is right at once */
        }
        free_lone(l);
    }
}

static void frames_may_be_uneven(void **state)
{
    (void)state;
    lone *l = corrected(60, LL_CORRECTION_SMOOTH, 2);
    double last_ms = ll_to_ms(ll_tick_time(5, HZ(60)));
    const int at[] = {100, 101, 130, 131, 180, 400};
    for (size_t i = 0; i < sizeof at / sizeof at[0]; i++) {
        frame(l, at[i] * LL_MS, NULL);
        assert_near(drawn(l) - 2 + 2 * exp2(-(at[i] - last_ms) / HALF_LIFE), 0, 1e-12);
    }
    free_lone(l);
}

static ll_summary pops(const lone *l)
{
    return ll_histogram_summary(&l->client_metrics->histogram[LL_METRIC_POP]);
}

/* Pop: how far a correction moves the rendered view, per frame: all at once, or in parts whose sum is the
 * same. */
static void pops_match_the_drawn_motion(void **state)
{
    (void)state;
    lone *a = corrected(50, LL_CORRECTION_SNAP, 2), *b = corrected(50, LL_CORRECTION_SMOOTH, 2);
    for (int f = 5; f < 200; f++) {
        frame(a, f * 20 * LL_MS, NULL);
        frame(b, f * 20 * LL_MS, NULL);
    }
    const double size = 2 * sqrt(17.0 / 16); /* 2 m to the right, half a metre down */
    assert_near(pops(a).max, size, 1e-12);
    assert_true(pops(a).count == 200);
    assert_near(pops(b).max, size * (1 - exp2(-20.0 / HALF_LIFE)), 1e-12); /* the first part */
    assert_near(pops(a).mean * 200, size, 1e-9);
    assert_near(pops(b).mean * 200, size, 1e-4);
    assert_true(drawn(b) == 2); /* bitwise in the end */
    free_lone(a);
    free_lone(b);
}

/* A second correction adds to the rest of the first. */
static void corrections_add_up(void **state)
{
    (void)state;
    lone *l = corrected(50, LL_CORRECTION_SMOOTH, 2);
    packet p = state_of(3, 150 * LL_MS, 0, 1, (double[]){1});
    for (int f = 5; f <= 10; f++) {
        if (f == 8)
            give(l, &p, 159 * LL_MS);
        frame(l, f * 20 * LL_MS, NULL);
    }
    double rest = 2 * exp2(-60.0 / HALF_LIFE) - 1; /* drawn at 140 ms, relative to the correct 1 */
    assert_near(drawn(l), (1 - rest * exp2(-60.0 / HALF_LIFE)), 1e-12);
    free_lone(l);
}

/* An error above the limit is a jump; half a millimetre below it is smoothed. */
static void large_errors_jump(void **state)
{
    (void)state;
    const double largest = LL_SMOOTH_MAX_M / sqrt(17.0 / 16);
    lone *a = corrected(50, LL_CORRECTION_SMOOTH, largest + 0.0005),
         *b = corrected(50, LL_CORRECTION_SMOOTH, largest - 0.0005);
    frame(a, 100 * LL_MS, NULL);
    frame(b, 100 * LL_MS, NULL);
    assert_true(drawn(a) == largest + 0.0005);
    assert_true(drawn(b) < 1);
    free_lone(a);
    free_lone(b);
}

/* Switched off while an error decays, it is gone at once. */
static void snapping_may_be_switched_on(void **state)
{
    (void)state;
    lone *l = corrected(50, LL_CORRECTION_SMOOTH, 2);
    frame(l, 100 * LL_MS, NULL);
    l->config.correction = LL_CORRECTION_SNAP;
    frame(l, 120 * LL_MS, NULL);
    assert_true(drawn(l) == 2);
    free_lone(l);
}

/* ---- others ---- */

/* 20 m/s to 1.9 s, then at rest: the extrapolation over the silence was wrong. */
static double stopping_at(ll_time t)
{
    return 20 * smaller(ll_to_s(t), 1.9);
}

static void stopping(int64_t k, ll_time time, ll_entity *other)
{
    (void)k;
    other->x = stopping_at(time);
    other->vx = time < 1900 * LL_MS ? 20 : 0;
}

static ll_time silent_over_the_stop(int64_t k)
{
    return k >= 57 && k < 64 ? LL_NEVER
                             : 50 * LL_MS; /* the last snapshot before is of 56/30 s, the next of 64/30 */
}

static double before, worst_step, last_error;

static void look_stop(view *v)
{
    double right = stopping_at(shown_time(v));
    if (v->now > LL_SECOND) {
        worst_step = larger(worst_step, fabs(other(v)->x - before - (before > 0 ? 20.0 / 60 : 0)));
        last_error = other(v)->x - right;
    }
    before = other(v)->x;
}

static double run_over_the_stop(int correction, ll_time until)
{
    view *v = new_view(&ll_sync_free);
    v->path = stopping;
    v->l->config.extrapolation_ms = 500;
    v->l->config.correction = correction;
    v->l->config.correction_half_life_ms = HALF_LIFE;
    before = worst_step = last_error = 0;
    run(v, until, silent_over_the_stop, look_stop);
    double pop = ll_histogram_summary(&v->l->client_metrics->histogram[LL_METRIC_POP]).max;
    free_view(v);
    return pop;
}

/* The snapshot of 64/30 s arrives at 2183 ms. The frame before it, of 2166.7 ms, drew 2166.7 - 50 - 76.7 =
 * 2040 ms by extrapolation: 20 m/s x (2040 - 1866.7 ms) from 37.33 m is 40.8 m. Between the snapshots of
 * 1866.7 and 2133.3 ms that time lies at fraction 0.65 of the way to 38 m: 37.767 m. */
static void wrong_extrapolations_are_corrected(void **state)
{
    (void)state;
    const double error = 40.8 - (20 * 56.0 / 30 + 0.65 * (38 - 20 * 56.0 / 30)), frame_ms = 1000.0 / 60;
    assert_near(run_over_the_stop(LL_CORRECTION_SNAP, 4 * LL_SECOND), error, 1e-6);
    double part = error * (1 - exp2(-frame_ms / HALF_LIFE));
    assert_near(run_over_the_stop(LL_CORRECTION_SMOOTH, 4 * LL_SECOND), part, 1e-6);
    /* At 2500 ms, 20 frames after the wrong one; by then the drawn snapshot is at rest. */
    run_over_the_stop(LL_CORRECTION_SMOOTH, 2500 * LL_MS + 1);
    assert_near(last_error, error * exp2(-20 * frame_ms / HALF_LIFE), 1e-5);
}

static void steady(int64_t k, ll_time time, ll_entity *other)
{
    (void)k;
    other->x = 20 * ll_to_s(time);
    other->vx = 20;
}

static ll_time wild(int64_t k)
{
    return (ll_time)(ll_rng_unit(5, 0, (uint64_t)k) * 300) * LL_MS;
}

/* Extrapolation of steady motion is right: there is nothing to correct, however late snapshots arrive. */
static void right_extrapolations_are_not(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    v->path = steady;
    v->l->config.extrapolation_ms = 1000;
    v->l->config.correction = LL_CORRECTION_SMOOTH;
    run(v, 30 * LL_SECOND, wild, NULL);
    assert_true(v->l->client_metrics->buffer.underruns > 20);
    assert_true(pops(v->l).max < 1e-9);
    free_view(v);
}

/* A flight that ended while it was extrapolated: the projectile is at once where it fell. */
static void ended_flights_are_not_smoothed(void **state)
{
    (void)state;
    lone *l = new_lone(2, &toy, &ll_sync_free);
    ll_entity flying = {.x = 3, .flags = LL_ENTITY_ACTIVE}, landed = {.x = 1};
    start_lone(l, 60, 0, 0);
    l->config.correction = LL_CORRECTION_SMOOTH;
    ll_smooth_correct(l->client, 1, &flying, &landed);
    frame(l, 0, NULL);
    assert_true(ll_client_rendered(l->client)->entity[1].x == 0 && pops(l).max == 0);
    free_lone(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_halve_in_a_half_life),
        cmocka_unit_test(frames_may_be_uneven),
        cmocka_unit_test(pops_match_the_drawn_motion),
        cmocka_unit_test(corrections_add_up),
        cmocka_unit_test(large_errors_jump),
        cmocka_unit_test(snapping_may_be_switched_on),
        cmocka_unit_test(wrong_extrapolations_are_corrected),
        cmocka_unit_test(right_extrapolations_are_not),
        cmocka_unit_test(ended_flights_are_not_smoothed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The others as drawn: between which snapshots, and at which time. */
#include "netcode/drawn.h"
#include "support/near.h"

/* What is drawn lies on the line between the two snapshots around its time, by a search from the
 * beginning. */
static void is_between_its_states(const view *v)
{
    ll_time t = shown_time(v);
    int64_t i = v->taken - 1;
    while (i > 0 && v->time[v->order[i]] > t)
        i--;
    int64_t a = v->order[i], b = i + 1 < v->taken ? v->order[i + 1] : a;
    assert_true(v->time[a] <= t && (a == b || v->time[b] > t));
    double alpha = a == b ? 0 : (double)(t - v->time[a]) / (double)(v->time[b] - v->time[a]);
    assert_near(other(v)->x, (v->x[a] + alpha * (v->x[b] - v->x[a])), 1e-9);
    assert_near(v->l->client->drawing.alpha, alpha, 1e-12);
    assert_near(v->l->client->drawing.buffer_ms, ll_to_ms(newest_time(v) - t), 1e-9);
}

/* ---- a steady link ---- */

static void look_steady(view *v)
{
    if (v->now < LL_SECOND / 2)
        return;
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - DELAY));
    assert_int_equal(ll_client_draw_infos(v->l->client)[1].flags, LL_RENDERED_INTERPOLATED);
    is_between_its_states(v);
}

static void steady_links_are_drawn_one_delay_back(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    run(v, 10 * LL_SECOND, lag_50, look_steady);
    assert_int_equal(v->l->client_metrics->buffer.underruns, 0);
    assert_true(v->taken > 290);
    free_view(v);
}

/* Ratio and margin may change during a run: render time moves to its new target without a jump. */
static void delay_follows_its_settings(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    run(v, 3 * LL_SECOND, lag_50, NULL);
    v->l->config.interpolation_ratio = 4;
    v->l->config.jitter_margin_ms = 35;
    run(v, 6 * LL_SECOND, lag_50, NULL);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - 4 * LL_SECOND / RATE - 35 * LL_MS));
    v->l->config.interpolation_ratio = 1;
    v->l->config.jitter_margin_ms = 0;
    run(v, 9 * LL_SECOND, lag_50, NULL);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - LL_SECOND / RATE));
    is_between_its_states(v);
    free_view(v);
}

/* ---- a buffer that runs empty ---- */

static ll_time gap(int64_t k)
{
    return k >= 60 && k < 66 ? LL_NEVER
                             : 50 * LL_MS; /* 7 intervals, 233 ms, without a snapshot from 2 s on */
}

static void look_dry(view *v)
{
    bool held = ll_client_draw_infos(v->l->client)[1].flags & LL_RENDERED_HELD;
    if (v->now < LL_SECOND / 2)
        return;
    assert_true(shown_time(v) <= newest_time(v));
    /* The last snapshot before the gap was made at 59/30 s. It is drawn when its time has come, and held
     * until the next one, of 66/30 s, has arrived. */
    ll_time last = 59 * LL_SECOND / RATE, next = 66 * LL_SECOND / RATE + 50 * LL_MS;
    assert_int_equal(held, v->now - 50 * LL_MS - DELAY > last + 2 && v->now < next);
    if (held) {
        assert_true(about(shown_time(v), last));
        assert_true(other(v)->x == path(59));
        assert_true(v->l->client->drawing.buffer_ms == 0);
    }
    is_between_its_states(v);
}

static void empty_buffers_hold(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    run(v, 8 * LL_SECOND, gap, look_dry);
    assert_int_equal(v->l->client_metrics->buffer.underruns, 1); /* one, of any length */
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - DELAY));
    free_view(v);
}

/* ---- render time ---- */

#define PERIOD (LL_SECOND / 60)
#define JUMP (250 * LL_MS)

static ll_time prev_shown;
static int jumps, catch_ups, slow_downs, holds;

/* The server's clock as brought by the fastest packet of the last two seconds (quarters of seconds). */
static ll_time heard_offset(const view *v, const ll_time *arrived)
{
    int64_t last = v->order[v->taken - 1], quarter = arrived[last] / (LL_SECOND / 4);
    ll_time best = INT64_MIN;
    for (int64_t i = 0; i < v->taken; i++) {
        int64_t k = v->order[i];
        if (arrived[k] / (LL_SECOND / 4) > quarter - 8 && v->time[k] - arrived[k] > best)
            best = v->time[k] - arrived[k];
    }
    return best;
}

static ll_time (*present_lag)(int64_t k);

static void look_moving(view *v)
{
    static ll_time arrived[STATES];
    if (v->taken == 0)
        return;
    for (int64_t k = 0; k < v->sent; k++)
        arrived[k] = v->time[k] + (present_lag(k) == LL_NEVER ? 0 : present_lag(k));
    ll_time now_shown = shown_time(v), moved = now_shown - prev_shown, before = prev_shown;
    prev_shown = now_shown;
    if (v->now < LL_SECOND)
        return;
    ll_time target = v->now + heard_offset(v, arrived) - DELAY, error = target - (before + PERIOD);
    assert_true(moved >= 0); /* never backwards */
    assert_true(now_shown <= newest_time(v));
    is_between_its_states(v);
    if (now_shown == newest_time(v)) {
        holds++;
    } else if (error > JUMP) {
        assert_true(about(now_shown, target));
        jumps++;
    } else {
        assert_in_range(moved, PERIOD * 9 / 10 - 2, PERIOD * 11 / 10 + 2);
        if (error > PERIOD / 10 + 2) {
            assert_true(about(moved, PERIOD * 11 / 10));
            catch_ups++;
        } else if (error < -PERIOD / 10 - 2) {
            assert_true(about(moved, PERIOD * 9 / 10));
            slow_downs++;
        } else {
            assert_true(about(now_shown, target));
        }
    }
}

static void watch(view *v, ll_time until, ll_time (*lag)(int64_t k))
{
    present_lag = lag;
    prev_shown = INT64_MIN / 2;
    jumps = catch_ups = slow_downs = holds = 0;
    run(v, until, lag, look_moving);
}

static ll_time wild(int64_t k)
{
    uint64_t draw = ll_rng_u64(9, 0, (uint64_t)k), mood = ll_rng_u64(9, 1, (uint64_t)k / 90) % 5;
    if (draw % 10 == 0 || (mood == 4 && k % 90 < 40))
        return LL_NEVER;
    return (ll_time)(mood * 120 + draw % (1 + 60 * mood)) * LL_MS;
}

static void time_never_runs_back_nor_too_fast(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    watch(v, 120 * LL_SECOND, wild);
    assert_true(jumps > 0 && catch_ups > 100 && slow_downs > 0 && holds > 100);
    free_view(v);
}

static ll_time falls_by_200(int64_t k)
{
    return (k < 90 ? 250 : 50) * LL_MS;
}

static ll_time falls_by_350(int64_t k)
{
    return (k < 90 ? 400 : 50) * LL_MS;
}

static ll_time rises_by_150(int64_t k)
{
    return (k < 90 ? 50 : 200) * LL_MS;
}

/* When a link gets faster by less than 250 ms, render time catches up at a tenth: 200 ms take 2 s. */
static void small_changes_are_caught_up_slowly(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    ll_time change = 3 * LL_SECOND + 50 * LL_MS;
    watch(v, change + 1900 * LL_MS, falls_by_200);
    assert_true(v->now - shown_time(v) > 50 * LL_MS + DELAY + 5 * LL_MS);
    run(v, change + 2050 * LL_MS, falls_by_200, look_moving);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - DELAY));
    assert_int_equal(jumps, 0);
    assert_in_range(catch_ups, 118, 120);
    free_view(v);
}

static void large_changes_are_jumped(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    watch(v, 3 * LL_SECOND + 100 * LL_MS, falls_by_350);
    assert_int_equal(jumps, 1);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - DELAY));
    free_view(v);
}

/* A delay that is set to 500 ms more: the view stands still until it is 250 ms off, then runs slower. */
static void larger_delays_are_waited_for(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    run(v, 3 * LL_SECOND, lag_50, NULL);
    ll_time before = shown_time(v);
    v->l->config.jitter_margin_ms = 510;
    run(v, 3 * LL_SECOND + 230 * LL_MS, lag_50, NULL);
    assert_true(shown_time(v) == before);
    run(v, 3 * LL_SECOND + 350 * LL_MS, lag_50, NULL);
    assert_true(shown_time(v) > before && v->now - shown_time(v) < 50 * LL_MS + DELAY + 300 * LL_MS);
    before = shown_time(v);
    run(v, 4 * LL_SECOND + 350 * LL_MS, lag_50, NULL); /* 60 frames later */
    assert_in_range(shown_time(v) - before, 900 * LL_MS - 120, 900 * LL_MS + 120);
    run(v, 8 * LL_SECOND, lag_50, NULL);
    assert_true(about(shown_time(v), v->now - 50 * LL_MS - DELAY - 500 * LL_MS));
    free_view(v);
}

/* A link that gets slower: the view holds at the newest snapshot until the fast packets are forgotten. */
static void slower_links_are_followed(void **state)
{
    (void)state;
    view *v = new_view(&ll_sync_free);
    watch(v, 12 * LL_SECOND, rises_by_150);
    assert_true(holds > 10 && jumps == 0);
    assert_true(about(shown_time(v), v->now - 200 * LL_MS - DELAY));
    free_view(v);
}

/* ---- the ring ---- */

/* With a delay longer than 64 snapshots last, the oldest that is kept is drawn. */
static void oldest_of_a_full_buffer(void **state)
{
    (void)state;
    lone *l = new_lone(2, &toy, &ll_sync_free);
    ll_time shown = 0;
    l->config.interpolation = true;
    l->config.interpolation_ratio = 10;
    start_lone(l, 60, 0, 0);
    for (int64_t k = 0; k < 400; k++) {
        ll_time now = ll_tick_time(k, HZ(60));
        packet p = state_of(k, now, 0, 2, (double[]){0, path(k)});
        p.head.update_hz = 2; /* so that the delay is 5 s and 10 ms */
        give(l, &p, now);
        frame(l, now, NULL);
        int64_t oldest = k < LL_STATE_RING ? 0 : k - LL_STATE_RING + 1;
        assert_int_equal(ll_client_draw_infos(l->client)[1].time, ll_tick_time(oldest, HZ(60)));
        assert_true(ll_client_rendered(l->client)->entity[1].x == path(oldest));
        assert_true(ll_client_draw_infos(l->client)[1].time >= shown);
        shown = ll_client_draw_infos(l->client)[1].time;
    }
    free_lone(l);
}

/* ---- flights ---- */

/* A projectile that was fired or landed between two snapshots is not drawn on its way there. */
static void flights_are_not_blended_across_their_ends(void **state)
{
    (void)state;
    for (int flags = 0; flags < 4; flags++) {
        lone *l = new_lone(2, &toy, &ll_sync_free);
        packet a = state_of(1, LL_SECOND, 0, 2, (double[]){0, 10}),
               b = state_of(2, 2 * LL_SECOND, 0, 2, (double[]){0, 30});
        a.entity[1] =
            (ll_entity){.x = 10, .y = 1, .vx = 100, .vy = 2, .flags = flags & 1 ? LL_ENTITY_ACTIVE : 0};
        b.entity[1] =
            (ll_entity){.x = 30, .y = 5, .vx = 200, .vy = 6, .flags = flags & 2 ? LL_ENTITY_ACTIVE : 0};
        a.head.update_hz = b.head.update_hz = 2;
        l->config.interpolation = true;
        l->config.interpolation_ratio = 1;
        l->config.jitter_margin_ms = 250; /* a delay of 750 ms */
        start_lone(l, 60, 0, 0);
        give(l, &a, LL_SECOND);
        give(l, &b, 2 * LL_SECOND);
        frame(l, 2 * LL_SECOND, NULL);
        const ll_entity *e = &ll_client_rendered(l->client)->entity[1];
        bool blended = flags == 0 || flags == 3;
        assert_int_equal(ll_client_draw_infos(l->client)[1].time, 1250 * LL_MS);
        assert_true(l->client->drawing.alpha == 0.25);
        assert_true(e->x == (blended ? 15 : 10) && e->y == (blended ? 2 : 1));
        assert_true(e->vx == (blended ? 125 : 100) && e->vy == (blended ? 3 : 2));
        assert_int_equal(e->flags, a.entity[1].flags);
        free_lone(l);
    }
}

static void the_own_entity_is_not_touched(void **state)
{
    (void)state;
    lone *l = new_lone(2, &toy, &ll_sync_free);
    packet a = state_of(1, 0, 0, 2, (double[]){1, 10}), b = state_of(2, LL_SECOND, 0, 2, (double[]){2, 20});
    l->config.interpolation = true;
    start_lone(l, 60, 0, 0);
    give(l, &a, 0);
    give(l, &b, LL_SECOND);
    frame(l, LL_SECOND, NULL);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 2); /* the newest snapshot */
    assert_int_equal(ll_client_draw_infos(l->client)[0].time, LL_SECOND);
    assert_int_equal(ll_client_draw_infos(l->client)[0].flags, 0);
    l->config.interpolation = false;
    frame(l, LL_SECOND + 1, NULL);
    assert_true(ll_client_rendered(l->client)->entity[1].x == 20);
    assert_int_equal(ll_client_draw_infos(l->client)[1].time, LL_SECOND);
    assert_int_equal(ll_client_draw_infos(l->client)[1].flags, 0);
    free_lone(l);
}

/* ---- the demo's rule ---- */

/* Snapshots are placed at their time of arrival, and drawn one update interval later. */
static void demo_interpolates_between_arrivals(void **state)
{
    (void)state;
    lone *l = new_lone(2, &toy, &ll_sync_gambetta);
    const ll_time came[] = {100 * LL_MS, 190 * LL_MS, 320 * LL_MS, 400 * LL_MS};
    const double x[] = {0, 9, 22, 30};
    l->config.interpolation = true;
    start_lone(l, 100, 0, 0);
    double last = 0;
    int held_frames = 0;
    for (ll_time now = 10 * LL_MS, i = 0; now <= 700 * LL_MS; now += 10 * LL_MS) {
        for (; i < 4 && came[i] <= now; i++) {
            packet p = state_of(i + 1, (i + 1) * 100 * LL_MS, 0, 2, (double[]){0, x[i]});
            p.head.update_hz = 10;
            give(l, &p, came[i]);
        }
        frame(l, now, NULL);
        double drawn = ll_client_rendered(l->client)->entity[1].x, ms = ll_to_ms(now - 100 * LL_MS);
        bool held = ll_client_draw_infos(l->client)[1].flags & LL_RENDERED_HELD;
        if (now < 190 * LL_MS)
            continue; /* no pair to interpolate yet */
        /* x is (arrival - 100) / 10: what is drawn grows evenly, except where no pair brackets the time. */
        bool bracketed = ms >= 100 && ms < 400 && !(now < 320 * LL_MS && ms >= 190);
        assert_int_equal(held, !bracketed);
        assert_near(drawn, (bracketed ? (ms - 100) / 10 : last), 1e-9);
        held_frames += held;
        last = drawn;
    }
    assert_int_equal(held_frames, 1 + 3 + 21); /* at 190, 290 to 310, 500 to 700 ms */
    assert_int_equal(l->client_metrics->buffer.underruns, 3);
    free_lone(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steady_links_are_drawn_one_delay_back),
        cmocka_unit_test(delay_follows_its_settings),
        cmocka_unit_test(empty_buffers_hold),
        cmocka_unit_test(time_never_runs_back_nor_too_fast),
        cmocka_unit_test(small_changes_are_caught_up_slowly),
        cmocka_unit_test(large_changes_are_jumped),
        cmocka_unit_test(larger_delays_are_waited_for),
        cmocka_unit_test(slower_links_are_followed),
        cmocka_unit_test(oldest_of_a_full_buffer),
        cmocka_unit_test(flights_are_not_blended_across_their_ends),
        cmocka_unit_test(the_own_entity_is_not_touched),
        cmocka_unit_test(demo_interpolates_between_arrivals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The paper's figures, as assertions on the scenarios that reproduce them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

static const ll_event *find(const tape *t, int type, int player, uint32_t number)
{
    for (size_t i = 0; i < t->count; i++)
        if (t->events[i].type == type && t->events[i].player == player && t->events[i].number == number)
            return &t->events[i];
    fail_msg("no event of type %d, player %d, number %u", type, player, number);
    return NULL;
}

#define NEAR_MS(t, ms) assert_near(ll_to_ms(t), ms, 0.5)

/* Figure 8: in lockstep at 3 updates per second the client's dots are the server's, 250 ms later, at the same
 * positions. */
static void figure_8_client_dots_are_the_servers_later(void **state)
{
    (void)state;
    tape t = {0};
    scene s = scene_open("paper/fig08", NULL);
    ll_recorder r = tape_recorder(&t);
    scene_run(&s, 20, &r);
    int dots = 0;
    double last = -1;
    for (size_t i = 0; i < t.count; i++) {
        const ll_event *e = &t.events[i];
        if (e->type != LL_EVENT_APPLIED || e->player != 0)
            continue;
        assert_int_equal(e->outcome, LL_OUTCOME_APPLIED);
        NEAR_MS(e->begin - find(&t, LL_EVENT_STEP, 0, e->number)->begin, 250);
        if (last >= 0)
            NEAR_MS(e->begin - ll_ms(last), 1000.0 / 3);
        last = ll_to_ms(e->begin);
        dots++;
    }
    assert_true(dots > 50);
    assert_true(ll_netgame_client_metrics(s.game, 0)->last.own_lead <= 0); /* the client is behind */
    double values[LL_GAME_VALUES];
    ll_netgame_game(s.game)->describe(ll_server_world(ll_netgame_server(s.game)), &s.game->env, 0, values);
    assert_true(values[1] >= 1); /* shots were fired */
    scene_close(&s);
    tape_free(&t);
}

/* Figure 9: latencies drawn uniformly from 10 to 500 ms, so that arrivals are not evenly spaced. */
static void figure_9_arrivals_are_spread_evenly_over_10_to_500_ms(void **state)
{
    (void)state;
    const char *const longer[] = {"duration_s=600", NULL};
    tape t = {0};
    scene s = scene_open("paper/fig09", longer);
    ll_recorder r = tape_recorder(&t);
    scene_run(&s, 600, &r);
    double sum = 0, squares = 0, least = 1e9, most = 0;
    int n = 0, bins[10] = {0};
    for (size_t i = 0; i < t.count; i++) {
        const ll_event *e = &t.events[i];
        if (e->type != LL_EVENT_INPUT || e->player != 0)
            continue;
        double delay = ll_to_ms(e->end - e->begin);
        least = smaller(least, delay);
        most = larger(most, delay);
        sum += delay;
        squares += delay * delay;
        bins[(int)smaller(9, (delay - 10) / 49)]++;
        n++;
    }
    assert_true(n > 30000);
    assert_true(least >= 10 && least < 10.5 && most <= 500 && most > 499.5);
    double mean = sum / n, sd = sqrt(squares / n - mean * mean), theory = 490 / sqrt(12);
    assert_near(mean, 255, 4 * theory / sqrt(n));
    assert_near(sd, theory, 4 * theory / sqrt(2.0 * n));
    for (int k = 0; k < 10; k++)
        assert_near(bins[k], n / 10.0, 4 * sqrt(n * 0.09));
    scene_close(&s);
    tape_free(&t);
}

/* Figure 10: 150, 250, 283, 433 and 533 ms. */
static void figure_10_events_of_one_round(void **state)
{
    (void)state;
    tape t = {0};
    scene s = scene_open("paper/fig10", NULL);
    ll_recorder r = tape_recorder(&t);
    scene_run(&s, 1, &r);
    const ll_event *a = find(&t, LL_EVENT_INPUT, 0, 1), *b = find(&t, LL_EVENT_INPUT, 1, 1);
    assert_true(a->begin == 0 && b->begin == 0);
    NEAR_MS(find(&t, LL_EVENT_INPUT_RESULT, 0, 1)->begin, 150);
    NEAR_MS(find(&t, LL_EVENT_INPUT_RESULT, 1, 1)->begin, 250);
    NEAR_MS(find(&t, LL_EVENT_STEP, 0, 1)->begin, 283);
    NEAR_MS(find(&t, LL_EVENT_APPLIED, 0, 1)->begin, 433);
    NEAR_MS(find(&t, LL_EVENT_APPLIED, 1, 1)->begin, 533);
    scene_close(&s);
    tape_free(&t);
}

/* Stop and wait: a step takes the slowest round trip and an interval, 500 ms and 33.3 ms, from the first to
 * the last. Each client sends an input with the snapshot that it waited for, and no other. */
static void figure_11_a_step_takes_533_ms(void **state)
{
    (void)state;
    tape t = {0};
    scene s = scene_open("paper/fig11", NULL);
    ll_recorder r = tape_recorder(&t);
    scene_run(&s, 30, &r);
    uint32_t steps = (uint32_t)ll_netgame_server(s.game)->step;
    assert_int_equal(steps, 56); /* the first at 283.3 ms, the last at 29 616.7 */
    for (uint32_t k = 1; k <= steps; k++) {
        ll_time at = find(&t, LL_EVENT_STEP, 0, k)->begin;
        assert_near(ll_to_ms(at), (850 + 1600.0 * (k - 1)) / 3, 0.001);
    }
    int inputs[2] = {0};
    for (size_t i = 0; i < t.count; i++) {
        const ll_event *e = &t.events[i];
        if (e->type != LL_EVENT_INPUT || e->begin < 0)
            continue;
        inputs[e->player]++;
        if (e->number > 1 && e->fate == LL_FATE_DELIVERED)
            assert_true(e->begin >= find(&t, LL_EVENT_APPLIED, e->player, e->number - 1)->begin);
    }
    for (int p = 0; p < 2; p++)
        assert_in_range(ll_netgame_client(s.game, p)->inputs.seq, steps, steps + 1);
    assert_int_equal(inputs[1],
                     ll_netgame_client(s.game, 1)->inputs.seq); /* the slowest repeats no request */
    scene_close(&s);
    tape_free(&t);
}

/* Figure 11: the same path in every view, the server first, then A, then B; nothing is corrected. */
static void figure_11_views_follow_in_the_order_of_lag(void **state)
{
    (void)state;
    scene s = scene_open("paper/fig11", NULL);
    /* step 38 is made at 283.3 + 37 x 533.3 = 20 016.7 ms and seen by A at 20 166.7 and by B at 20 266.7 */
    double seen[2][4];
    static const double at_s[] = {20.010, 20.020, 20.170, 20.270};
    for (int k = 0; k < 4; k++) {
        scene_run(&s, at_s[k], NULL);
        double truth = ll_server_world(ll_netgame_server(s.game))->entity[0].x;
        for (int p = 0; p < 2; p++) {
            const ll_world *shown = ll_client_rendered_const(ll_netgame_client(s.game, p));
            seen[p][k] = truth - shown->entity[0].x;
            assert_true(shown->entity[0].x == shown->entity[1].x);
        }
    }
    for (int p = 0; p < 2; p++)
        assert_true(seen[p][0] == 0 && seen[p][1] > 0 && seen[p][3] == 0);
    assert_true(seen[0][2] == 0 && seen[1][2] > 0);
    const ll_world *truth = ll_server_world(ll_netgame_server(s.game));
    assert_true(truth->entity[0].x > 3); /* race: 38 steps of 1/30 s from rest, at 6 m/s2 less drag */
    assert_true(truth->entity[0].x == truth->entity[1].x);
    for (int i = 0; i < 2; i++) {
        const ll_client_metrics *in = ll_netgame_client_metrics(s.game, i);
        assert_int_equal(in->corrections.count, 0);
        /* a snapshot is one lag old when it arrives, and a period older when the next one does; displays are
         * 1/60 s apart */
        ll_summary age = ll_histogram_summary(&in->histogram[LL_METRIC_VIEW_AGE]);
        assert_near(age.mean, ((i == 0 ? 150 : 250) + 1600.0 / 3 / 2), 1000.0 / 60);
        assert_true(age.max < (i == 0 ? 150 : 250) + 1600.0 / 3 + 0.01);
        assert_true(ll_histogram_summary(&in->histogram[LL_METRIC_TIMELINE_ERROR]).max == 0);
    }
    scene_close(&s);
}

/* Figure 12: inputs wait in a buffer until a snapshot acknowledges them, and the rest are applied again:
 * after it the prediction is the server's state plus exactly those. */
static void figure_12_open_inputs_are_applied_again(void **state)
{
    (void)state;
    tape t = {0};
    scene s = scene_open("paper/fig12", NULL);
    ll_recorder r = tape_recorder(&t);
    scene_run(&s, 30, &r);
    int corrections = 0;
    for (size_t i = 0; i < t.count; i++)
        corrections += t.events[i].type == LL_EVENT_CORRECTION;
    assert_true(corrections > 10);
    for (int i = 0; i < 2; i++) {
        ll_client *c = ll_netgame_client(s.game, i);
        assert_true(c->inputs.seq - c->inputs.acked >= 18); /* 300 ms of round trip at 60 inputs per second */
        ll_snapshot_entry *state_message = ll_client_state(c, c->snapshots.used - 1);
        ll_world *world = malloc((size_t)c->layout.world_size);
        __builtin_memcpy(world, ll_snapshot_entry_world(state_message), (size_t)c->layout.world_size);
        for (uint32_t seq = c->inputs.acked + 1; seq <= c->inputs.seq; seq++)
            ll_netgame_game(s.game)->step_own(world, &s.game->env, i, &ll_client_pending(c, seq)->action);
        assert_true(world->entity[i].x == ll_client_predicted(c)->entity[i].x);
        free(world);
    }
    scene_close(&s);
    tape_free(&t);
}

/* Figure 13: the own car leads the server's by the lag, without correction; the other's car is as late as
 * before. */
static void figure_13_own_car_leads_by_the_lag(void **state)
{
    (void)state;
    scene s = scene_open("paper/fig13", NULL);
    for (double t = 3; t < 20; t += 0.5) {
        scene_run(&s, t, NULL);
        const ll_world *truth = ll_server_world(ll_netgame_server(s.game));
        double ahead[2], later[2];
        for (int i = 0; i < 2; i++)
            ahead[i] = ll_client_rendered(ll_netgame_client(s.game, i))->entity[i].x;
        scene_run(&s, t + 0.150, NULL);
        for (int i = 0; i < 2; i++)
            later[i] = truth->entity[i].x;
        for (int i = 0; i < 2; i++)
            assert_true(ahead[i] == later[i]); /* bitwise what the server has 150 ms later */
    }
    for (int i = 0; i < 2; i++) {
        const ll_client_metrics *in = ll_netgame_client_metrics(s.game, i);
        assert_int_equal(in->corrections.count, 0);
        assert_true(ll_histogram_summary(&in->histogram[LL_METRIC_VIEW_AGE]).mean >= 150);
        assert_true(ll_histogram_summary(&in->histogram[LL_METRIC_OWN_TIMELINE_ERROR]).max == 0);
    }
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figure_8_client_dots_are_the_servers_later),
        cmocka_unit_test(figure_9_arrivals_are_spread_evenly_over_10_to_500_ms),
        cmocka_unit_test(figure_10_events_of_one_round),
        cmocka_unit_test(figure_11_a_step_takes_533_ms),
        cmocka_unit_test(figure_11_views_follow_in_the_order_of_lag),
        cmocka_unit_test(figure_12_open_inputs_are_applied_again),
        cmocka_unit_test(figure_13_own_car_leads_by_the_lag),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

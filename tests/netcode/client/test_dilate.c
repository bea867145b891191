/* Time dilation: the length of frames alone keeps the slack. */
#include "netcode/toy.h"

#include <stdio.h>

#include "support/near.h"
#include "support/scene.h"

#define PERIOD (LL_SECOND / 60)

/* The clock is moved by the requested time to the ns; no frame is shorter than 1/1.1 or longer than 1/0.9 of
 * a tick. Small changes are proportional: n ticks take 11 n frames (9 n when slower) and a tail. */
static void time_is_shifted_exactly_and_within_a_tenth(void **state)
{
    (void)state;
    for (int n = -1000; n <= 1000; n += 7) {
        ll_time clock_correction = n * PERIOD / 100 + n;
        ll_client c = {
            .ticks.period = PERIOD, .ticks.clock = {0, 0, HZ(60)}, .inputs.correction = clock_correction};
        int frames = 0;
        for (; c.inputs.correction != 0; frames++) {
            ll_time before = c.ticks.clock.epoch;
            ll_dilate_time(&c);
            ll_time frame = PERIOD + c.ticks.clock.epoch - before;
            assert_true(c.inputs.scale >= 0.9 - 1e-7 && c.inputs.scale <= 1.1 + 1e-7);
            assert_near(c.inputs.scale, (double)PERIOD / (double)frame, 1e-12);
            assert_true((c.inputs.scale >= 1) == (clock_correction >= 0));
        }
        assert_int_equal(c.ticks.clock.epoch, -clock_correction);
        double ticks = fabs(n / 100.0), whole = n > 0 ? 11 * (ticks - 10.0 / 11) : 9 * (ticks - 10.0 / 9);
        double tail = log(ticks < 1 ? ticks * 100 : 112) / log(10.0 / 9) + 3;
        assert_true(frames <= (whole > 0 ? whole : 0) + (tail > 1 ? tail : 1));
        assert_true(frames >= whole);
    }
}

typedef struct watch {
    double worst, best; /* scale of frames */
    int64_t doubled;    /* frames that made other than one input */
} watch;

/* Runs frame by frame and records what each makes. */
static watch run_watching(scene *s, double until_s)
{
    watch w = {1, 1, 0};
    ll_client *c = ll_netgame_client(s->game, 0);
    ll_time last = 0;
    uint32_t seq = c->inputs.seq;
    while (c->ticks.due <= (ll_time)(until_s * 1e9)) {
        scene_run(s, ll_to_s(c->ticks.due), NULL);
        double scale = last > 0 ? (double)c->ticks.period / (double)(c->ticks.last - last) : 1;
        w.worst = smaller(w.worst, scale);
        w.best = larger(w.best, scale);
        w.doubled += last > 0 && c->inputs.seq != seq + 1;
        last = c->ticks.last;
        seq = c->inputs.seq;
    }
    return w;
}

static void change_lag(scene *s, double lag_ms)
{
    ll_netgame_config config = scene_config(s->game);
    config.players[0].lag_ms = lag_ms;
    s->scenario.kind->change(s->game, &config, s->game->now);
}

/* After a change of lag of up to ten ticks the slack returns to the wanted value with one input per frame;
 * never late where the lag falls, never beyond where it rises. */
static void slack_is_kept_with_one_input_a_frame(void **state)
{
    (void)state;
    static const struct {
        double before, after;
    } lags[] = {{50, 190}, {190, 50}, {100, 120}, {120, 100}, {0, 160}, {900, 1000}, {1000, 860}};
    for (size_t i = 0; i < sizeof lags / sizeof lags[0]; i++)
        for (int want = 0; want <= 4; want += 2) {
            char before[48], slack[48];
            snprintf(before, sizeof before, "players.0.lag_ms=%g", lags[i].before);
            snprintf(slack, sizeof slack, "players.0.slack_ticks=%d", want);
            const char *const sets[] = {before, slack, "players.0.time_dilation=true", "warmup_s=0", NULL};
            scene s = scene_open("race", sets);
            const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[0];
            const ll_input_history *input_history = &ll_netgame_client_metrics(s.game, 0)->input_history;
            watch w = run_watching(&s, 5);
            assert_true(w.worst > 0.9999 && w.best < 1.0001 && w.doubled == 0); /* nothing to do */
            assert_in_range(client_slot->snapshots.last_slack, want, want + 1);
            change_lag(&s, lags[i].after);
            bool rises = lags[i].after > lags[i].before;
            w = run_watching(&s, 5 + 2 * 2 * lags[i].after / 1000 + 3 + 3);
            assert_int_equal(w.doubled, 0);
            assert_true(w.worst >= 0.9 - 1e-6 && w.best <= 1.1 + 1e-6);
            if (rises)
                assert_true(w.best > 1.01 && w.worst > 0.9999 && input_history->slack.max < want + 2);
            else
                assert_true(w.worst < 0.99 && w.best < 1.0001 && client_slot->counts.late == 0);
            assert_in_range(client_slot->snapshots.last_slack, want, want + 1);
            int64_t late = client_slot->counts.late;
            w = run_watching(&s, s.game->now / 1e9 + 5);
            assert_true(w.worst > 0.9999 && w.best < 1.0001 &&
                        client_slot->counts.late == late); /* and stays */
            assert_int_equal(input_history->doubled + input_history->left_out, 0);
            scene_close(&s);
        }
}

/* Of a greater change ten ticks are dilated and the rest is made up at once by doubled inputs. */
static void changes_beyond_ten_ticks_are_made_at_once(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.lag_ms=5", "players.0.time_dilation=true", "warmup_s=0", NULL};
    scene s = scene_open("race", sets);
    const ll_input_history *input_history = &ll_netgame_client_metrics(s.game, 0)->input_history;
    scene_run(&s, 5, NULL);
    change_lag(&s, 505); /* 30 ticks more */
    scene_run(&s, 15, NULL);
    assert_in_range(input_history->doubled, 18, 22);
    assert_int_equal(input_history->left_out, 0);
    assert_in_range(ll_netgame_server(s.game)->client_slots[0].snapshots.last_slack, 1, 2);
    scene_close(&s);
}

/* Without it a change of less than 100 ms doubles and skips inputs. */
static void without_dilation_inputs_are_doubled_and_left_out(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.lag_ms=50", "warmup_s=0", NULL};
    scene s = scene_open("race", sets);
    const ll_input_history *input_history = &ll_netgame_client_metrics(s.game, 0)->input_history;
    run_watching(&s, 5);
    change_lag(&s, 130); /* 4.8 ticks */
    watch w = run_watching(&s, 15);
    assert_true(w.doubled >= 4 && w.worst > 0.9999 && w.best < 1.0001);
    assert_in_range(input_history->doubled, 4, 5);
    assert_int_equal(ll_netgame_client(s.game, 0)->connection.clock.snaps, 0);
    change_lag(&s, 50);
    run_watching(&s, 25);
    assert_in_range(input_history->left_out, 4, 5);
    assert_true(input_history->scale.min == 1 && input_history->scale.max == 1);
    scene_close(&s);
}

/* A change of 100 ms or more skips the steps in between at once: the next input is for the first step that it
 * can reach in time, and one is still made per frame. Too far ahead, inputs are skipped until the server is
 * there. */
static void beyond_100_ms_steps_are_left_out(void **state)
{
    (void)state;
    static const double rises[] = {140, 400, 900};
    for (size_t i = 0; i < sizeof rises / sizeof rises[0]; i++) {
        const char *const sets[] = {"players.0.lag_ms=50", "warmup_s=0", NULL};
        scene s = scene_open("race", sets);
        const ll_input_history *input_history = &ll_netgame_client_metrics(s.game, 0)->input_history;
        const ll_client *c = ll_netgame_client(s.game, 0);
        const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[0];
        run_watching(&s, 5);
        int64_t ahead = c->inputs.tick - c->ticks.number, numbers = (int64_t)c->inputs.seq - c->ticks.number,
                made = ll_input_history_made_count(input_history);
        change_lag(&s, 50 + rises[i]);
        run_watching(&s, 5 + 2 * (0.05 + rises[i] / 1000) + 0.2); /* a round trip, and an update */
        double ticks = rises[i] * 60 / 1000;
        assert_int_equal(input_history->doubled, 0);
        assert_true(c->connection.clock.snaps >= 1);
        assert_near((double)(c->inputs.tick - c->ticks.number - ahead), ticks, 1);
        assert_int_equal((int64_t)c->inputs.seq - c->ticks.number - numbers,
                         c->inputs.tick - c->ticks.number - ahead); /* together */
        run_watching(&s, 15);
        const int64_t more = ll_input_history_made_count(input_history) - made;
        assert_true(more >= 598 && more <= 601); /* 10 s */
        assert_int_equal(c->connection.clock.snaps, 1);
        assert_in_range(client_slot->snapshots.last_slack, 1, 2);
        int64_t late = client_slot->counts.late;
        change_lag(&s, 50);
        run_watching(&s, 15 + 2 * 2 + 2 * (0.05 + rises[i] / 1000) + rises[i] / 1000 + 1);
        assert_in_range(client_slot->snapshots.last_slack, 1, 2);
        assert_near((double)input_history->left_out, ticks, 1);
        assert_int_equal(client_slot->counts.late, late);
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_is_shifted_exactly_and_within_a_tenth),
        cmocka_unit_test(slack_is_kept_with_one_input_a_frame),
        cmocka_unit_test(changes_beyond_ten_ticks_are_made_at_once),
        cmocka_unit_test(without_dilation_inputs_are_doubled_and_left_out),
        cmocka_unit_test(beyond_100_ms_steps_are_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

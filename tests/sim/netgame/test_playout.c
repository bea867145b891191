/* De-jitter buffers in front of clients. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "support/near.h"
#include "support/scene.h"

#define JITTER_MS 40.0
#define WIDTH_MS (2 * JITTER_MS) /* width of the uniform distribution of transit times */

static const ll_dejitter_stats *stats(const scene *s, int player)
{
    return ll_dejitter_get_stats(ll_netgame_dejitter(s->game, player));
}

/* Player A of the scenario `dejitter` with such a buffer; 20 snapshots per second for five minutes. */
static scene run_with(const char *policy, double delay_ms)
{
    char choice[64], delay[64];
    const char *const sets[] = {choice, delay, "duration_s=300", NULL};
    snprintf(choice, sizeof choice, "players.0.dejitter=%s", policy);
    snprintf(delay, sizeof delay, "players.0.dejitter_ms=%g", delay_ms);
    scene s = scene_open("dejitter", sets);
    scene_run_whole(&s);
    return s;
}

/* Played out d after the fastest delay of the last n snapshots: snapshots slower than that by more than d are
 * late. With x = d / w and the minimum m of n - 1 uniforms, P(u > x + m) = 1 - x - (1 - x^n) / n. To those in
 * time E (x + m - u) = x^2 / 2 + x / n + ... of w is added. The window is of 7 to 8 quarters of a second, 35
 * to 40 snapshots. */
static void late_states_are_those_beyond_the_delay(void **state)
{
    (void)state;
    for (double x = 0.25; x < 1; x += 0.25) {
        scene s = run_with("send_time", x * WIDTH_MS);
        double n = 37.5, count = (double)stats(&s, 0)->pushed, late = (double)stats(&s, 0)->late / count;
        double want = 1 - x - (1 - pow(x, n)) / n, added = stats(&s, 0)->added_sum_ms / count;
        assert_true(count > 5900 && stats(&s, 0)->overflowed == 0);
        assert_near(late, want, 3 * sqrt(want * (1 - want) / count) + 0.002); /* n is not one number */
        assert_near(added, WIDTH_MS * (x * x / 2 + x / n), 3 * 0.3 * WIDTH_MS / sqrt(count));
        scene_close(&s);
    }
}

/* Standard deviation of the times between two snapshots that a client applied, ms. */
static double unevenness(const char *policy, double delay_ms, double jitter_ms, int64_t *stale)
{
    char choice[64], delay[64], jitter[64];
    const char *const sets[] = {choice, delay, jitter, NULL};
    snprintf(jitter, sizeof jitter, "players.0.link.down.jitter_ms=%g", jitter_ms);
    snprintf(choice, sizeof choice, "players.0.dejitter=%s", policy);
    snprintf(delay, sizeof delay, "players.0.dejitter_ms=%g", delay_ms);
    scene s = scene_open("dejitter", sets);
    tape all = {0};
    ll_recorder r = tape_recorder(&all);
    scene_run(&s, 60, &r);
    double sum = 0, last = 0;
    int count = 0;
    for (size_t i = 0; i < all.count; i++) {
        const ll_event *e = &all.events[i];
        if (e->type != LL_EVENT_APPLIED || e->player != 0)
            continue;
        double now = ll_to_ms(e->begin), off = now - last - 50;
        sum += now > 5000 ? off * off : 0;
        count += now > 5000;
        last = now;
    }
    *stale = ll_netgame_client(s.game, 0)->snapshots.stale;
    tape_free(&all);
    scene_close(&s);
    return sqrt(sum / count);
}

/* The paper's version, arrival + d, only delays all packets: the gaps are as uneven, and as many snapshots
 * are overtaken. By send time, with d beyond the jitter, they are those of the server, except for the
 * variation of the fastest delay: the minimum of 37 uniforms, whose standard deviation is w / 38. */
static void only_send_times_take_the_jitter_out(void **state)
{
    (void)state;
    int64_t none, arrival, send;
    double even = 20 * sqrt(2.0 / 3); /* of the difference of two uniforms of +-20 ms, without overtaking */
    assert_near(unevenness("none", 0, 20, &none), even, 1);
    assert_near(unevenness("arrival", 100, 20, &arrival), even, 1);
    assert_true(unevenness("send_time", 100, 20, &send) < 40.0 / 38);
    assert_true(none == 0 && arrival == 0 && send == 0);
    unevenness("none", 0, JITTER_MS, &none);
    unevenness("arrival", 100, JITTER_MS, &arrival);
    assert_true(unevenness("send_time", 100, JITTER_MS, &send) < WIDTH_MS / 38);
    assert_true(none > 60 && llabs(arrival - none) <= 2 && send == 0);
}

static void arrival_adds_the_same_to_each(void **state)
{
    (void)state;
    scene s = run_with("arrival", 70);
    assert_near(stats(&s, 0)->added_sum_ms / (double)stats(&s, 0)->pushed, 70, 1e-6);
    assert_true(stats(&s, 0)->late == 0 && stats(&s, 0)->underruns == 0);
    scene_close(&s);
}

/* Behind a buffer that removes the jitter, interpolation needs one interval and the variation of the fastest
 * delay; without the buffer, an interval and the whole width of the jitter. */
static void interpolation_behind_a_buffer_needs_less_delay(void **state)
{
    (void)state;
    const char *const bare[] = {"players.0.interpolation=true", "players.0.interpolation_ratio=1",
                                "players.0.jitter_margin_ms=20", NULL};
    const char *const behind[] = {
        bare[0], bare[1], bare[2], "players.0.dejitter=send_time", "players.0.dejitter_ms=100", NULL};
    scene a = scene_open("dejitter", bare), b = scene_open("dejitter", behind);
    scene_run(&a, 60, NULL);
    scene_run(&b, 60, NULL);
    assert_true(ll_netgame_client_metrics(a.game, 0)->buffer.underruns > 100);
    assert_int_equal(ll_netgame_client_metrics(b.game, 0)->buffer.underruns, 0);
    scene_close(&a);
    scene_close(&b);
}

/* No held packet is lost or forgotten when policies and syncs change, and the block may be moved
 * meanwhile. */
static void buffers_may_change_while_they_hold(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.link.down.duplicate_pct=20", NULL};
    scene s = scene_open("dejitter", sets), t = scene_open("dejitter", sets);
    for (int i = 1; i <= 120; i++) {
        for (int k = 0; k < 2; k++) {
            scene *either = k ? &t : &s;
            ll_netgame_config *config = malloc(sizeof *config);
            scene_run(either, i / 4.0, NULL);
            memcpy(config, either->scenario.config, sizeof *config);
            for (int p = 0; p < 4; p++) {
                config->players[p].dejitter = (i + p) % 5;
                config->players[p].dejitter_ms = 100 * ((i / 5 + p) % 5);
            }
            config->server.sync = i % 30 < 25 ? 0 : 2;
            either->scenario.kind->change(either->game, config, either->game->now);
            free(config);
            for (int p = 0; p < 4; p++)
                assert_true(ll_dejitter_valid(ll_netgame_dejitter(either->game, p)) &&
                            ll_link_valid(ll_netgame_down(either->game, p)));
        }
        ll_netgame *elsewhere = malloc(ll_netgame_bytes(s.game));
        memcpy(elsewhere, s.game, ll_netgame_bytes(s.game));
        memset(s.game, 0xee, ll_netgame_bytes(s.game));
        free(s.game);
        s.game = elsewhere;
    }
    assert_int_equal(s.scenario.kind->hash(s.game), t.scenario.kind->hash(t.game));
    for (int p = 0; p < 4; p++)
        assert_true(stats(&s, p)->pushed > 300 && stats(&s, p)->overflowed == 0);
    scene_close(&s);
    scene_close(&t);
}

/* The client's rings limit how late a snapshot may be played out. */
static void long_delays_are_refused(void **state)
{
    (void)state;
    cJSON *json;
    ll_scenario scenario;
    ll_status status = ll_scenario_load("scenarios", "dejitter_500", &json);
    assert_false(ll_failed(&status));
    cJSON *player = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "players"), 0);
    cJSON_AddNumberToObject(player, "lag_ms", 300);
    status = ll_scenario_parse(json, &scenario);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.text,
                        "players.0.dejitter_ms and the longest delay of the player's link down must be at "
                        "most 1250 ms together; got 1290");
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(late_states_are_those_beyond_the_delay),
        cmocka_unit_test(only_send_times_take_the_jitter_out),
        cmocka_unit_test(arrival_adds_the_same_to_each),
        cmocka_unit_test(interpolation_behind_a_buffer_needs_less_delay),
        cmocka_unit_test(buffers_may_change_while_they_hold),
        cmocka_unit_test(long_delays_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

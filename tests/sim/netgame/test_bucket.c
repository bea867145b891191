/* Bucket synchronisation against its closed forms: the response, the share of late and of lost inputs, and
 * that it does not wait. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

enum { PLAYERS = 16, HZ = 25, BUCKET_MS = 1000 / HZ };

typedef struct setting {
    const char *sync;
    double delay_ms, duration_s;
    int seed, redundancy;
    double lag_step_ms; /* player i has i times this lag */
    bool random_phases; /* otherwise player i has the phase (i + 0.5) / PLAYERS */
    const char *link;   /* "up" of all players */
} setting;

static scene open_scene(const setting *c)
{
    char text[8000];
    int n = snprintf(text, sizeof text,
                     "{\"kind\":\"netgame\",\"game\":\"race\",\"params\":{\"laps\":1000},\"duration_s\":%g,"
                     "\"seed\":%d,\"warmup_s\":0,\"bucket_delay_ms\":%g,\"server\":{\"update_hz\":%d,"
                     "\"sync\":\"%s\",\"timeout_s\":0},\"players\":[",
                     c->duration_s, c->seed, c->delay_ms, HZ, c->sync);
    for (int i = 0; i < PLAYERS; i++)
        n += snprintf(text + n, sizeof text - (size_t)n,
                      "%s{\"script\":\"steady\",\"lag_ms\":%g,\"clock_phase\":%.17g,\"redundancy\":%d,"
                      "\"link\":{\"up\":{%s}}}",
                      i > 0 ? "," : "", i * c->lag_step_ms, c->random_phases ? -1 : (i + 0.5) / PLAYERS,
                      c->redundancy, c->link ? c->link : "");
    snprintf(text + n, sizeof text - (size_t)n, "]}");
    return scene_make(text, NULL);
}

/* ---- the response ---- */

/* What moves, as the server has it. */
typedef struct starts {
    scene *s;
    double since_ms[PLAYERS]; /* from a player's first input to the step that moved its car */
    int moved;
} starts;

static void note_step(void *context, const void *row)
{
    const ll_event *e = row;
    starts *d = context;
    const ll_world *world = ll_server_world(ll_netgame_server(d->s->game));
    for (int i = 0; i < PLAYERS && e->type == LL_EVENT_STEP; i++) {
        ll_client *client = ll_netgame_client(d->s->game, i);
        if (world->entity[i].vx == 0 || d->since_ms[i] > 0)
            continue;
        assert_int_equal(ll_client_pending(client, 1)->seq, 1);
        d->since_ms[i] = ll_to_ms(e->begin - ll_client_pending(client, 1)->made);
        d->moved++;
    }
}

static starts responses(const setting *c)
{
    scene s = open_scene(c);
    starts d = {.s = &s};
    scene_run(&s, 2, &(ll_recorder){.record = note_step, .context = &d});
    assert_int_equal(d.moved, PLAYERS);
    scene_close(&s);
    return d;
}

/* A car moves D and the rest of its bucket after its control, to the nanosecond, at any lag. */
static void the_response_is_the_delay_and_the_rest_of_the_bucket(void **state)
{
    (void)state;
    static const double delays_ms[] = {100, 80, 133.7, 500}, lag_steps_ms[] = {0, 5};
    for (int k = 0; k < 4; k++)
        for (int j = 0; j < 2; j++) {
            const setting c = {.sync = "bucket",
                               .delay_ms = delays_ms[k],
                               .duration_s = 3,
                               .seed = 1,
                               .lag_step_ms = lag_steps_ms[j]};
            starts d = responses(&c);
            for (int i = 0; i < PLAYERS; i++)
                assert_near(d.since_ms[i] - delays_ms[k], BUCKET_MS * (1 - (i + 0.5) / PLAYERS), 3e-6);
        }
}

/* Mean D + b / 2 over machines of random phase, which is uniform over a bucket: the mean of n of them is off
 * by b / sqrt(12 n), root mean square. */
static void the_mean_response_is_the_delay_and_half_a_bucket(void **state)
{
    (void)state;
    enum { SEEDS = 24 };
    double sum = 0;
    for (int seed = 1; seed <= SEEDS; seed++) {
        const setting c = {
            .sync = "bucket", .delay_ms = 100, .duration_s = 3, .seed = seed, .random_phases = true};
        starts d = responses(&c);
        for (int i = 0; i < PLAYERS; i++)
            sum += d.since_ms[i];
    }
    const double mean = sum / (SEEDS * PLAYERS), error = BUCKET_MS / sqrt(12.0 * SEEDS * PLAYERS);
    assert_near(mean, 120, 3 * error);
}

/* ---- inputs that come too late, or never ---- */

typedef struct shares {
    double all, of[PLAYERS]; /* of the inputs whose step is over, those that were not applied */
    double count;            /* such inputs of a player */
} shares;

static shares ignored(const setting *c)
{
    scene s = open_scene(c);
    shares d = {0};
    scene_run(&s, c->duration_s, NULL);
    const ll_server *server = ll_netgame_server(s.game);
    for (int i = 0; i < PLAYERS; i++) {
        const ll_input_history *h = &ll_netgame_client_metrics(s.game, i)->input_history;
        const ll_client_inputs *inputs = &ll_netgame_client(s.game, i)->inputs;
        const int64_t made = ll_input_history_made_count(h);
        const double over = (double)(made - (inputs->tick - server->step));
        d.of[i] = 1 - (double)h->count[LL_INPUT_WAS_APPLIED] / over;
        d.all += d.of[i] / PLAYERS;
        d.count = over;
        assert_int_equal(inputs->seq, made); /* one input in each bucket */
    }
    assert_int_equal(server->stalled, 0);
    assert_true(server->step >= (int64_t)(c->duration_s * HZ) - 1); /* it never waits */
    scene_close(&s);
    return d;
}

/* Share of a player's inputs that are late by a delay of U(low, high) if `left_ms` remain. */
static double late_share(double low, double high, double left_ms)
{
    double share = (high - left_ms) / (high - low);
    return share < 0 ? 0 : share > 1 ? 1 : share;
}

/* P(delay > D + b - u): the phases are the centres of equal parts of a bucket, and the share is linear in
 * each part, so that their mean is the integral. What remains is the sampling error of independent delays. */
static void check_late(double low, double high, double expected)
{
    char link[96];
    snprintf(link, sizeof link, "\"delay_ms\":%g,\"jitter_ms\":%g", (low + high) / 2, (high - low) / 2);
    const setting c = {.sync = "bucket", .delay_ms = 100, .duration_s = 120, .seed = 7, .link = link};
    const shares got = ignored(&c);
    double mean = 0, variance = 0;
    for (int i = 0; i < PLAYERS; i++) {
        const double left_ms = 100 + BUCKET_MS * (1 - (i + 0.5) / PLAYERS);
        const double p = late_share(low, high, left_ms), error = sqrt(p * (1 - p) / got.count);
        assert_true(p > 0 || got.of[i] == 0);
        assert_near(got.of[i], p, 4 * error);
        mean += p / PLAYERS;
        variance += p * (1 - p) / got.count / (PLAYERS * PLAYERS);
    }
    assert_near(mean, expected, 1e-12);
    assert_near(got.all, expected, 3 * sqrt(variance));
}

static void late_inputs_are_ignored(void **state)
{
    (void)state;
    check_late(10, 500, 1 - 110.0 / 490); /* D + b / 2 = 120 lies within: 77.6 % */
    check_late(20, 120, 0.05);
}

/* Each input travels with the next `redundancy` ones: copies 0, b and 2 b later are in time for its step,
 * since D + (b - u) >= 2 b. It is missing if all of them are lost. */
static void lost_inputs_are_ignored_unless_a_copy_comes_in_time(void **state)
{
    (void)state;
    for (int redundancy = 0; redundancy <= 2; redundancy++) {
        const setting c = {.sync = "bucket",
                           .delay_ms = 100,
                           .duration_s = 60,
                           .seed = 3,
                           .redundancy = redundancy,
                           .link = "\"loss_pct\":30"};
        const shares got = ignored(&c);
        const double p = pow(0.3, redundancy + 1), n = got.count * PLAYERS;
        /* copies of neighbours are lost together: their covariance is at most their variance */
        const double error = sqrt(p * (1 - p) / n * (1 + 2 * redundancy));
        assert_near(got.all, p, 3 * error);
    }
}

/* ---- next to lockstep ---- */

typedef struct pace {
    ll_time last, longest; /* between two steps */
    int64_t steps;
} pace;

static void note_pace(void *context, const void *row)
{
    const ll_event *e = row;
    pace *p = context;
    if (e->type != LL_EVENT_STEP)
        return;
    p->longest = p->steps > 0 && e->begin - p->last > p->longest ? e->begin - p->last : p->longest;
    p->last = e->begin;
    p->steps++;
}

static pace pace_of(const char *sync, const char *link)
{
    const setting c = {.sync = sync, .delay_ms = 100, .duration_s = 20, .seed = 2, .link = link};
    pace p = {0};
    scene s = open_scene(&c);
    scene_run(&s, 20, &(ll_recorder){.record = note_pace, .context = &p});
    scene_close(&s);
    return p;
}

/* Where lockstep waits for each lost input, the steps in buckets keep the time that they have without loss.
 */
static void lost_packets_stop_lockstep_and_no_bucket(void **state)
{
    (void)state;
    static const char *const loss = "\"loss_pct\":20",
                             *const outage = "\"blackout_at_ms\":5000,\"blackout_length_ms\":3000";
    const pace clean = pace_of("bucket", ""), lossy = pace_of("bucket", loss),
               cut = pace_of("bucket", outage);
    assert_true(clean.longest == BUCKET_MS * LL_MS);
    assert_int_equal(clean.steps, 20 * HZ - 1); /* step k is at k b + D mod b */
    assert_memory_equal(&clean, &lossy, sizeof clean);
    assert_memory_equal(&clean, &cut, sizeof clean);
    const pace waits = pace_of("lockstep_pipelined", loss), stops = pace_of("lockstep_pipelined", outage);
    assert_true(waits.longest > BUCKET_MS * LL_MS * 3 / 2);
    assert_true(stops.longest >= 3000 * LL_MS - 2 * BUCKET_MS * LL_MS);
}

/* ---- the parameter ---- */

/* It acts in a running game. */
static void the_delay_changes_in_a_running_game(void **state)
{
    (void)state;
    setting c = {.sync = "bucket", .delay_ms = 100, .duration_s = 10, .seed = 1};
    scene s = open_scene(&c);
    scene_run(&s, 4, NULL);
    for (int k = 0; k < 2; k++) {
        const double delay_ms = k == 0 ? 250 : 30;
        ll_netgame_config config = scene_config(s.game);
        config.bucket_delay_ms = delay_ms;
        s.scenario.kind->change(s.game, &config, s.game->now);
        tape t = {0};
        ll_recorder r = tape_recorder(&t);
        scene_run(&s, 6 + 2 * k, &r);
        int compared = 0;
        for (size_t i = 0; i < t.count; i++)
            for (size_t j = i; j < t.count && t.events[i].type == LL_EVENT_INPUT; j++) {
                const ll_event *made = &t.events[i], *step = &t.events[j];
                if (step->type != LL_EVENT_STEP || step->number != made->tick)
                    continue;
                const double rest_ms = BUCKET_MS * (1 - (made->player + 0.5) / PLAYERS);
                assert_near(ll_to_ms(step->begin - made->begin) - delay_ms, rest_ms, 3e-6);
                compared++;
                break;
            }
        assert_true(compared > PLAYERS * HZ);
        tape_free(&t);
    }
    scene_close(&s);
}

static uint64_t hash_with(const char *sync, double delay_ms)
{
    const setting c = {.sync = sync, .delay_ms = delay_ms, .duration_s = 3, .seed = 1};
    scene s = open_scene(&c);
    scene_run(&s, 3, NULL);
    uint64_t hash = s.scenario.kind->hash(s.game);
    scene_close(&s);
    return hash;
}

static void other_syncs_do_not_read_the_delay(void **state)
{
    (void)state;
    assert_true(hash_with("free", 100) == hash_with("free", 300));
    assert_true(hash_with("lockstep", 100) == hash_with("lockstep", 300));
    assert_true(hash_with("bucket", 100) != hash_with("bucket", 300));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_response_is_the_delay_and_the_rest_of_the_bucket),
        cmocka_unit_test(the_mean_response_is_the_delay_and_half_a_bucket),
        cmocka_unit_test(late_inputs_are_ignored),
        cmocka_unit_test(lost_inputs_are_ignored_unless_a_copy_comes_in_time),
        cmocka_unit_test(lost_packets_stop_lockstep_and_no_bucket),
        cmocka_unit_test(the_delay_changes_in_a_running_game),
        cmocka_unit_test(other_syncs_do_not_read_the_delay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Spectators: what they show is settled, their presence changes nothing for players, and its price is the
 * copies. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "sim/netgame/readings.h"
#include "sim/netgame/world_log.h"

#define RELAY "peers.topology=relay"
#define MESH "peers.topology=mesh"

static ll_spectator *spectator_of(const scene *s, int i)
{
    return ll_netgame_watcher(ll_netgame_spectator_of(s->game, i));
}

static void assert_sound(const scene *s)
{
    const char *broken = ll_netgame_broken(s->game);
    if (broken)
        fail_msg("%s", broken);
}

/* Continues frame by frame; at each the spectators show worlds that the server has made. Returns the number
 * of shown ticks. */
static int64_t watch(world_log *d, double from_s, double until_s)
{
    int64_t shown[LL_SPECTATORS_MAX] = {0}, count = 0;
    ll_recorder r = {.record = on_event, .context = d};
    for (int i = 0; i < ll_netgame_spectator_count(d->s->game); i++)
        shown[i] = spectator_of(d->s, i)->tick;
    for (int64_t k = (int64_t)(from_s * 60) + 1; k <= (int64_t)(until_s * 60); k++) {
        scene_run(d->s, (double)k / 60 + 1e-6, &r);
        for (int i = 0; i < ll_netgame_spectator_count(d->s->game); i++) {
            const ll_spectator *w = spectator_of(d->s, i);
            assert_true(w->tick >= shown[i] && w->tick <= d->seen[0]);
            count += w->tick > shown[i];
            shown[i] = w->tick;
            if (w->tick > 0 && ll_hash(1, ll_spectator_world(w), d->size) != d->hashes[0][w->tick])
                fail_msg("spectator %d shows another world at tick %lld", i, (long long)w->tick);
        }
    }
    return count;
}

/* One without impairments, one with loss, jitter and duplicates, and one whose link is cut at times. */
#define ALL(SERVER)                                                                                          \
    "spectators=[{\"lag_ms\":20},{\"lag_ms\":120,\"player\":1,\"link\":{\"down\":{\"loss_pct\":20,"          \
    "\"jitter_ms\":60,\"duplicate_pct\":10},\"up\":{\"loss_pct\":20,\"jitter_ms\":60}}},{\"lag_ms\":50,"     \
    "\"player\":" SERVER ",\"link\":{\"down\":{\"blackout_at_ms\":3000,\"blackout_every_ms\":4000,"          \
    "\"blackout_length_ms\":700},\"up\":{\"blackout_at_ms\":4500,\"blackout_every_ms\":8000,"                \
    "\"blackout_length_ms\":1500}}},{\"player\":0,\"lag_ms\":300,\"behind_ticks\":60,\"buffer_ticks\":20,"   \
    "\"link\":{\"down\":{\"blackout_at_ms\":3500,\"blackout_every_ms\":6000,\"blackout_length_ms\":2500,"    \
    "\"loss_pct\":5}}}]"

#define BAD_LINKS                                                                                            \
    "players.0.lag_ms=40", "players.1.lag_ms=90", "players.0.link.up.jitter_ms=30",                          \
        "players.1.link.down.jitter_ms=30", "players.0.link.down.loss_pct=10",                               \
        "players.1.link.up.loss_pct=10", "players.1.link.up.duplicate_pct=10"

static void the_shown_world_is_settled(void **state)
{
    (void)state;
    static const char *const games[] = {"contact", "cannon", "rollback_shooter", "eight"};
    for (int i = 0; i < 20; i++) {
        char seed[32];
        snprintf(seed, sizeof seed, "seed=%d", 100 + i);
        const char *const sets[] = {peer_syncs[i % 2],
                                    i % 4 < 2 ? RELAY : MESH,
                                    i % 4 < 2 ? ALL("-1") : ALL("1"),
                                    "server.update_hz=30",
                                    "warmup_s=0",
                                    "players.0.script=hold",
                                    "players.0.input_delay_ticks=3",
                                    seed,
                                    BAD_LINKS,
                                    NULL};
        scene s = scene_open(games[i / 4 % 4], sets);
        world_log d = log_of(&s, 0);
        int64_t shown = watch(&d, 0, i / 4 % 4 < 3 ? 14 : 8);
        assert_true(shown > d.seen[0]); /* of four spectators */
        assert_sound(&s);
        assert_true(spectator_of(&s, 0)->tick > d.seen[0] - 90);
        assert_int_equal(spectator_of(&s, 0)->falls, 0);
        bool slow = d.seen[0] < 100; /* eight wait for each other: it has few ticks to fall out with */
        assert_true(slow || (spectator_of(&s, 3)->falls > 0 && spectator_of(&s, 3)->worlds > 0));
        log_free(&d);
        scene_close(&s);
    }
}

/* ---- observing changes nothing ---- */

/* Of all that players, their links and the server have: up to the spectators of a block that has them. */
static uint64_t hash_of_players(const scene *s, const scene *with)
{
    const ll_netgame *g = s->game;
    int64_t end = ll_netgame_spectators_of(with->game)->at[0];
    assert_int_equal(g->server, with->game->server);
    return ll_hash(1, (const char *)g + g->server, (size_t)(end - g->server));
}

static double wire_bytes(const cJSON *metrics, int player, const char *what)
{
    char path[96];
    snprintf(path, sizeof path, "players.%d.bandwidth.%s.wire_bytes_per_s", player, what);
    return value(metrics, path);
}

static double spectator_value(const cJSON *metrics, int i, const char *what)
{
    char path[96];
    snprintf(path, sizeof path, "spectators.%d.%s", i, what);
    return value(metrics, path);
}

/* The blocks are equal to the last bit up to the spectators, and so are all metrics but for the bytes: of
 * each sender they rise by those of its copies, and of those that come back. */
static void players_are_the_same_without_them(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        const char *const sets[] = {peer_syncs[i % 2],
                                    i / 2 % 2 ? MESH : RELAY,
                                    "server.update_hz=30",
                                    i / 4 ? "peers.time_sync=stretch" : "peers.time_sync=wait",
                                    BAD_LINKS,
                                    i / 2 % 2 ? ALL("1") : ALL("-1"),
                                    NULL};
        const char *without[sizeof sets / sizeof sets[0]];
        memcpy(without, sets, sizeof sets);
        without[sizeof sets / sizeof sets[0] - 2] = NULL;
        scene a = scene_open("contact", without), b = scene_open("contact", sets);
        for (int k = 1; k <= 8; k++) {
            scene_run(&a, k, NULL);
            scene_run(&b, k, NULL);
            assert_true(hash_of_players(&a, &b) == hash_of_players(&b, &b));
        }
        cJSON *x = ll_netgame_metrics(a.game), *y = ll_netgame_metrics(b.game);
        assert_null(at(x, "spectators"));
        for (int p = 0; p < 2; p++) {
            double copies = 0, acks = 0;
            for (int w = 0; w < 4; w++)
                if (ll_netgame_spectator_of(b.game, w)->params.player == p) {
                    copies += spectator_value(y, w, "wire_bytes_per_s");
                    acks += spectator_value(y, w, "ack_bytes_per_s");
                }
            assert_true(copies > 0 && acks > 0);
            assert_true(fabs(wire_bytes(y, p, "input") - wire_bytes(x, p, "input") - copies) < 1e-6);
            assert_true(fabs(wire_bytes(y, p, "relay") - wire_bytes(x, p, "relay") - acks) < 1e-6);
            cJSON_DeleteItemFromObject(cJSON_GetArrayItem(at(x, "players"), p), "bandwidth");
            cJSON_DeleteItemFromObject(cJSON_GetArrayItem(at(y, "players"), p), "bandwidth");
        }
        char *one = cJSON_Print(at(x, "players")), *other = cJSON_Print(at(y, "players"));
        assert_string_equal(one, other);
        free(one);
        free(other);
        cJSON_Delete(x);
        cJSON_Delete(y);
        scene_close(&a);
        scene_close(&b);
    }
}

/* ---- age ---- */

/* From the server: the wait for an update, the lag, and the wait for a tick of the spectator's machine. From
 * a client: also the time until its own input is acknowledged, at most a round trip and the relay's wait. */
static void the_age_is_that_of_the_way(void **state)
{
    (void)state;
    static const double lags[] = {0, 35, 100, 400};
    const double period = 1000.0 / 60, update = 1000.0 / 30;
    for (int i = 0; i < 4; i++) {
        char one[160];
        snprintf(one, sizeof one, "spectators=[{\"lag_ms\":%g,\"player\":-1},{\"lag_ms\":%g,\"player\":1}]",
                 lags[i], lags[i]);
        const char *const sets[] = {"server.update_hz=30", one, NULL};
        scene s = scene_open("rollback", sets);
        scene_run(&s, 20, NULL);
        cJSON *metrics = ll_netgame_metrics(s.game);
        double mean = spectator_value(metrics, 0, "age_ms.mean"),
               most = spectator_value(metrics, 0, "age_ms.max");
        /* A packet brings two ticks, and one of them waits for a tick more. */
        assert_true(mean >= lags[i] && most <= lags[i] + update + 2 * period);
        double round_trip = 2 * 60 + update + period;
        mean = spectator_value(metrics, 1, "age_ms.mean");
        most = spectator_value(metrics, 1, "age_ms.max");
        assert_true(mean >= lags[i] + 115 && most <= lags[i] + round_trip + update + 4 * period);
        assert_true(spectator_value(metrics, 0, "catch_up_ticks") == 0);
        assert_true(spectator_value(metrics, 0, "fell_out") == 0);
        cJSON_Delete(metrics);
        scene_close(&s);
    }
}

/* ---- outages ---- */

/* The link down is cut for a while. Up to 60 ticks it catches up; longer, and it falls out once, and a world
 * brings it back. */
static void outages_are_caught_up_or_told(void **state)
{
    (void)state;
    for (int length = 100; length <= 2500; length += 400) {
        char one[256];
        snprintf(one, sizeof one,
                 "spectators=[{\"lag_ms\":50,\"link\":{\"down\":{\"blackout_at_ms\":8000,\"blackout_length_"
                 "ms\":%d}"
                 "}}]",
                 length);
        const char *const sets[] = {MESH, "params.laps=10000", one, NULL};
        scene s = scene_open("rollback", sets);
        world_log d = log_of(&s, 0);
        watch(&d, 0, 14);
        const ll_spectator *w = spectator_of(&s, 0);
        const int missed = length * 60 / 1000;
        cJSON *metrics = ll_netgame_metrics(s.game);
        if (abs(missed - 60) > 2)
            assert_int_equal(w->falls, missed > 60);
        assert_int_equal(w->worlds, w->falls);
        if (w->falls == 0) { /* with the tick that comes next */
            assert_true(fabs((double)w->catch_up - (missed > 10 ? missed + 1 - 10 : 0)) <= 2);
            assert_true(spectator_value(metrics, 0, "out_s") == 0);
        } else { /* a request, at once, and its answer */
            double out = spectator_value(metrics, 0, "out_s");
            assert_true(out >= 0.1 - 0.01 && out <= 0.1 + 4.0 / 60);
        }
        assert_true(w->known - w->tick <= 11);
        assert_true(w->tick > ll_netgame_server(s.game)->step - 40);
        cJSON_Delete(metrics);
        log_free(&d);
        scene_close(&s);
    }
}

/* Its sender is cut off, is dropped, and joins again: the inputs that it made in between have no effect, and
 * no spectator has seen them. */
static void a_sender_who_leaves_sends_nothing_that_changes(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        char seed[32];
        snprintf(seed, sizeof seed, "seed=%d", i);
        const char *const sets[] = {peer_syncs[i % 2],
                                    i / 2 % 2 ? MESH : RELAY,
                                    "server.timeout_s=2",
                                    "server.update_hz=30",
                                    "params.laps=10000",
                                    seed,
                                    "players.0.input_delay_ticks=6",
                                    "players.1.input_delay_ticks=6",
                                    "spectators=[{\"lag_ms\":30,\"player\":1},{\"lag_ms\":30,\"player\":0}]",
                                    NULL};
        scene s = scene_open("rollback", sets);
        world_log d = log_of(&s, 0);
        watch(&d, 0, 5);
        set_loss(&s, 1, 100);
        watch(&d, 5, 9);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[1].connection.connected, 0);
        set_loss(&s, 1, 0);
        watch(&d, 9, 16);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[1].connection.connected, 1);
        for (int w = 0; w < 2; w++)
            assert_true(spectator_of(&s, w)->tick > d.seen[0] - 60);
        assert_int_equal(spectator_of(&s, 0)->out, 0);
        assert_int_equal(spectator_of(&s, 1)->falls, 0);
        assert_sound(&s);
        log_free(&d);
        scene_close(&s);
    }
}

/* A change of the sync starts a game in another epoch, for spectators too. */
static void they_follow_a_change_of_the_sync(void **state)
{
    (void)state;
    const char *const sets[] = {peer_syncs[0], MESH, "server.update_hz=30", ALL("1"), NULL};
    scene s = scene_open("contact", sets);
    ll_netgame_config *config = malloc(sizeof *config);
    for (int k = 0; k < 6; k++) {
        scene_run(&s, 3 + 3 * k, NULL);
        *config = scene_config(s.game);
        config->server.sync = k % 2 ? 3 : 4;
        s.scenario.kind->change(s.game, config, s.game->now);
        int64_t step = ll_netgame_server(s.game)->step;
        for (int i = 0; i < 4; i++)
            assert_int_equal(spectator_of(&s, i)->tick, step);
        assert_sound(&s);
    }
    scene_run(&s, 21, NULL);
    assert_true(spectator_of(&s, 0)->tick > ll_netgame_server(s.game)->step - 40);
    free(config);
    scene_close(&s);
}

/* ---- refusals ---- */

static void assert_refused(const char *const *sets, int count, const char *text)
{
    scene s = scene_open("rollback", NULL);
    ll_netgame_config *config = malloc(ll_netgame_table.size);
    memcpy(config, s.scenario.config, ll_netgame_table.size);
    ll_status status = ll_param_put(&ll_netgame_table, config, sets, count);
    assert_false(ll_failed(&status));
    status = ll_param_check(&ll_netgame_table, config);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.text, text);
    free(config);
    scene_close(&s);
}

static void what_no_one_can_watch_is_refused(void **state)
{
    (void)state;
    assert_refused(
        (const char *const[]){"server.sync=free", "spectators=[{}]"}, 2,
        "spectators: must be none unless server.sync is deterministic or rollback; got 1 with free");
    assert_refused((const char *const[]){"server.transport=tcp", "spectators=[{},{}]"}, 2,
                   "spectators: must be none unless server.transport is udp; got 2 with tcp");
    assert_refused((const char *const[]){MESH, "spectators=[{\"player\":-1}]"}, 2,
                   "spectators.0.player: must be a player in a mesh; got -1");
    assert_refused((const char *const[]){"spectators=[{},{\"player\":2}]"}, 1,
                   "spectators.1.player: must be -1 to 1; got 2");
    assert_refused(
        (const char *const[]){"spectators=[{\"lag_ms\":1000,\"link\":{\"up\":{\"delay_ms\":300}}}]"}, 1,
        "spectators.0.link.up must delay a packet by at most 1250 ms; got 1300");
    assert_refused((const char *const[]){"spectators=[{\"link\":{\"down\":{\"profile\":\"profile_0\"}}}]"}, 1,
                   "spectators.0.link.down: must have the profile none; got profile_0");
}

/* ---- streamed ---- */

static double field(const ll_rows *rows, int row, const char *name)
{
    const ll_record *record = rows->record;
    for (int i = 0; i < record->count; i++)
        if (strcmp(record->fields[i].name, name) == 0)
            return ll_field_value(&record->fields[i], ll_rows_at(rows, row)[i]);
    fail_msg("the record has no field %s", name);
    return NAN;
}

/* The rows of both records; the caller frees `set`. */
static void look(const scene *s, ll_row_set *set)
{
    ll_row_set_add(set, &ll_netgame_spectator_record, true);
    ll_row_set_add(set, &ll_netgame_spectated_record, true);
    ll_netgame_fill_spectators(s->game, set);
    ll_netgame_fill_spectated(s->game, set);
    assert_false(set->failed);
}

static void assert_shown(const scene *s, const ll_rows *rows)
{
    const double step_m = 1.0 / (1 << LL_BITS_M);
    int row = 0;
    for (int i = 0; i < ll_netgame_spectator_count(s->game); i++) {
        const ll_world *world = ll_spectator_world(spectator_of(s, i));
        for (int k = 0; k < world->entities; k++, row++) {
            assert_true(row < rows->count);
            assert_int_equal(field(rows, row, "view"), 1 + world->players + i);
            assert_int_equal(field(rows, row, "entity"), k);
            assert_true(fabs(field(rows, row, "x") - world->entity[k].x) <= step_m);
            assert_true(fabs(field(rows, row, "y") - world->entity[k].y) <= step_m);
        }
    }
    assert_int_equal(rows->count, row);
}

/* A spectator's row, frame by frame. */
typedef struct glimpse {
    int state;
    double tick, catch_up, falls, age_ms;
} glimpse;

enum { FOLLOWING, CATCHING_UP, OUT, STATES };

static glimpse glimpse_of(const scene *s, const ll_rows *rows, int i)
{
    const ll_spectator *w = spectator_of(s, i);
    assert_int_equal(field(rows, i, "spectator"), i);
    assert_int_equal(field(rows, i, "buffered"), w->known - w->tick);
    return (glimpse){.state = (int)field(rows, i, "state"),
                     .tick = field(rows, i, "tick"),
                     .catch_up = field(rows, i, "catch_up"),
                     .falls = field(rows, i, "falls"),
                     .age_ms = field(rows, i, "age_ms")};
}

/* What a state says is what the next frame has: catching up it made two ticks, out it made none. */
static void assert_follows(const glimpse *before, const glimpse *now, double lag_ms)
{
    assert_true(now->age_ms >= lag_ms);
    if (now->tick == before->tick)
        assert_true(fabs(now->age_ms - before->age_ms - 1000.0 / 60) < 0.1);
    if (before->state == CATCHING_UP && now->state != OUT)
        assert_true(now->catch_up == before->catch_up + 1 && now->tick == before->tick + 2);
    if (before->state == OUT && now->state == OUT)
        assert_true(now->tick == before->tick);
    assert_true(now->falls == before->falls + (before->state != OUT && now->state == OUT));
}

static void what_they_show_is_streamed(void **state)
{
    (void)state;
    static const double lags[] = {50, 80, 80};
    const char *const sets[] = {
        MESH, "params.laps=10000",
        "spectators=[{\"lag_ms\":50},{\"lag_ms\":80,\"link\":{\"down\":{\"blackout_at_ms\":5000,"
        "\"blackout_length_ms\":700}}},{\"lag_ms\":80,\"link\":{\"down\":{\"blackout_at_ms\":5000,"
        "\"blackout_length_ms\":1500}}}]",
        NULL};
    scene s = scene_open("rollback", sets);
    glimpse before[3] = {0};
    int seen[3][STATES] = {0};
    for (int k = 180; k <= 480; k++) {
        scene_run(&s, (double)k / 60 + 1e-6, NULL);
        ll_row_set set = {0};
        look(&s, &set);
        assert_int_equal(set.rows[0]->count, 3);
        assert_shown(&s, set.rows[1]);
        for (int i = 0; i < 3; i++) {
            glimpse now = glimpse_of(&s, set.rows[0], i);
            if (k > 180)
                assert_follows(&before[i], &now, lags[i]);
            seen[i][now.state]++;
            before[i] = now;
        }
        ll_row_set_free(&set);
    }
    assert_true(seen[0][FOLLOWING] == 301);
    assert_true(seen[1][CATCHING_UP] >= 20 && seen[1][OUT] == 0);
    assert_true(seen[2][OUT] >= 5 && before[2].falls == 1);
    scene_close(&s);
}

static void without_any_there_are_no_rows(void **state)
{
    (void)state;
    const char *const sets[] = {MESH, NULL};
    scene s = scene_open("rollback", sets);
    ll_row_set set = {0};
    scene_run(&s, 2, NULL);
    look(&s, &set);
    assert_int_equal(set.rows[0]->count + set.rows[1]->count, 0);
    ll_row_set_free(&set);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_shown_world_is_settled),
        cmocka_unit_test(players_are_the_same_without_them),
        cmocka_unit_test(the_age_is_that_of_the_way),
        cmocka_unit_test(outages_are_caught_up_or_told),
        cmocka_unit_test(a_sender_who_leaves_sends_nothing_that_changes),
        cmocka_unit_test(they_follow_a_change_of_the_sync),
        cmocka_unit_test(what_no_one_can_watch_is_refused),
        cmocka_unit_test(what_they_show_is_streamed),
        cmocka_unit_test(without_any_there_are_no_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

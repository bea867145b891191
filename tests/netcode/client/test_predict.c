/* Prediction and reconciliation of the own entity. */
#include "netcode/toy.h"

#include "base/rng.h"
#include "game/games/games.h"

#define FRAMES 600
#define DELAY 9 /* frames from an input to the snapshot that includes it */

/* Two cars; the own one is pushed at times that no client can predict. */
typedef struct race_state {
    _Alignas(8) char bytes[sizeof(ll_world) + 2 * sizeof(ll_entity) + 128];
} race_state;

typedef struct race_track {
    ll_game_env env;
    race_state state[FRAMES + 1]; /* after each step */
    ll_action actions[FRAMES + 1];
    size_t size;
} race_track;

static ll_world *world_of(race_state *s)
{
    return (ll_world *)s->bytes;
}

static race_track *new_track(bool pushes)
{
    race_track *t = calloc(1, sizeof *t);
    char params[128];
    ll_param_defaults(&ll_race_table, params);
    t->env.dt = 1.0 / 60;
    t->env.dt_ns = LL_SECOND / 60;
    ll_game_race.prepare(&t->env, params);
    ll_extent extent = ll_game_race.extent(NULL, 2);
    t->size = ll_extent_size(extent);
    assert_true(t->size <= sizeof(race_state));
    world_of(&t->state[0])->players = world_of(&t->state[0])->entities = 2;
    world_of(&t->state[0])->tail = extent.tail;
    ll_game_race.init(world_of(&t->state[0]), &t->env, (const int32_t[]){0, 1});
    for (int k = 1; k <= FRAMES; k++) {
        t->actions[k] = push(ll_rng_unit(5, 0, (uint64_t)k / 20) * 2 - 0.7);
        ll_action both[2] = {t->actions[k], push(0.5)};
        t->state[k] = t->state[k - 1];
        ll_game_race.step(world_of(&t->state[k]), &t->env, both, ll_tick_time(k, HZ(60)), NULL);
        if (pushes && k % 50 < 3)
            world_of(&t->state[k])->entity[0].vx *= 0.9;
    }
    return t;
}

static lone *new_racer(const ll_game *game, race_track *t)
{
    lone *l = new_lone(2, game, &ll_sync_free);
    free(l->client);
    l->client = malloc(ll_client_size(ll_game_race.extent(NULL, 2)));
    l->env = t->env;
    l->config.prediction = l->config.reconciliation = true;
    l->config.slack_ticks = 0;
    ll_client_init(l->client, 0, world_of(&t->state[0]));
    measure_clock(l, 0);
    ll_client_start(l->client, &l->setup,
                    &(ll_client_begin){.epoch = 1, .freq = HZ(60), .world = world_of(&t->state[0])}, 0);
    return l;
}

/* Frame k (from 1 on) makes input k; the snapshot after input k arrives before frame k + DELAY, for every
 * third k. */
static void race_frame(lone *l, race_track *t, int k)
{
    struct {
        ll_snapshot_message head;
        race_state world;
    } p;
    int old = k - DELAY;
    ll_time now = ll_tick_time(k - 1, HZ(60));
    if (old > 0 && old % 3 == 0) {
        p.head = state_of(old, ll_tick_time(old, HZ(60)), (uint32_t)old, 0, NULL).head;
        p.world = t->state[old];
        int size = (int)(sizeof p.head + ll_world_size(world_of(&p.world)));
        assert_int_equal(ll_client_receive(l->client, &l->setup, &p, size, now), LL_OUTCOME_APPLIED);
    }
    l->client->inputs.held = t->actions[k];
    frame(l, now, NULL);
    assert_int_equal(l->client->inputs.seq, k);
}

static const ll_entity *own(const lone *l)
{
    return &ll_client_rendered(l->client)->entity[0];
}

/* If no snapshot differs, the prediction equals bitwise the truth at the time when the input counts. */
static void prediction_equals_the_truth_to_come(void **state)
{
    (void)state;
    race_track *t = new_track(false);
    lone *l = new_racer(&ll_game_race, t);
    for (int k = 1; k <= FRAMES; k++) {
        race_frame(l, t, k);
        assert_memory_equal(own(l), &world_of(&t->state[k])->entity[0], sizeof(ll_entity));
        assert_int_equal(ll_client_draw_infos(l->client)[0].flags, LL_RENDERED_PREDICTED);
        assert_int_equal(ll_client_draw_infos(l->client)[0].time, ll_tick_time(k - 1, HZ(60)));
    }
    assert_int_equal(l->client_metrics->corrections.count, 0);
    free_lone(l);
    free(t);
}

/* A game whose own step reads the tail is replayed at every snapshot; other games only when the snapshot
 * differs from the prediction. Both must draw the same. */
static void shortcut_equals_the_full_replay(void **state)
{
    (void)state;
    race_track *t = new_track(true);
    ll_game always = ll_game_race;
    always.own_reads_world = true;
    lone *a = new_racer(&ll_game_race, t), *b = new_racer(&always, t);
    for (int k = 1; k <= FRAMES; k++) {
        race_frame(a, t, k);
        race_frame(b, t, k);
        assert_memory_equal(own(a), own(b), sizeof(ll_entity));
        assert_int_equal(a->client_metrics->corrections.count, b->client_metrics->corrections.count);
    }
    assert_true(a->client_metrics->corrections.count > 10);
    free_lone(a);
    free_lone(b);
    free(t);
}

/* The replay itself, against one written here: the snapshot, and on it every input that it does not
 * include. */
static void replay_is_state_and_open_inputs(void **state)
{
    (void)state;
    race_track *t = new_track(true);
    lone *l = new_racer(&ll_game_race, t);
    for (int k = 1; k <= FRAMES; k++) {
        race_frame(l, t, k);
        int base = (k - DELAY) / 3 * 3;
        race_state expected = t->state[base > 0 ? base : 0];
        for (int j = (base > 0 ? base : 0) + 1; j <= k; j++)
            ll_game_race.step_own(world_of(&expected), &t->env, 0, &t->actions[j]);
        assert_memory_equal(own(l), &world_of(&expected)->entity[0], sizeof(ll_entity));
    }
    free_lone(l);
    free(t);
}

/* Off, the client draws the last snapshot; on again, it draws what it would have drawn had it never been
 * off. */
static void prediction_may_be_toggled(void **state)
{
    (void)state;
    race_track *t = new_track(true);
    lone *a = new_racer(&ll_game_race, t), *b = new_racer(&ll_game_race, t);
    for (int k = 1; k <= FRAMES; k++) {
        b->config.prediction = b->config.reconciliation = k / 37 % 2 == 0;
        race_frame(a, t, k);
        race_frame(b, t, k);
        if (b->config.prediction) {
            assert_memory_equal(own(a), own(b), sizeof(ll_entity));
            assert_int_equal(ll_client_draw_infos(b->client)[0].flags, LL_RENDERED_PREDICTED);
            continue;
        }
        int base = k > DELAY ? (k - DELAY) / 3 * 3 : 0;
        assert_memory_equal(own(b), &world_of(&t->state[base])->entity[0], sizeof(ll_entity));
        assert_int_equal(ll_client_draw_infos(b->client)[0].flags, 0);
    }
    free_lone(a);
    free_lone(b);
    free(t);
}

/* Prediction alone: every snapshot resets the car to where the server had it; later inputs are lost. */
static void without_reconciliation_states_win(void **state)
{
    (void)state;
    race_track *t = new_track(false);
    lone *l = new_racer(&ll_game_race, t);
    l->config.reconciliation = false;
    race_state expected = t->state[0];
    for (int k = 1; k <= FRAMES; k++) {
        race_frame(l, t, k);
        if (k > DELAY && (k - DELAY) % 3 == 0)
            expected = t->state[k - DELAY];
        ll_game_race.step_own(world_of(&expected), &t->env, 0, &t->actions[k]);
        assert_memory_equal(own(l), &world_of(&expected)->entity[0], sizeof(ll_entity));
    }
    free_lone(l);
    free(t);
}

/* A snapshot that acknowledges more than was ever sent: the client applies it and continues. */
static void acknowledged_beyond_the_newest_input(void **state)
{
    (void)state;
    const uint32_t acks[] = {6, 300, 5 + LL_PENDING_RING, UINT32_MAX};
    for (size_t i = 0; i < 2 * sizeof acks / sizeof acks[0]; i++) {
        lone *l = new_lone(1, &toy, i % 2 ? &ll_sync_gambetta : &ll_sync_free);
        packet p = state_of(5, 5, acks[i / 2], 1, (double[]){100});
        l->config.prediction = l->config.reconciliation = true;
        l->config.slack_ticks = 0;
        start_lone(l, 60, 0, 0);
        l->client->inputs.held = push(0.5);
        for (int f = 0; f < 5; f++)
            frame(l, f, NULL);
        assert_true(ll_client_rendered(l->client)->entity[0].x == 2.5);
        give(l, &p, 5);
        frame(l, 6, NULL);
        assert_int_equal(l->client->inputs.acked, 5);
        assert_int_equal(l->client->inputs.seq, 6);
        assert_true(ll_client_rendered(l->client)->entity[0].x ==
                    100.5); /* the snapshot and the one input since */
        frame(l, 7, NULL);
        assert_true(ll_client_rendered(l->client)->entity[0].x == 101);
        free_lone(l);
    }
}

/* The slot of such an input holds an older one, whose prediction proves nothing. */
static void acknowledged_beyond_the_ring(void **state)
{
    (void)state;
    for (int drains = 0; drains < 2; drains++) {
        lone *l = new_lone(1, &toy, drains ? &ll_sync_gambetta : &ll_sync_free);
        packet p = state_of(5, 5, 3 + LL_PENDING_RING, 1, (double[]){1.5});
        p.entity[0].vx = 0.5; /* as after input 3 */
        l->config.prediction = l->config.reconciliation = true;
        l->config.slack_ticks = 0;
        start_lone(l, 60, 0, 0);
        l->client->inputs.held = push(0.5);
        for (int f = 0; f < 5; f++)
            frame(l, f, NULL);
        give(l, &p, 5);
        frame(l, 6, NULL);
        assert_true(ll_client_rendered(l->client)->entity[0].x == 2);
        free_lone(l);
    }
}

/* Where inputs belong to steps, the snapshot's step determines which it includes, not what it claims to have
 * processed: if a server claims inputs for later steps, those still count as open. */
static void a_state_includes_the_inputs_up_to_its_step(void **state)
{
    (void)state;
    for (int64_t tick = 1; tick <= 5; tick++)
        for (uint32_t claim = (uint32_t)tick; claim <= 5; claim++) {
            lone *l = new_lone(1, &toy, &ll_sync_free);
            packet p = state_of(tick, 5, claim, 1, (double[]){100});
            l->config.prediction = l->config.reconciliation = true;
            l->config.slack_ticks = 0;
            start_lone(l, 60, 0, 0);
            for (int f = 0; f < 5; f++) {
                l->client->inputs.held = push(1 << f);
                frame(l, f, NULL);
            }
            l->client->inputs.held = push(32);
            give(l, &p, 5);
            frame(l, 6, NULL); /* 1 + 2 + ... + 32 by then, without the first `tick` */
            assert_true(ll_client_rendered(l->client)->entity[0].x == 100 + 64 - (1 << tick));
            free_lone(l);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prediction_equals_the_truth_to_come),
        cmocka_unit_test(shortcut_equals_the_full_replay),
        cmocka_unit_test(replay_is_state_and_open_inputs),
        cmocka_unit_test(prediction_may_be_toggled),
        cmocka_unit_test(without_reconciliation_states_win),
        cmocka_unit_test(acknowledged_beyond_the_newest_input),
        cmocka_unit_test(acknowledged_beyond_the_ring),
        cmocka_unit_test(a_state_includes_the_inputs_up_to_its_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

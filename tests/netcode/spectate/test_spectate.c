/* One spectator and what its sender keeps for it, fed by hand. The toy's world is the sum of the inputs. */
#include "netcode/toy.h"

#include "netcode/spectate/feed.h"
#include "netcode/spectate/spectator.h"

#define PLAYERS 2
#define STEP_HZ 50

/* The server steps; a packet is in the hand of the test. */
typedef struct pair {
    ll_server *server;
    ll_feed *feed;
    ll_spectator *spectator;
    ll_spectator_params params;
    ll_game_env env;
    _Alignas(8) char packet[1 << 14];
} pair;

static double input_of(int player, int64_t tick)
{
    return (double)(tick * (player + 2) % 7) / 8;
}

static pair *new_pair(void)
{
    pair *w = calloc(1, sizeof *w);
    size_t world_size = ll_extent_size(toy_extent(NULL, PLAYERS));
    w->server = new_server(PLAYERS, NULL, STEP_HZ, STEP_HZ);
    w->feed = malloc(ll_feed_size(PLAYERS));
    w->spectator = calloc(1, ll_spectator_size(PLAYERS, world_size));
    ll_param_defaults(&ll_spectator_table, &w->params);
    ll_feed_start(w->feed, PLAYERS, 1, 0);
    ll_spectator_start(w->spectator, ll_server_world(w->server), 1, 0, w->server->clock);
    return w;
}

static void free_pair(pair *w)
{
    free(w->server);
    free(w->feed);
    free(w->spectator);
    free(w);
}

/* `count` steps of the server by hand. */
static void steps(pair *w, int count)
{
    for (int i = 0; i < count; i++) {
        int64_t k = ++w->server->step;
        ll_action actions[PLAYERS];
        for (int p = 0; p < PLAYERS; p++) {
            actions[p] = push(input_of(p, k));
            w->server->client_slots[p].inputs.ring[k & (LL_INPUT_RING - 1)] =
                (ll_input_slot){.tick = k, .action = actions[p]};
        }
        toy_step(ll_server_world(w->server), &w->env, actions, 0, NULL);
    }
    ll_feed_follow_server(w->feed, w->server);
}

static int compose(pair *w)
{
    return ll_feed_compose(w->feed, ll_server_world(w->server), w->packet);
}

/* A packet that arrives. */
static void send(pair *w)
{
    assert_true(compose(w) > 0);
    ll_spectator_receive(w->spectator, &w->params, w->packet);
}

static void acknowledge(pair *w)
{
    ll_watch_message m;
    if (ll_spectator_compose(w->spectator, &m))
        ll_feed_receive(w->feed, &m);
}

static int tick(pair *w)
{
    return ll_spectator_tick(w->spectator, &w->params, &toy, &w->env);
}

static double sum_to(int player, int64_t step)
{
    double sum = 0;
    for (int64_t k = 1; k <= step; k++)
        sum += input_of(player, k);
    return sum;
}

static void assert_shows(const pair *w, int64_t step)
{
    assert_int_equal(w->spectator->tick, step);
    for (int p = 0; p < PLAYERS; p++)
        assert_true(ll_spectator_world(w->spectator)->entity[p].x == sum_to(p, step));
}

static void it_shows_a_tick_per_tick(void **state)
{
    (void)state;
    pair *w = new_pair();
    assert_int_equal(tick(w), 0);
    assert_int_equal(w->spectator->waits, 1);
    for (int k = 1; k <= 300; k++) {
        steps(w, 1);
        send(w);
        assert_int_equal(tick(w), 1);
        acknowledge(w);
        assert_shows(w, k);
        assert_int_equal(compose(w), 0); /* all is acknowledged */
    }
    assert_int_equal(w->spectator->catch_up, 0);
    assert_int_equal(w->spectator->falls, 0);
    free_pair(w);
}

/* What is not acknowledged is sent again, so that it does not matter which packets are lost or come twice. */
static void lost_packets_and_acknowledgements_change_nothing(void **state)
{
    (void)state;
    pair *w = new_pair();
    for (int k = 1; k <= 2000; k++) {
        uint32_t draw = (uint32_t)k * 2654435761u >> 16;
        steps(w, 1);
        if (compose(w) > 0 && draw % 3 != 0)
            for (uint32_t i = 0; i <= draw % 5 / 4; i++)
                ll_spectator_receive(w->spectator, &w->params, w->packet);
        tick(w);
        assert_shows(w, w->spectator->tick);
        if (draw % 7 < 4)
            acknowledge(w);
    }
    assert_true(w->spectator->tick > 1980);
    assert_int_equal(w->spectator->falls, 0);
    free_pair(w);
}

/* B ticks behind are caught up by one more tick each: B - 10 of them. At B of 60 it is in, at 61 it is out.
 */
static void it_catches_up_from_more_than_behind_ticks(void **state)
{
    (void)state;
    for (int behind = 1; behind <= 61; behind++) {
        pair *w = new_pair();
        for (int i = 0; i < behind; i += 20) { /* at most 32 runs are in a packet */
            steps(w, behind - i < 20 ? behind - i : 20);
            send(w);
            acknowledge(w);
        }
        assert_int_equal(w->spectator->out, behind > 60);
        assert_int_equal(w->spectator->falls, behind > 60);
        for (int k = 0; k < 200 && behind <= 60; k++) {
            int64_t ahead = w->spectator->known - w->spectator->tick;
            assert_int_equal(tick(w), ahead > 10 ? 2 : 1);
            steps(w, 1);
            send(w);
            acknowledge(w);
            assert_shows(w, w->spectator->tick);
        }
        if (behind <= 60)
            assert_int_equal(w->spectator->catch_up, behind > 10 ? behind - 10 : 0);
        free_pair(w);
    }
}

/* It shows the same tick until a world comes, and asks each 15 ticks of its machine. */
static void a_world_brings_it_back(void **state)
{
    (void)state;
    pair *w = new_pair();
    steps(w, 5);
    send(w);
    tick(w);
    acknowledge(w);
    steps(w, 200); /* of these the sender keeps 128 */
    send(w);
    assert_int_equal(w->spectator->out, 1);
    int asks = 0;
    for (int k = 0; k < 45; k++) {
        ll_watch_message m;
        assert_int_equal(tick(w), 0);
        assert_shows(w, 1);
        bool asked = ll_spectator_compose(w->spectator, &m);
        asks += asked;
        assert_int_equal(asked ? m.request : 1, 1);
        if (asked && k > 0)
            ll_feed_receive(w->feed, &m); /* the first request was lost */
    }
    assert_int_equal(asks, 3);
    steps(w, 1);
    send(w);
    assert_int_equal(w->spectator->out, 0);
    assert_int_equal(w->spectator->worlds, 1);
    assert_shows(w, 206);
    for (int k = 207; k < 300; k++) {
        steps(w, 1);
        send(w);
        assert_int_equal(tick(w), 1);
        assert_shows(w, k);
        acknowledge(w);
    }
    assert_int_equal(w->spectator->falls, 1);
    free_pair(w);
}

/* A request that is repeated because the answer is on its way is answered once more, and no input is left
 * out. */
static void a_second_answer_leaves_no_gap(void **state)
{
    (void)state;
    pair *w = new_pair();
    ll_watch_message m;
    _Alignas(8) char first[256];
    steps(w, 200);
    send(w);
    assert_true(ll_spectator_compose(w->spectator, &m));
    ll_feed_receive(w->feed, &m);
    int bytes = compose(w);
    assert_true(bytes <= (int)sizeof first);
    memcpy(first, w->packet, (size_t)bytes);
    for (int k = 0; k < 15; k++)
        tick(w);
    assert_true(ll_spectator_compose(w->spectator, &m)); /* again */
    ll_feed_receive(w->feed, &m);
    steps(w, 3);
    assert_true(((ll_feed_message *)(void *)w->packet)->world == 1 && compose(w) > 0);
    ll_spectator_receive(w->spectator, &w->params, first);
    assert_shows(w, 200);
    steps(w, 1);
    send(w);
    for (int k = 201; k <= 204; k++) {
        assert_int_equal(tick(w), 1);
        assert_shows(w, k);
    }
    assert_int_equal(w->spectator->falls, 1);
    free_pair(w);
}

/* 20 bytes, and for each player 4 and 16 for each run of equal inputs. */
static void a_packet_has_runs(void **state)
{
    (void)state;
    for (int ticks = 1; ticks <= 40; ticks++) {
        pair *w = new_pair();
        steps(w, ticks);
        int bytes = compose(w), runs = 0, count = ticks;
        for (int k = 1; k <= ticks; k++) {
            runs += k == 1 || input_of(0, k) != input_of(0, k - 1);
            runs += k == 1 || input_of(1, k) != input_of(1, k - 1);
        }
        if (runs > 2 * LL_RUNS_MAX) { /* both change with each tick */
            runs = 2 * LL_RUNS_MAX;
            count = LL_RUNS_MAX;
        }
        const ll_feed_message *m = (const ll_feed_message *)(const void *)w->packet;
        assert_int_equal(m->count, count);
        assert_int_equal(bytes, (int)sizeof *m + 2 * 4 + runs * 16);
        free_pair(w);
    }
}

/* Packets of an earlier game are discarded, on both sides. */
static void an_epoch_ends_what_was_sent(void **state)
{
    (void)state;
    pair *w = new_pair();
    ll_watch_message m;
    steps(w, 3);
    send(w);
    assert_true(ll_spectator_compose(w->spectator, &m));
    ll_spectator_start(w->spectator, ll_server_world(w->server), 2, 3, w->server->clock);
    ll_feed_start(w->feed, PLAYERS, 2, 3);
    ll_spectator_receive(w->spectator, &w->params, w->packet);
    assert_int_equal(w->spectator->known, 3);
    steps(w, 1);
    m.known = 4;
    ll_feed_receive(w->feed, &m);
    send(w);
    assert_int_equal(w->spectator->known, 4);
    free_pair(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_shows_a_tick_per_tick),
        cmocka_unit_test(lost_packets_and_acknowledgements_change_nothing),
        cmocka_unit_test(it_catches_up_from_more_than_behind_ticks),
        cmocka_unit_test(a_world_brings_it_back),
        cmocka_unit_test(a_second_answer_leaves_no_gap),
        cmocka_unit_test(a_packet_has_runs),
        cmocka_unit_test(an_epoch_ends_what_was_sent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

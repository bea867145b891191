/* One client of the peer-to-peer syncs, fed by hand; and one relay server. The toy's world is the sum of the
 * inputs. */
#include "netcode/toy.h"

#include "netcode/observe/desync.h"
#include "netcode/peer/float_mode.h"
#include "netcode/server/relay_server.h"
#include "netcode/state/peer.h"

#define TICK (LL_SECOND / 50)

/* A client's message, decoded. */
typedef struct sent {
    ll_peer_message head;
    ll_peer_ack acks[LL_PLAYERS_MAX];
    ll_input_run runs[LL_RUNS_MAX];
    uint32_t hashes[LL_HASHES_MAX];
    int inputs;
} sent;

static sent frame_at(lone *l, int64_t frame)
{
    _Alignas(8) char bytes[2048];
    sent m = {0};
    int size = ll_peer_tick(l->client, &l->setup, frame * TICK, bytes);
    ll_peer_display(l->client, &l->setup, frame * TICK);
    memcpy(&m.head, bytes, sizeof m.head);
    const char *at = bytes + sizeof m.head;
    memcpy(m.acks, at, (size_t)l->players * sizeof m.acks[0]);
    at += (size_t)l->players * sizeof m.acks[0];
    memcpy(m.runs, at, m.head.runs * sizeof m.runs[0]);
    at += m.head.runs * sizeof m.runs[0];
    memcpy(m.hashes, at, m.head.hashes * sizeof m.hashes[0]);
    assert_int_equal(size, at - bytes + (ptrdiff_t)(m.head.hashes * sizeof m.hashes[0]));
    for (uint32_t i = 0; i < m.head.runs; i++)
        m.inputs += (int)m.runs[i].count;
    assert_int_equal(m.head.head.count, m.inputs);
    return m;
}

/* A relay to player 0 of two: inputs of player 1 from `tick` on, and all of 0's up to `acked`
 * acknowledged. */
static void relay(lone *l, uint32_t acked, int64_t tick, int count, const double *pushes, int at, int ahead)
{
    struct {
        ll_relay_message head;
        ll_relay_part part;
        ll_input_run runs[LL_RUNS_MAX];
    } m = {.head = {.head = {.type = LL_MESSAGE_RELAY, .count = 1, .epoch = 1, .seq = acked}, .tick = acked},
           .part = {.tick = (int32_t)tick, .at = at, .ahead = ahead, .player = 1}};
    int runs = 0;
    for (int i = 0; i < count; i++)
        assert_true(ll_run_add(m.runs, &runs, &(ll_controls){.axis = {(float)pushes[i], 0}}));
    m.part.runs = (uint16_t)runs;
    assert_int_equal(ll_peer_receive(l->client, &l->setup, &m, (int)sizeof m, l->client->ticks.number * TICK),
                     LL_OUTCOME_APPLIED);
}

static lone *new_peer(const ll_sync_mode *sync, int guesses)
{
    lone *l = new_lone(2, &toy, sync);
    l->rules.max_rollback_ticks = guesses;
    start_lone(l, 50, 0, 0);
    return l;
}

static double x_of(const lone *l, int player)
{
    return ll_client_rendered(l->client)->entity[player].x;
}

static const ll_peer *peer_of(const lone *l)
{
    return ll_client_peer(l->client);
}

static void inputs_are_repeated_until_acknowledged(void **state)
{
    (void)state;
    lone *l = new_peer(&ll_sync_rollback, 8);
    for (int k = 0; k < 6; k++) {
        l->client->inputs.held = push(k / 2);
        sent m = frame_at(l, k);
        assert_int_equal(m.head.tick, 1);
        assert_int_equal(m.head.head.seq, 1);
        assert_int_equal(m.inputs, k + 1);
        assert_int_equal(m.head.runs, k / 2 + 1); /* equal ones share a run */
    }
    relay(l, 4, 1, 0, NULL, -1, 0);
    sent m = frame_at(l, 6);
    assert_int_equal(m.head.tick, 5);
    assert_int_equal(m.inputs, 3);
    assert_true(m.runs[0].input.axis[0] == 2 && m.runs[0].count == 3);
    relay(l, 2, 1, 0, NULL, -1, 0); /* an older one reverts nothing */
    assert_int_equal(frame_at(l, 7).head.tick, 5);
    free_lone(l);
}

static void deterministic_waits_for_each_input(void **state)
{
    (void)state;
    lone *l = new_peer(&ll_sync_deterministic, 8); /* the parameter of rollback has no effect */
    l->client->inputs.held = push(1);
    for (int k = 0; k < 5; k++)
        frame_at(l, k);
    assert_int_equal(peer_of(l)->tick, 0);
    assert_int_equal(peer_of(l)->waiting, 1 << 1);
    assert_int_equal(l->client->inputs.seq, 1);
    relay(l, 1, 1, 2, (const double[]){10, 20}, 2, 0);
    sent m = frame_at(l, 5);
    assert_int_equal(peer_of(l)->tick, 1);
    assert_int_equal(peer_of(l)->confirmed, 1);
    assert_int_equal(m.inputs, 1); /* the next is made in the same frame */
    assert_int_equal(m.head.tick, 2);
    assert_int_equal(m.acks[1].known, 2);
    frame_at(l, 6);
    assert_true(x_of(l, 0) == 2 && x_of(l, 1) == 30);
    frame_at(l, 7);
    assert_int_equal(peer_of(l)->tick, 2);
    const ll_stepping *n = &l->client_metrics->stepping;
    assert_int_equal(n->stalls, 2);
    assert_int_equal(n->stalled_frames, 6);
    assert_int_equal(n->waited_frames[1], 6);
    assert_int_equal(n->waited_frames[0], 0);
    free_lone(l);
}

static void a_right_guess_costs_nothing_and_a_wrong_one_is_made_again(void **state)
{
    (void)state;
    lone *l = new_peer(&ll_sync_rollback, 4);
    l->client->inputs.held = push(1);
    relay(l, 0, 1, 1, (const double[]){5}, 1, 0);
    for (int k = 0; k < 10; k++)
        frame_at(l, k);
    assert_int_equal(peer_of(l)->tick, 5); /* one confirmed tick and four guesses */
    assert_int_equal(peer_of(l)->confirmed, 1);
    assert_int_equal(peer_of(l)->waiting, 1 << 1);
    assert_true(x_of(l, 1) == 25);

    relay(l, 0, 2, 2, (const double[]){5, 5}, 3, 0);
    frame_at(l, 10);
    assert_int_equal(l->client_metrics->stepping.rollbacks, 0);
    assert_int_equal(peer_of(l)->tick, 6);

    relay(l, 0, 2, 3, (const double[]){5, 5, 7}, 4, 0); /* tick 4 is 7, so 5 and 6 are guessed as 7 too */
    frame_at(l, 11);
    assert_int_equal(l->client_metrics->stepping.rollbacks, 1);
    assert_int_equal(l->client_metrics->stepping.rollback_ticks, 3);
    assert_int_equal(peer_of(l)->tick, 7);
    assert_int_equal(peer_of(l)->confirmed, 4);
    assert_true(x_of(l, 0) == 7 && x_of(l, 1) == 15 + 7 + 7 + 7 + 7);
    assert_true(ll_histogram_summary(&l->client_metrics->histogram[LL_METRIC_POP]).max ==
                2 + 2 + 2);                                    /* of tick 6 */
    assert_int_equal(l->client_metrics->corrections.count, 0); /* the own entity has not moved */

    relay(l, 0, 2, 4, (const double[]){5, 5, 7, 7}, 5, 0); /* as guessed again */
    frame_at(l, 12);
    assert_int_equal(l->client_metrics->stepping.rollbacks, 1);
    free_lone(l);
}

/* A gap, or more than the ring holds: not accepted, not acknowledged, so it is sent again. */
static void inputs_beyond_the_ring_are_not_acknowledged(void **state)
{
    (void)state;
    double ones[70];
    lone *l = new_peer(&ll_sync_deterministic, 0);
    for (int i = 0; i < 70; i++)
        ones[i] = 1;
    relay(l, 0, 2, 3, ones, 1, 0);
    assert_int_equal(frame_at(l, 0).acks[1].known, 0);
    relay(l, 0, 1, 70, ones, 1, 0);
    int64_t known = frame_at(l, 1).acks[1].known;
    assert_true(known > 40 && known < LL_PEER_RING);
    for (int k = 2; k < 70; k++)
        relay(l, 0, known + 1, 70 - (int)known, ones, k, 0), known = frame_at(l, k).acks[1].known;
    assert_int_equal(known, 70);
    assert_true(x_of(l, 1) == (double)peer_of(l)->tick && peer_of(l)->tick == 69);
    free_lone(l);
}

static void input_delay_begins_with_nothing_and_may_change(void **state)
{
    (void)state;
    lone *l = new_peer(&ll_sync_rollback, 16);
    l->config.input_delay_ticks = 3;
    for (int k = 0; k < 10; k++) {
        l->client->inputs.held = push(k + 1);
        assert_int_equal(frame_at(l, k).inputs, k + 4);
    }
    assert_true(x_of(l, 0) == 1 + 2 + 3 + 4 + 5 + 6 + 7); /* ticks 4 to 10 */
    l->config.input_delay_ticks = 5;                      /* two more at once */
    l->client->inputs.held = push(100);
    assert_int_equal(frame_at(l, 10).inputs, 16);
    l->config.input_delay_ticks = 0; /* none until the made ones are applied */
    for (int k = 11; k < 16; k++)
        assert_int_equal(frame_at(l, k).inputs, 16);
    assert_int_equal(peer_of(l)->tick, 16);
    assert_true(x_of(l, 0) == 28 + 8 + 9 + 10 + 300);
    free_lone(l);
}

/* The same world, the same inputs, another result: the effect of a variable outside of the saved state. */
static int forgotten;

static void impure_step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                        const struct ll_past *past)
{
    (void)past;
    toy_step(world, env, actions, now, NULL);
    world->entity[1].x += forgotten++ % 1000 == 0;
}

static void sync_test_finds_a_variable_outside_the_state(void **state)
{
    (void)state;
    ll_game impure = toy;
    impure.step = impure_step;
    const ll_game *const games[] = {&toy, &impure};
    for (int i = 0; i < 2; i++) {
        lone *l = new_lone(2, games[i], &ll_sync_rollback);
        l->rules.max_rollback_ticks = 16;
        l->rules.sync_test_ticks = 4;
        start_lone(l, 50, 0, 0);
        forgotten = -8;
        for (int k = 0; k < 16; k++)
            frame_at(l, k);
        assert_int_equal(l->client_metrics->stepping.sync_tests, 13); /* from the fourth tick on */
        assert_true((l->client_metrics->stepping.sync_test_mismatches > 0) == (i == 1));
        free_lone(l);
    }
}

/* This client sees itself five ticks ahead, the other sees itself one behind: (5 + 1) / 2 = 3 frames of
 * waiting, and no more, though the other's reports follow slowly. */
static void the_client_ahead_waits(void **state)
{
    (void)state;
    lone *l = new_peer(&ll_sync_rollback, 16);
    double zero[2] = {0};
    for (int k = 0; k < 119; k++) {
        int64_t tick = peer_of(l)->tick;
        relay(l, (uint32_t)(tick > 2 ? tick - 2 : 0), k / 2 * 2 + 1, 2, zero, k - 5, (int)(k - tick - 1));
        frame_at(l, k);
    }
    assert_int_equal(l->client_metrics->stepping.time_sync_frames, 3);
    assert_int_equal(l->client_metrics->stepping.stalls, 0);
    assert_int_equal(peer_of(l)->tick, 116);
    free_lone(l);
}

/* ---- the relay server ---- */

/* A message of a client of two: inputs from `tick` on, hashes from `hashed` on. */
static void give_relay_server(ll_server *server, int player, int64_t tick, int count, const double *pushes,
                              int64_t hashed, int hashes, const uint32_t *hash)
{
    struct {
        ll_peer_message head;
        ll_peer_ack acks[2];
        char rest[1024];
    } m = {.head = {.head = {LL_MESSAGE_INPUT, (uint8_t)count, 1, (uint32_t)tick},
                    .tick = tick,
                    .at = (int32_t)tick,
                    .hashed = (int32_t)hashed,
                    .hashes = (uint32_t)hashes}};
    ll_input_result results[LL_INPUTS_MAX];
    ll_input_run *runs = (ll_input_run *)(void *)m.rest;
    int n = 0;
    for (int i = 0; i < count; i++)
        assert_true(ll_run_add(runs, &n, &(ll_controls){.axis = {(float)pushes[i], 0}}));
    m.head.runs = (uint16_t)n;
    if (hashes > 0)
        memcpy(runs + n, hash, (size_t)hashes * sizeof *hash);
    ll_relay_server_take(server, &ll_sync_rollback, player, &m, LL_MS, results);
}

static int steps_due(ll_server *server)
{
    int n = 0;
    ll_game_env env = {0};
    while (ll_relay_server_due(server) != LL_NEVER) {
        ll_relay_server_step(server, &toy, &env, NULL, LL_MS);
        n++;
    }
    return n;
}

static ll_relay_part part_to(ll_server *server, int player, uint32_t *acked, ll_input_run runs[LL_RUNS_MAX])
{
    _Alignas(8) char bytes[2048];
    ll_relay_part part;
    ll_relay_message m;
    int size = ll_relay_server_compose(server, &ll_sync_rollback, player, NULL, bytes);
    memcpy(&m, bytes, sizeof m);
    memcpy(&part, bytes + sizeof m, sizeof part);
    memcpy(runs, bytes + sizeof m + sizeof part, part.runs * sizeof runs[0]);
    assert_int_equal(size, sizeof m + sizeof part + part.runs * sizeof runs[0]);
    *acked = m.head.seq;
    return part;
}

static void relay_server_steps_and_forwards(void **state)
{
    (void)state;
    ll_server *server = new_server(2, &ll_sync_rollback, 50, 50);
    ll_input_run runs[LL_RUNS_MAX];
    uint32_t acked;
    give_relay_server(server, 0, 1, 3, (const double[]){0.5, 0.5, 0.25}, 0, 0, NULL);
    assert_int_equal(steps_due(server), 0);
    for (int i = 0; i < 3; i++) { /* again and again, until it is acknowledged */
        ll_relay_part part = part_to(server, 1, &acked, runs);
        assert_int_equal(part.player, 0);
        assert_int_equal(part.tick, 1);
        assert_int_equal(part.runs, 2);
        assert_int_equal(runs[0].count, 2);
        assert_int_equal(acked, 0);
    }
    give_relay_server(server, 1, 1, 2, (const double[]){1, 1}, 0, 0, NULL);
    assert_int_equal(steps_due(server), 2);
    assert_true(ll_server_world(server)->entity[0].x == 1 && ll_server_world(server)->entity[1].x == 2);
    ll_relay_part part = part_to(server, 1, &acked, runs);
    assert_int_equal(acked, 2);
    give_relay_server(server, 1, 3, 1, (const double[]){1}, 0, 0, NULL);
    assert_int_equal(server->client_slots[1].counts.accepted, 3);
    give_relay_server(server, 1, 2, 2, (const double[]){1, 1}, 0, 0, NULL);
    assert_int_equal(server->client_slots[1].counts.duplicate, 2);
    assert_int_equal(part.tick, 1); /* client 1 has acknowledged nothing */
    free(server);
}

static void a_refused_input_is_replaced_for_all_clients(void **state)
{
    (void)state;
    ll_server *server = new_server(2, &ll_sync_rollback, 50, 50);
    ll_input_run runs[LL_RUNS_MAX];
    uint32_t acked;
    give_relay_server(server, 0, 1, 3, (const double[]){0.5, 1.5, 0.25}, 0, 0, NULL);
    give_relay_server(server, 1, 1, 3, (const double[]){0, 0, 0}, 0, 0, NULL);
    assert_int_equal(steps_due(server), 3);
    assert_int_equal(server->client_slots[0].counts.refused[LL_RULE_MAGNITUDE], 1);
    part_to(server, 1, &acked, runs);
    assert_true(runs[0].input.axis[0] == 0.5f && runs[0].count == 1);
    assert_true(runs[1].input.axis[0] == 0 && runs[1].count == 1); /* neutral */
    assert_true(ll_server_world(server)->entity[0].x == 0.75);
    free(server);
}

static void a_wrong_hash_is_caught_at_its_tick(void **state)
{
    (void)state;
    ll_server *server = new_server(2, &ll_sync_rollback, 50, 50);
    double ones[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    uint32_t hashes[8];
    give_relay_server(server, 0, 1, 4, ones, 0, 0, NULL);
    give_relay_server(server, 1, 1, 6, ones, 0, 0, NULL);
    assert_int_equal(steps_due(server), 4);
    for (int k = 0; k < 8; k++)
        hashes[k] = server->hashes[k];
    give_relay_server(server, 0, 5, 0, NULL, 1, 4, &hashes[1]);
    assert_int_equal(server->client_slots[0].peer.hashed, 4);
    assert_int_equal(server->client_slots[0].peer.desync, -1);
    hashes[3]++;
    give_relay_server(server, 1, 7, 0, NULL, 1, 2, &hashes[1]);
    assert_int_equal(server->client_slots[1].peer.desync, -1);
    give_relay_server(server, 1, 7, 0, NULL, 1, 6,
                      &hashes[1]); /* 5 and 6 are not stepped yet: not compared */
    assert_int_equal(server->client_slots[1].peer.hashed, 4);
    assert_int_equal(server->client_slots[1].peer.desync, 3);
    assert_int_equal(server->client_slots[0].peer.desync, -1);
    free(server);
}

/* ---- float modes ---- */

static void each_hardware_does_as_it_says(void **state)
{
    (void)state;
    lone *l = new_peer(&ll_sync_rollback, 0);
    ll_action actions[2] = {push(0.1), push(0.2)};
    for (int h = 0; ll_float_mode_names[h]; h++) {
        int64_t slips = 0;
        l->config.float_mode = h;
        for (int64_t tick = 1; tick <= 6400; tick++) {
            ll_world *world = new_world(2), *exact = new_world(2);
            world->entity[0].x = exact->entity[0].x = 1.0 / 3;
            ll_float_mode_step(&l->setup, 0, world, actions, tick, 0);
            toy_step(exact, &l->env, actions, 0, NULL);
            double ulps = 0;
            for (int i = 0; i < 2; i++) {
                const ll_entity *a = &world->entity[i], *b = &exact->entity[i];
                if (strcmp(ll_float_mode_names[h], "float") == 0)
                    assert_true(a->x == (double)(float)b->x && a->vx == (double)(float)b->vx);
                else
                    ulps += ll_ulps(a->x, b->x) + ll_ulps(a->vx, b->vx) + ll_ulps(a->y, b->y);
            }
            assert_true(ulps <= 1);
            slips += ulps > 0;
            free(exact);
            free(world);
        }
        /* One in 64, half of them on a zero, which stays: 50 +- 7. */
        assert_true(strcmp(ll_float_mode_names[h], "ulp") == 0 ? slips > 29 && slips < 71 : slips == 0);
    }
    free_lone(l);
}

/* Of worlds of every size: GCC 12 vectorises the loop over entities and skips fields of the last. */
static void floats_are_stored_in_every_field(void **state)
{
    (void)state;
    const ll_float_mode *h = NULL;
    for (int i = 0; ll_float_mode_names[i]; i++)
        h = strcmp(ll_float_mode_names[i], "float") == 0 ? &ll_float_modes[i] : h;
    assert_non_null(h);
    for (int n = 1; n <= 9; n++) {
        ll_world *world = new_world(n);
        double third = 1.0 / 3, rounded = (double)0.333333343f;
        for (int i = 0; i < n; i++)
            world->entity[i] = (ll_entity){third, third, third, third, third, third, 0};
        h->after(world, 0, 1);
        for (int i = 0; i < n; i++) {
            const ll_entity *e = &world->entity[i];
            const double values[] = {e->x, e->y, e->vx, e->vy, e->angle, e->angular_velocity};
            for (int k = 0; k < 6; k++)
                assert_true(values[k] == rounded);
        }
        free(world);
    }
}

static void ulps_are_counted_across_zero(void **state)
{
    (void)state;
    assert_true(ll_ulps(1, 1) == 0);
    assert_true(ll_ulps(0.0, -0.0) == 0);
    assert_true(ll_ulps(1, nextafter(1, 2)) == 1 && ll_ulps(nextafter(1, 0), 1) == 1);
    assert_true(ll_ulps(-1, nextafter(-1, 0)) == 1);
    assert_true(ll_ulps(5e-324, -5e-324) == 2);
    assert_true(ll_ulps(1, 2) == 0x1p52);
    assert_true(ll_ulps(-1, 1) == 2 * 0x3ffp52);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inputs_are_repeated_until_acknowledged),
        cmocka_unit_test(deterministic_waits_for_each_input),
        cmocka_unit_test(a_right_guess_costs_nothing_and_a_wrong_one_is_made_again),
        cmocka_unit_test(inputs_beyond_the_ring_are_not_acknowledged),
        cmocka_unit_test(input_delay_begins_with_nothing_and_may_change),
        cmocka_unit_test(sync_test_finds_a_variable_outside_the_state),
        cmocka_unit_test(the_client_ahead_waits),
        cmocka_unit_test(relay_server_steps_and_forwards),
        cmocka_unit_test(a_refused_input_is_replaced_for_all_clients),
        cmocka_unit_test(a_wrong_hash_is_caught_at_its_tick),
        cmocka_unit_test(each_hardware_does_as_it_says),
        cmocka_unit_test(floats_are_stored_in_every_field),
        cmocka_unit_test(ulps_are_counted_across_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

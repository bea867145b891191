/* Which inputs count as applied with either method of acknowledgement, and the cost of a wrong
 * acknowledgement. */
#include "netcode/toy.h"

#include <stdio.h>

#include "base/rng.h"
#include "netcode/client/ack.h"
#include "support/scene.h"

/* ---- the server's bits ---- */

#define RESULT_BITS (32 * LL_INPUT_RESULT_WORDS)

static bool bit(const ll_client_slot *client_slot, uint32_t seq)
{
    return client_slot->inputs.results[seq / 32 % LL_INPUT_RESULT_WORDS] >> seq % 32 & 1;
}

/* In any order, with gaps: the bits of the last 512 inputs are set for those that were applied. */
static void bits_are_those_of_the_last_512(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 30; seed++) {
        ll_client_slot client_slot = {.inputs.acked = 0};
        static bool applied[2600];
        memset(applied, 0, sizeof applied);
        uint32_t newest = 0, processed = 0;
        for (uint32_t k = 0; k < 1400; k++) {
            uint32_t seq = 1 + k + (uint32_t)(ll_rng_u64(seed, 0, k) % 300);
            bool yes = ll_rng_unit(seed, 1, k) < 0.7;
            if (k == 700)
                seq += 700; /* a gap beyond the window */
            if (seq + RESULT_BITS <= newest)
                continue; /* no slot holds an input that old: the server has none to apply */
            newest = seq > newest ? seq : newest;
            processed = yes && seq > processed ? seq : processed;
            applied[seq] = yes;
            ll_client_slot_done(&client_slot, seq, yes);
            assert_int_equal(client_slot.inputs.decided, newest);
            assert_int_equal(client_slot.inputs.processed, processed);
            for (uint32_t i = 0; i < RESULT_BITS && i < newest; i++)
                assert_int_equal(bit(&client_slot, newest - i), applied[newest - i]);
        }
    }
}

/* Acknowledgement in the snapshot to player 0: the bit of each input, newest first. */
static ll_input_result_part acknowledgement_of(ll_server *s, const ll_sync_mode *sync,
                                               uint32_t words[LL_INPUT_RESULT_WORDS_MAX])
{
    char bytes[4096];
    ll_snapshot_message m;
    ll_input_result_part part;
    int size = ll_server_compose(s, sync, 0, NULL, bytes);
    memcpy(&m, bytes, sizeof m);
    assert_int_equal(m.head.count, LL_PART_APPLIED);
    assert_int_equal(m.applied, s->client_slots[0].inputs.processed);
    memcpy(&part, bytes + sizeof m, sizeof part);
    assert_true(part.words <= LL_INPUT_RESULT_WORDS_MAX);
    memcpy(words, bytes + sizeof m + sizeof part, part.words * sizeof *words);
    assert_int_equal(size, sizeof m + sizeof part + part.words * sizeof *words +
                               ll_extent_size(toy_extent(NULL, s->players)));
    return part;
}

/* The words reach back to the newest snapshot that the client is known to have, at any rates and round trip.
 * Where inputs belong to no step, they reach back to the beginning, or by 512 inputs. */
static void results_reach_back_to_the_acknowledged_snapshot(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 300; k++) {
        ll_server *s = new_server(1, &ll_sync_free, 60, 60);
        uint32_t words[LL_INPUT_RESULT_WORDS_MAX];
        uint32_t decided = 1 + (uint32_t)(ll_rng_u64(k, 2, 0) % 2000);
        int64_t ahead = (int64_t)(ll_rng_u64(k, 2, 1) % 700), lead = (int64_t)(ll_rng_u64(k, 2, 2) % 20);
        bool applied[2001];
        for (uint32_t seq = 1; seq <= decided; seq++) {
            applied[seq] = ll_rng_unit(k, 3, seq) < 0.6;
            ll_client_slot_done(&s->client_slots[0], seq, applied[seq]);
        }
        s->client_slots[0].inputs.wants = LL_PART_APPLIED;
        s->step = decided + lead; /* inputs began at some step */
        s->client_slots[0].snapshots.received = s->step > ahead ? s->step - ahead : 0;
        bool drains = k % 3 == 0;
        ll_input_result_part part = acknowledgement_of(s, drains ? &ll_sync_gambetta : &ll_sync_free, words);
        assert_int_equal(part.newest, decided);
        int64_t needed = drains || s->client_slots[0].snapshots.received == 0
                             ? decided
                             : s->step - s->client_slots[0].snapshots.received;
        needed = needed > decided ? decided : needed > RESULT_BITS ? RESULT_BITS : needed;
        assert_true(part.words * 32 >= needed && (int64_t)part.words * 32 < needed + 32);
        for (uint32_t i = 0; i < 32 * part.words; i++) {
            bool is = i < decided && applied[decided - i];
            assert_int_equal(words[i / 32] >> i % 32 & 1, is);
        }
        free(s);
    }
}

/* A step whose input is missing, late or refused repeats the one before: its input does not count as
 * applied. */
static void only_valid_inputs_in_time_are_set(void **state)
{
    (void)state;
    const ll_game_env env = {.dt = 1.0 / 60};
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message a = inputs(1, 2, (double[]){0.5, 2}), late = inputs(3, 1, (double[]){0.5}),
                     c = inputs(5, 1, (double[]){0.5});
    ll_server_receive(s, &ll_sync_free, 0, &a, 0, v); /* 1 is good, 2 too large */
    for (int k = 0; k < 3; k++)
        ll_sync_free.step(s, &toy, &env, NULL, ll_sync_free.due(s));
    ll_server_receive(s, &ll_sync_free, 0, &late, s->stepped, v); /* 3 is late, 4 never arrives */
    ll_server_receive(s, &ll_sync_free, 0, &c, s->stepped, v);
    for (int k = 0; k < 2; k++)
        ll_sync_free.step(s, &toy, &env, NULL, ll_sync_free.due(s));
    const ll_client_slot *client_slot = &s->client_slots[0];
    uint32_t words[LL_INPUT_RESULT_WORDS_MAX];
    s->client_slots[0].inputs.wants = LL_PART_APPLIED;
    assert_int_equal(client_slot->inputs.acked, 5);
    assert_int_equal(client_slot->inputs.processed, 5);
    assert_int_equal(client_slot->inputs.decided, 5);
    ll_input_result_part part = acknowledgement_of(s, &ll_sync_free, words);
    assert_int_equal(part.newest, 5);
    assert_int_equal(part.words, 1);
    assert_int_equal(words[0], 0x11);                            /* 5 and 1 */
    ll_sync_free.step(s, &toy, &env, NULL, ll_sync_free.due(s)); /* 6 never arrives either */
    assert_int_equal(client_slot->inputs.acked, 6);              /* its step is over, */
    assert_int_equal(client_slot->inputs.processed, 5);          /* but it was not applied */
    part = acknowledgement_of(s, &ll_sync_free, words);
    assert_int_equal(part.newest, 6);
    assert_int_equal(words[0], 0x22);
    free(s);
}

/* ---- the client ---- */

static int receive_packet(lone *l, packet p, uint32_t newest, uint64_t bits, ll_time now)
{
    char bytes[256];
    struct {
        ll_input_result_part part;
        uint32_t words[2];
    } applied = {{newest, 2}, {(uint32_t)bits, (uint32_t)(bits >> 32)}};
    size_t head = sizeof p.head, world = (size_t)size_of(&p) - head;
    p.head.head.count = LL_PART_APPLIED;
    memcpy(bytes, &p.head, head);
    memcpy(bytes + head, &applied, sizeof applied);
    memcpy(bytes + head + sizeof applied, &p.world_players, world);
    return ll_client_receive(l->client, &l->setup, bytes, (int)(head + sizeof applied + world), now);
}

static int receive_bits(lone *l, int64_t tick, uint32_t acked, uint32_t newest, uint64_t bits, double x,
                        ll_time now)
{
    return receive_packet(l, state_of(tick, now, acked, 1, &x), newest, bits, now);
}

/* The same for an entity that moves on with held controls, so that a prediction may agree bitwise. */
static int receive_bits_in_motion(lone *l, int64_t tick, uint32_t acked, uint64_t bits, double x, ll_time now)
{
    packet p = state_of(tick, now, acked, 1, &x);
    p.entity[0].vx = (double)l->client->inputs.held.axis[0];
    return receive_packet(l, p, acked, bits, now);
}

static lone *new_predictor(const ll_sync_mode *sync, int ack)
{
    lone *l = new_lone(1, &toy, sync);
    l->config.prediction = l->config.reconciliation = true;
    l->config.slack_ticks = 0;
    l->config.ack = ack;
    start_lone(l, 60, 0, 0);
    l->client->inputs.held = push(0.5);
    return l;
}

/* Inputs by step: of 1 to 6, with 2 and 5 skipped, four count as applied; 7 and 8 are open. */
static void skipped_inputs_are_not_taken_as_applied(void **state)
{
    (void)state;
    const ll_input_state expected[] = {LL_INPUT_APPLIED, LL_INPUT_SKIPPED, LL_INPUT_APPLIED, LL_INPUT_APPLIED,
                                       LL_INPUT_SKIPPED, LL_INPUT_APPLIED, LL_INPUT_OPEN,    LL_INPUT_OPEN};
    for (int ack = 0; ack < 2; ack++) {
        lone *l = new_predictor(&ll_sync_free, ack);
        ll_input_message m;
        for (int f = 0; f < 7; f++)
            frame(l, ll_tick_time(f, HZ(60)), &m);
        assert_int_equal(m.wants, ack == 0 ? 0 : LL_PART_APPLIED);
        const uint32_t applied[] = {1, 3, 4, 6};
        for (int i = 0; i < 4; i++)
            server_applies(l, applied[i], applied[i], applied[i]);
        receive_bits(l, 6, 6, 6, 0x2d /* 101101 */, 100, ll_tick_time(7, HZ(60)));
        frame(l, ll_tick_time(7, HZ(60)), NULL);
        for (uint32_t seq = 1; seq <= 8; seq++)
            assert_int_equal(ll_client_pending(l->client, seq)->state,
                             ack == 0 && seq <= 6 ? LL_INPUT_APPLIED : expected[seq - 1]);
        assert_int_equal(l->client->inputs.acked, 6);
        assert_int_equal(l->client_metrics->histogram[LL_METRIC_ACK_RTT].count,
                         4); /* independent of what the client assumes */
        assert_int_equal(l->client_metrics->input_history.skipped, ack == 0 ? 0 : 2);
        assert_true(ll_client_rendered(l->client)->entity[0].x == 101);
        free_lone(l);
    }
}

/* High water sends two numbers. Inputs up to the newest applied one count as applied; later ones whose step
 * is over count as skipped, and a later snapshot does not reopen them. */
static void high_water_skips_decided_inputs_that_were_not_applied(void **state)
{
    (void)state;
    lone *l = new_predictor(&ll_sync_free, 0);
    for (int f = 0; f < 9; f++)
        frame(l, ll_tick_time(f, HZ(60)), NULL);
    packet p = state_of(6, ll_tick_time(9, HZ(60)), 6, 1, (double[]){100});
    p.head.applied = 4;
    server_applies(l, 1, 4, 4);
    give(l, &p, ll_tick_time(9, HZ(60)));
    frame(l, ll_tick_time(9, HZ(60)), NULL);
    for (uint32_t seq = 1; seq <= 10; seq++)
        assert_int_equal(ll_client_pending(l->client, seq)->state, seq <= 4   ? LL_INPUT_APPLIED
                                                                   : seq <= 6 ? LL_INPUT_SKIPPED
                                                                              : LL_INPUT_OPEN);
    assert_int_equal(l->client->inputs.acked, 6);
    assert_int_equal(l->client_metrics->input_history.skipped, 2);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 102); /* and 7 to 10 */
    p = state_of(7, ll_tick_time(10, HZ(60)), 7, 1, (double[]){100.5});
    server_applies(l, 7, 7, 7);
    give(l, &p, ll_tick_time(10, HZ(60)));
    frame(l, ll_tick_time(10, HZ(60)), NULL);
    assert_int_equal(ll_client_pending(l->client, 6)->state, LL_INPUT_SKIPPED);
    assert_int_equal(ll_client_pending(l->client, 7)->state, LL_INPUT_APPLIED);
    assert_int_equal(l->client_metrics->histogram[LL_METRIC_ACK_RTT].count, 5);
    free_lone(l);
}

/* Inputs applied on arrival: 4 and 5 overtook 3. Input 3 stays open and is applied again on every snapshot
 * that lacks it, and an older snapshot later does no harm. High water drops it. */
static void overtaken_inputs_stay_open(void **state)
{
    (void)state;
    for (int ack = 0; ack < 2; ack++) {
        lone *l = new_predictor(&ll_sync_gambetta, ack);
        for (int f = 0; f < 6; f++)
            frame(l, f, NULL);
        server_applies(l, 1, 2, 1);
        server_applies(l, 4, 5, 1);
        receive_bits(l, 1, 5, 5, 0x1b /* 1, 2, 4, 5 */, 2, 6);
        frame(l, 6, NULL); /* makes 7 */
        assert_true(ll_client_rendered(l->client)->entity[0].x == (ack == 0 ? 3 : 3.5));
        server_applies(l, 3, 3, 2);
        server_applies(l, 6, 6, 2);
        receive_bits(l, 2, 6, 6, 0x3f, 3, 7); /* the next update includes it */
        frame(l, 7, NULL);
        assert_true(ll_client_rendered(l->client)->entity[0].x == 4);
        receive_bits(l, 1, 2, 2, 0x3, 1, 8); /* an old snapshot: 1 and 2 alone */
        frame(l, 8, NULL);                   /* makes 9 */
        assert_true(ll_client_rendered(l->client)->entity[0].x ==
                    (ack == 0 ? 2.5 : 4.5)); /* 3 to 6 are gone */
        assert_int_equal(l->client_metrics->histogram[LL_METRIC_ACK_RTT].count,
                         ack == 0 ? 5 : 6); /* each once; 3 counted as applied before it was */
        free_lone(l);
    }
}

/* A newer snapshot restores what an old one has undone. With high water the client no longer has the inputs
 * that the old one lacks, so they are not drawn until then. */
static void a_newer_snapshot_restores_what_an_old_one_undid(void **state)
{
    (void)state;
    for (int ack = 0; ack < 2; ack++) {
        lone *l = new_predictor(&ll_sync_gambetta, ack);
        l->client->inputs.held = push(0.25);
        for (int f = 0; f < 9; f++)
            frame(l, f, NULL);
        receive_bits_in_motion(l, 2, 8, 0xff, 2, 9);
        frame(l, 9, NULL); /* makes 10 */
        assert_true(ll_client_rendered(l->client)->entity[0].x == 2.5);
        receive_bits_in_motion(l, 1, 5, 0x1f, 1.25, 10); /* an old snapshot: 1 to 5 alone */
        frame(l, 10, NULL);                              /* makes 11 */
        assert_true(ll_client_rendered(l->client)->entity[0].x == (ack == 0 ? 2 : 2.75));
        receive_bits_in_motion(l, 3, 9, 0x1ff, 2.25, 11);
        frame(l, 11, NULL); /* makes 12 */
        assert_true(ll_client_rendered(l->client)->entity[0].x == 3);
        free_lone(l);
    }
}

/* An input that has not arrived is given up when it is older than the window of a snapshot, 64 here. */
static void lost_inputs_are_given_up_beyond_the_window(void **state)
{
    (void)state;
    lone *l = new_predictor(&ll_sync_gambetta, 1);
    for (int f = 0; f < 80; f++)
        frame(l, f, NULL);
    receive_bits(l, 1, 65, 65, ~UINT64_C(0) >> 1, 64 * 0.5 - 0.5,
                 80); /* 3 to 65; 1 is out of the window, 2 is not there */
    frame(l, 80, NULL);
    assert_int_equal(ll_client_pending(l->client, 1)->state, LL_INPUT_SKIPPED);
    assert_int_equal(ll_client_pending(l->client, 2)->state, LL_INPUT_OPEN);
    assert_int_equal(l->client->inputs.acked, 1);
    assert_true(ll_client_rendered(l->client)->entity[0].x ==
                64 * 0.5 - 0.5 + 0.5 + 16 * 0.5); /* and 2, 66 to 81 */
    receive_bits(l, 2, 66, 66, ~UINT64_C(0), 64 * 0.5, 81);
    frame(l, 81, NULL);
    assert_int_equal(ll_client_pending(l->client, 2)->state, LL_INPUT_SKIPPED);
    assert_int_equal(l->client->inputs.acked, 66);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 64 * 0.5 + 16 * 0.5);
    assert_int_equal(l->client_metrics->input_history.skipped, 2);
    free_lone(l);
}

/* ---- in whole games ---- */

#define PREDICTING "players.0.prediction=true", "players.0.reconciliation=true", "warmup_s=0"

static const ll_input_history *input_history(const scene *s)
{
    return &ll_netgame_client_metrics(s->game, 0)->input_history;
}

static int64_t corrections(const scene *s)
{
    return ll_netgame_client_metrics(s->game, 0)->corrections.count;
}

/* Where the server applies inputs on arrival, packets that overtake each other make high water wrong, and
 * each wrong drop causes a jump and a jump back. With one bit per input nothing is wrong, so nothing is
 * corrected; not even by snapshots that overtake each other. */
static void overtaking_is_harmless_with_a_bit_per_input(void **state)
{
    (void)state;
    for (int seed = 1; seed <= 3; seed++)
        for (int ack = 0; ack < 2; ack++) {
            char way[32], draws[32];
            snprintf(way, sizeof way, "players.0.ack=%s", ll_ack_names[ack]);
            snprintf(draws, sizeof draws, "seed=%d", seed);
            const char *const sets[] = {PREDICTING,
                                        way,
                                        draws,
                                        "server.update_hz=20",
                                        "players.0.link.up.jitter_ms=60",
                                        "players.0.link.down.jitter_ms=80",
                                        NULL};
            scene s = scene_open("gambetta", sets);
            scene_run(&s, 60, NULL);
            assert_true(input_history(&s)->applied > 2000);
            assert_int_equal(input_history(&s)->skipped, 0);
            if (ack == 0) {
                assert_true(input_history(&s)->wrong > 200);
                assert_true(corrections(&s) > 200);
            } else {
                assert_int_equal(input_history(&s)->wrong, 0);
                assert_int_equal(corrections(&s), 0);
            }
            scene_close(&s);
        }
}

/* Of the inputs that the link lost, high water counts each as applied if a later one was applied before the
 * snapshot; the bits count none. */
static void lost_inputs_are_known_as_such(void **state)
{
    (void)state;
    for (int ack = 0; ack < 2; ack++) {
        char way[32];
        snprintf(way, sizeof way, "players.0.ack=%s", ll_ack_names[ack]);
        const char *const sets[] = {PREDICTING, way, "players.0.link.up.loss_pct=10",
                                    "players.0.redundancy=0", NULL};
        tape t = {0};
        scene s = scene_open("race", sets);
        ll_recorder r = tape_recorder(&t);
        scene_run(&s, 60, &r);
        ll_client *c = ll_netgame_client(s.game, 0);
        static bool gone[4096];
        int64_t lost = 0, hidden = 0;
        memset(gone, 0, sizeof gone);
        for (size_t i = 0; i < t.count; i++)
            if (t.events[i].type == LL_EVENT_INPUT && t.events[i].player == 0 && t.events[i].number < 4096)
                gone[t.events[i].number] = t.events[i].fate == 1;
        for (uint32_t seq = 1; seq <= c->inputs.acked; seq++) {
            int64_t tick = c->inputs.tick - (int64_t)(c->inputs.seq - seq);
            lost += gone[seq];
            hidden += gone[seq] && tick % 2 == 1 && !gone[seq + 1]; /* snapshots are of even ticks */
        }
        assert_true(lost > 250 && hidden > 100);
        assert_int_equal(input_history(&s)->wrong, ack == 0 ? hidden : 0);
        assert_int_equal(input_history(&s)->skipped, ack == 0 ? lost - hidden : lost);
        scene_close(&s);
        tape_free(&t);
    }
}

/* ---- causes ---- */

/* Runs with another input at every frame, so that no repeated input can replace a missing one, and with a
 * snapshot after every step, so that each correction has its own cause. */
static scene run_wild(const char *const *sets, double seconds)
{
    scene s = scene_open("gambetta_default", sets);
    for (int k = 0; k < (int)(seconds * 50); k++) {
        ll_action any = push(2 * ll_rng_unit(3, 3, (uint64_t)k) - 1);
        s.scenario.kind->input(s.game, 0, &any);
        scene_run(&s, k / 50.0, NULL);
    }
    return s;
}

#define WILD PREDICTING, "players.0.control=person", "server.update_hz=50"

static void must_be_all(const scene *s, ll_cause cause, int64_t count)
{
    for (int i = 0; i < LL_CAUSES; i++)
        assert_int_equal(input_history(s)->corrections[i].count, i == (int)cause ? count : 0);
    assert_int_equal(corrections(s), count);
}

static void each_lost_input_is_a_correction_by_loss(void **state)
{
    (void)state;
    const char *const sets[] = {WILD, "players.0.ack=per_input", "players.0.link.up.loss_pct=10",
                                "players.0.redundancy=0", NULL};
    scene s = run_wild(sets, 30);
    assert_true(input_history(&s)->skipped > 100);
    must_be_all(&s, LL_CAUSE_LOSS, input_history(&s)->skipped);
    scene_close(&s);
}

/* Before the server has received an input of the player, its snapshots acknowledge nothing: the cause of a
 * correction is still loss. It holds for every phase of the client's clock and for every subset of lost first
 * packets. */
static void the_first_inputs_may_be_lost(void **state)
{
    (void)state;
    int64_t early = 0;
    for (int seed = 1; seed <= 24; seed++) {
        char draws[24];
        snprintf(draws, sizeof draws, "seed=%d", seed);
        const char *const sets[] = {
            WILD, draws, "players.0.ack=per_input", "players.0.link.up.loss_pct=50", "players.0.redundancy=0",
            NULL};
        scene s = run_wild(sets, 2);
        must_be_all(&s, LL_CAUSE_LOSS, corrections(&s));
        early += input_history(&s)->corrections[LL_CAUSE_LOSS].count;
        scene_close(&s);
    }
    assert_true(early > 24 * 20);
}

static void each_late_input_is_a_correction_by_lateness(void **state)
{
    (void)state;
    const char *const sets[] = {WILD,
                                "players.0.ack=per_input",
                                "players.0.link.up.jitter_ms=40",
                                "players.0.link.up.distribution=normal",
                                "players.0.slack_ticks=0",
                                "players.0.redundancy=0",
                                NULL};
    scene s = run_wild(sets, 120);
    assert_true(input_history(&s)->skipped > 10);
    must_be_all(&s, LL_CAUSE_LATE, input_history(&s)->skipped);
    assert_true(ll_netgame_server(s.game)->client_slots[0].counts.late >= input_history(&s)->skipped);
    scene_close(&s);
}

static void each_refused_input_is_a_correction_by_refusal(void **state)
{
    (void)state;
    const char *const sets[] = {WILD, "players.0.ack=per_input", "players.0.cheat=magnitude", NULL};
    scene s = run_wild(sets, 30); /* a third of the inputs exceeds 1 when half as large again */
    assert_in_range(input_history(&s)->skipped, 1500 / 4, 1500 / 2);
    must_be_all(&s, LL_CAUSE_REFUSED, input_history(&s)->skipped);
    scene_close(&s);
}

static void touches_are_corrections_by_contact(void **state)
{
    (void)state;
    scene s = scene_open("contact", NULL);
    scene_run(&s, 40, NULL);
    assert_true(corrections(&s) > 100);
    must_be_all(&s, LL_CAUSE_CONTACT, corrections(&s));
    scene_close(&s);
}

/* On any link, all corrections of honest players have a cause: loss or lateness without contact, and also
 * contact with it. */
static void no_correction_is_without_a_cause(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"eight", "contact", "race", "cannon", "contact_scopes"};
    for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i++) {
        const char *const sets[] = {"players.0.link.up.jitter_ms=50", "players.0.link.up.loss_pct=20",
                                    "players.0.redundancy=0", "players.0.slack_ticks=0", NULL};
        scene s = scene_open(scenarios[i], sets);
        scene_run(&s, 40, NULL);
        for (int p = 0; p < s.game->config.player_count; p++)
            assert_int_equal(
                ll_netgame_client_metrics(s.game, p)->input_history.corrections[LL_CAUSE_OTHER].count, 0);
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_are_those_of_the_last_512),
        cmocka_unit_test(results_reach_back_to_the_acknowledged_snapshot),
        cmocka_unit_test(only_valid_inputs_in_time_are_set),
        cmocka_unit_test(skipped_inputs_are_not_taken_as_applied),
        cmocka_unit_test(high_water_skips_decided_inputs_that_were_not_applied),
        cmocka_unit_test(overtaken_inputs_stay_open),
        cmocka_unit_test(a_newer_snapshot_restores_what_an_old_one_undid),
        cmocka_unit_test(lost_inputs_are_given_up_beyond_the_window),
        cmocka_unit_test(overtaking_is_harmless_with_a_bit_per_input),
        cmocka_unit_test(lost_inputs_are_known_as_such),
        cmocka_unit_test(each_lost_input_is_a_correction_by_loss),
        cmocka_unit_test(the_first_inputs_may_be_lost),
        cmocka_unit_test(each_late_input_is_a_correction_by_lateness),
        cmocka_unit_test(each_refused_input_is_a_correction_by_refusal),
        cmocka_unit_test(touches_are_corrections_by_contact),
        cmocka_unit_test(no_correction_is_without_a_cause),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

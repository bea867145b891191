/* The server: its handling of inputs in any order and number. */
#include "netcode/server/admission.h"
#include "netcode/toy.h"

/* The header of an update's message. */
static ll_snapshot_message state_to(ll_server *s, int player)
{
    char bytes[4096];
    ll_snapshot_message m;
    assert_true(ll_server_compose(s, &ll_sync_free, player, NULL, bytes) <= (int)sizeof bytes);
    memcpy(&m, bytes, sizeof m);
    return m;
}

static const ll_game_env env = {.dt = 1.0 / 60};

static int take_at(ll_server *s, const ll_sync_mode *sync, int player, const ll_input_message *m, ll_time now,
                   ll_input_result results[LL_INPUTS_MAX])
{
    ll_input_result unused[LL_INPUTS_MAX];
    return ll_server_receive(s, sync, player, m, now, results != NULL ? results : unused);
}

static int take(ll_server *s, const ll_sync_mode *sync, const ll_input_message *m,
                ll_input_result results[LL_INPUTS_MAX])
{
    return take_at(s, sync, 0, m, s->stepped, results);
}

/* Makes a step if one is due. */
static void step(ll_server *s, const ll_sync_mode *sync)
{
    ll_time due = sync->due(s);
    assert_true(due != LL_NEVER);
    sync->step(s, &toy, &env, NULL, due);
}

static double at(ll_server *s, int player)
{
    return ll_server_world(s)->entity[player].x;
}

static uint32_t acked(ll_server *s)
{
    return state_to(s, 0).head.seq;
}

static void inputs_apply_at_their_step(void **state)
{
    (void)state;
    ll_server *s = new_server(2, &ll_sync_free, 60, 60);
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message m = inputs(2, 3, (double[]){1, 0.5, -1}); /* for steps 2, 3 and 4 */
    configure(s, (const char *[]){"starved=repeat", NULL});
    assert_int_equal(take(s, &ll_sync_free, &m, v), 3);
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(v[i].seq, 2 + i);
        assert_int_equal(v[i].outcome, LL_OUTCOME_APPLIED);
        assert_int_equal(v[i].rule, LL_RULE_NONE);
    }
    const double expected[] = {0, 1, 1.5, 0.5, -0.5, -1.5}; /* after step 4 the last is repeated */
    for (int k = 0; k < 6; k++) {
        assert_int_equal(ll_sync_free.due(s), (k + 1) * LL_SECOND / 60);
        step(s, &ll_sync_free);
        assert_true(at(s, 0) == expected[k]);
        assert_true(at(s, 1) == 0);
        assert_int_equal(s->step, k + 1);
    }
    assert_int_equal(s->client_slots[0].counts.accepted, 3);
    assert_int_equal(s->client_slots[0].counts.starved,
                     3); /* step 1, whose input was made but never arrived, 5 and 6 */
    assert_int_equal(s->client_slots[1].counts.starved, 0); /* never played */
    free(s);
}

/* A disconnected player is neutral after its last received input, with any starvation policy for others. */
static void disconnected_players_are_neutral_after_their_last_input(void **state)
{
    (void)state;
    static const char *const starved[] = {"starved=decay", "starved=repeat", "starved=repeat_n",
                                          "starved=neutral"};
    for (int i = 0; i < 4; i++) {
        ll_server *s = new_server(2, &ll_sync_free, 50, 50);
        ll_input_message m = inputs(1, 4, (double[]){1, -0.5, 0.25, 0.75}); /* for steps 1 to 4 */
        configure(s, (const char *[]){starved[i], NULL});
        assert_int_equal(take(s, &ll_sync_free, &m, NULL), 4);
        step(s, &ll_sync_free);
        step(s, &ll_sync_free);
        assert_true(
            ll_admission_check(s, 0, LL_SECOND, s->client_slots[0].connection.last_ack + 1001 * LL_MS));
        const double expected[] = {0.75, 1.5, 1.5, 1.5, 1.5};
        for (int k = 0; k < 5; k++) {
            step(s, &ll_sync_free);
            assert_true(at(s, 0) == expected[k]);
        }
        free(s);
    }
}

static void repetitions_are_no_news(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message m = inputs(1, 2, (double[]){0.5, 0.25}), other = inputs(1, 3, (double[]){-1, -1, 1});
    assert_int_equal(take(s, &ll_sync_free, &m, v), 2);
    assert_int_equal(take(s, &ll_sync_free, &m, v), 0);
    assert_int_equal(take(s, &ll_sync_free, &other, v), 1); /* the first one counts */
    assert_int_equal(v[0].seq, 3);
    assert_int_equal(s->client_slots[0].counts.duplicate, 4);
    for (int k = 0; k < 3; k++)
        step(s, &ll_sync_free);
    assert_true(at(s, 0) == 0.5 + 0.25 + 1);
    assert_int_equal(take(s, &ll_sync_free, &m, v), 0); /* also when it is decided */
    assert_int_equal(s->client_slots[0].counts.late, 0);
    free(s);
}

static void late_inputs_are_reported_and_not_applied(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message first = inputs(1, 1, (double[]){0.5}), late = inputs(2, 4, (double[]){1, 1, 1, 1});
    configure(s, (const char *[]){"starved=repeat", NULL});
    take(s, &ll_sync_free, &first, v);
    for (int k = 0; k < 4; k++)
        step(s, &ll_sync_free);
    assert_true(at(s, 0) == 4 * 0.5);
    assert_int_equal(acked(s), 4);                         /* the snapshot no longer waits for these */
    assert_int_equal(take(s, &ll_sync_free, &late, v), 4); /* for 2, 3, 4: too late; 5: in time */
    for (int i = 0; i < 3; i++)
        assert_int_equal(v[i].outcome, LL_OUTCOME_LATE);
    assert_int_equal(v[3].outcome, LL_OUTCOME_APPLIED);
    assert_int_equal(s->client_slots[0].counts.late, 3);
    assert_int_equal(s->client_slots[0].counts.accepted, 2);
    step(s, &ll_sync_free);
    assert_true(at(s, 0) == 4 * 0.5 + 1);
    assert_int_equal(acked(s), 5);
    free(s);
}

/* A refused input is replaced according to `refused`, so that no player waits for it. `x`: after each
 * step. */
static void refused_inputs_are_replaced(const char *refused, const double x[5])
{
    const ll_sync_mode *const syncs[] = {&ll_sync_free, &ll_sync_lockstep};
    for (size_t i = 0; i < 2; i++) {
        ll_server *s = new_server(1, syncs[i], 60, 60);
        if (refused)
            configure(s, (const char *[]){refused, NULL});
        ll_input_result v[LL_INPUTS_MAX];
        ll_input_message m = inputs(1, 4, (double[]){0.5, 2, NAN, -0.25}),
                         again = inputs(5, 1, (double[]){-7});
        assert_int_equal(take(s, syncs[i], &m, v), 4);
        const ll_outcome outcomes[] = {LL_OUTCOME_APPLIED, LL_OUTCOME_REFUSED, LL_OUTCOME_REFUSED,
                                       LL_OUTCOME_APPLIED};
        for (int k = 0; k < 4; k++) {
            assert_int_equal(v[k].outcome, outcomes[k]);
            assert_int_equal(v[k].rule, outcomes[k] == LL_OUTCOME_REFUSED ? LL_RULE_MAGNITUDE : LL_RULE_NONE);
            step(s, syncs[i]);
            assert_true(at(s, 0) == x[k]);
            assert_int_equal(acked(s), k + 1);
        }
        take(s, syncs[i], &again, v); /* the one before was applied already */
        step(s, syncs[i]);
        assert_true(at(s, 0) == x[4]);
        assert_int_equal(s->client_slots[0].counts.refused[LL_RULE_MAGNITUDE], 3);
        assert_int_equal(s->client_slots[0].counts.accepted, 2);
        free(s);
    }
}

static void refused_inputs_are_neutral(void **state)
{
    (void)state;
    refused_inputs_are_replaced(NULL, (double[]){0.5, 0.5, 0.5, 0.25, 0.25});
}

static void refused_inputs_may_be_those_before(void **state)
{
    (void)state;
    refused_inputs_are_replaced("refused=previous", (double[]){0.5, 1, 1.5, 1.25, 1});
}

static void packets_of_another_epoch_are_discarded(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    ll_client_slot before = s->client_slots[0];
    ll_input_message m = inputs(1, 2, (double[]){1, 2});
    const uint16_t epochs[] = {0, 2, 65535};
    for (size_t i = 0; i < 3; i++) {
        m.head.epoch = epochs[i];
        assert_int_equal(take(s, &ll_sync_free, &m, NULL), 0);
    }
    assert_memory_equal(&s->client_slots[0], &before, sizeof before);
    free(s);
}

static void inputs_before_the_first_tick_are_ignored(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    ll_input_message m = inputs(-3, 5, (double[]){1, 1, 1, 1, 1}),
                     far = inputs(INT32_MIN + 1, 1, (double[]){1});
    ll_input_result v[LL_INPUTS_MAX];
    assert_int_equal(take(s, &ll_sync_free, &m, v), 1);
    assert_int_equal(take(s, &ll_sync_free, &far, v), 0);
    step(s, &ll_sync_free);
    assert_true(at(s, 0) == 1);
    free(s);
}

/* Push of input `tick`: binary fractions, so that sums are exact. */
static double pattern(int64_t tick)
{
    return (double)(tick * 7 % 17 - 8) / 8;
}

static ll_input_message patterned(int64_t tick, int count)
{
    double x[LL_INPUTS_MAX];
    for (int i = 0; i < count; i++)
        x[i] = pattern(tick + i);
    return inputs(tick, count, x);
}

/* More ticks than the ring has slots, inputs up to 100 steps early, out of order and repeated. */
static void ring_goes_round(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    double x = 0;
    int64_t sent = 0;
    for (int64_t tick = 1; tick <= 1000; tick++) {
        for (; sent < tick + 100; sent += 4) { /* four at a time, the last pair first */
            ll_input_message b = patterned(sent + 3, 2), a = patterned(sent + 1, 4);
            take(s, &ll_sync_free, &b, NULL);
            take(s, &ll_sync_free, &a, NULL);
            s->client_slots[0].limits.allowance.tokens = 80; /* the rate limit is not tested here */
        }
        step(s, &ll_sync_free);
        x += pattern(tick);
        assert_true(at(s, 0) == x);
        assert_int_equal(acked(s), tick);
    }
    assert_int_equal(s->client_slots[0].counts.starved, 0);
    assert_int_equal(s->client_slots[0].counts.late, 0);
    assert_int_equal(s->client_slots[0].counts.accepted, sent);
    assert_int_equal(s->client_slots[0].counts.duplicate, sent / 2);
    /* An input whose slot a later one has is not mistaken for new. */
    int64_t duplicate = s->client_slots[0].counts.duplicate, newest = s->client_slots[0].inputs.newest;
    ll_input_message old = patterned(newest - LL_INPUT_RING - 1, 2);
    assert_int_equal(take(s, &ll_sync_free, &old, NULL), 0);
    assert_int_equal(s->client_slots[0].counts.duplicate, duplicate + 2);
    assert_int_equal(s->client_slots[0].inputs.ring[newest % LL_INPUT_RING].tick, newest);
    free(s);
}

/* Slack: how many steps later an input could have arrived, the smallest since the last update. */
static void slack_is_the_least_since_the_last_update(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    assert_int_equal(state_to(s, 0).slack, LL_SLACK_UNKNOWN);
    const struct {
        int64_t tick;
        int slack;
    } news[] = {{1, 0}, {6, 5}, {4, 3}, {8, 7}};
    for (size_t i = 0; i < sizeof news / sizeof news[0]; i++) {
        ll_input_message m = patterned(news[i].tick, 1);
        take(s, &ll_sync_free, &m, NULL);
    }
    ll_snapshot_message m = state_to(s, 0);
    assert_int_equal(m.slack, 0);
    assert_int_equal(m.slack_seq, 1);
    assert_int_equal(state_to(s, 0).slack, LL_SLACK_UNKNOWN); /* nothing arrived since */
    step(s, &ll_sync_free);
    step(s, &ll_sync_free);
    ll_input_message early = patterned(12, 1), later = patterned(13, 1);
    take(s, &ll_sync_free, &early, NULL); /* 9 steps early at step 2 */
    take(s, &ll_sync_free, &later, NULL); /* 10 */
    m = state_to(s, 0);
    assert_int_equal(m.slack, 9);
    assert_int_equal(m.slack_seq, 12);
    for (int k = 0; k < 14; k++)
        step(s, &ll_sync_free);
    ll_input_message late = patterned(14, 1);
    take(s, &ll_sync_free, &late, NULL); /* at step 16 */
    assert_int_equal(state_to(s, 0).slack, -3);
    ll_input_message ahead = patterned(30, 1), behind = patterned(20, 1);
    take(s, &ll_sync_free, &ahead, NULL);
    take(s, &ll_sync_free, &behind, NULL); /* arrives after a later one, and is the one that is nearly late */
    m = state_to(s, 0);
    assert_int_equal(m.slack, 3);
    assert_int_equal(m.slack_seq, 20);
    free(s);
}

static void snapshots_contain_step_time_and_rate(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    step(s, &ll_sync_free);
    step(s, &ll_sync_free);
    ll_snapshot_message m = state_to(s, 0);
    assert_int_equal(m.head.type, LL_MESSAGE_SNAPSHOT);
    assert_int_equal(m.head.epoch, 1);
    assert_int_equal(m.tick, 2);
    assert_int_equal(m.time, 2 * LL_SECOND / 60);
    assert_true(m.update_hz == 30);
    free(s);
}

/* A client that asks for them gets the others' controls at the step, between the message and the world. */
static void controls_are_sent_on_request(void **state)
{
    (void)state;
    ll_server *s = new_server(3, &ll_sync_free, 60, 60);
    ll_input_message ask = inputs(1, 1, (double[]){0.5}), other = inputs(1, 1, (double[]){-0.25});
    size_t world = ll_world_size(ll_server_world(s));
    char bytes[4096];
    ll_snapshot_message m;
    ll_axes axes[2];
    ask.wants = LL_PART_AXES;
    take_at(s, &ll_sync_free, 1, &ask, 0, NULL);
    take_at(s, &ll_sync_free, 2, &other, 0, NULL);
    step(s, &ll_sync_free);
    assert_int_equal(ll_server_compose(s, &ll_sync_free, 2, NULL, bytes), sizeof m + world);
    memcpy(&m, bytes, sizeof m);
    assert_int_equal(m.head.count, 0);
    assert_int_equal(ll_server_compose(s, &ll_sync_free, 1, NULL, bytes), sizeof m + sizeof axes + world);
    memcpy(&m, bytes, sizeof m);
    memcpy(axes, bytes + sizeof m, sizeof axes);
    assert_int_equal(m.head.count, LL_PART_AXES);
    assert_true(axes[0].axis[0] == 0 && axes[1].axis[0] == -0.25f);
    assert_memory_equal(bytes + sizeof m + sizeof axes, ll_server_world(s), world);
    ask.wants = LL_PART_AXES | LL_PART_APPLIED; /* all that can be requested */
    take_at(s, &ll_sync_free, 1, &ask, 0, NULL);
    size_t all = sizeof m + sizeof axes + sizeof(ll_input_result_part) + world;
    assert_int_equal(ll_server_compose(s, &ll_sync_free, 1, NULL, bytes),
                     all + sizeof(uint32_t)); /* of one input */
    for (uint32_t seq = 2; seq <= 600;
         seq++) /* and more than is kept, with no snapshot that the client is known to have */
        ll_client_slot_done(&s->client_slots[1], seq, true);
    assert_int_equal(ll_server_compose(s, &ll_sync_free, 1, NULL, bytes),
                     all + LL_INPUT_RESULT_WORDS_MAX * sizeof(uint32_t));
    assert_int_equal(all + LL_INPUT_RESULT_WORDS_MAX * sizeof(uint32_t),
                     ll_server_message_max(toy_extent(NULL, 3), 3));
    ask.wants = 0; /* and no longer */
    take_at(s, &ll_sync_free, 1, &ask, 0, NULL);
    assert_int_equal(ll_server_compose(s, &ll_sync_free, 1, NULL, bytes), sizeof m + world);
    free(s);
}

/* After a restart the steps count on from where they were, at the new rate. */
static void clocks_start_again(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 60, 60);
    ll_input_message m = patterned(1, 8);
    m.head.seq = 11;
    take(s, &ll_sync_free, &m, NULL);
    for (int k = 0; k < 3; k++)
        step(s, &ll_sync_free);
    assert_int_equal(acked(s), 13);
    double x = at(s, 0);
    ll_server_start(s, HZ(7), HZ(7), HZ(60), 123456789);
    assert_int_equal(s->step, 3);
    assert_int_equal(acked(s), 0);
    for (int64_t k = 1; k < 30; k++) {
        assert_int_equal(ll_sync_free.due(s), 123456789 + k * LL_SECOND / 7);
        step(s, &ll_sync_free);
    }
    assert_true(at(s, 0) == x); /* inputs of the old epoch are gone */
    m.tick = 33;
    m.head.epoch = 2;
    m.head.seq = 1;
    assert_int_equal(take(s, &ll_sync_free, &m, NULL), 8);
    step(s, &ll_sync_free);
    assert_int_equal(acked(s), 1);
    free(s);
}

/* ---- lockstep ---- */

static void lockstep_waits_for_all_players(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_lockstep;
    ll_server *s = new_server(2, sync, 10, 10);
    ll_input_message one = inputs(1, 1, (double[]){1}), two = inputs(2, 1, (double[]){0.5});
    assert_int_equal(sync->due(s), LL_NEVER);
    take_at(s, sync, 0, &one, 20 * LL_MS, NULL);
    assert_int_equal(sync->due(s), LL_NEVER);
    take_at(s, sync, 0, &two, 120 * LL_MS, NULL); /* A is a step ahead */
    assert_int_equal(sync->due(s), LL_NEVER);
    take_at(s, sync, 1, &one, 350 * LL_MS, NULL);
    assert_int_equal(sync->due(s), 450 * LL_MS); /* an interval after the last arrived */
    step(s, sync);
    assert_true(at(s, 0) == 1 && at(s, 1) == 1);
    assert_int_equal(s->stalled, 350 * LL_MS); /* 450 instead of 100 */
    assert_int_equal(sync->due(s), LL_NEVER);
    take_at(s, sync, 1, &two, 460 * LL_MS, NULL);
    assert_int_equal(sync->due(s), 560 * LL_MS);
    step(s, sync);
    assert_int_equal(s->stalled, 360 * LL_MS);
    assert_true(at(s, 0) == 1.5 && at(s, 1) == 1.5);
    assert_int_equal(state_to(s, 1).head.seq, 2);
    free(s);
}

/* When all players' inputs arrive an interval apart, at any delay, so are the steps, and nothing stalls. */
static void lockstep_keeps_its_rate(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_lockstep_pipelined;
    ll_server *s = new_server(2, sync, 10, 10);
    double x = 0;
    for (int64_t k = 1; k <= 3; k++) { /* some arrive early */
        ll_input_message early = patterned(k, 1);
        take_at(s, sync, 0, &early, (k - 4) * 100 * LL_MS, NULL);
    }
    for (int64_t k = 1; k <= 50; k++) {
        ll_input_message a = patterned(k + 3, 1), b = patterned(k, 1);
        take_at(s, sync, 0, &a, (k - 1) * 100 * LL_MS, NULL);
        take_at(s, sync, 1, &b, (k - 1) * 100 * LL_MS, NULL);
        assert_int_equal(sync->due(s), k * 100 * LL_MS);
        step(s, sync);
        x += pattern(k);
        assert_true(at(s, 0) == x && at(s, 1) == x);
        assert_int_equal(sync->due(s), LL_NEVER);
    }
    assert_int_equal(s->stalled, 0);
    free(s);
}

/* Of two players whose inputs arrive 30 ms apart either may be the last of an interval. At the start it is B,
 * who is farther. Then A's inputs stop for a time and arrive a step later, so that B's are early and A's are
 * the last: steps stay where B's inputs have them, 30 ms later, for as long as B takes to skip one. */
static void lockstep_restores_its_rhythm(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_lockstep_pipelined;
    ll_server *s = new_server(2, sync, 10, 10);
    s->client_slots[0].connection.offset =
        1; /* as measured by their pings: the first of A would arrive after 120 ms, of B after 250 */
    s->client_slots[1].connection.offset = 2;
    ll_time slowest = 0;
    for (int64_t k = 1; k <= 60; k++) {
        ll_time outage = k > 20 ? 3 * 100 * LL_MS : 0; /* of A's, who was early by a step before */
        ll_input_message a = patterned(k, 1), b = patterned(k, 1);
        ll_time at_a = (k * 100 + 20) * LL_MS + outage, at_b = (k * 100 + 150) * LL_MS;
        take_at(s, sync, at_a < at_b ? 0 : 1, at_a < at_b ? &a : &b, at_a < at_b ? at_a : at_b, NULL);
        take_at(s, sync, at_a < at_b ? 1 : 0, at_a < at_b ? &b : &a, at_a < at_b ? at_b : at_a, NULL);
        ll_time due = sync->due(s), natural = (at_a > at_b ? at_a : at_b) + 100 * LL_MS;
        assert_true(due >= natural);
        slowest = due - natural > slowest ? due - natural : slowest;
        if (k <= 20)
            assert_int_equal(due, natural);
        else if (k > 21 && due < 21 * 100 * LL_MS + 4 * LL_SECOND)
            assert_in_range(due - natural, 30 * LL_MS, 31 * LL_MS); /* B's 50 ms are A's 20 and 30 */
        step(s, sync);
    }
    assert_true(slowest < 100 * LL_MS);
    free(s);
}

/* Steps that were delayed too long are made four times as fast, so that latency returns to what it was. */
static void lockstep_makes_up_for_a_stall(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_lockstep_pipelined;
    ll_server *s = new_server(2, sync, 10, 10);
    ll_input_message m = patterned(1, 16);
    take_at(s, sync, 0, &m, 0, NULL);
    take_at(s, sync, 1, &m, 700 * LL_MS, NULL);
    double x = 0;
    for (int64_t k = 1; k <= 16; k++) {
        assert_int_equal(sync->due(s), (800 + (k - 1) * 25) * LL_MS);
        step(s, sync);
        x += pattern(k);
        assert_true(at(s, 0) == x && at(s, 1) == x);
    }
    assert_int_equal(s->stalled, 700 * LL_MS); /* step 1 at 800 instead of 100 */
    assert_int_equal(sync->due(s), LL_NEVER);
    free(s);
}

/* No player waits for a disconnected one, which gets neutral inputs instead of its received ones. With no
 * player connected the game stops. */
static void lockstep_does_not_wait_for_disconnected_players(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_lockstep;
    ll_server *s = new_server(2, sync, 10, 10);
    ll_input_message one = inputs(1, 1, (double[]){1}), two = inputs(2, 2, (double[]){0.5, 0.5});
    take_at(s, sync, 0, &one, 0, NULL);
    take_at(s, sync, 1, &one, 0, NULL);
    take_at(s, sync, 1, &two, 0, NULL);
    step(s, sync);
    s->client_slots[1].connection.connected = 0;
    take_at(s, sync, 0, &two, 230 * LL_MS, NULL);
    assert_int_equal(sync->due(s), 330 * LL_MS);
    step(s, sync);
    assert_true(at(s, 0) == 1.5 && at(s, 1) == 1);
    s->client_slots[0].connection.connected = 0;
    assert_int_equal(sync->due(s), LL_NEVER);
    free(s);
}

/* ---- gambetta ---- */

static void gambetta_applies_all_received_inputs(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_gambetta;
    ll_server *s = new_server(2, sync, 3, 50);
    ll_input_message m = patterned(1, 5), later = patterned(7, 1), gap = patterned(6, 1),
                     wild = inputs(8, 1, (double[]){3});
    ll_input_result v[LL_INPUTS_MAX];
    assert_int_equal(take(s, sync, &m, v), 5);
    assert_int_equal(sync->due(s), LL_SECOND / 3);
    step(s, sync);
    double x = 0;
    for (int64_t k = 1; k <= 5; k++)
        x += pattern(k);
    assert_true(at(s, 0) == x && at(s, 1) == 0);
    assert_int_equal(acked(s), 5);
    step(s, sync); /* nothing arrived: nothing moves, nothing is repeated */
    assert_true(at(s, 0) == x);
    assert_int_equal(take(s, sync, &m, v), 0);
    step(s, sync);
    assert_true(at(s, 0) == x);
    take(s, sync, &later, v);
    step(s, sync);
    assert_true(at(s, 0) == (x += pattern(7)));
    assert_int_equal(acked(s), 7);
    assert_int_equal(take(s, sync, &gap, v), 1); /* not late: the demo's rule */
    assert_int_equal(v[0].outcome, LL_OUTCOME_APPLIED);
    step(s, sync);
    assert_true(at(s, 0) == (x += pattern(6)));
    assert_int_equal(acked(s), 6); /* and the acknowledgement decreases: the demo's defect */
    assert_int_equal(take(s, sync, &wild, v), 1);
    assert_int_equal(v[0].outcome, LL_OUTCOME_REFUSED);
    step(s, sync);
    assert_true(at(s, 0) == x); /* dropped, not replaced */
    free(s);
}

static void gambetta_drains_for_longer_than_the_ring(void **state)
{
    (void)state;
    const ll_sync_mode *sync = &ll_sync_gambetta;
    ll_server *s = new_server(1, sync, 10, 50);
    double x = 0;
    for (int64_t first = 1; first < 1000; first += 5) {
        ll_input_message m = patterned(first, 5);
        take(s, sync, &m, NULL);
        take(s, sync, &m, NULL);
        step(s, sync);
        for (int64_t k = first; k < first + 5; k++)
            x += pattern(k);
        assert_true(at(s, 0) == x);
        assert_int_equal(acked(s), first + 4);
    }
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inputs_apply_at_their_step),
        cmocka_unit_test(disconnected_players_are_neutral_after_their_last_input),
        cmocka_unit_test(repetitions_are_no_news),
        cmocka_unit_test(late_inputs_are_reported_and_not_applied),
        cmocka_unit_test(refused_inputs_are_neutral),
        cmocka_unit_test(refused_inputs_may_be_those_before),
        cmocka_unit_test(packets_of_another_epoch_are_discarded),
        cmocka_unit_test(inputs_before_the_first_tick_are_ignored),
        cmocka_unit_test(ring_goes_round),
        cmocka_unit_test(slack_is_the_least_since_the_last_update),
        cmocka_unit_test(snapshots_contain_step_time_and_rate),
        cmocka_unit_test(controls_are_sent_on_request),
        cmocka_unit_test(clocks_start_again),
        cmocka_unit_test(lockstep_waits_for_all_players),
        cmocka_unit_test(lockstep_keeps_its_rate),
        cmocka_unit_test(lockstep_restores_its_rhythm),
        cmocka_unit_test(lockstep_makes_up_for_a_stall),
        cmocka_unit_test(lockstep_does_not_wait_for_disconnected_players),
        cmocka_unit_test(gambetta_applies_all_received_inputs),
        cmocka_unit_test(gambetta_drains_for_longer_than_the_ring),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

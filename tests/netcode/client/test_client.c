/* A client: how far ahead it runs, what it sends, what it accepts. */
#include "netcode/toy.h"

/* ---- lead ---- */

/* The first input reaches the server `slack_ticks` before its step must be made: packets count for the step
 * at whose instant they arrive. */
static void lead_matches_the_link(void **state)
{
    (void)state;
    static const struct {
        double lag, delay, jitter;
        int slack;
        double hz;
        int lead; /* steps from the server's present one to the first input's */
    } cases[] = {
        {0, 0, 0, 0, 60, 1},       {0, 0, 0, 1, 60, 2},      {10, 0, 0, 1, 60, 2},
        {17, 0, 0, 1, 60, 3},      {50, 0, 0, 0, 60, 3},     {50.1, 0, 0, 0, 60, 4},
        {50, 100, 0, 0, 60, 9},    {50, 100, 50, 2, 60, 14}, {100, 0, 0, 0, 50, 5},
        {100, 0, 0, 3, 10, 4},     {101, 0, 0, 3, 10, 5},    {1000, 1000, 500, 30, 60, 180},
        {150, 0, 0, 1, 59.94, 10},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lone *l = new_lone(1, &toy, &ll_sync_free);
        ll_input_message m;
        l->config.lag_ms = cases[i].lag;
        l->config.link.up.delay_ms = cases[i].delay;
        l->config.link.up.jitter_ms = cases[i].jitter;
        l->config.slack_ticks = cases[i].slack;
        start_lone(l, cases[i].hz, 1000, LL_SECOND);
        assert_true(frame(l, LL_SECOND, &m) > 0);
        assert_int_equal(m.tick, 1000 + cases[i].lead);
        assert_int_equal(m.head.seq, 1);
        assert_int_equal(m.head.count, 1);
        free_lone(l);
    }
}

static void others_do_not_lead(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_lockstep);
    ll_input_message m;
    l->config.lag_ms = 500;
    start_lone(l, 10, 70, 0);
    assert_true(frame(l, 0, &m) > 0);
    assert_int_equal(m.tick, 71); /* the next step */
    free_lone(l);
    l = new_lone(1, &toy, &ll_sync_gambetta);
    l->client->inputs.held = push(1);
    start_lone(l, 50, 70, 0);
    assert_true(frame(l, 0, &m) > 0);
    assert_int_equal(m.tick, 1); /* inputs have numbers, not steps */
    free_lone(l);
}

/* ---- following the slack ---- */

#define LOOP_HZ 60
#define LOOP_FRAMES 2400
#define LOOP_FLIGHTS 512

typedef struct flight {
    ll_time due;
    bool up;
    int64_t tick; /* up: of the newest input */
    uint32_t seq;
    packet state;
} flight;

/* A client at 60 Hz and a server reduced to its slack: it steps at 60 Hz, takes the newest input of each
 * packet, and every second step reports its slack. `lag` may change with time. Returns the slack of each
 * frame's newest input, by the frame that sent it. */
static void run_loop(lone *l, ll_time (*lag)(ll_time now), int slack_of[LOOP_FRAMES])
{
    flight *flights = calloc(LOOP_FLIGHTS, sizeof *flights);
    int frame_of[4 * LOOP_FRAMES] = {0};
    int64_t least = LL_SLACK_UNKNOWN, newest = -1;
    uint32_t least_seq = 0, acked = 0;
    for (int i = 0; i < LOOP_FLIGHTS; i++)
        flights[i].due = LL_NEVER;
    for (int f = 0; f < LOOP_FRAMES; f++)
        slack_of[f] = LL_SLACK_UNKNOWN;
    for (int64_t tick = 0, step = 0, f = 0; f < LOOP_FRAMES; tick++) { /* of a fifth of a ms */
        ll_time now = tick * LL_MS / 5;
        for (int i = 0; i < LOOP_FLIGHTS; i++) {
            flight *p = &flights[i];
            if (p->due > now)
                continue;
            p->due = LL_NEVER;
            if (!p->up) {
                give(l, &p->state, now);
            } else if (p->tick > newest) {
                newest = p->tick;
                int64_t slack = p->tick - 1 - step;
                slack_of[frame_of[p->seq]] = (int)slack;
                acked = p->seq;
                if (slack < least) {
                    least = slack;
                    least_seq = p->seq;
                }
            }
        }
        flight *out = flights;
        while (out->due != LL_NEVER)
            out++;
        if (now >= ll_tick_time(step + 1, HZ(LOOP_HZ))) {
            step++;
            if (step % 2 == 0) {
                *out = (flight){.due = now + lag(now), .state = state_of(step, now, acked, 1, (double[]){0})};
                out->state.head.slack = (int32_t)least;
                out->state.head.slack_seq = least_seq;
                least = LL_SLACK_UNKNOWN;
                while (out->due != LL_NEVER)
                    out++;
            }
        }
        if (now >= ll_tick_time(f, HZ(LOOP_HZ))) {
            ll_input_message m;
            if (frame(l, now, &m) > 0) {
                int64_t last = m.tick + m.head.count - 1;
                uint32_t seq = m.head.seq + m.head.count - 1u;
                assert_true(seq < 4 * LOOP_FRAMES);
                frame_of[seq] = (int)f;
                *out = (flight){.due = now + lag(now), .up = true, .tick = last, .seq = seq};
            }
            f++;
        }
    }
    free(flights);
}

static ll_time lag_rises(ll_time now)
{
    return now < 5 * LL_SECOND ? 50 * LL_MS : 190 * LL_MS;
}

static ll_time lag_falls(ll_time now)
{
    return now < 5 * LL_SECOND ? 190 * LL_MS : 50 * LL_MS;
}

static ll_time lag_falls_little(ll_time now)
{
    return now < 5 * LL_SECOND ? 90 * LL_MS : 50 * LL_MS;
}

static ll_time lag_rises_far(ll_time now)
{
    return now < 5 * LL_SECOND ? 5 * LL_MS : 900 * LL_MS;
}

static ll_time lag_falls_far(ll_time now)
{
    return now < 5 * LL_SECOND ? 900 * LL_MS : 5 * LL_MS;
}

/* After a change of lag the slack returns to the wanted value: from too late within two round trips, from too
 * early within a few seconds more, both without overshoot. */
static void slack_is_followed_without_overshoot(void **state)
{
    (void)state;
    static const struct {
        ll_time (*lag)(ll_time now);
        double before_ms, after_ms;
        bool rises;
    } cases[] = {{lag_rises, 50, 190, true},
                 {lag_falls, 190, 50, false},
                 {lag_falls_little, 90, 50, false},
                 {lag_rises_far, 5, 900, true},
                 {lag_falls_far, 900, 5, false}};
    static int slack_of[LOOP_FRAMES];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        for (int want = 0; want <= 4; want += 2) {
            lone *l = new_lone(1, &toy, &ll_sync_free);
            l->config.lag_ms = cases[i].before_ms;
            l->config.slack_ticks = want;
            start_lone(l, LOOP_HZ, 0, 0);
            run_loop(l, cases[i].lag, slack_of);
            for (int f = 0; f < 5 * LOOP_HZ; f++) /* before: as measured by the handshake */
                assert_true(slack_of[f] == LL_SLACK_UNKNOWN || slack_of[f] == want);
            /* A report takes a round trip and an update; the correction takes one frame per step. */
            double steps = (cases[i].after_ms - cases[i].before_ms) * LOOP_HZ / 1000;
            double settled = 5 + 2 * 2 * cases[i].after_ms / 1000 + 5 + fabs(steps) / LOOP_HZ;
            int measured = 0;
            for (int f = 5 * LOOP_HZ; f < LOOP_FRAMES - LOOP_HZ * 2; f++) {
                if (slack_of[f] == LL_SLACK_UNKNOWN)
                    continue;
                if (cases[i].rises)
                    assert_true(slack_of[f] <= want + 1); /* never beyond */
                else
                    assert_true(slack_of[f] >= want); /* never late */
                if (f > settled * LOOP_HZ) {
                    measured++;
                    assert_in_range(slack_of[f], want, want + 1);
                }
            }
            assert_true(measured > 1000);
            free_lone(l);
        }
}

/* ---- sent packets ---- */

/* A number that identifies each input. */
static ll_action numbered(uint32_t seq)
{
    return push((double)seq / 1024);
}

static void must_hold(const ll_input_message *m, uint32_t first, int count, int64_t tick)
{
    assert_int_equal(m->head.type, LL_MESSAGE_INPUT);
    assert_int_equal(m->head.epoch, 1);
    assert_int_equal(m->head.seq, first);
    assert_int_equal(m->head.count, count);
    assert_int_equal(m->tick, tick);
    for (int i = 0; i < count; i++) {
        ll_action a = numbered(first + (uint32_t)i);
        assert_memory_equal(&m->inputs[i], &a, offsetof(ll_action, view_age_ns));
    }
}

static int numbered_frame(lone *l, int f, ll_input_message *m)
{
    l->client->inputs.held = numbered(l->client->inputs.seq + 1);
    return frame(l, ll_tick_time(f, HZ(60)), m);
}

static void acknowledge(lone *l, int64_t tick, uint32_t seq, ll_time now)
{
    packet p = state_of(tick, now, seq, 1, (double[]){0});
    assert_int_equal(give(l, &p, now), LL_OUTCOME_APPLIED);
}

static void packets_repeat_open_inputs(void **state)
{
    (void)state;
    for (int redundancy = 0; redundancy <= 15; redundancy += 3) {
        lone *l = new_lone(1, &toy, &ll_sync_free);
        l->config.redundancy = redundancy;
        l->config.slack_ticks = 0;
        start_lone(l, 60, 0, 0);
        for (int f = 0; f < 40; f++) {
            ll_input_message m;
            int count = f + 1 < 1 + redundancy ? f + 1 : 1 + redundancy, bytes = numbered_frame(l, f, &m);
            assert_int_equal(bytes, 16 + 16 * count);
            must_hold(&m, (uint32_t)(f + 1 - count + 1), count, f + 1 - count + 1);
        }
        /* Acknowledged inputs are not repeated. */
        ll_input_message m;
        acknowledge(l, 1, 39, LL_SECOND);
        assert_true(numbered_frame(l, 60, &m) > 0);
        int count = redundancy < 1 ? 1 : 2;
        must_hold(&m, (uint32_t)(41 - count + 1), count, 41 - count + 1);
        free_lone(l);
    }
}

static void idle_clients_are_silent_where_the_rules_say_so(void **state)
{
    (void)state;
    ll_input_message m;
    lone *l = new_lone(1, &toy, &ll_sync_gambetta);
    start_lone(l, 60, 0, 0);
    assert_int_equal(frame(l, 0, &m), 0);
    l->client->inputs.held = push(1);
    assert_true(frame(l, LL_SECOND / 60, &m) > 0);
    l->client->inputs.held = push(0);
    assert_int_equal(frame(l, 2 * LL_SECOND / 60, &m), 0); /* nothing new: nothing is repeated either */
    l->client->inputs.held = (ll_action){.buttons = LL_BUTTON_FIRE};
    assert_true(frame(l, 3 * LL_SECOND / 60, &m) > 0);
    l->client->inputs.held = (ll_action){.axis = {0, -1}};
    assert_true(frame(l, 4 * LL_SECOND / 60, &m) > 0);
    assert_int_equal(l->client->inputs.seq, 3);
    free_lone(l);
    l = new_lone(1, &toy, &ll_sync_free);
    start_lone(l, 60, 0, 0);
    assert_true(frame(l, 0, &m) > 0);
    free_lone(l);
}

/* 512 inputs are kept open. A client without packets for longer continues: it drops the oldest and always
 * sends the newest; acknowledgements of dropped inputs do no harm. */
static void a_full_window_gives_up_its_oldest(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    ll_input_message m;
    int64_t lead = 0;
    start_lone(l, 60, 0, 0);
    for (int f = 0; f < 700; f++) {
        assert_true(numbered_frame(l, f, &m) > 0);
        assert_int_equal(l->client->inputs.seq, f + 1);
        assert_int_equal(l->client->inputs.acked, f + 1 > LL_PENDING_RING ? f + 1 - LL_PENDING_RING : 0);
        if (f == 0)
            lead = l->client->inputs.tick;
        int count = f + 1 < 3 ? f + 1 : 3;
        must_hold(&m, (uint32_t)(f + 2 - count), count, lead + f - count + 1);
    }
    acknowledge(l, 1, 50, 12 * LL_SECOND); /* dropped long ago */
    assert_true(numbered_frame(l, 720, &m) > 0);
    assert_int_equal(l->client->inputs.acked, 701 - LL_PENDING_RING);
    must_hold(&m, 699, 3, l->client->inputs.tick - 2);
    acknowledge(l, 2, 400, 13 * LL_SECOND);
    assert_true(numbered_frame(l, 780, &m) > 0);
    assert_int_equal(l->client->inputs.acked, 400);
    for (uint32_t seq = 401; seq <= 702; seq++)
        assert_true(ll_client_is_open(l->client, seq));
    acknowledge(l, 3, 702, 14 * LL_SECOND);
    assert_true(numbered_frame(l, 840, &m) > 0);
    must_hold(&m, 703, 1, l->client->inputs.tick);
    free_lone(l);
}

/* Where the server waits, every packet is full of open inputs, and every other packet starts with the oldest
 * one. This also holds when no input may be made any more: the server refuses inputs 128 steps ahead of it.
 */
static void pipelined_lockstep_repeats_the_oldest(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_lockstep_pipelined);
    ll_input_message m;
    int oldest = 0, made = 0, acknowledged = 0;
    start_lone(l, 60, 0, 0);
    for (int f = 0; f < 400; f++) { /* the server steps at a third of the rate and acknowledges no input */
        int steps = f / 3, most = LL_BUDGET_TICKS - 1 + steps;
        if (f % 3 == 0 && steps > 0)
            acknowledge(l, steps, 0, ll_tick_time(f, HZ(60)));
        made += made < most;
        int count = made < 16 ? made : 16;
        assert_true(numbered_frame(l, f, &m) > 0);
        if (made > 16 && f % 2 == 0) { /* the older ones in turn, from the oldest on */
            int turns = (made - 1) / 16, first = 1 + (f + 1) / 2 % turns * 16;
            must_hold(&m, (uint32_t)first, 16, first);
            assert_int_equal(m.fresh, 0); /* a repeated input says nothing about the link */
            oldest += first == 1;
        } else {
            must_hold(&m, (uint32_t)(made - count + 1), count, made - count + 1);
            assert_int_equal(m.fresh,
                             made - acknowledged); /* including those made with a packet of older ones */
            acknowledged = made;
        }
    }
    assert_int_equal(made, LL_BUDGET_TICKS - 1 + 399 / 3);
    assert_true(oldest > 400 / 2 / 17);
    acknowledge(l, 200, 200, ll_tick_time(400, HZ(60)));
    int from_oldest = 0;
    for (int f = 400; f < 400 + 2 * 8; f++) {
        assert_true(numbered_frame(l, f, &m) > 0);
        from_oldest += m.head.seq == 201;
    }
    assert_true(from_oldest >= 1);
    uint32_t all = l->client->inputs.seq;
    acknowledge(l, all, all, 8 * LL_SECOND); /* only inputs made in this frame are open */
    assert_true(numbered_frame(l, 480, &m) > 0);
    must_hold(&m, all + 1, 1, all + 1);
    free_lone(l);
}

/* A server without snapshots for four intervals waits for a player: inputs made meanwhile would all be late
 * by as much, permanently. Open inputs are still sent. */
static void pipelined_lockstep_makes_nothing_in_a_stall(void **state)
{
    (void)state;
    static const int stalls[] = {3, 5, 6, 50, 400};
    for (size_t i = 0; i < sizeof stalls / sizeof stalls[0]; i++) {
        lone *l = new_lone(1, &toy, &ll_sync_lockstep_pipelined);
        ll_input_message m;
        int f = 0;
        l->config.lag_ms = 50;
        start_lone(l, 60, 0, 0);
        for (; f < 100; f++) { /* the snapshot after step k arrives after frame k + 6 */
            assert_true(numbered_frame(l, f, &m) > 0);
            assert_int_equal(l->client->inputs.seq, f + 1);
            if (f > 6)
                acknowledge(l, f - 6, (uint32_t)(f - 6), ll_tick_time(f, HZ(60)) + LL_MS);
        }
        for (; f < 100 + stalls[i];
             f++) { /* the last arrived after frame 99: those within four intervals of it */
            assert_true(numbered_frame(l, f, &m) > 0);
            assert_int_equal(l->client->inputs.seq, f < 104 ? f + 1 : 104);
        }
        uint32_t open = l->client->inputs.seq;
        acknowledge(l, 94, 94, ll_tick_time(f, HZ(60)));
        assert_true(numbered_frame(l, f, &m) > 0);
        assert_int_equal(l->client->inputs.seq, open + 1); /* one per frame, none for skipped frames */
        free_lone(l);
    }
}

/* The first snapshot comes a round trip after the first input: before it the client makes the inputs of that
 * time, and those of four intervals. */
static void pipelined_lockstep_waits_for_the_first_state_too(void **state)
{
    (void)state;
    static const int lags_ms[] = {0, 20, 250};
    for (int i = 0; i < 3; i++) {
        lone *l = new_lone(1, &toy, &ll_sync_lockstep_pipelined);
        ll_input_message m;
        l->config.lag_ms = lags_ms[i];
        start_lone(l, 60, 0, LL_SECOND);
        for (int f = 60; f < 400; f++)
            assert_true(numbered_frame(l, f, &m) > 0); /* open inputs are still sent */
        double intervals = 4 + 2 * lags_ms[i] * 60 / 1000.0;
        assert_true(l->client->inputs.seq >= floor(intervals) &&
                    l->client->inputs.seq <= floor(intervals) + 1);
        acknowledge(l, 1, 1, ll_tick_time(400, HZ(60)));
        uint32_t before = l->client->inputs.seq;
        numbered_frame(l, 400, &m);
        assert_int_equal(l->client->inputs.seq, before + 1);
        free_lone(l);
    }
}

/* The snapshot of step 0 arrived at time 0: exactly four intervals later, to the ns, the wait is not over
 * yet. */
static void pipelined_lockstep_waits_four_intervals_whole(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_lockstep_pipelined);
    ll_input_message m;
    start_lone(l, 40, 0, 0); /* an interval is 25 ms to the ns */
    for (int f = 0; f < 8; f++) {
        assert_true(frame(l, f * 25 * LL_MS, &m) > 0);
        assert_int_equal(l->client->inputs.seq, f < 4 ? f + 1 : 5);
    }
    free_lone(l);
}

/* Stop and wait: input n + 1 is made when the snapshot that includes n has arrived, however late, and not on
 * another one; until then n is sent again at every timer. */
static void lockstep_makes_one_input_a_state(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_lockstep);
    ll_input_message m;
    ll_time now = 0;
    start_lone(l, 60, 0, 0);
    for (uint32_t n = 1; n < 50; n++) {
        for (uint32_t again = 0; again <= n % 4; again++) {
            now += (7 + 90 * again) * LL_MS;
            l->client->inputs.held = numbered(n);
            assert_true(frame(l, now, &m) > 0);
            assert_int_equal(l->client->inputs.seq, n);
            must_hold(&m, n, 1, n);
        }
        if (n > 1) {
            packet old = state_of(n - 1, now, n - 1, 1, (double[]){0});
            assert_int_equal(give(l, &old, now), LL_OUTCOME_STALE);
            assert_true(frame(l, now, &m) > 0);
            assert_int_equal(l->client->inputs.seq, n);
        }
        l->client->ticks.due = LL_NEVER;
        acknowledge(l, n, n, now + 3 * LL_MS);
        assert_int_equal(l->client->ticks.due, now + 3 * LL_MS); /* and it is made at once */
    }
    free_lone(l);
}

static void cheats_send_inputs_as_defined(void **state)
{
    (void)state;
    ll_input_message m;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    l->config.slack_ticks = 0;
    l->client->inputs.held = push(0.5);
    start_lone(l, 60, 0, 0);
    l->config.cheat = LL_CHEAT_MAGNITUDE;
    frame(l, 0, &m);
    assert_true(m.inputs[0].axis[0] == 0.75f);
    l->config.cheat = LL_CHEAT_RATE;
    frame(l, 1, &m);
    assert_int_equal(l->client->inputs.seq, 3);
    l->config.cheat = LL_CHEAT_BUDGET;
    for (int f = 2; f < 52; f++)
        frame(l, f, &m);
    assert_int_equal(l->client->inputs.seq, 3 + 60);
    free_lone(l);
}

static void a_leap_is_one_huge_input_now_and_then(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    int leaps = 0;
    l->config.cheat = LL_CHEAT_TELEPORT;
    l->config.redundancy = 0;
    l->client->inputs.held = push(0.5);
    start_lone(l, 60, 0, 0);
    for (int f = 0; f < 600; f++) {
        ll_input_message m;
        acknowledge(l, f + 1, l->client->inputs.seq, ll_tick_time(f, HZ(60)));
        frame(l, ll_tick_time(f, HZ(60)), &m);
        assert_true(m.inputs[0].axis[0] == 0.5f || m.inputs[0].axis[0] == 1000);
        leaps += m.inputs[0].axis[0] == 1000;
    }
    assert_int_equal(leaps, 5);
    free_lone(l);
}

/* Nothing is sent from 3 to 6 s; then everything at once, each input once, and afterwards as before. */
static void a_lag_switch_holds_back_and_releases(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    uint32_t sent = 0;
    l->config.cheat = LL_CHEAT_LAG_SWITCH;
    l->config.redundancy = 0;
    l->config.slack_ticks = 0;
    start_lone(l, 60, 0, 0);
    for (int f = 0; f < 500; f++) {
        ll_input_message m;
        ll_time now = ll_tick_time(f, HZ(60));
        int packets = 0;
        acknowledge(l, f + 1, f < 180 || f > 362 ? l->client->inputs.seq : 180, now);
        for (int bytes = numbered_frame(l, f, &m); bytes > 0; packets++) {
            must_hold(&m, sent + 1, m.head.count, sent + 1);
            sent += m.head.count;
            bytes = ll_client_held(l->client, &l->setup, now, &m);
        }
        assert_int_equal(packets, f < 180 || f > 360 ? 1 : f == 360 ? 12 : 0); /* 181 inputs by 16 */
        assert_true(sent == l->client->inputs.seq || (f >= 180 && f < 360));
    }
    assert_int_equal(sent, 500);
    free_lone(l);
}

/* ---- received packets ---- */

static void stale_states_are_dropped(void **state)
{
    (void)state;
    lone *l = new_lone(2, &toy, &ll_sync_free);
    packet ten = state_of(10, 10, 0, 2, (double[]){1, 2}), nine = state_of(9, 9, 0, 2, (double[]){3, 4}),
           eleven = state_of(11, 11, 0, 2, (double[]){5, 6});
    start_lone(l, 60, 0, 0);
    assert_int_equal(give(l, &ten, LL_MS), LL_OUTCOME_APPLIED);
    assert_int_equal(give(l, &ten, LL_MS), LL_OUTCOME_STALE); /* a copy */
    assert_int_equal(give(l, &nine, 2 * LL_MS), LL_OUTCOME_STALE);
    assert_int_equal(l->client->snapshots.stale, 2);
    frame(l, 3 * LL_MS, NULL);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 1 &&
                ll_client_rendered(l->client)->entity[1].x == 2);
    assert_int_equal(give(l, &eleven, 4 * LL_MS), LL_OUTCOME_APPLIED);
    frame(l, 5 * LL_MS, NULL);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 5 &&
                ll_client_rendered(l->client)->entity[1].x == 6);
    assert_int_equal(ll_client_draw_infos(l->client)[1].time, 11);
    free_lone(l);
    l = new_lone(2, &toy, &ll_sync_gambetta); /* the demo applies the snapshot that arrives last */
    start_lone(l, 60, 0, 0);
    assert_int_equal(give(l, &ten, LL_MS), LL_OUTCOME_APPLIED);
    assert_int_equal(give(l, &nine, 2 * LL_MS), LL_OUTCOME_APPLIED);
    frame(l, 3 * LL_MS, NULL);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 3 &&
                ll_client_rendered(l->client)->entity[1].x == 4);
    free_lone(l);
}

static void packets_of_another_epoch_are_discarded(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_gambetta);
    packet p = state_of(10, 10, 0, 1, (double[]){1});
    ll_message_head refusal = {LL_MESSAGE_REFUSAL, LL_RULE_RATE, 7, 3};
    start_lone(l, 60, 0, 0);
    p.head.head.epoch = 2;
    assert_int_equal(give(l, &p, LL_MS), LL_OUTCOME_STALE);
    assert_int_equal(ll_client_receive(l->client, &l->setup, &refusal, sizeof refusal, LL_MS),
                     LL_OUTCOME_STALE);
    assert_int_equal(l->client->snapshots.received, 0);
    assert_int_equal(l->client->inputs.refused, 0);
    refusal.epoch = 1;
    assert_int_equal(ll_client_receive(l->client, &l->setup, &refusal, sizeof refusal, LL_MS),
                     LL_OUTCOME_REFUSED);
    assert_int_equal(l->client->inputs.refused, 1);
    free_lone(l);
}

/* Of several snapshots received since the last frame the newest is drawn, and its acknowledgement counts. */
static void newest_state_is_drawn(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    start_lone(l, 60, 0, 0);
    for (int f = 0; f < 10; f++)
        numbered_frame(l, f, NULL);
    for (int k = 1; k <= 5; k++) {
        packet p = state_of(k, k, (uint32_t)k, 1, (double[]){k * 0.5});
        assert_int_equal(give(l, &p, LL_SECOND), LL_OUTCOME_APPLIED);
    }
    assert_true(ll_client_rendered(l->client)->entity[0].x == 0);
    numbered_frame(l, 60, NULL);
    assert_true(ll_client_rendered(l->client)->entity[0].x == 2.5);
    assert_int_equal(l->client->inputs.acked, 5);
    free_lone(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lead_matches_the_link),
        cmocka_unit_test(others_do_not_lead),
        cmocka_unit_test(slack_is_followed_without_overshoot),
        cmocka_unit_test(packets_repeat_open_inputs),
        cmocka_unit_test(idle_clients_are_silent_where_the_rules_say_so),
        cmocka_unit_test(a_full_window_gives_up_its_oldest),
        cmocka_unit_test(pipelined_lockstep_repeats_the_oldest),
        cmocka_unit_test(pipelined_lockstep_makes_nothing_in_a_stall),
        cmocka_unit_test(pipelined_lockstep_waits_for_the_first_state_too),
        cmocka_unit_test(pipelined_lockstep_waits_four_intervals_whole),
        cmocka_unit_test(lockstep_makes_one_input_a_state),
        cmocka_unit_test(cheats_send_inputs_as_defined),
        cmocka_unit_test(a_leap_is_one_huge_input_now_and_then),
        cmocka_unit_test(a_lag_switch_holds_back_and_releases),
        cmocka_unit_test(stale_states_are_dropped),
        cmocka_unit_test(packets_of_another_epoch_are_discarded),
        cmocka_unit_test(newest_state_is_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

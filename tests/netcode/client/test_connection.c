/* Connections: the measured clock, a client's states, admission by the server, and the handshake over any
 * link. Packets are made by hand. */
#include "netcode/toy.h"

#include "base/rng.h"
#include "netcode/server/admission.h"

static ll_time draw(uint64_t seed, uint64_t stream, uint64_t k, ll_time least, ll_time most)
{
    return least + (ll_time)(ll_rng_u64(seed, stream, k) % (uint64_t)(most - least + 1));
}

/* ---- a client's states ---- */

typedef struct states {
    uint8_t state[64];
    ll_time at[64];
    int count;
} states;

static void keep(void *context, const void *row)
{
    const ll_event *e = row;
    states *s = context;
    assert_int_equal(e->type, LL_EVENT_CONNECTION);
    assert_true(s->count < 64);
    s->state[s->count] = e->outcome;
    s->at[s->count++] = e->begin;
}

typedef struct joiner {
    lone *l;
    states seen;
    ll_recorder recorder;
} joiner;

/* A client that is not connected yet, at time 0. */
static joiner *new_joiner(double timeout_s)
{
    joiner *j = calloc(1, sizeof *j);
    j->l = new_lone(1, &toy, &ll_sync_free);
    j->l->rules.timeout_s = timeout_s;
    j->recorder = (ll_recorder){.record = keep, .context = &j->seen};
    j->l->setup.recorder = &j->recorder;
    ll_connection_init(&j->l->client->connection, 0);
    return j;
}

static void free_joiner(joiner *j)
{
    free_lone(j->l);
    free(j);
}

static ll_connection *connection(joiner *j)
{
    return &j->l->client->connection;
}

static ll_time due(joiner *j)
{
    return ll_connection_due(j->l->client, &j->l->setup);
}

/* Whether it sends something at `now`. */
static bool tends(joiner *j, ll_time now, ll_request_message *m)
{
    int size = ll_connection_poll(j->l->client, &j->l->setup, now, m);
    assert_true(size == 0 || size == (int)sizeof *m);
    if (size > 0)
        connection(j)->sent = now; /* the sender records this */
    return size > 0;
}

static void answers(joiner *j, ll_message type, uint16_t epoch, const ll_request_message *to,
                    ll_time received, ll_time now)
{
    ll_answer_message m = {
        .head = {.type = (uint8_t)type, .epoch = epoch}, .received = received, .tick = 5, .first = 5};
    if (to) {
        m.head.count = LL_ANSWER_ECHO;
        m.head.seq = to->head.seq;
        m.sent = to->sent;
    }
    assert_true(ll_connection_receive(j->l->client, &j->l->setup, &m, (int)sizeof m, now));
}

/* From `now` on each ping is answered after `way`, and the answer takes as long, until the clock is measured.
 * Returns that time. */
static ll_time measures(joiner *j, uint16_t epoch, ll_time now, ll_time way, int pings)
{
    ll_request_message sent[16];
    ll_time first = due(j);
    int n = 0, back = 0;
    assert_true(first >= now);
    while (!(ll_connection_plays(connection(j)) && connection(j)->state == LL_CONNECTION_PLAYING)) {
        ll_time next = due(j), comes = back < n ? sent[back].sent + 2 * way : LL_NEVER;
        if (next < comes) {
            assert_true(n < 16 && tends(j, next, &sent[n]));
            assert_int_equal(sent[n].head.type, LL_MESSAGE_PING);
            assert_int_equal(sent[n].head.epoch, epoch);
            assert_int_equal(sent[n].sent, first + n * LL_SYNC_EVERY);
            n++;
        } else {
            answers(j, LL_MESSAGE_PONG, epoch, &sent[back], sent[back].sent + way, comes);
            back++;
            now = comes;
        }
    }
    assert_int_equal(back, pings);
    return now;
}

/* Accepts the client at `now`. */
static void is_accepted(joiner *j, uint16_t epoch, ll_time now)
{
    ll_request_message m = {.head = {.seq = connection(j)->attempt}, .sent = now - 40 * LL_MS};
    answers(j, LL_MESSAGE_ACCEPT, epoch, &m, now - 20 * LL_MS, now);
    assert_int_equal(connection(j)->epoch, epoch);
    assert_int_equal(j->l->client->epoch, epoch);
}

/* It sends a connect every half second without limit, and acknowledges no answer before it has one. An answer
 * that it is not connected makes it ask at once, acknowledging that answer. */
static void an_unconnected_client_asks_every_half_second(void **state)
{
    (void)state;
    joiner *j = new_joiner(5);
    ll_request_message m;
    for (int k = 0; k < 100; k++) {
        assert_int_equal(due(j), k * LL_SECOND / 2);
        assert_true(tends(j, due(j), &m));
        assert_int_equal(m.head.type, LL_MESSAGE_CONNECT);
        assert_int_equal(m.head.seq, 1);
        assert_int_equal(m.sent, k * LL_SECOND / 2);
        assert_int_equal(m.seen, LL_NEVER);
        assert_false(tends(j, k * LL_SECOND / 2 + LL_SECOND / 3, &m));
    }
    ll_time now = 49 * LL_SECOND + 700 * LL_MS;
    answers(j, LL_MESSAGE_PONG, 0, &m, now - 30 * LL_MS, now);
    assert_int_equal(connection(j)->state, LL_CONNECTION_CONNECTING);
    assert_int_equal(due(j), now);
    assert_true(tends(j, now, &m));
    assert_int_equal(m.head.type, LL_MESSAGE_CONNECT);
    assert_int_equal(m.seen, now - 30 * LL_MS);
    assert_int_equal(due(j), now + LL_SECOND / 2);
    assert_int_equal(j->seen.count, 0); /* all the same state */
    free_joiner(j);
}

/* After it is accepted it measures its clock by five samples 50 ms apart, the first being the accepting
 * answer, and plays. */
static void an_accepted_client_measures_its_clock(void **state)
{
    (void)state;
    static const int ways_ms[] = {0, 1, 24, 26, 200, 240};
    for (size_t i = 0; i < sizeof ways_ms / sizeof ways_ms[0]; i++) {
        joiner *j = new_joiner(5);
        ll_time way = ways_ms[i] * LL_MS, now = 3 * LL_SECOND;
        is_accepted(j, 9, now);
        assert_int_equal(connection(j)->state, LL_CONNECTION_SYNCHRONISING);
        assert_int_equal(connection(j)->joins, 1);
        assert_false(ll_connection_plays(connection(j)));
        assert_int_equal(measures(j, 9, now, way, 4), now + 3 * LL_SYNC_EVERY + 2 * way);
        assert_int_equal(j->seen.count, 2);
        assert_int_equal(j->seen.state[1], LL_CONNECTION_PLAYING);
        assert_int_equal(connection(j)->clock.count, 5);
        assert_int_equal(connection(j)->clock.offset, 0);
        free_joiner(j);
    }
}

/* While playing it sends a ping every quarter of a second, and when nothing else was sent for a tenth. */
static void a_playing_client_is_never_silent(void **state)
{
    (void)state;
    for (int inputs_ms = 0; inputs_ms <= 300; inputs_ms += 60) {
        joiner *j = new_joiner(5);
        ll_request_message m;
        is_accepted(j, 1, LL_SECOND);
        ll_time start = measures(j, 1, LL_SECOND, 10 * LL_MS, 4), last = start, input = start, longest = 0;
        int pings = 0;
        for (ll_time now = start; now < start + 10 * LL_SECOND; now += LL_MS) {
            bool sends = false;
            if (inputs_ms > 0 && now >= input) {
                connection(j)->sent = input = now;
                input += inputs_ms * LL_MS;
                sends = true;
            }
            if (now >= due(j) && tends(j, now, &m)) {
                answers(j, LL_MESSAGE_PONG, 1, &m, now, now);
                pings++;
                sends = true;
            }
            longest = now - last > longest ? now - last : longest;
            last = sends ? now : last;
        }
        assert_true(longest <= LL_KEEP_ALIVE + LL_MS);
        if (inputs_ms == 60)
            assert_in_range(pings, 39, 41); /* every quarter of a second */
        else if (inputs_ms == 0)
            assert_in_range(pings, 99, 101); /* nothing else is sent */
        else
            assert_true(pings > 41);
        assert_int_equal(connection(j)->state, LL_CONNECTION_PLAYING);
        free_joiner(j);
    }
}

/* Silence is noticed after half a second. One packet of any kind ends it, and the clock is measured again.
 * After `timeout_s` the connection is over; 0 waits without limit. */
static void silence_is_noticed_and_then_the_end(void **state)
{
    (void)state;
    static const double timeouts_s[] = {0, 0.3, 0.5, 1, 5, 30};
    for (size_t i = 0; i < sizeof timeouts_s / sizeof timeouts_s[0]; i++) {
        joiner *j = new_joiner(timeouts_s[i]);
        ll_request_message m;
        ll_time timeout = timeouts_s[i] > 0 ? ll_ms(1000 * timeouts_s[i]) : LL_NEVER;
        is_accepted(j, 1, LL_SECOND);
        ll_time last_packet = measures(j, 1, LL_SECOND, LL_MS, 4), end = last_packet + 40 * LL_SECOND;
        if (timeout > LL_NOTICE) {
            while (connection(j)->state == LL_CONNECTION_PLAYING)
                tends(j, due(j), &m);
            assert_int_equal(connection(j)->state, LL_CONNECTION_STALLED);
            assert_int_equal(connection(j)->since, last_packet + LL_NOTICE);
            assert_true(ll_connection_plays(connection(j)));
            packet state_packet = state_of(1, 0, 0, 1, (double[]){0});
            assert_false(ll_connection_receive(j->l->client, &j->l->setup, &state_packet,
                                               size_of(&state_packet), last_packet + LL_NOTICE + LL_MS));
            assert_int_equal(connection(j)->state, LL_CONNECTION_RESYNCHRONISING);
            assert_true(ll_connection_plays(connection(j)));
            last_packet = measures(j, 1, last_packet + LL_NOTICE + LL_MS, LL_MS, 5);
        }
        while (ll_connection_plays(connection(j)) && due(j) < end)
            tends(j, due(j), &m);
        if (timeout == LL_NEVER) {
            assert_int_equal(connection(j)->state, LL_CONNECTION_STALLED);
        } else {
            assert_int_equal(connection(j)->state, LL_CONNECTION_DISCONNECTED);
            assert_int_equal(connection(j)->since, last_packet + timeout);
            assert_int_equal(connection(j)->time_outs, 1);
            assert_true(m.head.type == LL_MESSAGE_CONNECT); /* it asks in the same moment */
            assert_int_equal(m.head.seq, 2);
            for (int k = 1; k < 20; k++) {
                assert_int_equal(due(j), last_packet + timeout + k * LL_SECOND / 2);
                assert_true(tends(j, due(j), &m));
            }
        }
        free_joiner(j);
    }
}

/* A client that was never connected keeps asking, and has not been disconnected. */
static void silence_before_the_clock_is_known(void **state)
{
    (void)state;
    joiner *j = new_joiner(2);
    ll_request_message m;
    is_accepted(j, 1, LL_SECOND);
    while (connection(j)->state == LL_CONNECTION_SYNCHRONISING)
        assert_true(tends(j, due(j), &m));
    assert_int_equal(connection(j)->state, LL_CONNECTION_CONNECTING);
    assert_int_equal(connection(j)->since, 3 * LL_SECOND);
    free_joiner(j);
}

/* It joins again in a new epoch: answers to earlier attempts, and all packets sent in the old epoch, are
 * discarded. */
static void a_client_joins_again_in_a_new_epoch(void **state)
{
    (void)state;
    joiner *j = new_joiner(1);
    ll_request_message m, before;
    ll_input_message input;
    start_lone(j->l, 60, 0, 0);
    j->l->client->connection.state = LL_CONNECTION_CONNECTING;
    assert_true(tends(j, 0, &before));
    is_accepted(j, 3, LL_SECOND);
    ll_time now = measures(j, 3, LL_SECOND, LL_MS, 4);
    assert_true(frame(j->l, now, &input) > 0);
    assert_int_equal(input.head.epoch, 3);
    answers(j, LL_MESSAGE_ACCEPT, 4, &before, now,
            now); /* a copy of the accepting answer, or another: it is connected */
    assert_int_equal(connection(j)->epoch, 3);
    while (connection(j)->state != LL_CONNECTION_DISCONNECTED)
        tends(j, due(j), &m);
    now = connection(j)->since;
    assert_false(ll_connection_plays(connection(j)));
    assert_int_equal(j->l->client->inputs.seq, j->l->client->inputs.acked); /* no input is open any more */
    assert_int_equal(frame(j->l, now, &input), 0);                          /* and no input is made */
    answers(j, LL_MESSAGE_ACCEPT, 4, &before, now, now);                    /* of the attempt before */
    assert_int_equal(connection(j)->state, LL_CONNECTION_DISCONNECTED);
    answers(j, LL_MESSAGE_ACCEPT, 7, &m, now, now + LL_MS);
    assert_int_equal(connection(j)->state, LL_CONNECTION_RESYNCHRONISING);
    assert_int_equal(connection(j)->joins, 2);
    packet old = state_of(50, now, 1, 1, (double[]){99}), fresh = old;
    old.head.head.epoch = 3;
    fresh.head.head.epoch = 7;
    assert_int_equal(give(j->l, &old, now + LL_MS), LL_OUTCOME_STALE);
    assert_int_equal(give(j->l, &fresh, now + LL_MS), LL_OUTCOME_APPLIED);
    assert_true(frame(j->l, now + 2 * LL_MS, &input) > 0); /* it plays while resynchronising */
    assert_int_equal(input.head.epoch, 7);
    assert_int_equal(input.head.seq, 1);
    static const uint8_t all[] = {LL_CONNECTION_SYNCHRONISING, LL_CONNECTION_PLAYING, LL_CONNECTION_STALLED,
                                  LL_CONNECTION_DISCONNECTED, LL_CONNECTION_RESYNCHRONISING};
    assert_int_equal(j->seen.count, 5);
    assert_memory_equal(j->seen.state, all, 5);
    ll_time spent = 0;
    for (int i = 0; i < LL_CONNECTION_STATES; i++)
        spent += connection(j)->in_state[i];
    assert_int_equal(spent, connection(j)->since); /* every moment was in one state */
    free_joiner(j);
}

/* The server reports that it has dropped the player: the client asks at once. An answer from before the
 * client was accepted has no effect. */
static void a_dropped_client_asks_again(void **state)
{
    (void)state;
    joiner *j = new_joiner(5);
    ll_request_message m;
    is_accepted(j, 1, LL_SECOND);
    ll_time now = measures(j, 1, LL_SECOND, LL_MS, 4);
    answers(j, LL_MESSAGE_PONG, 0, NULL, LL_SECOND - 300 * LL_MS,
            now); /* overtaken by the accepting answer */
    assert_int_equal(connection(j)->state, LL_CONNECTION_PLAYING);
    answers(j, LL_MESSAGE_PONG, 0, NULL, now, now + LL_MS);
    assert_int_equal(connection(j)->state, LL_CONNECTION_DISCONNECTED);
    assert_int_equal(due(j), now + LL_MS);
    assert_true(tends(j, now + LL_MS, &m));
    assert_int_equal(m.head.type, LL_MESSAGE_CONNECT);
    assert_int_equal(m.head.seq, 2);
    assert_int_equal(m.seen, now);
    free_joiner(j);
}

/* ---- admission ---- */

static ll_server *new_admission_server(void)
{
    ll_server *server = new_server(2, &ll_sync_free, 60, 60);
    server->client_slots[0].connection.connected = server->client_slots[1].connection.connected = 0;
    return server;
}

typedef union reply {
    ll_answer_message m;
    char bytes[4096];
} reply;

static ll_admitted asks(ll_server *server, ll_message type, uint32_t attempt, ll_time seen, ll_time now,
                        reply *r)
{
    ll_request_message m = {
        .head = {.type = (uint8_t)type, .seq = attempt}, .sent = now - LL_MS, .seen = seen};
    ll_admitted done = ll_admission_receive(server, false, 0, &m, now, r);
    if (done.reply > 0) {
        server->client_slots[0].connection.last_sent = now; /* the sender records this */
        assert_int_equal(done.reply, sizeof r->m);
        assert_int_equal(r->m.received, now);
        assert_int_equal(r->m.tick, server->step);
        assert_int_equal(r->m.sent, now - LL_MS);
        assert_int_equal(r->m.head.seq, attempt);
    }
    return done;
}

/* A client is accepted only if it acknowledges an answer at most 3 s old; every request gets an answer to
 * acknowledge. */
static void only_clients_that_receive_are_accepted(void **state)
{
    (void)state;
    static const ll_time ages[] = {0, LL_SECOND, 3 * LL_SECOND, 3 * LL_SECOND + 1, 60 * LL_SECOND, LL_NEVER};
    for (size_t i = 0; i < sizeof ages / sizeof ages[0]; i++) {
        ll_server *server = new_admission_server();
        ll_time now = 100 * LL_SECOND, seen = ages[i] == LL_NEVER ? LL_NEVER : now - ages[i];
        reply r;
        ll_admitted done = asks(server, LL_MESSAGE_CONNECT, 1, seen, now, &r);
        bool in = ages[i] <= 3 * LL_SECOND;
        assert_int_equal(done.joined, in);
        assert_int_equal(server->client_slots[0].connection.connected, in);
        assert_int_equal(server->client_slots[1].connection.connected, 0);
        assert_int_equal(r.m.head.type, in ? LL_MESSAGE_ACCEPT : LL_MESSAGE_PONG);
        assert_int_equal(r.m.head.epoch, in ? server->epoch : 0);
        assert_int_equal(server->client_slots[0].connection.joins, in);
        assert_true(done.reply > 0 && !done.game);
        done = asks(server, LL_MESSAGE_PING, 1, LL_NEVER, now,
                    &r); /* a ping is answered, and accepts no client */
        assert_true(done.reply > 0 && !done.joined && !done.game);
        assert_int_equal(r.m.head.epoch, in ? server->epoch : 0);
        free(server);
    }
}

/* The same attempt again, after a lost answer, is the same join. A later attempt is another join, in a new
 * epoch, which starts with nothing; one that arrives after a later one is discarded. */
static void each_attempt_joins_once(void **state)
{
    (void)state;
    ll_server *server = new_admission_server();
    reply r;
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message m = inputs(41, 3, (double[]){1, 1, 1});
    server->step = 40;
    uint16_t before = server->epoch;
    assert_true(asks(server, LL_MESSAGE_CONNECT, 4, LL_SECOND, LL_SECOND, &r).joined);
    assert_int_equal(r.m.head.epoch, before + 1);
    assert_int_equal(r.m.first, 40);
    for (int k = 0; k < 3; k++) {
        assert_false(asks(server, LL_MESSAGE_CONNECT, 4, LL_SECOND, LL_SECOND + k * LL_MS, &r).joined);
        assert_int_equal(r.m.head.type, LL_MESSAGE_ACCEPT);
        assert_int_equal(r.m.head.epoch, before + 1);
    }
    m.head.epoch = (uint16_t)(before + 1);
    assert_true(ll_admission_receive(server, false, 0, &m, LL_SECOND, &r).game);
    assert_int_equal(ll_server_receive(server, &ll_sync_free, 0, &m, LL_SECOND, v), 3);
    server->step = 41;
    assert_true(asks(server, LL_MESSAGE_CONNECT, 5, 2 * LL_SECOND, 2 * LL_SECOND, &r).joined);
    assert_int_equal(r.m.head.epoch, before + 2);
    assert_int_equal(server->client_slots[0].inputs.newest, -1);
    assert_int_equal(server->client_slots[0].inputs.acked, 0);
    assert_false(ll_admission_receive(server, false, 0, &m, 2 * LL_SECOND, &r).game); /* of the old epoch */
    assert_false(asks(server, LL_MESSAGE_CONNECT, 4, 2 * LL_SECOND, 2 * LL_SECOND + LL_MS, &r).joined);
    assert_int_equal(server->client_slots[0].connection.epoch, before + 2);
    assert_int_equal(server->client_slots[0].connection.joins, 2);
    assert_int_equal(server->client_slots[1].connection.joins, 0);
    free(server);
}

/* Where clients have worlds of their own the answer contains the server's, and the player's inputs begin
 * after those that the server made for it. */
static void an_accepted_client_gets_the_world(void **state)
{
    (void)state;
    ll_server *server = new_admission_server();
    reply r;
    size_t size = ll_world_size(ll_server_world(server));
    ll_request_message m = {.head = {.type = LL_MESSAGE_CONNECT, .seq = 1}, .seen = 0};
    server->step = 40;
    server->client_slots[0].inputs.newest = 47;
    ll_server_world(server)->entity[1].x = 0.1;
    assert_int_equal(ll_admission_receive(server, true, 0, &m, LL_MS, &r).reply, sizeof r.m + size);
    assert_int_equal(r.m.head.count, LL_ANSWER_ECHO | LL_ANSWER_WORLD);
    assert_int_equal(r.m.tick, 40);
    assert_int_equal(r.m.first, 47);
    assert_memory_equal(r.bytes + sizeof r.m, ll_server_world(server), size);
    free(server);
}

/* A client whose inputs arrive but that does not receive the server's packets is dropped exactly when it has
 * acknowledged no newer answer for the timeout, at any age of its answers. A client that receives them stays,
 * and without a timeout all stay. */
static void a_client_that_does_not_receive_is_dropped(void **state)
{
    (void)state;
    static const double timeouts_s[] = {0.5, 2, 30};
    for (size_t i = 0; i < sizeof timeouts_s / sizeof timeouts_s[0]; i++) {
        ll_server *server = new_admission_server();
        ll_time timeout = ll_ms(1000 * timeouts_s[i]), start = 10 * LL_SECOND, now = start,
                last_packet = start;
        reply r;
        assert_true(asks(server, LL_MESSAGE_CONNECT, 1, now, now, &r).joined);
        for (now += LL_SECOND / 4; now < start + 20 * LL_SECOND; now += LL_SECOND / 4) { /* two seconds old */
            asks(server, LL_MESSAGE_PING, 0, last_packet += LL_SECOND / 4, now + 2 * LL_SECOND, &r);
            assert_false(ll_admission_check(server, 0, timeout, now + 2 * LL_SECOND + LL_SECOND / 5));
        }
        now += 2 * LL_SECOND - LL_SECOND / 4;
        ll_time last = now;
        for (; server->client_slots[0].connection.connected;
             now += LL_SECOND / 4) { /* its link down is dead */
            asks(server, LL_MESSAGE_PING, 0, last_packet, now, &r);
            assert_int_equal(r.m.head.epoch, server->epoch);
            assert_false(ll_admission_check(server, 0, LL_NEVER, now));
            assert_int_equal(ll_admission_check(server, 0, timeout, now), now - last > timeout);
        }
        assert_int_equal(server->client_slots[0].connection.drops, 1);
        asks(server, LL_MESSAGE_PING, 0, last_packet, now, &r);
        assert_int_equal(r.m.head.epoch, 0);                                   /* it is informed */
        assert_false(ll_admission_check(server, 0, timeout, now + LL_SECOND)); /* once */
        free(server);
    }
}

/* A connected client to which nothing was sent for a tenth of a second gets a keep-alive. A client that is
 * not connected but sends inputs gets a refusal, at most ten times a second. */
static void silence_is_filled(void **state)
{
    (void)state;
    ll_server *server = new_admission_server();
    ll_input_message m = inputs(1, 1, (double[]){1});
    reply r;
    int refused_out = 0;
    m.head.epoch = 77;
    for (ll_time now = LL_SECOND; now < 3 * LL_SECOND; now += 10 * LL_MS) {
        assert_int_equal(ll_admission_keep_alive(server, 0, now, &r), 0);
        ll_admitted done = ll_admission_receive(server, false, 0, &m, now, &r);
        assert_false(done.game || done.joined);
        if (done.reply == 0)
            continue;
        refused_out++;
        server->client_slots[0].connection.last_sent = now;
        assert_int_equal(r.m.head.type, LL_MESSAGE_PONG);
        assert_int_equal(r.m.head.epoch, 0);
        assert_int_equal(r.m.head.count & LL_ANSWER_ECHO, 0); /* it asked for no time */
    }
    assert_int_equal(refused_out, 20);
    asks(server, LL_MESSAGE_CONNECT, 1, 3 * LL_SECOND, 3 * LL_SECOND, &r);
    ll_time sent = 3 * LL_SECOND;
    for (ll_time now = sent; now < 5 * LL_SECOND; now += 10 * LL_MS) {
        int size = ll_admission_keep_alive(server, 0, now, &r);
        assert_int_equal(size > 0, now - sent >= LL_SECOND / 10);
        if (size == 0)
            continue;
        assert_int_equal(r.m.head.type, LL_MESSAGE_PONG);
        assert_int_equal(r.m.head.epoch, server->client_slots[0].connection.epoch);
        assert_int_equal(r.m.head.count, 0);
        server->client_slots[0].connection.last_sent = sent = now;
    }
    free(server);
}

/* ---- the handshake over any link ---- */

#define FLIGHTS 1024

typedef struct flight {
    ll_time due;
    bool up;
    int size;
    reply bytes;
} flight;

typedef struct world_of_two {
    joiner *j;
    ll_server *server;
    uint64_t seed, drawn;
    double loss, copies;
    ll_time longest, timeout;
    flight flights[FLIGHTS];
} world_of_two;

static double chance(world_of_two *w)
{
    return ll_rng_unit(w->seed, 9, w->drawn++);
}

/* Lost, doubled and delayed by the present link, so that packets arrive in any order. */
static void sends(world_of_two *w, bool up, const void *bytes, int size, ll_time now)
{
    if (up)
        w->j->l->client->connection.sent = now;
    else
        w->server->client_slots[0].connection.last_sent = now;
    for (int copies = chance(w) < w->copies ? 2 : 1; copies > 0; copies--) {
        flight *f = w->flights;
        if (chance(w) < w->loss)
            continue;
        while (f->due != LL_NEVER)
            assert_true(++f < w->flights + FLIGHTS);
        *f = (flight){.due = now + (ll_time)(chance(w) * (double)w->longest), .up = up, .size = size};
        memcpy(f->bytes.bytes, bytes, (size_t)size);
    }
}

static void arrives(world_of_two *w, flight *f)
{
    flight came = *f;
    reply r;
    f->due = LL_NEVER;
    if (came.up) {
        int size = ll_admission_receive(w->server, false, 0, &came.bytes, came.due, &r).reply;
        if (size > 0)
            sends(w, false, &r, size, came.due);
    } else {
        ll_connection_receive(w->j->l->client, &w->j->l->setup, &came.bytes, came.size, came.due);
    }
}

static void runs(world_of_two *w, ll_time *next_check, ll_time until)
{
    for (;;) {
        flight *next = w->flights;
        ll_request_message m;
        reply r;
        for (int i = 1; i < FLIGHTS; i++)
            next = w->flights[i].due < next->due ? &w->flights[i] : next;
        ll_time client = due(w->j), first = client < *next_check ? client : *next_check;
        first = next->due < first ? next->due : first;
        if (first > until)
            return;
        if (next->due == first) {
            arrives(w, next);
        } else if (*next_check == first) {
            *next_check += LL_CONNECTION_CHECK_INTERVAL;
            int size = ll_admission_keep_alive(w->server, 0, first, &r);
            if (size > 0)
                sends(w, false, &r, size, first);
            ll_admission_check(w->server, 0, w->timeout, first);
        } else {
            int size = ll_connection_poll(w->j->l->client, &w->j->l->setup, first, &m);
            if (size > 0)
                sends(w, true, &m, size, first);
        }
    }
}

/* After packets were lost, doubled, held for up to 1.2 s and overtaken, with any timeout: once the link is
 * good, both sides have the same connection within a retry, the packets still on their way, and a few round
 * trips, and keep it. */
static void the_handshake_always_ends(void **state)
{
    (void)state;
    static const double timeouts_s[] = {0, 0.6, 1, 5};
    world_of_two *w = malloc(sizeof *w);
    int joins = 0;
    for (uint64_t seed = 0; seed < 600; seed++) {
        double timeout_s = timeouts_s[seed % 4];
        ll_time next_check = 0, well = draw(seed, 1, 0, 0, 15 * LL_SECOND);
        *w = (world_of_two){.j = new_joiner(timeout_s), .server = new_admission_server(), .seed = seed};
        w->j->l->setup.recorder = NULL;
        w->timeout = timeout_s > 0 ? ll_ms(1000 * timeout_s) : LL_NEVER;
        w->loss = 0.8 * ll_rng_unit(seed, 2, 0);
        w->copies = ll_rng_unit(seed, 2, 1);
        w->longest = draw(seed, 2, 2, 0, 1200 * LL_MS);
        for (int i = 0; i < FLIGHTS; i++)
            w->flights[i].due = LL_NEVER;
        runs(w, &next_check, well);
        w->loss = w->copies = 0;
        w->longest = 40 * LL_MS;
        for (ll_time after = 3 * LL_SECOND; after <= 13 * LL_SECOND; after += LL_SECOND) {
            const ll_connection *c = connection(w->j);
            runs(w, &next_check, well + after);
            if (c->state != LL_CONNECTION_PLAYING || !w->server->client_slots[0].connection.connected ||
                c->epoch != w->server->client_slots[0].connection.epoch)
                fail_msg("seed %d, %g s after: %s in epoch %d, the server has %d in %d", (int)seed,
                         ll_to_s(after), ll_connection_state_names[c->state], c->epoch,
                         w->server->client_slots[0].connection.connected,
                         w->server->client_slots[0].connection.epoch);
        }
        joins += (int)connection(w->j)->joins;
        free(w->server);
        free_joiner(w->j);
    }
    assert_true(joins > 650); /* of 600 players: they came and went */
    free(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unconnected_client_asks_every_half_second),
        cmocka_unit_test(an_accepted_client_measures_its_clock),
        cmocka_unit_test(a_playing_client_is_never_silent),
        cmocka_unit_test(silence_is_noticed_and_then_the_end),
        cmocka_unit_test(silence_before_the_clock_is_known),
        cmocka_unit_test(a_client_joins_again_in_a_new_epoch),
        cmocka_unit_test(a_dropped_client_asks_again),
        cmocka_unit_test(only_clients_that_receive_are_accepted),
        cmocka_unit_test(each_attempt_joins_once),
        cmocka_unit_test(an_accepted_client_gets_the_world),
        cmocka_unit_test(a_client_that_does_not_receive_is_dropped),
        cmocka_unit_test(silence_is_filled),
        cmocka_unit_test(the_handshake_always_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Snapshots of some of the entities: priority accumulators, states by entity over bad links, and the area of
 * interest. */
#include "netcode/toy.h"

#include "base/rng.h"
#include "netcode/snapshot/priority.h"
#include "netcode/snapshot/select.h"
#include "support/link.h"
#include "support/near.h"

/* ---- priority accumulators alone ---- */

enum { MOST = 64 };

/* `updates` of `places` each: how often each entity is sent, and its longest wait. */
static void share_out(const double *priority, int count, int places, int updates, int *times, int *gap)
{
    double accumulated[MOST] = {0};
    int sent[MOST] = {0}, first = 0;
    memset(times, 0, (size_t)count * sizeof *times);
    memset(gap, 0, (size_t)count * sizeof *gap);
    for (int k = 1; k <= updates; k++) {
        ll_candidate heap[MOST];
        int left = count;
        for (int i = 0; i < count; i++)
            heap[i] = (ll_candidate){accumulated[i] += priority[i], i, ll_candidate_turn(i, first, count)};
        ll_candidates_order(heap, left);
        for (int n = 0; n < places; n++) {
            int i = ll_candidates_take(heap, &left).entity;
            gap[i] = k - sent[i] > gap[i] ? k - sent[i] : gap[i];
            accumulated[i] = 0;
            sent[i] = k;
            first = i + 1;
            times[i]++;
        }
    }
}

static int fill(double *priority, int at, int count, double value)
{
    for (int i = 0; i < count; i++)
        priority[at + i] = value;
    return at + count;
}

/* The rate of a priority is p K / sum p, and at most 1; it waits at most ceil(sum p / (K p)) + 3 updates. */
static void rates_are_the_shares_of_the_priorities(void **state)
{
    (void)state;
    enum { UPDATES = 8000 };
    double p[MOST];
    int times[MOST], gap[MOST], count = fill(p, fill(p, fill(p, 0, 2, 8), 4, 4), 32, 1);
    share_out(p, count, 8, UPDATES, times, gap);
    for (int i = 0; i < count; i++) {
        assert_float_equal((double)times[i] / UPDATES, p[i] / 8, 0.002);
        assert_true(gap[i] <= (int)ceil(8 / p[i]) + 3);
    }
}

/* Of random priorities and places no accumulator grows beyond twice sum p / K. */
static void no_wait_is_longer_than_its_bound(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 300; round++) {
        double p[MOST], sum = 0;
        int times[MOST], gap[MOST], count = 2 + (int)(ll_rng_u64(1, round, 0) % (MOST - 2));
        int places = 1 + (int)(ll_rng_u64(1, round, 1) % (uint64_t)(count > 8 ? 8 : count));
        for (int i = 0; i < count; i++)
            sum += p[i] = (double)(1 + ll_rng_u64(2, round, (uint64_t)i) % 8);
        share_out(p, count, places, 2000, times, gap);
        for (int i = 0; i < count; i++)
            if (times[i] == 0 || !(gap[i] <= ceil(2 * sum / (places * p[i])) + 1))
                fail_msg("%d entities, %d places: one of %g in %g waits %d", count, places, p[i], sum,
                         gap[i]);
    }
}

/* Equal priorities take turns: none is left behind by its index. */
static void equals_take_turns(void **state)
{
    (void)state;
    double p[MOST];
    int times[MOST], gap[MOST], count = fill(p, 0, 30, 1);
    share_out(p, count, 7, 30 * 100, times, gap);
    for (int i = 0; i < count; i++) {
        assert_int_equal(times[i], 700);
        assert_true(gap[i] <= 5);
    }
}

/* ---- a server, clients and links ---- */

enum { CLIENTS = 3, STEPS = 1800 };

typedef struct net {
    ll_extent extent;
    ll_server *server;
    ll_client *client[CLIENTS];
    ll_recent *recent[CLIENTS]; /* NULL: not noted */
    ll_client_metrics *client_metrics;
    ll_player_config config;
    ll_server_config rules;
    ll_game_env env;
    ll_link *up[CLIENTS], *down[CLIENTS];
    ll_link_params link;
    ll_world **sent; /* by step */
    int64_t *known;  /* of each client's entity: the step of the state that it had last */
    int64_t applied, unreadable, bytes, snapshots;
} net;

static ll_link *new_link(uint64_t stream)
{
    ll_link *link = malloc(ll_link_size(512, 512 * 8192));
    ll_link_init(link, 512, 512 * 8192, 11, stream);
    return link;
}

static ll_client_setup setup_of(net *n, int client)
{
    return (ll_client_setup){.recent = n->recent[client],
                             .game = &toy,
                             .env = &n->env,
                             .sync = &ll_sync_free,
                             .config = &n->config,
                             .rules = &n->rules,
                             .client_metrics = n->client_metrics,
                             .selects = true};
}

/* Positions uniform in a square of `side`, at most 4 m/s; a quarter rests. */
static void place(ll_world *world, double side)
{
    for (int i = 0; i < world->entities; i++) {
        world->entity[i].x = side * ll_rng_unit(5, (uint64_t)i, 0);
        world->entity[i].y = side * ll_rng_unit(5, (uint64_t)i, 1);
    }
}

static void drift(ll_world *world, int64_t step)
{
    for (int i = 0; i < world->entities; i++) {
        ll_entity *e = &world->entity[i];
        bool moves = i % 4 != 3;
        e->vx = moves ? 8 * ll_rng_unit(3, (uint64_t)i, (uint64_t)(step / 90)) - 4 : 0;
        e->vy = moves ? 2 : 0;
        if (step / 90 % 2)
            e->vy = -e->vy;
        e->x += e->vx / 60;
        e->y += e->vy / 60;
    }
}

static net *new_net(int entities, double side, const ll_server_config *rules, const ll_link_params *link)
{
    net *n = calloc(1, sizeof *n);
    n->extent = (ll_extent){entities, 16};
    n->rules = *rules;
    n->link = *link;
    size_t size = ll_server_size(CLIENTS, n->extent);
    n->server = malloc(size + ll_replicas_size(CLIENTS, entities));
    ll_server_init(n->server, CLIENTS, n->extent);
    ll_server_replicate(n->server);
    ll_server_configure(n->server, rules);
    place(ll_server_world(n->server), side);
    ll_server_start(n->server, HZ(60), HZ(30), HZ(60), 0);
    n->client_metrics = malloc(ll_client_metrics_size(entities));
    ll_client_metrics_init(n->client_metrics, entities, 0);
    ll_param_defaults(&ll_player_table, &n->config);
    n->config.control = LL_CONTROL_PERSON;
    for (int i = 0; i < CLIENTS; i++) {
        ll_client_setup setup = setup_of(n, i);
        n->client[i] = malloc(ll_client_size(n->extent));
        ll_client_init(n->client[i], i, ll_server_world(n->server));
        n->server->client_slots[i].connection.connected = 1;
        n->client[i]->connection.state = LL_CONNECTION_PLAYING;
        ll_client_start(n->client[i], &setup,
                        &(ll_client_begin){.epoch = 1, .freq = HZ(60), .world = ll_server_world(n->server)},
                        0);
        n->up[i] = new_link((uint64_t)(2 * i));
        n->down[i] = new_link((uint64_t)(2 * i + 1));
    }
    n->sent = calloc(STEPS + 1, sizeof(ll_world *));
    n->known = calloc((size_t)(CLIENTS * entities), sizeof *n->known);
    return n;
}

static void free_net(net *n)
{
    for (int i = 0; i < CLIENTS; i++) {
        free(n->client[i]);
        free(n->recent[i]);
        free(n->up[i]);
        free(n->down[i]);
    }
    for (int k = 0; k <= STEPS; k++)
        free(n->sent[k]);
    free(n->sent);
    free(n->known);
    free(n->client_metrics);
    free(n->server);
    free(n);
}

static bool is_state(const net *n, const ll_entity *got, int64_t step, int entity)
{
    const ll_world *then = n->sent[step];
    if (!then)
        return false;
    ll_cell cell = ll_cell_of(&then->entity[entity], &n->server->grid);
    ll_entity e = ll_cell_entity(&cell, &n->server->grid);
    return memcmp(&e, got, sizeof e) == 0;
}

/* Each entity that the client has is, to the bit, what the server had in some step on the grid, no earlier
 * one than before; its own is that of the snapshot. */
static void check(net *n, int client)
{
    ll_snapshot_entry *r = ll_client_state(n->client[client], n->client[client]->snapshots.received - 1);
    const ll_world *got = ll_snapshot_entry_world(r);
    n->applied++;
    assert_memory_equal(&got->entity[client], &n->sent[r->tick]->entity[client], sizeof(ll_entity));
    for (int i = 0; i < got->entities; i++) {
        int64_t *known = &n->known[client * got->entities + i], step = r->tick;
        if (i == client || got->entity[i].flags & LL_ENTITY_UNKNOWN)
            continue;
        while (step > *known && !is_state(n, &got->entity[i], step, i))
            step--;
        if (step < r->tick && step == *known && *known > 0 && !is_state(n, &got->entity[i], step, i))
            fail_msg("client %d has of entity %d in step %lld what the server never had, or had earlier",
                     client, i, (long long)r->tick);
        if (*known == 0 || !is_state(n, &got->entity[i], *known, i))
            *known = step;
    }
}

typedef void after_fn(net *n, int client, const ll_snapshot_entry *snapshot);

static void deliver(net *n, int i, ll_time now, after_fn *after)
{
    static _Alignas(8) char bytes[65536];
    ll_client_setup setup = setup_of(n, i);
    ll_input_result results[LL_INPUTS_MAX];
    ll_time sent_at, due;
    int size;
    while (ll_link_receive(n->up[i], now, bytes, (int)sizeof bytes, &sent_at, &due) >= 0)
        ll_server_receive(n->server, &ll_sync_free, i, bytes, now, results);
    while ((size = ll_link_receive(n->down[i], now, bytes, (int)sizeof bytes, &sent_at, &due)) >= 0) {
        int outcome = ll_client_receive(n->client[i], &setup, bytes, size, now);
        n->unreadable += outcome == LL_OUTCOME_UNDECODABLE;
        if (outcome != LL_OUTCOME_APPLIED)
            continue;
        check(n, i);
        if (after)
            after(n, i, ll_client_state(n->client[i], n->client[i]->snapshots.received - 1));
    }
}

static void update(net *n, ll_time now, int64_t counts_from)
{
    static _Alignas(8) char bytes[65536];
    ll_world **sent = &n->sent[n->server->step];
    if (!*sent)
        *sent = malloc(ll_extent_size(n->extent));
    memcpy(*sent, ll_server_world(n->server), ll_extent_size(n->extent));
    for (int i = 0; i < CLIENTS; i++) {
        int size = ll_server_compose(n->server, &ll_sync_free, i, NULL, bytes);
        if (n->server->step >= counts_from) {
            n->bytes += size;
            n->snapshots++;
        }
        link_send(n->down[i], &n->link, 40, now, bytes, size);
    }
}

/* Every 150 steps a step is sent twice. */
static void run(net *n, int64_t steps, after_fn *after)
{
    for (int64_t k = n->server->step + 1, end = n->server->step + steps; k <= end; k++) {
        static _Alignas(8) char m[sizeof(ll_input_message) + 8];
        ll_time now = ll_tick_time(k, HZ(60));
        drift(ll_server_world(n->server), k);
        n->server->step = k;
        n->server->stepped = now;
        if (k % 2 == 0)
            update(n, now, 300);
        if (k % 150 == 0)
            update(n, now, 300);
        for (int i = 0; i < CLIENTS; i++) {
            ll_client_setup setup = setup_of(n, i);
            deliver(n, i, now, after);
            int size = ll_client_tick(n->client[i], &setup, now, m);
            ll_client_display(n->client[i], &setup, now);
            if (size > 0)
                link_send(n->up[i], &n->link, 40, now, m, size);
        }
    }
}

static ll_server_config rules_of(const ll_codec *codec, int64_t bytes, double radius_m, double margin_m)
{
    ll_server_config rules;
    ll_param_defaults(&ll_server_table, &rules);
    rules.snapshot = ll_codec_index(codec);
    rules.selection = (ll_selection){bytes, radius_m, margin_m};
    return rules;
}

/* Under random loss, jitter and duplicates, in both directions, what a client decodes is a state that the
 * server had; and it decodes every snapshot. */
static void decoded_states_are_those_of_the_server(void **state)
{
    (void)state;
    const ll_codec *const codecs[] = {&ll_codec_partial, &ll_codec_partial_delta, &ll_codec_interest};
    for (uint64_t round = 0; round < 18; round++) {
        const ll_link_params link = {.loss_pct = 60 * ll_rng_unit(7, round, 0),
                                     .jitter_ms = 80 * ll_rng_unit(7, round, 1),
                                     .duplicate_pct = 20 * ll_rng_unit(7, round, 2)};
        const ll_server_config rules =
            rules_of(codecs[round % 3], round % 2 ? 200 : 0, 30, round % 4 ? 5 : 0);
        net *n = new_net(80, 100, &rules, &link);
        run(n, 900, NULL);
        assert_int_equal(n->unreadable, 0);
        assert_true(n->applied > 200);
        free_net(n);
    }
}

/* What a client notes of its newest snapshots saves work, and changes no byte of it: in every display and
 * on links of any quality, also where its choices change on the way. */
static void noting_what_is_recent_changes_nothing(void **state)
{
    (void)state;
    const ll_codec *const codecs[] = {&ll_codec_partial, &ll_codec_partial_delta, &ll_codec_interest};
    for (uint64_t round = 0; round < 12; round++) {
        const ll_link_params link = {.loss_pct = 40 * ll_rng_unit(8, round, 0),
                                     .jitter_ms = 60 * ll_rng_unit(8, round, 1)};
        const ll_server_config rules = rules_of(codecs[round % 3], round % 2 ? 200 : 0, 30, 5);
        net *both[2];
        for (int noted = 0; noted < 2; noted++) {
            net *n = both[noted] = new_net(80, 100, &rules, &link);
            for (int i = 0; i < CLIENTS && noted; i++) {
                n->recent[i] = malloc(sizeof *n->recent[i]);
                ll_recent_init(n->recent[i], 80, i);
            }
            n->config.prediction = n->config.reconciliation = round % 4 != 0;
            n->config.extrapolation_ms = round % 5 == 4 ? 100 : 0;
            n->config.correction = LL_CORRECTION_SMOOTH;
            n->config.interpolation = 1;
            run(n, 200 + 31 * (int64_t)round, NULL);
            n->config.interpolation_method = round % 3 == 1; /* hermite */
            n->config.interpolation = round % 6 != 5;
            run(n, 100, NULL);
            n->config.interpolation_method = 0;
            n->config.interpolation = 1;
            run(n, 100, NULL);
        }
        for (int i = 0; i < CLIENTS; i++) {
            assert_true(both[0]->client[i]->snapshots.received > 60);
            assert_memory_equal(both[0]->client[i], both[1]->client[i], ll_client_size(both[0]->extent));
            for (int e = 0; e < 80; e++)
                assert_int_equal(
                    both[1]->recent[i]->known[e >> 6] >> (e & 63) & 1,
                    !(ll_client_rendered(both[1]->client[i])->entity[e].flags & LL_ENTITY_UNKNOWN));
        }
        free_net(both[0]);
        free_net(both[1]);
    }
}

/* Without a limit and without loss, a client has after each snapshot exactly the entities of its area: all
 * inside in their state of that step, so none is absent for longer than the delay and an interval; none
 * beyond the radius and the margin. */
static void area_is_complete(net *n, int client, const ll_snapshot_entry *snapshot)
{
    const ll_world *got = (const ll_world *)(snapshot + 1), *then = n->sent[snapshot->tick];
    for (int i = 0; i < got->entities; i++) {
        double dx = then->entity[i].x - then->entity[client].x,
               dy = then->entity[i].y - then->entity[client].y;
        double distance = sqrt(dx * dx + dy * dy);
        bool unknown = got->entity[i].flags & LL_ENTITY_UNKNOWN;
        if (i == client || snapshot->tick % 150 == 0)
            continue; /* sent twice, and then empty */
        if (!(distance > 30) && (unknown || !is_state(n, &got->entity[i], snapshot->tick, i)))
            fail_msg("client %d lacks entity %d, %g m away", client, i, distance);
        if (!(distance <= 35.001) && !unknown)
            fail_msg("client %d has entity %d, %g m away", client, i, distance);
    }
}

static void the_area_of_interest_is_complete(void **state)
{
    (void)state;
    const ll_server_config rules = rules_of(&ll_codec_interest, 0, 30, 5);
    const ll_link_params link = {0};
    net *n = new_net(200, 150, &rules, &link);
    run(n, 1200, area_is_complete);
    assert_true(n->applied > 3 * 590);
    free_net(n);
}

/* A snapshot has no bytes of what is outside: other states there give the same bytes. */
static void what_is_outside_leaves_no_trace(void **state)
{
    (void)state;
    static _Alignas(8) char bytes[2][65536];
    const ll_server_config rules = rules_of(&ll_codec_interest, 0, 30, 5);
    const ll_link_params link = {0};
    int size[2], outside = 0;
    for (int other = 0; other < 2; other++) {
        net *n = new_net(200, 150, &rules, &link);
        ll_world *world = ll_server_world(n->server);
        run(n, 299, NULL);
        for (int i = CLIENTS; i < world->entities; i++) {
            ll_entity *e = &world->entity[i];
            double dx = e->x - world->entity[0].x, dy = e->y - world->entity[0].y;
            if (dx * dx + dy * dy < 36.0 * 36)
                continue;
            outside++;
            if (other)
                *e = (ll_entity){.x = e->x + dx, .y = e->y + dy, .vx = 17, .angle = 3, .flags = 1};
        }
        n->server->step = 300;
        size[other] = ll_server_compose(n->server, &ll_sync_free, 0, NULL, bytes[other]);
        free_net(n);
    }
    assert_true(outside > 200);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], (size_t)size[0]);
}

/* At equal density the bytes of a client do not grow with the number of entities; without an area they do. */
static double bytes_of(const ll_codec *codec, int entities)
{
    const ll_server_config rules = rules_of(codec, 0, 20, 4);
    const ll_link_params link = {0};
    net *n = new_net(entities, 6 * sqrt(entities), &rules, &link);
    ll_world *world = ll_server_world(n->server);
    for (int i = 0; i < CLIENTS; i++) { /* away from the edges */
        world->entity[i].x = (2.5 + 0.5 * i) * sqrt(entities);
        world->entity[i].y = 3 * sqrt(entities);
    }
    run(n, 900, NULL);
    double mean = (double)n->bytes / (double)n->snapshots - sizeof(ll_snapshot_message);
    free_net(n);
    return mean;
}

static void bytes_do_not_grow_with_the_number(void **state)
{
    (void)state;
    double few = bytes_of(&ll_codec_interest, 250), many = bytes_of(&ll_codec_interest, 1000);
    double all_few = bytes_of(&ll_codec_partial_delta, 60), all_many = bytes_of(&ll_codec_partial_delta, 240);
    assert_true(many > 0.75 * few && many < 1.25 * few); /* the density of a random place varies */
    assert_true(all_many > 3.5 * all_few && all_many < 4.5 * all_few);
}

/* A limit holds for every snapshot, and all entities come in turns. */
static void a_limit_holds(void **state)
{
    (void)state;
    const ll_server_config rules = rules_of(&ll_codec_partial_delta, 150, 0, 0);
    const ll_link_params link = {0};
    net *n = new_net(100, 100, &rules, &link);
    run(n, 1800, NULL);
    const ll_replica *r = ll_replicas_of(ll_server_replicas(n->server), 0);
    const ll_world *got = ll_client_latest(n->client[0]);
    assert_true((double)n->bytes / (double)n->snapshots <= 150 + sizeof(ll_snapshot_message));
    assert_true(r->counts.choked > r->counts.snapshots / 2);
    assert_true(r->counts.interval_ticks_max < 60); /* 75 moving ones, some 15 in a snapshot */
    for (int i = 0; i < got->entities; i++)
        assert_false(got->entity[i].flags & LL_ENTITY_UNKNOWN);
    free_net(n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rates_are_the_shares_of_the_priorities),
        cmocka_unit_test(no_wait_is_longer_than_its_bound),
        cmocka_unit_test(equals_take_turns),
        cmocka_unit_test(decoded_states_are_those_of_the_server),
        cmocka_unit_test(noting_what_is_recent_changes_nothing),
        cmocka_unit_test(the_area_of_interest_is_complete),
        cmocka_unit_test(what_is_outside_leaves_no_trace),
        cmocka_unit_test(bytes_do_not_grow_with_the_number),
        cmocka_unit_test(a_limit_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

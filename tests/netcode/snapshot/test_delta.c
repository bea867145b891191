/* Delta-compressed snapshots over bad links: a client decodes bitwise what the server sent, or nothing. */
#include "netcode/toy.h"

#include "base/rng.h"
#include "netcode/snapshot/common.h"
#include "support/link.h"

#define CLIENTS 2
#define ENTITIES 42
#define TAIL 16
#define STEPS 6000 /* of a 60th of a second */

static const ll_extent extent = {ENTITIES, TAIL};

/* A third of the entities is at rest, a third always moves, a third moves at times; one leaves the grid at
 * times. */
static void drift(ll_world *world, int64_t step)
{
    uint64_t *tail = ll_world_tail(world);
    tail[1] += step % 50 == 0;
    for (int i = 0; i < ENTITIES; i++) {
        ll_entity *e = &world->entity[i];
        bool moves = i % 3 == 1 || (i % 3 == 2 && step / 40 % 3 == i % 5);
        e->vx = moves ? 4 * (2 * ll_rng_unit(3, (uint64_t)i, (uint64_t)(step / 20)) - 1) : 0;
        e->vy = moves ? 1 : 0;
        e->x += e->vx / 60;
        e->y += e->vy / 60;
        e->angle += e->vx / 30;
        e->flags = moves && i % 7 == 0 ? LL_ENTITY_ACTIVE : 0;
    }
    world->entity[20].y = step / 100 % 4 == 3 ? 1e12 : 5;
}

/* How the world of a step was sent; a step may be sent in two ways. */
typedef struct sent {
    ll_world *world;
    int ways;
    int codec[2];
    ll_quantization grid[2];
} sent;

typedef struct net {
    ll_server *server;
    ll_client *client[CLIENTS];
    ll_client_metrics *client_metrics;
    ll_player_config config;
    ll_server_config rules;
    ll_game_env env;
    ll_link *up[CLIENTS], *down[CLIENTS];
    sent *sent; /* by step */
    int64_t applied, unreadable;
} net;

static ll_link *new_link(uint64_t stream)
{
    ll_link *link = malloc(ll_link_size(512, 512 * 4096));
    ll_link_init(link, 512, 512 * 4096, 11, stream);
    return link;
}

static ll_client_setup setup_of(net *n, const ll_sync_mode *sync)
{
    return (ll_client_setup){.game = &toy,
                             .env = &n->env,
                             .sync = sync,
                             .config = &n->config,
                             .rules = &n->rules,
                             .client_metrics = n->client_metrics};
}

static net *new_net(const ll_sync_mode *sync)
{
    net *n = calloc(1, sizeof *n);
    n->server = malloc(ll_server_size(CLIENTS, extent));
    ll_server_init(n->server, CLIENTS, extent);
    ll_server_start(n->server, HZ(60), HZ(30), HZ(60), 0);
    n->client_metrics = malloc(ll_client_metrics_size(ENTITIES));
    ll_client_metrics_init(n->client_metrics, ENTITIES, 0);
    ll_param_defaults(&ll_player_table, &n->config);
    ll_param_defaults(&ll_server_table, &n->rules);
    n->config.control = LL_CONTROL_PERSON;
    ll_client_setup setup = setup_of(n, sync);
    for (int i = 0; i < CLIENTS; i++) {
        n->client[i] = malloc(ll_client_size(extent));
        ll_client_init(n->client[i], i, ll_server_world(n->server));
        n->server->client_slots[i].connection.connected = 1;
        n->client[i]->connection.state = LL_CONNECTION_PLAYING;
        ll_client_start(n->client[i], &setup,
                        &(ll_client_begin){.epoch = 1, .freq = HZ(60), .world = ll_server_world(n->server)},
                        0);
        n->client[i]->inputs.held = push(0.5);
        n->up[i] = new_link((uint64_t)(2 * i));
        n->down[i] = new_link((uint64_t)(2 * i + 1));
    }
    n->sent = calloc(STEPS + 1, sizeof *n->sent);
    return n;
}

static void free_net(net *n)
{
    for (int i = 0; i < CLIENTS; i++) {
        free(n->client[i]);
        free(n->up[i]);
        free(n->down[i]);
    }
    for (int k = 0; k <= STEPS; k++)
        free(n->sent[k].world);
    free(n->sent);
    free(n->client_metrics);
    free(n->server);
    free(n);
}

/* The world that client `self` must decode of step `s`, sent in way `way`. */
static bool is_what_was_sent(const ll_world *got, const sent *s, int way, int self)
{
    const ll_quantization *grid = &s->grid[way];
    bool same = memcmp(ll_world_tail_const(got), ll_world_tail_const(s->world), TAIL) == 0;
    for (int i = 0; i < ENTITIES; i++) {
        ll_entity e = s->world->entity[i];
        ll_cell cell = ll_cell_of(&e, grid);
        if (ll_codecs[s->codec[way]]->gridded && i != self && ll_cell_fits(&cell))
            e = ll_cell_entity(&cell, grid);
        same = same && memcmp(&e, &got->entity[i], sizeof e) == 0;
    }
    return same;
}

static void check(net *n, int i)
{
    ll_snapshot_entry *r = ll_client_state(n->client[i], n->client[i]->snapshots.received - 1);
    const sent *s = &n->sent[r->tick];
    bool same = false;
    for (int way = 0; way < s->ways; way++)
        same = same || is_what_was_sent(ll_snapshot_entry_world(r), s, way, i);
    if (!same)
        fail_msg("client %d decoded step %lld differently from what was sent", i, (long long)r->tick);
    n->applied++;
}

static void receive(net *n, const ll_sync_mode *sync, int i, ll_time now)
{
    static _Alignas(8) char bytes[8192];
    ll_client_setup setup = setup_of(n, sync);
    ll_input_result results[LL_INPUTS_MAX];
    ll_time sent_at, due;
    int size;
    while (ll_link_receive(n->up[i], now, bytes, (int)sizeof bytes, &sent_at, &due) >= 0)
        ll_server_receive(n->server, sync, i, bytes, now, results);
    while ((size = ll_link_receive(n->down[i], now, bytes, (int)sizeof bytes, &sent_at, &due)) >= 0) {
        int outcome = ll_client_receive(n->client[i], &setup, bytes, size, now);
        n->unreadable += outcome == LL_OUTCOME_UNDECODABLE;
        if (outcome == LL_OUTCOME_APPLIED)
            check(n, i);
    }
}

static void update(net *n, const ll_sync_mode *sync, const ll_link_params *link, ll_time now)
{
    static _Alignas(8) char bytes[8192];
    static ll_snapshot_common common;
    ll_snapshot_common_clear(&common);
    sent *s = &n->sent[n->server->step];
    if (!s->world)
        s->world = malloc(ll_extent_size(extent));
    memcpy(s->world, ll_server_world(n->server), ll_extent_size(extent));
    s->codec[s->ways] = n->server->codec;
    s->grid[s->ways++] = n->server->grid;
    for (int i = 0; i < CLIENTS; i++) {
        ll_client_slot *client_slot = &n->server->client_slots[i];
        client_slot->inputs.acked =
            client_slot->inputs.newest < 0
                ? 0
                : (uint32_t)(client_slot->inputs.newest + client_slot->inputs.seq_minus_tick);
        int size = ll_server_compose(n->server, sync, i, &common, bytes);
        link_send(n->down[i], link, 80, now, bytes, size);
    }
}

typedef void change_fn(ll_server *server, int64_t step);

static net *run(const ll_sync_mode *sync, const ll_link_params *link, change_fn *change)
{
    net *n = new_net(sync);
    ll_client_setup setup = setup_of(n, sync);
    for (int64_t k = 1; k <= STEPS; k++) {
        ll_time now = ll_tick_time(k, HZ(60));
        ll_input_message m;
        drift(ll_server_world(n->server), k);
        n->server->step = k;
        n->server->stepped = now;
        if (k % 2 == 0) {
            update(n, sync, link, now);
            change(n->server, k);
            if (k % 100 == 0) /* the same step once more: in another way when it has just been changed */
                update(n, sync, link, now);
        }
        for (int i = 0; i < CLIENTS; i++) {
            receive(n, sync, i, now);
            int size = ll_client_tick(n->client[i], &setup, now, &m);
            ll_client_display(n->client[i], &setup, now);
            if (size > 0)
                link_send(n->up[i], link, 80, now, &m, size);
        }
    }
    return n;
}

static void set(ll_server *server, const ll_codec *codec, double quantum)
{
    ll_server_config config = {.snapshot = ll_codec_index(codec),
                               .quantum_m = quantum,
                               .quantum_mps = 10 * quantum,
                               .quantum_rad = 2 * quantum,
                               .quantum_radps = 20 * quantum};
    ll_server_configure(server, &config);
}

static void always_delta(ll_server *server, int64_t step)
{
    (void)step;
    set(server, &ll_codec_delta, 0.002);
}

/* Every 5 s another grid, at times twice while the first is in flight, or full and then the previous grid. */
static void ever_new(ll_server *server, int64_t step)
{
    static const double quanta[] = {0.002, 0.003, 0.01, 0.003};
    int64_t phase = step / 300;
    if (step % 300 == 0)
        set(server, phase % 5 == 2 ? &ll_codec_full : &ll_codec_delta, quanta[phase % 4]);
    if (step % 300 == 4 && phase % 2 == 0 && phase % 5 != 2)
        set(server, &ll_codec_delta, quanta[(phase + 2) % 4]);
}

static const ll_link_params bad = {.jitter_ms = 60, .loss_pct = 20, .duplicate_pct = 10};

static double share(int64_t part, int64_t whole)
{
    return (double)part / (double)whole;
}

/* Under 20 % loss, reordering and duplicates nothing is decoded against a wrong baseline, and no snapshot
 * arrives without its baseline; the acknowledged baseline makes nearly every snapshot a delta. */
static void every_decoded_world_is_the_one_sent(void **state)
{
    (void)state;
    net *n = run(&ll_sync_free, &bad, always_delta);
    assert_true(n->applied > 2 * 1500); /* of 2 * 3000, 20 % lost and others overtaken */
    assert_int_equal(n->unreadable, 0);
    for (int i = 0; i < CLIENTS; i++) {
        const ll_snapshot_cost *c = &n->server->client_slots[i].counts.sent;
        assert_true(share(c->whole, c->entities / ENTITIES) < 0.01);
        assert_true(share(c->unchanged, c->entities) > 0.3); /* those at rest */
        assert_true(ll_link_get_stats(n->down[i])->reordered > 100);
        assert_true(ll_link_get_stats(n->down[i])->duplicated > 100);
    }
    free_net(n);
}

/* Also where stale snapshots are applied, packets overtake one another by far, and the grid and the codec
 * change while packets are in flight. */
static void changes_under_way_mix_nothing_up(void **state)
{
    (void)state;
    ll_sync_mode careless = ll_sync_free;
    careless.drops_stale = false;
    const ll_link_params wild = {.jitter_ms = 500, .loss_pct = 5};
    const ll_link_params *const links[] = {&bad, &wild};
    for (int i = 0; i < 2; i++) {
        net *strict = run(&ll_sync_free, links[i], ever_new), *loose = run(&careless, links[i], ever_new);
        assert_true(strict->applied > 1000 && loose->applied > 2 * 1500);
        assert_int_equal(strict->unreadable, 0);
        assert_true(share(loose->unreadable, loose->applied) < 0.1); /* on an earlier grid */
        const ll_snapshot_cost *c = &strict->server->client_slots[0].counts.sent;
        assert_true(share(c->whole, c->entities / ENTITIES) < 0.5); /* a fifth is full */
        free_net(strict);
        free_net(loose);
    }
}

/* A client that acknowledges nothing, or too late, gets full snapshots. */
static void without_a_baseline_snapshots_are_full(void **state)
{
    (void)state;
    const ll_link_params late = {.delay_ms = 600}, deaf = {.loss_pct = 100};
    const ll_link_params *const links[] = {&late, &deaf};
    for (size_t i = 0; i < 2; i++) {
        net *n = run(&ll_sync_free, links[i], always_delta);
        const ll_snapshot_cost *c = &n->server->client_slots[0].counts.sent;
        assert_int_equal(c->whole, c->entities / ENTITIES);
        assert_int_equal(n->unreadable, 0);
        assert_true(i == 1 || n->applied > 2 * 2900);
        free_net(n);
    }
}

/* ---- snapshots that a client rejects ---- */

static ll_server *one_server(void)
{
    ll_server *server = malloc(ll_server_size(2, extent));
    ll_server_init(server, 2, extent);
    ll_server_start(server, HZ(60), HZ(30), HZ(60), 0);
    set(server, &ll_codec_delta, 0.002);
    return server;
}

static int compose(ll_server *server, int64_t step, char *bytes)
{
    drift(ll_server_world(server), step);
    server->step = step;
    server->stepped = ll_tick_time(step, HZ(60));
    return ll_server_compose(server, &ll_sync_free, 0, NULL, bytes);
}

static void undecodable_snapshots_change_nothing(void **state)
{
    (void)state;
    static _Alignas(8) char first[8192], second[8192], third[8192];
    ll_server *server = one_server();
    net *n = new_net(&ll_sync_free);
    ll_client_setup setup = setup_of(n, &ll_sync_free);
    ll_client *c = n->client[0];
    int size1 = compose(server, 1, first), size2 = compose(server, 2, second);
    server->client_slots[0].snapshots.received = 2;
    int size3 = compose(server, 3, third);
    ll_snapshot_message m;
    memcpy(&m, third, sizeof m);
    assert_int_equal(m.baseline, 1);
    assert_int_equal(m.codec, ll_codec_index(&ll_codec_delta));
    assert_int_equal(ll_client_receive(c, &setup, third, size3, 0), LL_OUTCOME_UNDECODABLE); /* no baseline */
    assert_int_equal(ll_client_receive(c, &setup, first, size1, 0), LL_OUTCOME_APPLIED);
    assert_int_equal(ll_client_receive(c, &setup, third, size3, 0),
                     LL_OUTCOME_UNDECODABLE); /* not that one */
    assert_int_equal(ll_client_receive(c, &setup, second, size2 - 1, 0), LL_OUTCOME_UNDECODABLE);
    assert_int_equal(ll_client_receive(c, &setup, second, (int)sizeof(ll_message_head), 0),
                     LL_OUTCOME_UNDECODABLE);
    second[offsetof(ll_snapshot_message, codec)] = 17; /* no such codec */
    assert_int_equal(ll_client_receive(c, &setup, second, size2, 0), LL_OUTCOME_UNDECODABLE);
    second[offsetof(ll_snapshot_message, codec)] = (char)ll_codec_index(&ll_codec_quantised);
    assert_int_equal(c->snapshots.received, 1);
    assert_int_equal(c->snapshots.confirmed, 1);
    assert_int_equal(ll_client_receive(c, &setup, second, size2, 0), LL_OUTCOME_APPLIED);
    assert_int_equal(ll_client_receive(c, &setup, third, size3, 0), LL_OUTCOME_APPLIED);
    assert_int_equal(c->snapshots.unreadable, 5);
    assert_int_equal(c->snapshots.confirmed, 3);
    free_net(n);
    free(server);
}

/* An acknowledged tick that the server never sent, or sent long ago, is no baseline. */
static void a_false_acknowledgement_is_no_baseline(void **state)
{
    (void)state;
    static _Alignas(8) char bytes[8192];
    ll_server *server = one_server();
    ll_snapshot_message m;
    for (int64_t step = 1; step <= 100; step++)
        compose(server, step, bytes);
    const int64_t claims[] = {0, 1, 68, 69, 70, 99, 101, UINT32_MAX};
    for (size_t i = 0; i < sizeof claims / sizeof claims[0]; i++) {
        server->client_slots[0].snapshots.received = claims[i];
        ll_server_compose(server, &ll_sync_free, 0, NULL, bytes);
        memcpy(&m, bytes, sizeof m);
        bool kept = claims[i] >= 69 && claims[i] <= 100; /* the last 32 */
        assert_int_equal(m.baseline, kept ? 100 - claims[i] : 0);
        assert_int_equal(m.codec, ll_codec_index(kept ? &ll_codec_delta : &ll_codec_quantised));
    }
    free(server);
}

/* A world that no grid can hold is sent full; later snapshots do not use it as a baseline, since no grid came
 * with it. */
static void longer_encodings_become_full(void **state)
{
    (void)state;
    static _Alignas(8) char bytes[8192];
    ll_server *server = one_server();
    ll_snapshot_message m;
    compose(server, 1, bytes);
    compose(server, 2, bytes);
    for (int i = 0; i < ENTITIES; i++) {
        const double odd = 1e30 / 3;
        ll_server_world(server)->entity[i] = (ll_entity){odd, odd, odd, odd, odd, odd, UINT64_MAX};
    }
    server->step = 3;
    int size = ll_server_compose(server, &ll_sync_free, 0, NULL, bytes);
    memcpy(&m, bytes, sizeof m);
    assert_int_equal(m.codec, ll_codec_index(&ll_codec_full));
    assert_int_equal(size, sizeof(ll_snapshot_message) + ll_extent_size(extent));
    const struct {
        int64_t received;
        const ll_codec *codec;
    } then[] = {{2, &ll_codec_quantised}, {3, &ll_codec_quantised}, {4, &ll_codec_delta}};
    memset(ll_server_world(server)->entity, 0, ENTITIES * sizeof(ll_entity));
    for (int i = 0; i < 3; i++) {
        server->client_slots[0].snapshots.received = then[i].received;
        compose(server, 4 + i, bytes);
        memcpy(&m, bytes, sizeof m);
        assert_int_equal(m.codec, ll_codec_index(then[i].codec));
    }
    free(server);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_decoded_world_is_the_one_sent),
        cmocka_unit_test(changes_under_way_mix_nothing_up),
        cmocka_unit_test(without_a_baseline_snapshots_are_full),
        cmocka_unit_test(undecodable_snapshots_change_nothing),
        cmocka_unit_test(a_false_acknowledgement_is_no_baseline),
        cmocka_unit_test(longer_encodings_become_full),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

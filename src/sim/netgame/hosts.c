/* A server on the machine of a player: messages take two links, the host may leave, and another player's
 * machine then becomes the server.
 *
 * The server of the block is that of the present host. When another takes over, it becomes what that machine
 * knows: the state that it had, and nothing of the players. netcode/hosting/hosting.h decides who does. */
#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "sim/netgame/parts.h"

#define LOOP_SLOTS 48 /* messages of one instant from a machine to itself */
#define STREAM 2048   /* of random numbers, which a machine's own messages do not use */

/* Who gets a message at a machine. */
typedef enum side { TO_SERVER, TO_CLIENT, TO_PLAYER } side;

/* Ends each message. Stands for addresses of IP, and for a promise (netcode/hosting/hosting.h). */
typedef struct route {
    uint8_t from, to, side, reserved;
    uint32_t promise_us; /* from `sent` on */
    ll_time sent;
} route;

_Static_assert(sizeof(route) == 16, "what links have room for, by netgame.c and the docs");

static ll_netgame_hosts *hosts_of(const ll_netgame_run *run)
{
    return ll_netgame_hosts_of(run->game);
}

static ll_world *farewell_of(const ll_netgame_run *run)
{
    return (ll_world *)((char *)run->game + hosts_of(run)->farewell);
}

/* ---- layout ---- */

int64_t ll_netgame_lay_out_hosts(ll_netgame *g, const ll_netgame_config *c, int64_t at, int longest)
{
    ll_netgame_hosts all = {.farewell = 0};
    const ll_extent world = ll_games[c->game]->extent(c->params, c->player_count);
    for (int i = 0; i < c->player_count; i++) {
        all.loop[i] = at;
        at += (int64_t)ll_link_size(LOOP_SLOTS, LOOP_SLOTS * longest);
    }
    all.farewell = at;
    at += (int64_t)((ll_extent_size(world) + 7) & ~(size_t)7);
    if (g)
        memcpy((char *)g + at, &all, sizeof all);
    return at + (int64_t)sizeof all;
}

void ll_netgame_init_hosts(ll_netgame *g, const ll_netgame_config *c, int longest)
{
    ll_netgame_hosts *all = ll_netgame_hosts_of(g);
    const ll_world *world = ll_server_world_const(ll_netgame_server(g));
    ll_hosting_init(&all->hosting, &c->hosting, c->player_count);
    memcpy((char *)g + all->farewell, world, ll_world_size(world));
    for (int i = 0; i < c->player_count; i++)
        ll_link_init((ll_link *)((char *)g + all->loop[i]), LOOP_SLOTS, LOOP_SLOTS * longest,
                     (uint64_t)c->head.seed, STREAM + (uint64_t)i);
}

/* ---- messages ---- */

static const ll_link_params no_impairments;

/* Whose message it is for metrics: a player's to or from its host. */
static int counted_for(const route *r)
{
    return r->side == TO_CLIENT ? r->to : r->from;
}

static void note_fate(ll_netgame_run *run, const route *r, const void *packet, const ll_sending *s)
{
    if (r->side == TO_SERVER)
        ll_netgame_note_arrival(run, r->from, packet, s);
    if (run->recorder && r->side != TO_PLAYER)
        ll_netgame_record_sent(run, counted_for(r), packet, r->sent, s);
}

static ll_sending put(ll_netgame_run *run, int player, bool up, bool tapped, const void *bytes, int size)
{
    ll_netgame_seat *seat = &run->seat[player];
    ll_packet_tap tap;
    const bool taps = tapped && ll_netgame_records_packets(run);
    if (taps)
        ll_netgame_tap(run, player, up, &tap);
    return ll_link_send_by(up ? seat->up : seat->down,
                           taps ? &tap.plan
                           : up ? &seat->up_plan
                                : &seat->down_plan,
                           run->game->now, bytes, size);
}

static bool arrives(const ll_sending *s)
{
    return s->fate == LL_FATE_DELIVERED || (s->duplicated && s->copy_fate == LL_FATE_DELIVERED);
}

/* A message to oneself takes no link and no time, and counts as no traffic. */
static void send_by(ll_netgame_run *run, route r, const void *packet, int bytes)
{
    _Alignas(8) char out[LL_NETGAME_PACKET_MAX + sizeof r];
    const ll_time now = run->game->now;
    ll_netgame_seat *seat = &run->seat[counted_for(&r)];
    ll_message_head head;
    r.sent = now;
    memcpy(&head, packet, sizeof head);
    memcpy(out, packet, (size_t)bytes);
    memcpy(out + bytes, &r, sizeof r);
    *(r.side == TO_CLIENT ? &seat->slot->connection.last_sent : &seat->client->connection.sent) = now;
    if (r.from == r.to) {
        const ll_link_plan here = ll_link_plan_of(&no_impairments, 0);
        const ll_sending s = ll_link_send_by(run->seat[r.from].loop, &here, now, out, bytes + (int)sizeof r);
        note_fate(run, &r, packet, &s);
        return;
    }
    const ll_sending s = put(run, r.from, true, r.side == TO_SERVER, out, bytes + (int)sizeof r);
    if (now >= seat->metrics->from)
        ll_netgame_count_traffic(&seat->metrics->traffic, head.type, bytes + (int)sizeof r, s.fragments);
    if (!arrives(&s))
        note_fate(run, &r, packet, &s);
}

/* The next message that is due, in `received`; returns its size without the route. */
static int take(ll_netgame_run *run, ll_link *link, route *r)
{
    int size;
    const char *packet = ll_link_next(link, run->game->now, &size);
    LL_ASSERT(packet && size >= (int)(sizeof(ll_message_head) + sizeof *r));
    LL_ASSERT(size <= LL_NETGAME_PACKET_MAX);
    size -= (int)sizeof *r;
    memcpy(r, packet + size, sizeof *r);
    memcpy(run->received, packet, (size_t)size + sizeof *r);
    return size;
}

void ll_netgame_host_pass(ll_netgame_run *run, int player)
{
    route r;
    const int size = take(run, run->seat[player].up, &r);
    const ll_sending s = put(run, r.to, false, r.side == TO_CLIENT, run->received, size + (int)sizeof r);
    note_fate(run, &r, run->received, &s);
}

/* What one player's machine reports to another's. `world`: NULL, or what follows. */
static void tell(ll_netgame_run *run, int from, int to, ll_host_message m, const ll_world *world)
{
    size_t size = sizeof m;
    m.head.type = LL_MESSAGE_PING;
    memcpy(run->composed, &m, sizeof m);
    if (world) {
        memcpy(run->composed + size, world, ll_world_size(world));
        size += ll_world_size(world);
    }
    send_by(run, (route){.from = (uint8_t)from, .to = (uint8_t)to, .side = TO_PLAYER}, run->composed,
            (int)size);
}

static void tell_all(ll_netgame_run *run, int from, ll_host_message m, const ll_world *world)
{
    for (int to = 0; to < run->players; to++)
        if (to != from)
            tell(run, from, to, m, world);
}

/* ---- the newest state of a player's machine ---- */

typedef struct state {
    int64_t tick;
    const ll_world *world;
} state;

static state newest_state(const ll_netgame_run *run, int player)
{
    ll_client *c = run->seat[player].client;
    const ll_host_view *v = &run->hosting->view[player];
    state s = {c->latest.tick, ll_client_latest(c)};
    if (run->sync->observe) {
        s.tick = ll_client_peer(c)->confirmed;
        s.world = ll_peer_world(c, s.tick);
    } else if (c->snapshots.received > 0) {
        ll_snapshot_entry *newest = ll_client_state(c, c->snapshots.received - 1);
        s = (state){newest->tick, ll_snapshot_entry_world(newest)};
    }
    return v->announced > s.tick ? (state){v->announced, farewell_of(run)} : s;
}

/* ---- a client without a host ---- */

static ll_time timeout_of(const ll_netgame_run *run)
{
    return (ll_time)(run->game->config.server.timeout_s * 1e9);
}

/* Before its clock forgets the way to the host. */
static void lose(ll_netgame_run *run, int player)
{
    ll_connection *n = &run->seat[player].client->connection;
    const ll_candidacy own = {newest_state(run, player).tick, ll_clock_sync_round_trip(&n->clock)};
    ll_hosting_lose(run->hosting, player, &own, run->game->now);
    ll_clock_sync_restart(&n->clock);
}

/* Whom a client asks that has lost its host; false: it still waits for what others say of themselves. */
static bool find_target(ll_netgame_run *run, int player)
{
    ll_hosting *h = run->hosting;
    ll_host_view *v = &h->view[player];
    ll_connection *n = &run->seat[player].client->connection;
    const ll_time now = run->game->now;
    const bool asks = ll_hosting_election(h)->asks;
    if (v->asked == LL_NEVER && asks && !ll_hosting_heard_all(h, player) && now - v->since < LL_CONNECT_RETRY)
        return false;
    if (v->asked != LL_NEVER && now - v->asked < ll_hosting_patience(h))
        return true;
    if (now < v->bound)
        return false;
    n->attempt += v->asked != LL_NEVER; /* an accept of the last one must not count any more */
    v->target = ll_hosting_choose(h, player);
    v->asked = now;
    v->promises = 1;
    v->bound = now + ll_hosting_patience(h);
    return true;
}

/* A client asks to be let in: by the host that it knows, or, if that has been silent, by whom it wants as the
 * next one. */
static void ask(ll_netgame_run *run, int player, const void *packet)
{
    ll_hosting *h = run->hosting;
    ll_host_view *v = &h->view[player];
    const ll_connection *n = &run->seat[player].client->connection;
    const ll_time now = run->game->now;
    route r = {.from = (uint8_t)player, .side = TO_SERVER};
    ll_request_message m;
    memcpy(&m, packet, sizeof m);
    if (n->joined && (v->lost >= 0 || now - n->last_received >= timeout_of(run))) {
        if (v->lost < 0)
            lose(run, player);
        if (ll_hosting_election(h)->asks)
            tell_all(run, player, (ll_host_message){.head.count = LL_HOST_CANDIDACY, .of = v->of[player]},
                     NULL);
        if (!find_target(run, player))
            return;
        if (v->promises)
            r.promise_us = (uint32_t)((v->asked + ll_hosting_patience(h) - now) / 1000);
        m.head.seq = n->attempt;
    }
    r.to = (uint8_t)v->target;
    send_by(run, r, &m, (int)sizeof m);
}

void ll_netgame_host_send(ll_netgame_run *run, int player, bool up, const void *packet, int bytes)
{
    const ll_hosting *h = run->hosting;
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    if (up && head.type == LL_MESSAGE_CONNECT) {
        ask(run, player, packet);
        return;
    }
    const route r =
        up ? (route){.from = (uint8_t)player, .to = (uint8_t)h->view[player].target, .side = TO_SERVER}
           : (route){.from = (uint8_t)h->host, .to = (uint8_t)player, .side = TO_CLIENT};
    LL_ASSERT(up || h->host >= 0);
    send_by(run, r, packet, bytes);
}

/* It asks at once, without waiting for its timer. */
static void ask_now(ll_netgame_run *run, int player)
{
    ll_netgame_seat *seat = &run->seat[player];
    ll_connection *n = &seat->client->connection;
    if (n->state != LL_CONNECTION_CONNECTING && n->state != LL_CONNECTION_DISCONNECTED)
        ll_connection_end(seat->client, &seat->setup, run->game->now);
    n->asks = run->game->now;
    ll_client_set_due(seat->client, &seat->setup);
}

/* Whether the player's client has a host of which it has heard lately. */
static bool has_host(const ll_netgame_run *run, int player)
{
    const ll_connection *n = &run->seat[player].client->connection;
    return n->state == LL_CONNECTION_PLAYING || n->state == LL_CONNECTION_SYNCHRONISING ||
           n->state == LL_CONNECTION_RESYNCHRONISING;
}

static void hear_candidacy(ll_netgame_run *run, int player, int from, const ll_host_message *m)
{
    ll_hosting *h = run->hosting;
    ll_host_view *v = &h->view[player];
    v->of[from] = m->of;
    ll_hosting_hear_of(h, player, from);
    v->heard |= UINT64_C(1) << from;
    if (v->lost >= 0 && v->asked == LL_NEVER && ll_hosting_heard_all(h, player))
        ask_now(run, player);
}

/* A host that is named to it it asks to be let in, and promises nothing: it may have promised itself to
 * another. As long as its own host may still host, it believes the new one alone. */
static void hear_of_host(ll_netgame_run *run, int player, int from, const ll_host_message *m)
{
    ll_host_view *v = &run->hosting->view[player];
    if (has_host(run, player) || m->host == player || (v->lost < 0 && m->host != from))
        return;
    if (v->lost >= 0 && v->asked != LL_NEVER && v->target == m->host)
        return; /* it asks that one already */
    if (v->lost < 0)
        lose(run, player);
    run->seat[player].client->connection.attempt++;
    v->target = m->host;
    v->asked = run->game->now;
    v->promises = 0;
    ask_now(run, player);
}

static void hear_farewell(ll_netgame_run *run, int player, int from, const ll_host_message *m,
                          const ll_world *world)
{
    ll_host_view *v = &run->hosting->view[player];
    if (v->target != from || v->lost >= 0)
        return;
    memcpy(farewell_of(run), world,
           (size_t)run->seat[player].client->layout.world_size); /* the same for all */
    v->announced = m->of.tick;
    lose(run, player);
    ask_now(run, player);
}

static void hear(ll_netgame_run *run, int player, int from, const char *packet)
{
    ll_host_message m;
    memcpy(&m, packet, sizeof m);
    if (m.head.count == LL_HOST_CANDIDACY)
        hear_candidacy(run, player, from, &m);
    else if (m.head.count == LL_HOST_IS)
        hear_of_host(run, player, from, &m);
    else if (m.head.count == LL_HOST_FAREWELL)
        hear_farewell(run, player, from, &m, (const ll_world *)(const void *)(packet + sizeof m));
}

void ll_netgame_host_joined(ll_netgame_run *run, int player)
{
    ll_client *c = run->seat[player].client;
    ll_hosting_join(run->hosting, player, run->game->now);
    if (!run->sync->observe || run->game->now < 0)
        return;
    c->latest.tick = c->snapshots.confirmed = ll_client_peer(c)->start; /* of the new host */
    c->latest.time = run->game->now;
}

/* ---- taking over ---- */

static double distance(const ll_entity *a, const ll_entity *b)
{
    double dx = a->x - b->x, dy = a->y - b->y;
    return ll_sqrt(dx * dx + dy * dy);
}

/* The steps from that of `from` on, with the last controls of each player that the new host knows. */
static void run_on(ll_netgame_run *run, int host, int64_t from, int64_t upto)
{
    ll_netgame *g = run->game;
    ll_client *c = run->seat[host].client;
    ll_action actions[LL_PLAYERS_MAX] = {0};
    for (int p = 0; p < run->players; p++)
        actions[p] = (ll_action){.axis = {c->latest.controls[p].axis[0], c->latest.controls[p].axis[1]}};
    actions[host] = ll_held(&ll_client_pending(c, c->inputs.seq)->action);
    for (int64_t k = from + 1; k <= upto; k++) {
        run->rules->step(run->world, &g->env, actions, ll_clock_time(&run->server->clock, k), NULL);
        if (k > run->server->step)
            ll_history_add(run->history, ll_clock_time(&run->server->clock, k), run->world);
    }
    run->hosting->again_ticks += upto - from;
}

/* Steps have times, and the clock of the steps goes on: the new host's world is that of the last step whose
 * time has passed. Returns this step. */
static int64_t take_world_by_clock(ll_netgame_run *run, int host, const state *s)
{
    const ll_clock *clock = &run->server->clock;
    const int64_t before = run->server->step;
    int64_t upto = before;
    while (ll_clock_time(clock, upto + 1) < run->game->now)
        upto++;
    if (run->hosting->params.meanwhile == LL_HOSTLESS_RUN_ON) {
        memcpy(run->world, s->world, ll_world_size(run->world));
        run_on(run, host, s->tick, upto);
        return upto;
    }
    for (int64_t k = before + 1; k < upto; k++)
        ll_history_add(run->history, ll_clock_time(clock, k), run->world);
    memcpy(run->world, s->world, ll_world_size(run->world));
    if (upto > before)
        ll_history_add(run->history, ll_clock_time(clock, upto), run->world);
    return upto;
}

/* Ticks are made when their inputs have come: the game goes on with the next one. */
static int64_t take_world_by_inputs(ll_netgame_run *run, const state *s)
{
    memcpy(run->world, s->world, ll_world_size(run->world));
    ll_history_rewind(run->history, s->tick + 1);
    while (run->history->count <= s->tick)
        ll_history_add(run->history, run->game->now, run->world);
    return s->tick;
}

static void take_world(ll_netgame_run *run, int host)
{
    ll_hosting *h = run->hosting;
    ll_server *server = run->server;
    const state s = newest_state(run, host);
    ll_entity before[LL_PEERS_MAX];
    memcpy(before, run->world->entity, (size_t)run->players * sizeof before[0]);
    h->lost_ticks += server->step > s.tick ? server->step - s.tick : 0;
    const int64_t step =
        run->sync->observe ? take_world_by_inputs(run, &s) : take_world_by_clock(run, host, &s);
    for (int p = 0; p < run->players; p++)
        h->view[p].set_back_m += distance(&before[p], &run->world->entity[p]);
    ll_server_resume(server, step, run->game->now);
    if (!run->sync->observe)
        server->stepped = ll_clock_time(&server->clock, step);
    for (int p = 0; p < run->players; p++) {
        if (run->sync->observe)
            server->client_slots[p].inputs.newest = step;
        else
            run->world->entity[p].flags |= LL_ENTITY_AWAY; /* until it is let in */
    }
}

/* The machine of `host` becomes the server. It lets in those who asked it, and sends the others word. */
static void take_over(ll_netgame_run *run, int host)
{
    ll_hosting *h = run->hosting;
    const ll_time now = run->game->now;
    ll_host_vote votes[LL_PEERS_MAX];
    LL_ASSERT(h->host < 0); /* its leases were over */
    memcpy(votes, h->votes[host], sizeof votes);
    take_world(run, host);
    ll_hosting_begin(h, host, now, timeout_of(run));
    for (int p = 0; p < run->players; p++) {
        if (votes[p].until > now)
            run->server_gets(run, p, &votes[p].request);
        else if (p != host)
            tell(run, host, p, (ll_host_message){.head.count = LL_HOST_IS, .host = host}, NULL);
    }
    if (run->sync->stand_in)
        run->sync->stand_in(run->server, now);
}

/* The first host stays the host until the game begins, also of players whose links are so bad that they lose
 * it before: its leases count from the first check of the game on. */
static bool may_end(const ll_netgame_run *run)
{
    return run->hosting->host < 0 || run->game->now > LL_CONNECTION_CHECK_INTERVAL;
}

/* A machine that is not the server is asked to be it. */
static void take_vote(ll_netgame_run *run, int player, const route *r, const void *packet)
{
    ll_hosting *h = run->hosting;
    ll_host_vote *vote = &h->votes[player][r->from];
    if (has_host(run, player) && h->view[player].target != player) {
        vote->until = 0;
        tell(run, player, r->from,
             (ll_host_message){.head.count = LL_HOST_IS, .host = h->view[player].target}, NULL);
        return;
    }
    memcpy(&vote->request, packet, sizeof vote->request);
    vote->until = r->sent + (ll_time)r->promise_us * 1000;
    if (ll_hosting_elected(h, player, run->game->now + LL_CONNECTION_CHECK_INTERVAL) && may_end(run))
        take_over(run, player);
}

/* What a request says of how long its sender will ask no other player. */
static void take_lease(ll_netgame_run *run, const route *r, const ll_message_head *head, const void *packet)
{
    ll_hosting *h = run->hosting;
    ll_request_message m;
    if (head->type != LL_MESSAGE_PING && head->type != LL_MESSAGE_CONNECT)
        return;
    memcpy(&m, packet, sizeof m);
    if (m.seen != LL_NEVER && m.seen >= h->since)
        ll_hosting_renew(h, r->from, m.seen + timeout_of(run));
    if (r->promise_us > 0)
        ll_hosting_renew(
            h, r->from,
            ll_hosting_lease(r->sent + (ll_time)r->promise_us * 1000, run->game->now, timeout_of(run)));
}

static void serve(ll_netgame_run *run, int player, const route *r, const void *packet)
{
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    if (run->hosting->host == player) {
        take_lease(run, r, &head, packet);
        run->server_gets(run, r->from, packet);
    } else if (head.type == LL_MESSAGE_CONNECT) {
        take_vote(run, player, r, packet);
    }
}

void ll_netgame_host_arrive(ll_netgame_run *run, int player, bool looped)
{
    ll_netgame_seat *seat = &run->seat[player];
    const ll_hosting *h = run->hosting;
    route r;
    const int size = take(run, looped ? seat->loop : seat->down, &r);
    if (h->gone >> player & 1)
        return;
    if (r.side == TO_SERVER)
        serve(run, player, &r, run->received);
    else if (r.side == TO_PLAYER)
        hear(run, player, r.from, run->received);
    else if (h->view[player].target == r.from)
        run->client_gets(run, player, run->received, size);
}

/* ---- leaving ---- */

/* The host's machine is gone, with the server and its player's client. */
static void leave(ll_netgame_run *run)
{
    ll_hosting *h = run->hosting;
    const int host = (int)h->host;
    ll_netgame_seat *seat = &run->seat[host];
    const ll_host_message m = {.head.count = LL_HOST_FAREWELL, .of.tick = run->server->step};
    if (h->params.leaving == LL_LEAVING_ANNOUNCED)
        tell_all(run, host, m, run->world);
    h->gone |= UINT64_C(1) << host;
    h->leaves = LL_NEVER;
    ll_hosting_stop(h, run->game->now);
    ll_connection_end(seat->client, &seat->setup, run->game->now);
    seat->client->ticks.due = seat->client->displays.due = seat->client->due = LL_NEVER;
}

bool ll_netgame_host_check(ll_netgame_run *run)
{
    ll_hosting *h = run->hosting;
    const ll_time now = run->game->now;
    if (h->host < 0 || now < 0)
        return h->host >= 0;
    if (now >= h->leaves) {
        leave(run);
    } else if (!ll_hosting_holds(h, now + LL_CONNECTION_CHECK_INTERVAL)) {
        h->step_downs++;
        ll_hosting_stop(h, now);
    }
    return h->host >= 0;
}

/* ---- metrics ---- */

static double hosted_s(const ll_netgame *g, const ll_hosting *h, int player)
{
    ll_time hosted = h->view[player].hosted;
    if (h->host == player && g->now > 0)
        hosted += g->now - (h->since > 0 ? h->since : 0);
    return ll_to_s(hosted);
}

static ll_time without(const ll_netgame *g, const ll_host_view *v)
{
    return v->without == LL_NEVER ? 0 : g->now - v->without;
}

#define HOST(X)                                                                                              \
    X(number, host, NULL, h->host < 0 ? NAN : (double)h->host, "index of the player who hosts",              \
      "No one hosts.")                                                                                       \
    X(events, changes, NULL, h->changes, "times that another player became the host", NULL)                  \
    X(events, step_downs, NULL, h->step_downs,                                                               \
      "times that a host stopped because it could not know any more that no other one was chosen", NULL)     \
    X(number, without_s, "s", ll_to_s(h->without + (h->host < 0 ? g->now - h->stopped : 0)),                 \
      "time in which no one hosted", NULL)                                                                   \
    X(count, lost_ticks, "ticks", h->lost_ticks,                                                             \
      "steps that a host had made and that were not in the state from which the next one went on", NULL)     \
    X(count, again_ticks, "ticks", h->again_ticks,                                                           \
      "with run_on, steps that a new host made at once to catch up with the time", NULL)

#define HOST_PLAYER(X)                                                                                       \
    X(flag, gone, NULL, (h->gone >> player & 1) != 0, "the player's machine has left for good", NULL)        \
    X(number, hosted_s, "s", hosted_s(g, h, player), "time that the player hosted", NULL)                    \
    X(number, host_from_s, "s", v->host_from == LL_NEVER ? NAN : ll_to_s(v->host_from),                      \
      "when the player last began to host", "The player has never hosted.")                                  \
    X(number, without_s, "s", ll_to_s(v->without_sum + without(g, v)),                                       \
      "time without a host: from the moment at which a host stopped to the arrival of the next one's "       \
      "accept, "                                                                                             \
      "in all",                                                                                              \
      NULL)                                                                                                  \
    X(number, without_max_s, "s", ll_to_s(without(g, v) > v->without_max ? without(g, v) : v->without_max),  \
      "the longest of these times", NULL)                                                                    \
    X(number, set_back_m, "m", v->set_back_m,                                                                \
      "distance that changes of the host moved the player's entity by, in all: from the last world of one "  \
      "host to the first of the next",                                                                       \
      NULL)

const ll_metric_table ll_netgame_host_table = {LL_OF_RUN("hosting"), .when = "Only with hosting.by_player.",
                                               .help = "Who hosts, from time 0 on.", LL_METRICS_FROM(HOST)};

const ll_metric_table ll_netgame_host_player_table = {
    LL_OF_PLAYERS(".hosting"), .when = "Only with hosting.by_player.",
    .help = "The player as a host, and without one, from time 0 on.", LL_METRICS_FROM(HOST_PLAYER)};

void ll_netgame_host_metrics(const ll_netgame *g, cJSON *metrics)
{
    const ll_netgame_hosts *all = ll_netgame_hosts_of(g);
    if (!all)
        return;
    const ll_hosting *h = &all->hosting;
    cJSON *o = cJSON_AddObjectToObject(metrics, "hosting");
    LL_METRICS_PUT(o, &ll_netgame_host_table, HOST);
}

void ll_netgame_host_player_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    const ll_netgame_hosts *all = ll_netgame_hosts_of(g);
    if (!all)
        return;
    const ll_hosting *h = &all->hosting;
    const ll_host_view *v = &h->view[player];
    cJSON *o = cJSON_AddObjectToObject(metrics, "hosting");
    LL_METRICS_PUT(o, &ll_netgame_host_player_table, HOST_PLAYER);
}

/* Whose turn is next: packets, the server and the clients, in the order of virtual time. */
#include <stdio.h>

#include "sim/netgame/parts.h"

ll_client_setup ll_netgame_client_setup(const ll_netgame *g, int i, const ll_recorder *recorder)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    const ll_player_config *player = &g->config.players[i];
    ll_freq ticks = ll_netgame_rate(g, sync->client_steps_at_update_hz), displays = ll_netgame_rate(g, false);
    if (player->display_hz > 0)
        displays = ll_freq_from_hz(player->display_hz);
    bool together = player->display_hz == 0 && ticks == displays && !sync->answers;
    return (ll_client_setup){.game = ll_netgame_game(g),
                             .env = &g->env,
                             .sync = sync,
                             .config = player,
                             .display_freq = together ? 0 : displays,
                             .client_metrics = ll_netgame_client_metrics(g, i),
                             .recorder = recorder,
                             .rules = &g->config.server,
                             .weapon_prediction = ll_netgame_weapon_prediction(g, i),
                             .shots = ll_netgame_shots(g),
                             .seed = (uint64_t)g->config.head.seed};
}

/* Where a position or speed is not finite. */
typedef struct divergence {
    int entity;
    int viewer; /* the player in whose view; -1: in the server's world */
} divergence;

static double sum_of(const ll_entity *e)
{
    return e->x + e->y + e->vx + e->vy + e->angle + e->angular_velocity;
}

static bool is_finite(double x)
{
    return x - x == 0; /* false for infinity and NaN */
}

static bool finite_world(const ll_world *world, int *entity)
{
    double all = 0;
    for (int i = 0; i < world->entities; i++)
        all += sum_of(&world->entity[i]);
    if (is_finite(all))
        return true;
    for (int i = 0; i < world->entities; i++)
        if (!is_finite(sum_of(&world->entity[i]))) {
            *entity = i;
            return false;
        }
    return true; /* each is, their sum is not */
}

static ll_status not_finite(const ll_netgame *g, divergence where)
{
    char name[LL_NAME_MAX + 16], view[LL_NAME_MAX + 32] = "";
    if (where.entity < g->config.player_count)
        snprintf(name, sizeof name, "player %s", g->config.players[where.entity].name);
    else
        snprintf(name, sizeof name, "entity %d", where.entity);
    if (where.viewer >= 0)
        snprintf(view, sizeof view, " in the view of player %s", g->config.players[where.viewer].name);
    return ll_error(LL_DIVERGED, "the position or speed of %s%s is not finite at step %lld (%.6f s)", name,
                    view, (long long)ll_netgame_server(g)->step, ll_to_s(g->now));
}

/* A step in which shots are judged. */
static void step_armed(ll_netgame *g)
{
    ll_server *server = ll_netgame_server(g);
    ll_past past = {.history = ll_netgame_history(g),
                    .rules = &g->config.server.compensation,
                    .buffer = 2 * ll_tick_time(1, server->updates.freq),
                    .witness = ll_netgame_record_shot,
                    .context = g};
    ll_netgame_sync(g)->step(server, ll_netgame_game(g), &g->env, &past, g->now);
}

/* False when the world has diverged, at `where`. */
static bool server_steps(ll_netgame *g, const ll_recorder *r, divergence *where)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_server *server = ll_netgame_server(g);
    ll_time before = server->stepped;
    if (ll_netgame_shots(g))
        step_armed(g);
    else
        sync->step(server, ll_netgame_game(g), &g->env, NULL, g->now);
    where->viewer = -1;
    if (!finite_world(ll_server_world(server), &where->entity))
        return false;
    ll_netgame_watch_players(g, g->now - before);
    for (int i = 0; i < server->players && g->now < ll_netgame_client_metrics(g, i)->from; i++)
        ll_netgame_client_metrics(g, i)->input_history.starved_before =
            server->client_slots[i].counts.starved;
    ll_history_add(ll_netgame_history(g), g->now, ll_server_world(server));
    ll_netgame_observe_step(g);
    if (ll_netgame_shots(g))
        ll_shots_step(ll_netgame_shots(g), server->step, ll_netgame_history(g));
    if (r)
        ll_netgame_record(
            r, (ll_event){
                   .type = LL_EVENT_STEP, .begin = g->now, .end = g->now, .number = (uint32_t)server->step});
    if (sync->server_steps_at_update_hz)
        ll_netgame_update(g, r);
    return true;
}

static void client_ticks(ll_netgame *g, int player, const ll_client_setup *s)
{
    ll_client *client = ll_netgame_client(g, player);
    _Alignas(8) char packet[LL_NETGAME_PACKET_MAX];
    int bytes = s->sync->tick(client, s, g->now, packet);
    ll_netgame_watch_tick(g, player, s);
    ll_client_set_timer(client, s, g->now);
    for (; bytes > 0; bytes = ll_client_held(client, s, g->now, packet))
        ll_netgame_send(g, player, true, packet, bytes, s->recorder);
    if (s->sync->observe)
        s->sync->observe(ll_netgame_desync(g, player), client, s, ll_netgame_server(g));
}

/* Whether the display that was just made shows a snapshot for the first time, or, where displays are apart
 * from ticks, a predicted input. */
static bool shows_news(const ll_client *client, const ll_client_setup *s, ll_time now)
{
    ll_time before = now - client->displays.elapsed;
    if (s->sync->observe || client->snapshots.received == 0)
        return false; /* a peer draws its own world */
    const ll_pending_input *input = &client->pending[client->inputs.seq & (LL_PENDING_RING - 1)];
    bool predicted = s->config->prediction && s->display_freq != 0 && input->made > before;
    return predicted ||
           ll_client_state((ll_client *)client, client->snapshots.received - 1)->arrived > before;
}

/* A client's prediction may diverge before the server does: false then. */
static bool client_displays(ll_netgame *g, int player, const ll_client_setup *s, divergence *where)
{
    ll_client *client = ll_netgame_client(g, player);
    s->sync->display(client, s, g->now);
    ll_client_set_display(client, s);
    if (s->recorder && shows_news(client, s, g->now))
        ll_netgame_record(s->recorder, (ll_event){.type = LL_EVENT_DISPLAY,
                                                  .player = (uint8_t)player,
                                                  .begin = g->now,
                                                  .end = g->now,
                                                  .number = (uint32_t)client->latest.tick});
    where->viewer = player;
    if (!finite_world(ll_client_rendered_const(client), &where->entity))
        return false;
    ll_netgame_observe_display(g, player);
    if (s->shots)
        ll_shots_frame(s->shots, &(ll_sight){ll_client_rendered_const(client), player}, g->now);
    if (player == g->config.player_count - 1)
        ll_netgame_compare_views(g, client->displays.elapsed);
    return true;
}

static bool client_acts(ll_netgame *g, int player, const ll_client_setup *s, divergence *where)
{
    ll_client *client = ll_netgame_client(g, player);
    bool ticks = client->ticks.due <= g->now,
         displays = s->display_freq == 0 ? ticks : client->displays.due <= g->now;
    ll_request_message request;
    if (ticks)
        client_ticks(g, player, s);
    bool finite = !displays || client_displays(g, player, s, where);
    ll_client_set_due(client, s);
    if (client->due > g->now)
        return finite; /* nothing is due for its connection */
    int bytes = ll_connection_poll(client, s, g->now, &request);
    if (bytes > 0)
        ll_netgame_send(g, player, true, &request, bytes, s->recorder);
    ll_client_set_due(client, s);
    return finite;
}

/* The next actor. At one instant packets come first, then the server's step, its update, and the clients: so
 * a packet that arrives at a tick counts for that tick. */
typedef enum actor {
    ACTOR_UP,
    ACTOR_DOWN,
    ACTOR_PLAYOUT,
    ACTOR_STEP,
    ACTOR_UPDATE,
    ACTOR_TEND,
    ACTOR_CLIENT
} actor;

/* Time and actor in one number: of two turns the smaller comes first. */
typedef int64_t turn;

enum { ACTORS_MAX = 8 };

static turn turn_of(ll_time time, actor who)
{
    ll_time latest = INT64_MAX / ACTORS_MAX - 1; /* stands for LL_NEVER */
    return (time < latest ? time : latest) * ACTORS_MAX + (turn)who;
}

static actor actor_of(turn t)
{
    return (actor)(t & (ACTORS_MAX - 1));
}

static ll_time time_of(turn t)
{
    return (t - (turn)actor_of(t)) / ACTORS_MAX;
}

static turn earlier(turn a, turn b)
{
    return a < b ? a : b;
}

/* Whose packets and frames come next: what a player's turn depends on. */
typedef struct seat {
    const ll_client *client;
    const ll_link *up, *down;
    const ll_dejitter *dejitter;
} seat;

/* A run without changes from outside: places and set-ups of the clients stay the same, and the next turn of
 * the server and of a player is computed again only if the last event may have changed it. */
typedef struct schedule {
    const ll_sync_mode *sync;
    const ll_server *at_server;
    turn server, player[LL_PLAYERS_MAX];
    int players;
    seat seat[LL_PLAYERS_MAX];
    ll_client_setup setup[LL_PLAYERS_MAX];
} schedule;

static turn server_turn(const schedule *now)
{
    const ll_server *server = now->at_server;
    turn next = earlier(turn_of(now->sync->due(server), ACTOR_STEP), turn_of(server->next_check, ACTOR_TEND));
    if (now->sync->server_steps_at_update_hz)
        return next;
    return earlier(next, turn_of(ll_clock_time(&server->updates, server->update), ACTOR_UPDATE));
}

static void put_earlier(ll_time *first, actor *who, ll_time time, actor other)
{
    *who = time < *first ? other : *who;
    *first = time < *first ? time : *first;
}

/* Of equal times the first in the order of actors. */
static turn player_turn(const seat *p, ll_time now)
{
    ll_time due = p->client->due, first = ll_link_next_due(p->up);
    actor who = ACTOR_UP;
    put_earlier(&first, &who, ll_link_next_due(p->down), ACTOR_DOWN);
    put_earlier(&first, &who, ll_dejitter_next_due(p->dejitter), ACTOR_PLAYOUT);
    /* a received packet may have made something due */
    put_earlier(&first, &who, due > now ? due : now, ACTOR_CLIENT);
    return turn_of(first, who);
}

static void renew_all(schedule *now, ll_time time)
{
    now->server = server_turn(now);
    for (int i = 0; i < now->players; i++)
        now->player[i] = player_turn(&now->seat[i], time);
}

static void begin_schedule(schedule *now, const ll_netgame *g, const ll_recorder *r)
{
    now->sync = ll_netgame_sync(g);
    now->at_server = ll_netgame_server(g);
    now->players = g->config.player_count;
    for (int i = 0; i < now->players; i++) {
        now->seat[i] = (seat){ll_netgame_client(g, i), ll_netgame_up(g, i), ll_netgame_down(g, i),
                              ll_netgame_dejitter(g, i)};
        now->setup[i] = ll_netgame_client_setup(g, i, r);
    }
    renew_all(now, g->now);
}

/* After a turn of `player` at `time`; -1: of the server. */
static void renew(schedule *now, ll_time time, int player, actor done)
{
    if (player >= 0) {
        now->player[player] = player_turn(&now->seat[player], time);
        if (done == ACTOR_UP && now->sync->steps_by_inputs)
            now->server = server_turn(now);
    } else if (done == ACTOR_STEP && !now->sync->server_steps_at_update_hz) {
        now->server = server_turn(now);
    } else {
        renew_all(now, time); /* it has sent to all players */
    }
}

/* -1: the server is next. Of players with equal turns, the first. */
static int next_turn(const schedule *now, turn *next)
{
    int player = -1;
    *next = now->server;
    for (int i = 0; i < now->players; i++)
        if (now->player[i] < *next) {
            *next = now->player[i];
            player = i;
        }
    return player;
}

/* False when a world has diverged, at `where`. */
static bool take_turn(ll_netgame *g, actor who, int player, const ll_client_setup *s, const ll_recorder *r,
                      divergence *where)
{
    switch (who) {
    case ACTOR_UP:
        ll_netgame_deliver_up(g, player, r);
        break;
    case ACTOR_DOWN:
        ll_netgame_deliver_down(g, player, s);
        break;
    case ACTOR_PLAYOUT:
        ll_netgame_deliver_held(g, player, s);
        break;
    case ACTOR_STEP:
        return server_steps(g, r, where);
    case ACTOR_UPDATE:
        ll_netgame_update(g, r);
        ll_netgame_server(g)->update++;
        break;
    case ACTOR_TEND:
        ll_netgame_check_connections(g, r);
        break;
    case ACTOR_CLIENT:
        return client_acts(g, player, s, where);
    }
    return true;
}

ll_status ll_netgame_run_until(ll_netgame *g, ll_time until, const ll_recorder *r, ll_pace *pace)
{
    schedule now;
    divergence where = {0, -1};
    begin_schedule(&now, g, r);
    for (;;) {
        turn next;
        int player = next_turn(&now, &next);
        if (time_of(next) > until)
            break;
        if (!ll_goes_on(pace))
            return ll_error(LL_INTERRUPTED, "a tick was interrupted");
        if (time_of(next) > g->now) /* otherwise a live change has brought it forward */
            g->now = time_of(next);
        if (!take_turn(g, actor_of(next), player, &now.setup[player < 0 ? 0 : player], r, &where))
            return not_finite(g, where);
        renew(&now, g->now, player, actor_of(next));
    }
    g->now = until;
    return ll_ok();
}

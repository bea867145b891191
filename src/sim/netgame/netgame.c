#include "sim/netgame/netgame.h"

#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "base/hash.h"
#include "netcode/client/cheat.h"
#include "sim/core/scenario_rows.h"
#include "sim/netgame/parts.h"

#define LINK_SECONDS 1.3    /* of packets at full rate that a link holds; more would overflow its queue */
#define DEJITTER_PACKETS 64 /* half a second at the highest rate */

/* ---- layout ---- */

static int up_slots(const ll_netgame_config *c)
{
    return (int)(c->tick_hz * LINK_SECONDS) + 32;
}

static int down_slots(const ll_netgame_config *c)
{
    (void)c;
    return (int)((128 + 32) * LINK_SECONDS); /* updates, and answers to pings */
}

/* Peers send all open inputs. After a change to a peer-to-peer sync during a game, links hold fewer of these
 * longest packets: other configurations need not pay for them. */
static bool among_peers(const ll_netgame_config *c)
{
    return ll_syncs[c->server.sync]->observe != NULL;
}

static int up_arena(const ll_netgame_config *c)
{
    int states = ll_input_message_size(LL_INPUTS_MAX) + 16;
    int peers = among_peers(c) ? ll_peer_message_max(c->player_count) : 0;
    return up_slots(c) * (peers > states ? peers : states);
}

static ll_extent extent(const ll_netgame_config *c)
{
    return ll_games[c->game]->extent(c->params, c->player_count);
}

static int down_arena(const ll_netgame_config *c)
{
    int state = ll_server_message_max(extent(c), c->player_count);
    int relay = among_peers(c) ? ll_relay_message_max(c->player_count) : 0;
    return down_slots(c) * (relay > state ? relay : state);
}

/* False in a game without weapons. */
static bool arena_of(const ll_netgame_config *c, ll_arena *arena)
{
    const ll_game *game = ll_games[c->game];
    ll_game_env env = {.dt = 1 / c->tick_hz};
    if (!game->weapons)
        return false;
    game->prepare(&env, c->params);
    game->weapons->arena(&env, c->player_count, arena);
    return true;
}

/* Of the configuration that a block contains. */
static size_t config_size(const ll_netgame_config *c)
{
    return offsetof(ll_netgame_config, players) + (size_t)c->player_count * sizeof c->players[0];
}

/* Computes the offsets of all parts; with a NULL block only the size. */
static int64_t lay_out(ll_netgame *g, const ll_netgame_config *c)
{
    int n = c->player_count;
    ll_extent world = extent(c);
    ll_netgame counted, *at = g ? g : &counted;
    int64_t end = (int64_t)(offsetof(ll_netgame, config) + config_size(c));
    at->server = end;
    end += (int64_t)ll_server_size(n, world);
    at->history = end;
    end += (int64_t)ll_history_size(world.entities);
    ll_arena arena;
    bool armed = arena_of(c, &arena);
    at->shots = armed ? end : 0;
    end += armed ? (int64_t)ll_shots_size(n, arena.bodies) : 0;
    for (int i = 0; i < n; i++) {
        at->at[i].client = end;
        end += (int64_t)ll_client_size(world);
        at->at[i].up = end;
        end += (int64_t)ll_link_size(up_slots(c), up_arena(c));
        at->at[i].down = end;
        end += (int64_t)ll_link_size(down_slots(c), down_arena(c));
        at->at[i].dejitter = end;
        end += (int64_t)ll_dejitter_size(DEJITTER_PACKETS);
        at->at[i].client_metrics = end;
        end += (int64_t)ll_client_metrics_size(world.entities);
        at->at[i].desync = end;
        end += (int64_t)ll_desync_size(ll_extent_size(world));
        at->at[i].weapon_prediction = armed ? end : 0;
        end += armed ? (int64_t)sizeof(ll_weapon_prediction) : 0;
    }
    return end;
}

static size_t size(const void *config)
{
    return (size_t)lay_out(NULL, config);
}

/* ---- start ---- */

static ll_freq rate(const ll_netgame *g, bool at_update_hz)
{
    return ll_freq_from_hz(at_update_hz ? g->config.server.update_hz : g->config.tick_hz);
}

static ll_client_setup setup(const ll_netgame *g, int i, const ll_recorder *recorder)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    const ll_player_config *player = &g->config.players[i];
    ll_freq ticks = rate(g, sync->client_steps_at_update_hz), displays = rate(g, false);
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

static void start_server(ll_netgame *g, ll_time now)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_freq client_freq = rate(g, sync->client_steps_at_update_hz);
    g->env.dt = 1000.0 / (double)client_freq;
    g->env.dt_ns = ll_tick_time(1, client_freq);
    ll_netgame_game(g)->prepare(&g->env, g->config.params);
    ll_server_start(ll_netgame_server(g), rate(g, sync->server_steps_at_update_hz), rate(g, true),
                    client_freq, now);
}

/* All clients resync: the game starts, or restarts in another sync mode. All clocks start, and packets in
 * flight are discarded. Players who are not connected join later. */
static void begin_game(ll_netgame *g, ll_time now)
{
    ll_server *server = ll_netgame_server(g);
    start_server(g, now);
    for (int i = 0; i < server->players; i++) {
        ll_client_setup s = setup(g, i, NULL);
        ll_client_start(ll_netgame_client(g, i), &s, server->epoch, server->client_freq, server->step,
                        ll_server_world(server), now);
        ll_desync_start(ll_netgame_desync(g, i), server->step);
        ll_client_metrics_resync(ll_netgame_client_metrics(g, i));
        ll_twin_resync(&ll_netgame_client_metrics(g, i)->twin, ll_netgame_client(g, i)->inputs.tick);
        if (s.weapon_prediction)
            ll_weapon_prediction_start(ll_netgame_client(g, i), &s);
    }
}

static ll_status run_until(ll_netgame *g, ll_time until, const ll_recorder *r, ll_pace *pace);
#define SCREEN_PX 1920 /* as wide as the scene */

static void see_through_screen(ll_netgame *g, int player)
{
    ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    ll_game_scene scene = ll_netgame_game(g)->scene(&g->env, g->config.player_count);
    in->corrections.pixel_m = (scene.x_max - scene.x_min) / SCREEN_PX;
    in->changes.others = ((UINT32_C(1) << g->config.player_count) - 1) & ~(UINT32_C(1) << player);
}

static ll_status init(void *block, const void *config)
{
    ll_netgame *g = block;
    const ll_netgame_config *c = config;
    int n = c->player_count;
    memset(block, 0, size(config));
    memcpy(&g->config, c, config_size(c));
    ll_scenario_head_strip(&g->config.head);
    g->size = lay_out(g, c);

    const ll_game *game = ll_netgame_game(g);
    ll_extent size_of_world = extent(c);
    LL_ASSERT(ll_server_message_max(size_of_world, n) <= LL_NETGAME_PACKET_MAX);
    ll_server *server = ll_netgame_server(g);
    ll_server_init(server, n, size_of_world);
    ll_server_configure(server, &c->server);
    server->from = (ll_time)(c->warmup_s * 1e9);
    ll_world *world = ll_server_world(server);
    int32_t lanes[LL_PLAYERS_MAX];
    for (int i = 0; i < n; i++)
        lanes[i] = c->players[i].lane < 0 ? i : (int32_t)c->players[i].lane;
    g->env.dt = 1 / c->tick_hz;
    game->prepare(&g->env, c->params);
    game->init(world, &g->env, lanes);
    ll_history_init(ll_netgame_history(g), world->entities);
    ll_history_add(ll_netgame_history(g), 0, world);
    for (int i = 0; i < n; i++) {
        uint64_t stream = (uint64_t)i * 2;
        ll_client_init(ll_netgame_client(g, i), i, world);
        ll_link_init(ll_netgame_up(g, i), up_slots(c), up_arena(c), (uint64_t)c->head.seed, stream);
        ll_link_init(ll_netgame_down(g, i), down_slots(c), down_arena(c), (uint64_t)c->head.seed, stream + 1);
        ll_dejitter_init(ll_netgame_dejitter(g, i), DEJITTER_PACKETS);
        ll_client_metrics_init(ll_netgame_client_metrics(g, i), world->entities,
                               (ll_time)(c->warmup_s * 1e9));
        ll_cheat_gain_watch(&ll_netgame_client_metrics(g, i)->gain, &world->entity[i]);
        see_through_screen(g, i);
        ll_twin_watch(&ll_netgame_client_metrics(g, i)->twin, &world->entity[i], 0);
    }
    ll_arena arena;
    if (arena_of(c, &arena))
        ll_shots_init(ll_netgame_shots(g), &arena, (ll_time)(c->warmup_s * 1e9));
    start_server(g, 0);
    server->next_check = g->now = -LL_LOBBY;
    ll_status status = run_until(g, -1, NULL, NULL);
    for (int i = 0; i < n; i++) {
        ll_link_restart_stats(ll_netgame_up(g, i));
        ll_link_restart_stats(ll_netgame_down(g, i));
    }
    begin_game(g, 0);
    return status;
}

static ll_freq tick_freq(const void *config)
{
    return ll_freq_from_hz(((const ll_netgame_config *)config)->tick_hz);
}

static void settle(void *config, const void *before)
{
    ll_netgame_config *c = config;
    const ll_netgame_config *b = before;
    for (int i = 0; i < c->player_count; i++) {
        ll_player_apply_dependencies(&c->players[i], &b->players[i]);
        if (c->players[i].name[0] == '\0')
            c->players[i].name[0] = (char)('A' + i);
    }
}

/* ---- time ---- */

/* Where a position or speed is not finite. */
typedef struct divergence {
    int entity;
    int viewer; /* the player in whose view; -1: in the server's world */
} divergence;

static bool finite_world(const ll_world *world, int *entity)
{
    for (int i = 0; i < world->entities; i++) {
        const ll_entity *e = &world->entity[i];
        double sum = e->x + e->y + e->vx + e->vy + e->angle + e->angular_velocity;
        if (sum - sum != 0) { /* true for infinity and NaN */
            *entity = i;
            return false;
        }
    }
    return true;
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

/* A client's prediction may diverge before the server does: false then. */
static bool client_displays(ll_netgame *g, int player, const ll_client_setup *s, divergence *where)
{
    ll_client *client = ll_netgame_client(g, player);
    s->sync->display(client, s, g->now);
    ll_client_set_display(client, s);
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

static turn server_turn(const ll_netgame *g)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    const ll_server *server = ll_netgame_server(g);
    turn next = earlier(turn_of(sync->due(server), ACTOR_STEP), turn_of(server->next_check, ACTOR_TEND));
    if (sync->server_steps_at_update_hz)
        return next;
    return earlier(next, turn_of(ll_clock_time(&server->updates, server->update), ACTOR_UPDATE));
}

static turn player_turn(const ll_netgame *g, int i)
{
    ll_time due = ll_netgame_client(g, i)->due; /* a received packet may have made something due */
    turn up = turn_of(ll_link_next_due(ll_netgame_up(g, i)), ACTOR_UP);
    turn down = turn_of(ll_link_next_due(ll_netgame_down(g, i)), ACTOR_DOWN);
    turn held = turn_of(ll_dejitter_next_due(ll_netgame_dejitter(g, i)), ACTOR_PLAYOUT);
    turn client = turn_of(due > g->now ? due : g->now, ACTOR_CLIENT);
    return earlier(earlier(up, down), earlier(held, client));
}

/* A run without changes from outside: the set-ups of the clients stay the same, and the next turn of the
 * server and of a player is computed again only if the last event may have changed it. */
typedef struct schedule {
    turn server, player[LL_PLAYERS_MAX];
    ll_client_setup setup[LL_PLAYERS_MAX];
} schedule;

static void renew_all(schedule *now, const ll_netgame *g)
{
    now->server = server_turn(g);
    for (int i = 0; i < g->config.player_count; i++)
        now->player[i] = player_turn(g, i);
}

/* After a turn of `player`; -1: of the server. */
static void renew(schedule *now, const ll_netgame *g, int player, actor done)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    if (player >= 0) {
        now->player[player] = player_turn(g, player);
        if (done == ACTOR_UP && sync->steps_by_inputs)
            now->server = server_turn(g);
    } else if (done == ACTOR_STEP && !sync->server_steps_at_update_hz) {
        now->server = server_turn(g);
    } else {
        renew_all(now, g); /* it has sent to all players */
    }
}

/* -1: the server is next. Of players with equal turns, the first. */
static int next_turn(const schedule *now, const ll_netgame *g, turn *next)
{
    int player = -1;
    *next = now->server;
    for (int i = 0; i < g->config.player_count; i++)
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

static ll_status run_until(ll_netgame *g, ll_time until, const ll_recorder *r, ll_pace *pace)
{
    schedule now;
    divergence where = {0, -1};
    for (int i = 0; i < g->config.player_count; i++)
        now.setup[i] = setup(g, i, r);
    renew_all(&now, g);
    for (;;) {
        turn next;
        int player = next_turn(&now, g, &next);
        if (time_of(next) > until)
            break;
        if (!ll_goes_on(pace))
            return ll_error(LL_INTERRUPTED, "a tick was interrupted");
        if (time_of(next) > g->now) /* otherwise a live change has brought it forward */
            g->now = time_of(next);
        if (!take_turn(g, actor_of(next), player, &now.setup[player < 0 ? 0 : player], r, &where))
            return not_finite(g, where);
        renew(&now, g, player, actor_of(next));
    }
    g->now = until;
    return ll_ok();
}

static ll_status advance(void *block, ll_time until, const ll_recorder *r, ll_step_profiler *step_profiler,
                         const ll_interrupt *interrupt)
{
    ll_pace pace = ll_pace_by(interrupt);
    (void)step_profiler;
    return run_until(block, until, r, &pace);
}

static ll_time stands_at(const void *block)
{
    return ((const ll_netgame *)block)->now;
}

/* ---- commands ---- */

static void change(void *block, const void *config, ll_time now)
{
    ll_netgame *g = block;
    ll_server_config before = g->config.server;
    ll_netgame_watch_cheats_begin(g, config);
    memcpy(&g->config, config, config_size(config));
    ll_scenario_head_strip(&g->config.head);
    ll_server_configure(ll_netgame_server(g), &g->config.server);
    const ll_sync_mode *sync = ll_netgame_sync(g);
    bool other_rate = before.update_hz != g->config.server.update_hz;
    if (before.sync != g->config.server.sync || (other_rate && sync->server_steps_at_update_hz)) {
        begin_game(g, now);
    } else if (other_rate) {
        ll_server *server = ll_netgame_server(g);
        server->updates = (ll_clock){now, 0, rate(g, true)};
        server->update = 1;
    }
}

static ll_status accepts(const void *config, int player, const ll_action *action)
{
    const ll_netgame_config *c = config;
    if (player < 0 || player >= c->player_count)
        return ll_field_error(LL_BAD_INPUT, "player", "player: must be 0 to %d; got %d", c->player_count - 1,
                              player);
    for (int i = 0; i < 2; i++)
        if (!(action->axis[i] >= -1 && action->axis[i] <= 1))
            return ll_field_error(LL_BAD_INPUT, "axes", "axes: must be -1 to 1; got %g",
                                  (double)action->axis[i]);
    if (c->players[player].control != LL_CONTROL_PERSON)
        return ll_error(LL_CONFLICT,
                        "player %s is driven by a script; set players.%d.control to person first",
                        c->players[player].name, player);
    return ll_ok();
}

static void input(void *block, int player, const ll_action *action)
{
    ll_netgame_client(block, player)->inputs.held = *action;
}

static ll_action controls(const void *block, int player)
{
    return ll_netgame_client_metrics(block, player)->controls;
}

static uint64_t hash(const void *block)
{
    return ll_hash(0, block, (size_t)((const ll_netgame *)block)->size);
}

const ll_sim_kind ll_sim_netgame = {
    .name = "netgame",
    .help = "A game over a network: server, clients and links.",
    .table = &ll_netgame_table,
    .size = size,
    .init = init,
    .settle = settle,
    .tick_freq = tick_freq,
    .advance = advance,
    .stands_at = stands_at,
    .change = change,
    .accepts = accepts,
    .input = input,
    .controls = controls,
    .hash = hash,
    .state = ll_netgame_state,
    .metrics = ll_netgame_metrics,
    .metric_tables = ll_netgame_metric_tables,
    .notices = ll_netgame_notices,
    .layout = ll_netgame_layout,
    .records = ll_netgame_records,
    .fill = ll_netgame_fill,
    .trace_columns = ll_netgame_trace_columns,
    .trace_row = ll_netgame_trace_row,
};

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
        at->at[i].weapon_prediction = armed ? end : 0;
        end += armed ? (int64_t)sizeof(ll_weapon_prediction) : 0;
    }
    at->observed = end;
    for (int i = 0; i < n; i++) {
        at->at[i].client_metrics = end;
        end += (int64_t)ll_client_metrics_size(world.entities);
        at->at[i].desync = end;
        end += (int64_t)ll_desync_size(ll_extent_size(world));
    }
    return end;
}

static size_t size(const void *config)
{
    return (size_t)lay_out(NULL, config);
}

/* ---- start ---- */

static void start_server(ll_netgame *g, ll_time now)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_freq client_freq = ll_netgame_rate(g, sync->client_steps_at_update_hz);
    g->env.dt = 1000.0 / (double)client_freq;
    g->env.dt_ns = ll_tick_time(1, client_freq);
    ll_netgame_game(g)->prepare(&g->env, g->config.params);
    ll_server_start(ll_netgame_server(g), ll_netgame_rate(g, sync->server_steps_at_update_hz),
                    ll_netgame_rate(g, true), client_freq, now);
}

/* All clients resync: the game starts, or restarts in another sync mode. All clocks start, and packets in
 * flight are discarded. Players who are not connected join later. */
static void begin_game(ll_netgame *g, ll_time now)
{
    ll_server *server = ll_netgame_server(g);
    start_server(g, now);
    for (int i = 0; i < server->players; i++) {
        ll_client_setup s = ll_netgame_client_setup(g, i, NULL);
        ll_client_begin begin = {.epoch = server->epoch,
                                 .freq = server->client_freq,
                                 .step = server->step,
                                 .world = ll_server_world(server)};
        ll_client_start(ll_netgame_client(g, i), &s, &begin, now);
        ll_desync_start(ll_netgame_desync(g, i), server->step);
        ll_client_metrics_resync(ll_netgame_client_metrics(g, i));
        ll_honest_resync(&ll_netgame_client_metrics(g, i)->honest, ll_netgame_client(g, i)->inputs.tick);
        if (s.weapon_prediction)
            ll_weapon_prediction_start(ll_netgame_client(g, i), &s);
    }
}

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
        ll_honest_watch(&ll_netgame_client_metrics(g, i)->honest, &world->entity[i], 0);
    }
    ll_arena arena;
    if (arena_of(c, &arena))
        ll_shots_init(ll_netgame_shots(g), &arena, (ll_time)(c->warmup_s * 1e9));
    start_server(g, 0);
    server->next_check = g->now = -LL_LOBBY;
    ll_status status = ll_netgame_run_until(g, -1, NULL, NULL);
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

enum { SHORT_ROUNDS = 32 }; /* more than the events of a tick of few players, each some microseconds */

static ll_status advance(void *block, ll_time until, const ll_recorder *r, ll_step_profiler *step_profiler,
                         const ll_interrupt *interrupt, ll_team *team)
{
    (void)team;
    ll_pace pace = ll_pace_by(interrupt, SHORT_ROUNDS);
    (void)step_profiler;
    return ll_netgame_run_until(block, until, r, &pace);
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
        server->updates = (ll_clock){now, 0, ll_netgame_rate(g, true)};
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

/* Of what is simulated. What is observed of it follows from that, and depends on what is asked for. */
static uint64_t hash(const void *block)
{
    return ll_hash(0, block, (size_t)((const ll_netgame *)block)->observed);
}

static void observe(void *block, uint32_t what)
{
    const ll_netgame *g = block;
    for (int i = 0; i < g->config.player_count; i++)
        ll_netgame_client_metrics(g, i)->observes = what;
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
    .observed_for = ll_netgame_observed_for,
    .observe = observe,
    .state = ll_netgame_state,
    .metrics = ll_netgame_metrics,
    .metric_tables = ll_netgame_metric_tables,
    .notices = ll_netgame_notices,
    .layout = ll_netgame_layout,
    .records = ll_netgame_records,
    .fill = ll_netgame_fill,
    .trace_tables = ll_netgame_trace_tables,
    .trace = ll_netgame_trace,
};

#include "sim/netgame/netgame.h"

#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "base/hash.h"
#include "base/prefetch.h"
#include "netcode/client/cheat.h"
#include "netcode/protocol/bucket.h"
#include "sim/core/scenario_rows.h"
#include "sim/netgame/parts.h"
#include "sim/netgame/transport.h"

#define LINK_SECONDS 1.3    /* of packets at full rate that a link holds; more would overflow its queue */
#define DEJITTER_PACKETS 64 /* half a second at the highest rate */

/* ---- layout ---- */

/* Whether messages are packets. */
static bool plain(const ll_netgame_config *c)
{
    return ll_transport_plain(c->server.transport);
}

static ll_transport_setup transport_of(const ll_netgame_config *c);

/* Whether snapshots contain some of the entities. */
static bool selects(const ll_netgame_config *c)
{
    return ll_codecs[c->server.snapshot]->selects;
}

/* Of the messages of its ticks that a client sends over a mesh. */
static int copies(const ll_netgame_config *c)
{
    bool meshed = c->peers.topology == LL_TOPOLOGY_MESH && c->player_count > 1;
    return meshed ? c->player_count - 1 : 0;
}

static int ticks_on_link(const ll_netgame_config *c)
{
    return (int)(c->tick_hz * LINK_SECONDS);
}

static int up_slots(const ll_netgame_config *c)
{
    ll_transport_setup setup = transport_of(c);
    int each = copies(c) > 0 ? copies(c) : 1;
    return plain(c) ? each * ticks_on_link(c) + 32 : ll_transport_link_slots(&setup, LL_CLIENT_SIDE);
}

/* Updates, and answers to pings. Next to a transport's packets the de-jitter buffer keeps its messages. */
static int down_slots(const ll_netgame_config *c)
{
    ll_transport_setup setup = transport_of(c);
    return plain(c) ? (int)((128 + 32) * LINK_SECONDS) + copies(c) * ticks_on_link(c)
                    : ll_transport_link_slots(&setup, LL_SERVER_SIDE) + DEJITTER_PACKETS;
}

/* Peers send all open inputs. After a change to a peer-to-peer sync during a game, links hold fewer of these
 * longest packets: other configurations need not pay for them. */
static bool among_peers(const ll_netgame_config *c)
{
    return ll_syncs[c->server.sync]->observe != NULL || copies(c) > 0;
}

static int up_arena(const ll_netgame_config *c)
{
    int states = ll_input_message_size(LL_INPUTS_MAX) +
                 (ll_netgame_config_reports(c) ? (int)sizeof(ll_motion) : 0) + 16;
    int peers = among_peers(c) ? ll_peer_message_max(c->player_count) : 0;
    ll_transport_setup setup = transport_of(c);
    return plain(c) ? up_slots(c) * (peers > states ? peers : states)
                    : ll_transport_link_arena(&setup, LL_CLIENT_SIDE);
}

static ll_extent extent(const ll_netgame_config *c)
{
    return ll_games[c->game]->extent(c->params, c->player_count);
}

/* Whether clients note which entities their newest snapshots contain. */
static bool notes_recent(const ll_netgame_config *c)
{
    return selects(c) && c->reckoning.model == 0;
}

/* Of a snapshot, in bytes. */
static int longest_state(const ll_netgame_config *c)
{
    enum { BESIDE = 128 }; /* more than the own entity and a grid, which the limit may not hold */
    int64_t bytes = c->server.selection.bytes, whole = ll_server_message_max(extent(c), c->player_count);
    int64_t limited = whole - (int64_t)ll_extent_size(extent(c)) + extent(c).tail + bytes + BESIDE;
    int64_t extra = c->reckoning.model != 0 ? ll_reckoning_extra_bits(extent(c).entities) / 8 + 1 : 0;
    return (int)(selects(c) && bytes > 0 && limited < whole ? limited : whole + extra);
}

static int down_arena(const ll_netgame_config *c)
{
    int state = longest_state(c);
    int relay = among_peers(c) ? ll_relay_message_max(c->player_count) : 0;
    ll_transport_setup setup = transport_of(c);
    int passing = copies(c) * ticks_on_link(c), own = down_slots(c) - passing;
    return plain(c) ? own * (relay > state ? relay : state) + passing * ll_peer_message_max(c->player_count)
                    : ll_transport_link_arena(&setup, LL_SERVER_SIDE) + DEJITTER_PACKETS * state;
}

/* For the longest messages of any sync mode, since that may change. */
static ll_transport_setup transport_of(const ll_netgame_config *c)
{
    int inputs = ll_input_message_size(LL_INPUTS_MAX) + (selects(c) ? (int)sizeof(uint32_t) : 0) +
                 (ll_netgame_config_reports(c) ? (int)sizeof(ll_motion) : 0),
        peers = ll_peer_message_max(c->player_count);
    int state = longest_state(c), relay = ll_relay_message_max(c->player_count);
    return ll_netgame_transport_setup(c, peers > inputs ? peers : inputs, relay > state ? relay : state);
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

static ll_shelf_setup shelf_of(const ll_netgame_config *c)
{
    return (ll_shelf_setup){.profiles = c->profiles,
                            .count = c->profile_count,
                            .ways = 2 * c->player_count,
                            .bottleneck = &c->bottleneck,
                            .seed = (uint64_t)c->head.seed};
}

/* Whether the policies have other parameters than the defaults. */
static bool tuned(const ll_netgame_config *c)
{
    return memcmp(&c->policies, &ll_policy_defaults, sizeof c->policies) != 0;
}

/* Computes the offsets of all parts; with a NULL block only the size. */
static int64_t lay_out(ll_netgame *g, const ll_netgame_config *c)
{
    int n = c->player_count;
    ll_extent world = extent(c);
    ll_netgame counted, *at = g ? g : &counted;
    const ll_shelf_setup shelf = shelf_of(c);
    int64_t end = (int64_t)ll_netgame_head_size(c);
    end += (int64_t)ll_profile_shelf_size(&shelf);
    at->server = end;
    end += (int64_t)ll_server_size(n, world);
    end += selects(c) ? (int64_t)ll_replicas_size(n, world.entities) : 0;
    at->history = end;
    end += (int64_t)ll_history_size(world.entities);
    end += ll_netgame_config_reports(c) ? (int64_t)ll_netgame_reports_size(n) : 0;
    ll_arena arena;
    bool armed = arena_of(c, &arena), carried = !plain(c);
    ll_transport_setup setup = transport_of(c);
    at->shots = armed ? end : 0;
    end += armed ? (int64_t)ll_shots_size(n, arena.bodies) : 0;
    for (int i = 0; i < n; i++) {
        ll_netgame_parts unused, *parts = g ? ll_netgame_parts_of(g, i) : &unused;
        parts->client = end;
        end += (int64_t)ll_client_size(world);
        parts->up = end;
        end += (int64_t)ll_link_size(up_slots(c), up_arena(c));
        parts->down = end;
        end += (int64_t)ll_link_size(down_slots(c), down_arena(c));
        parts->dejitter = end;
        end += (int64_t)ll_dejitter_size(DEJITTER_PACKETS);
        parts->weapon_prediction = armed ? end : 0;
        end += armed ? (int64_t)sizeof(ll_weapon_prediction) : 0;
        parts->transport = carried ? end : 0;
        end += carried ? (int64_t)ll_transport_size(&setup) : 0;
    }
    end += ll_peers_choices(&c->peers) != 0 ? n * (int64_t)sizeof(ll_peer_choices) : 0;
    end += c->server.detection ? n * (int64_t)sizeof(ll_detection) : 0;
    end += c->reckoning.model != 0 ? (int64_t)ll_reckoning_size(n, world.entities) : 0;
    end += tuned(c) ? (int64_t)sizeof(ll_policy_params) : 0;
    at->observed = end;
    for (int i = 0; i < n; i++) {
        ll_netgame_parts unused, *parts = g ? ll_netgame_parts_of(g, i) : &unused;
        parts->client_metrics = end;
        end += (int64_t)ll_client_metrics_size(world.entities);
        parts->desync = end;
        end += (int64_t)ll_desync_size(ll_extent_size(world));
        end += selects(c) ? (int64_t)sizeof(ll_nearness) : 0;
        parts->transport_metrics = carried ? end : 0;
        end += carried ? (int64_t)sizeof(ll_transport_metrics) : 0;
    }
    return end;
}

static size_t size(const void *config)
{
    ll_arena arena;
    size_t behind = 0;
    if (arena_of(config, &arena)) {
        behind = ll_behind_cover_size(arena.players);
        behind += arena.projectile_drag > 0 ? ll_drag_neglect_size(arena.players) : 0;
        if (((const ll_netgame_config *)config)->server.detection)
            behind += (size_t)arena.players * sizeof(ll_aim_watch);
    }
    if (notes_recent(config))
        behind += (size_t)((const ll_netgame_config *)config)->player_count * sizeof(ll_recent);
    return (size_t)lay_out(NULL, config) + behind;
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
    if (sync->buckets)
        ll_netgame_server(g)->clock.epoch += ll_bucket_phase(g->config.bucket_delay_ms, client_freq);
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
    const uint64_t all = UINT64_MAX >> (64 - g->config.player_count);
    in->changes.others = (uint32_t)(all & ~(UINT64_C(1) << player));
}

/* Where messages are not packets. */
static void init_transports(ll_netgame *g)
{
    const ll_transport_setup setup = transport_of(&g->config);
    for (int i = 0; i < g->config.player_count && ll_netgame_transport(g, i); i++) {
        ll_transport_init(ll_netgame_transport(g, i), &setup, -LL_LOBBY);
        ll_transport_metrics_init(ll_netgame_transport_metrics_of(g, i));
    }
}

static void copy_config(ll_netgame *g, const ll_netgame_config *c)
{
    memcpy(&g->config, c, ll_netgame_config_size(c));
    ll_scenario_head_strip(&g->config.head);
    if (!ll_netgame_sync(g)->buckets)
        g->config.bucket_delay_ms = 0; /* a parameter without effect is no part of the hash */
}

static void init_player(ll_netgame *g, const ll_netgame_config *c, int i, const ll_world *world)
{
    uint64_t stream = (uint64_t)i * 2;
    ll_client_init(ll_netgame_client(g, i), i, world);
    ll_link_init(ll_netgame_up(g, i), up_slots(c), up_arena(c), (uint64_t)c->head.seed, stream);
    ll_link_init(ll_netgame_down(g, i), down_slots(c), down_arena(c), (uint64_t)c->head.seed, stream + 1);
    ll_dejitter_init(ll_netgame_dejitter(g, i), DEJITTER_PACKETS);
    ll_client_metrics_init(ll_netgame_client_metrics(g, i), world->entities, (ll_time)(c->warmup_s * 1e9));
    ll_cheat_gain_watch(&ll_netgame_client_metrics(g, i)->gain, &world->entity[i]);
    see_through_screen(g, i);
    ll_honest_watch(&ll_netgame_client_metrics(g, i)->honest, &world->entity[i], 0);
    if (ll_netgame_detection(g))
        ll_detection_init(&ll_netgame_detection(g)[i]);
}

static void init_reports(ll_netgame *g, const ll_netgame_config *c)
{
    ll_reports *all = ll_netgame_reports(g);
    if (all)
        ll_reports_init(all, &c->reports, c->player_count);
    for (int i = 0; all && i < c->player_count; i++)
        if (c->players[i].authority == LL_AUTHORITY_POSITION)
            ll_reports_watch(all, i);
}

/* What lies behind the hashed block: the place of each depends on what is before it. */
static void init_observers(ll_netgame *g, const ll_netgame_config *c, const ll_world *world)
{
    const int n = c->player_count;
    const ll_time from = (ll_time)(c->warmup_s * 1e9);
    ll_arena arena;
    if (arena_of(c, &arena)) {
        ll_shots_init(ll_netgame_shots(g), &arena, from);
        ll_behind_cover_init(ll_netgame_behind_cover(g), n, from);
        if (ll_netgame_drag_neglect(g))
            ll_drag_neglect_init(ll_netgame_drag_neglect(g), n, from);
        for (int i = 0; i < n && ll_netgame_aim_watch(g); i++)
            ll_aim_watch_init(&ll_netgame_aim_watch(g)[i]);
    }
    for (int i = 0; i < n && ll_netgame_recent(g, i); i++)
        ll_recent_init(ll_netgame_recent(g, i), world->entities, i);
}

static ll_status init(void *block, const void *config)
{
    ll_netgame *g = block;
    const ll_netgame_config *c = config;
    int n = c->player_count;
    memset(block, 0, size(config));
    copy_config(g, c);
    g->config.server.compensation.tuned = tuned(c);
    g->config.server.reckons = c->reckoning.model != 0;
    g->config.server.peers = ll_peers_choices(&c->peers) & 127u;
    g->size = lay_out(g, c);
    if (tuned(c))
        *(ll_policy_params *)ll_netgame_policies(g) = c->policies;

    const ll_game *game = ll_netgame_game(g);
    ll_extent size_of_world = extent(c);
    LL_ASSERT(longest_state(c) <= LL_NETGAME_PACKET_MAX);
    ll_server *server = ll_netgame_server(g);
    ll_server_init(server, n, size_of_world);
    if (selects(c))
        ll_server_replicate(server);
    ll_server_configure(server, &g->config.server);
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
    for (int i = 0; i < n; i++)
        init_player(g, c, i, world);
    init_transports(g);
    init_reports(g, c);
    for (int i = 0; i < n && ll_netgame_choices(g, i); i++)
        ll_netgame_choices(g, i)->budget = c->peers.budget_ticks;
    if (ll_netgame_reckoning(g))
        ll_reckoning_init(ll_netgame_reckoning(g), &c->reckoning, n, world->entities, server->from);
    const ll_shelf_setup shelf = shelf_of(c);
    if (ll_netgame_profiles(g))
        ll_profile_shelf_init(ll_netgame_profiles(g), &shelf);
    init_observers(g, c, world);
    start_server(g, 0);
    server->next_check = g->now = -LL_LOBBY;
    ll_status status = ll_netgame_run_until(g, -1, NULL, NULL);
    for (int i = 0; i < n; i++) {
        ll_link_restart_stats(ll_netgame_up(g, i));
        ll_link_restart_stats(ll_netgame_down(g, i));
    }
    if (ll_netgame_profiles(g))
        ll_profile_shelf_restart_stats(ll_netgame_profiles(g));
    begin_game(g, 0);
    return status;
}

static ll_freq tick_freq(const void *config)
{
    return ll_freq_from_hz(((const ll_netgame_config *)config)->tick_hz);
}

/* A to Z, then AA to AZ and so on. */
static void name_player(char *name, int i)
{
    if (i >= 26)
        *name++ = (char)('A' + i / 26 - 1);
    *name++ = (char)('A' + i % 26);
    *name = '\0';
}

/* The block of a session has room for what its first encoding needs. */
static ll_status may_change(const void *config, const void *before)
{
    const ll_netgame_config *c = config, *b = before;
    if (selects(c) == selects(b))
        return ll_ok();
    return ll_field_error(
        LL_CONFLICT, "server.snapshot_encoding",
        "server.snapshot_encoding: between partial, partial_delta or interest and the others "
        "it must not change in a running session; got %s after %s",
        ll_codecs[c->server.snapshot]->name, ll_codecs[b->server.snapshot]->name);
}

static void settle(void *config, const void *before)
{
    static const ll_player_config none;
    ll_netgame_config *c = config;
    const ll_netgame_config *b = before;
    for (int i = 0; i < c->player_count; i++) {
        ll_player_apply_dependencies(&c->players[i], b ? &b->players[i] : &none);
        if (c->players[i].name[0] == '\0')
            name_player(c->players[i].name, i);
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
    const double delay_before_ms = g->config.bucket_delay_ms;
    ll_netgame_watch_cheats_begin(g, config);
    copy_config(g, config);
    g->config.server.compensation.tuned =
        before.compensation.tuned; /* fixed for a session, as the layout is */
    g->config.server.reckons = before.reckons;
    g->config.server.peers = before.peers;
    ll_server_configure(ll_netgame_server(g), &g->config.server);
    const ll_sync_mode *sync = ll_netgame_sync(g);
    bool other_rate = before.update_hz != g->config.server.update_hz;
    bool other_delay = delay_before_ms != g->config.bucket_delay_ms;
    if (before.sync != g->config.server.sync || (other_rate && sync->server_steps_at_update_hz) ||
        (other_delay && sync->buckets)) {
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

static const char *player_name(const void *config, int player)
{
    const ll_netgame_config *c = config;
    return player < c->player_count ? c->players[player].name : NULL;
}

/* ---- what a tick touches: the heads of all parts, and the places of their rings ---- */

typedef struct touched {
    const char *block;
    ll_block_range *range;
    int count;
} touched;

/* Of a large part only the first lines: the processor sees by itself how it goes on. */
static void add(touched *t, const void *from, size_t bytes)
{
    enum { BYTES_MOST = 2048 };
    bytes = bytes < BYTES_MOST ? bytes : BYTES_MOST;
    size_t at = (size_t)((const char *)from - t->block), first = at / LL_LINE,
           last = (at + bytes - 1) / LL_LINE;
    if (t->count < LL_BLOCK_RANGES_MAX && last <= UINT16_MAX)
        t->range[t->count++] = (ll_block_range){(uint16_t)first, (uint16_t)(last - first + 1)};
}

/* From the first of two members to before the second. */
#define ADD_BETWEEN(t, of, from, to)                                                                         \
    add(t, &(of)->from, (size_t)((const char *)&(of)->to - (const char *)&(of)->from))

static void add_metrics(touched *t, const ll_client_metrics *in)
{
    for (int i = 0; i < LL_METRICS; i++)
        ADD_BETWEEN(t, &in->histogram[i], unit, bucket);
    add(t, in, offsetof(ll_client_metrics, histogram));
    ADD_BETWEEN(t, in, entities, animation_error);
    ADD_BETWEEN(t, &in->animation_error, unit, bucket);
    ADD_BETWEEN(t, in, input_history.count, changes.ring);
    add(t, &in->input_history.input[in->input_history.newest & (LL_INPUT_HISTORY_RING - 1)],
        2 * sizeof in->input_history.input[0]);
    add(t, &in->gain, sizeof in->gain);
    add(t, &in->honest.newest,
        (size_t)((const char *)&in->track[in->entities] - (const char *)&in->honest.newest));
}

static void add_player(touched *t, const ll_netgame *g, int i)
{
    enum { LINK_HEAD = 384, BEHIND = 512 };
    ll_client *client = ll_netgame_client(g, i);
    const ll_client_slot *slot = &ll_netgame_server(g)->client_slots[i];
    const ll_world *world = ll_client_rendered_const(client);
    add(t, &slot->inputs.held, (size_t)((const char *)(slot + 1) - (const char *)&slot->inputs.held));
    add(t, client, offsetof(ll_client, pending));
    add(t, &client->pending[client->inputs.seq & (LL_PENDING_RING - 1)], 2 * sizeof client->pending[0]);
    add(t, client + 1, BEHIND);
    add(t, world, ll_world_size(world));
    if (client->snapshots.received > 0)
        add(t, ll_client_state(client, client->snapshots.received - 1), sizeof(ll_snapshot_entry));
    add(t, ll_netgame_up(g, i), LINK_HEAD);
    add(t, ll_netgame_down(g, i), LINK_HEAD);
    add_metrics(t, ll_netgame_client_metrics(g, i));
}

static int touches(const void *block, ll_block_range *range)
{
    const ll_netgame *g = block;
    const ll_server *server = ll_netgame_server(g);
    const ll_world *world = ll_server_world_const(server);
    const ll_history *history = ll_netgame_history(g);
    touched t = {block, range, 0};
    add(&t, g, offsetof(ll_netgame, at) + 2 * sizeof g->at[0]);
    ADD_BETWEEN(&t, &g->config, head.seed, head.title);
    add(&t, &g->config.server, sizeof g->config.server);
    add(&t, g->config.players, (size_t)g->config.player_count * sizeof g->config.players[0]);
    add(&t, server, offsetof(ll_server, hashes));
    add(&t, world, ll_world_size(world));
    add(&t, history, sizeof *history);
    add(&t, ll_history_record_at(history, history->count), 2 * LL_LINE);
    for (int i = 0; i < g->config.player_count; i++)
        add_player(&t, g, i);
    return t.count;
}

static ll_block_use use(const void *block)
{
    const ll_netgame *g = block;
    const ll_shots *shots = ll_netgame_shots(g);
    size_t judged = shots ? ll_shots_size(g->config.player_count, shots->arena.bodies) : 0;
    return (ll_block_use){.metrics = ll_netgame_bytes(g) - (size_t)g->observed + judged,
                          .histories = ll_history_size(ll_netgame_history(g)->entities)};
}

const ll_sim_kind ll_sim_netgame = {
    .name = "netgame",
    .help = "A game over a network: server, clients and links.",
    .table = &ll_netgame_table,
    .size = size,
    .init = init,
    .may_change = may_change,
    .settle = settle,
    .tick_freq = tick_freq,
    .records_events = true,
    .advance = advance,
    .stands_at = stands_at,
    .touches = touches,
    .use = use,
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
    .player_name = player_name,
    .trace_tables = ll_netgame_trace_tables,
    .trace = ll_netgame_trace,
};

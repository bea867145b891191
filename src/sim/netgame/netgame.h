/* Simulations of kind `netgame`: a server, its clients and the links between them, under one virtual clock.
 *
 * The actors share nothing: only packets pass between them. This room carries the packets, keeps the clocks,
 * and, since it sees all actors, measures every view against the truth. */
#pragma once

#include "link/line/profile_shelf.h"
#include "link/transport/transport.h"
#include "netcode/metrics/behind_cover.h"
#include "netcode/metrics/client_metrics.h"
#include "netcode/metrics/drag_neglect.h"
#include "netcode/metrics/shots.h"
#include "netcode/observe/desync.h"
#include "netcode/observe/player_observer.h"
#include "netcode/protocol/config.h"
#include "netcode/server/admission.h"
#include "netcode/server/aim_snaps.h"
#include "netcode/server/detect.h"
#include "netcode/server/reports.h"
#include "netcode/server/server.h"
#include "netcode/state/client.h"
#include "netcode/state/peer_choices.h"
#include "sim/core/sim.h"

typedef struct ll_netgame_config {
    ll_scenario_head head;
    double bucket_delay_ms; /* in a block 0 unless its sync has buckets */
    double tick_hz, warmup_s;
    int32_t game; /* index into ll_games */
    int32_t player_count;
    double params[LL_GAME_PARAMS]; /* the game's */
    ll_server_config server;
    ll_player_config players[LL_PLAYERS_MAX];
    /* From here on a block has no copy: it has these by themselves, and only where they differ from the
     * defaults. */
    ll_policy_params policies;
    ll_reckoning_params reckoning;
    ll_peers_params peers;
    ll_report_params reports;
    ll_bottleneck_params bottleneck;
    int32_t profile_count, reserved;
    ll_profile_params profiles[LL_PROFILES_MAX];
} ll_netgame_config;

extern const ll_param_table ll_netgame_table;

/* Where the parts of a player lie in a block. */
typedef struct ll_netgame_parts {
    int64_t client, up, down, dejitter, client_metrics, desync, weapon_prediction;
    int64_t transport, transport_metrics; /* 0 where messages are packets */
} ll_netgame_parts;

/* The start of a block. Offsets are from here. */
typedef struct ll_netgame {
    int64_t size; /* up to the times behind cover, the neglect of drag and the watch on aims, which games
                     with weapons have behind all else, and what clients note of snapshots of some entities */
    ll_game_env env;
    ll_time now;
    int64_t server, history;
    int64_t shots;    /* 0 in a game without weapons */
    int64_t observed; /* from here on the observer's, which no actor reads: not part of the hash */
    ll_netgame_parts at[LL_PEERS_MAX]; /* of the first players; ll_netgame_parts_of has all */
    ll_netgame_config config; /* last member: a block contains only the configured players of it, and then
                                 the ll_netgame_parts of the players after the first LL_PEERS_MAX */
} ll_netgame;

static inline ll_netgame_parts *ll_netgame_parts_of(const ll_netgame *g, int i)
{
    ll_netgame_parts *more = (ll_netgame_parts *)&g->config.players[g->config.player_count];
    return i < LL_PEERS_MAX ? (ll_netgame_parts *)&g->at[i] : &more[i - LL_PEERS_MAX];
}

static inline ll_server *ll_netgame_server(const ll_netgame *g)
{
    return (ll_server *)((char *)g + g->server);
}

static inline ll_history *ll_netgame_history(const ll_netgame *g)
{
    return (ll_history *)((char *)g + g->history);
}

/* Bytes of the configuration that a block contains. */
static inline size_t ll_netgame_config_size(const ll_netgame_config *c)
{
    return offsetof(ll_netgame_config, players) + (size_t)c->player_count * sizeof c->players[0];
}

/* Bytes of a block before its first part: with the places of parts of the players after the first
 * LL_PEERS_MAX. */
static inline size_t ll_netgame_head_size(const ll_netgame_config *c)
{
    int more = c->player_count > LL_PEERS_MAX ? c->player_count - LL_PEERS_MAX : 0;
    return offsetof(ll_netgame, config) + ll_netgame_config_size(c) + (size_t)more * sizeof(ll_netgame_parts);
}

/* Profiles and shared queues, between configuration and server. NULL: there are none, and not a byte of them.
 */
static inline ll_profile_shelf *ll_netgame_profiles(const ll_netgame *g)
{
    size_t at = ll_netgame_head_size(&g->config);
    return (int64_t)at < g->server ? (ll_profile_shelf *)((char *)g + at) : NULL;
}

static inline ll_client *ll_netgame_client(const ll_netgame *g, int i)
{
    return (ll_client *)((char *)g + ll_netgame_parts_of(g, i)->client);
}

static inline ll_link *ll_netgame_up(const ll_netgame *g, int i)
{
    return (ll_link *)((char *)g + ll_netgame_parts_of(g, i)->up);
}

static inline ll_link *ll_netgame_down(const ll_netgame *g, int i)
{
    return (ll_link *)((char *)g + ll_netgame_parts_of(g, i)->down);
}

static inline ll_dejitter *ll_netgame_dejitter(const ll_netgame *g, int i)
{
    return (ll_dejitter *)((char *)g + ll_netgame_parts_of(g, i)->dejitter);
}

static inline ll_client_metrics *ll_netgame_client_metrics(const ll_netgame *g, int i)
{
    return (ll_client_metrics *)((char *)g + ll_netgame_parts_of(g, i)->client_metrics);
}

static inline ll_desync *ll_netgame_desync(const ll_netgame *g, int i)
{
    return (ll_desync *)((char *)g + ll_netgame_parts_of(g, i)->desync);
}

/* NULL where snapshots contain every entity. It follows the desync. */
static inline ll_nearness *ll_netgame_nearness(const ll_netgame *g, int i)
{
    size_t world = ll_world_size(ll_server_world_const(ll_netgame_server(g)));
    return ll_server_replicas(ll_netgame_server(g))
               ? (ll_nearness *)((char *)ll_netgame_desync(g, i) + ll_desync_size(world))
               : NULL;
}

static inline ll_shots *ll_netgame_shots(const ll_netgame *g)
{
    return g->shots != 0 ? (ll_shots *)((char *)g + g->shots) : NULL;
}

static inline ll_weapon_prediction *ll_netgame_weapon_prediction(const ll_netgame *g, int i)
{
    return ll_netgame_parts_of(g, i)->weapon_prediction != 0
               ? (ll_weapon_prediction *)((char *)g + ll_netgame_parts_of(g, i)->weapon_prediction)
               : NULL;
}

/* NULL: the player's messages are packets on its links. */
static inline ll_transport *ll_netgame_transport(const ll_netgame *g, int i)
{
    return ll_netgame_parts_of(g, i)->transport != 0
               ? (ll_transport *)((char *)g + ll_netgame_parts_of(g, i)->transport)
               : NULL;
}

/* NULL in a game without weapons. */
static inline ll_behind_cover *ll_netgame_behind_cover(const ll_netgame *g)
{
    return g->shots != 0 ? (ll_behind_cover *)((char *)g + g->size) : NULL;
}

/* Behind that; NULL where projectiles have no drag. */
static inline ll_drag_neglect *ll_netgame_drag_neglect(const ll_netgame *g)
{
    return g->shots != 0 && ll_netgame_shots(g)->arena.projectile_drag > 0
               ? (ll_drag_neglect *)((char *)g + g->size + ll_behind_cover_size(g->config.player_count))
               : NULL;
}

/* Behind that, one per player; NULL in a game without weapons, and where the server detects nothing. */
static inline ll_aim_watch *ll_netgame_aim_watch(const ll_netgame *g)
{
    int players = g->config.player_count;
    size_t neglect = ll_netgame_drag_neglect(g) ? ll_drag_neglect_size(players) : 0;
    return g->shots != 0 && g->config.server.detection
               ? (ll_aim_watch *)((char *)g + g->size + ll_behind_cover_size(players) + neglect)
               : NULL;
}

/* Behind that, where snapshots contain some of the entities. */
static inline size_t ll_netgame_recent_at(const ll_netgame *g)
{
    int players = g->config.player_count;
    return (size_t)g->size + (g->shots != 0 ? ll_behind_cover_size(players) : 0) +
           (ll_netgame_drag_neglect(g) ? ll_drag_neglect_size(players) : 0) +
           (ll_netgame_aim_watch(g) ? (size_t)players * sizeof(ll_aim_watch) : 0);
}

/* NULL where snapshots contain every entity, or with dead reckoning. */
static inline ll_recent *ll_netgame_recent(const ll_netgame *g, int i)
{
    if (!ll_server_replicas(ll_netgame_server(g)) || g->config.server.reckons)
        return NULL;
    return (ll_recent *)((char *)g + ll_netgame_recent_at(g)) + i;
}

/* Of the whole block. */
static inline size_t ll_netgame_bytes(const ll_netgame *g)
{
    const int players = g->config.player_count;
    const ll_recent *end = ll_netgame_recent(g, players);
    return end ? (size_t)((const char *)end - (const char *)g) : ll_netgame_recent_at(g);
}

/* The last part that is simulated, or the defaults. */
static inline const ll_policy_params *ll_netgame_policies(const ll_netgame *g)
{
    bool tuned = g->config.server.compensation.tuned != 0;
    return tuned ? (const ll_policy_params *)((char *)g + g->observed) - 1 : &ll_policy_defaults;
}

/* Before that, NULL: no dead reckoning. */
static inline ll_reckoning *ll_netgame_reckoning(const ll_netgame *g)
{
    if (!g->config.server.reckons)
        return NULL;
    int entities = ll_server_world_const(ll_netgame_server(g))->entities;
    size_t behind = g->config.server.compensation.tuned ? sizeof(ll_policy_params) : 0;
    size_t size = ll_reckoning_size(g->config.player_count, entities);
    return (ll_reckoning *)((char *)g + g->observed - behind - size);
}

/* Before that, one per player. NULL: the server detects nothing. */
static inline ll_detection *ll_netgame_detection(const ll_netgame *g)
{
    if (!g->config.server.detection)
        return NULL;
    int entities = ll_server_world_const(ll_netgame_server(g))->entities, players = g->config.player_count;
    size_t behind = (size_t)players * sizeof(ll_detection);
    behind += g->config.server.compensation.tuned ? sizeof(ll_policy_params) : 0;
    behind += g->config.server.reckons ? ll_reckoning_size(players, entities) : 0;
    return (ll_detection *)((char *)g + g->observed - behind);
}

/* Before that, NULL: peers are as by default. */
static inline ll_peer_choices *ll_netgame_choices(const ll_netgame *g, int player)
{
    if (g->config.server.peers == 0)
        return NULL;
    int entities = ll_server_world_const(ll_netgame_server(g))->entities, players = g->config.player_count;
    size_t behind = g->config.server.compensation.tuned ? sizeof(ll_policy_params) : 0;
    behind += g->config.server.reckons ? ll_reckoning_size(players, entities) : 0;
    behind += g->config.server.detection ? (size_t)players * sizeof(ll_detection) : 0;
    size_t from = (size_t)(players - player) * sizeof(ll_peer_choices);
    return (ll_peer_choices *)((char *)g + g->observed - behind - from);
}

/* Whether the inputs of players travel directly to each other. */
static inline bool ll_netgame_meshed(const ll_netgame *g)
{
    return (g->config.server.peers & LL_PEERS_MESH) && ll_syncs[g->config.server.sync]->observe;
}

/* Whether a player reports the state of its entity. */
static inline bool ll_netgame_config_reports(const ll_netgame_config *c)
{
    for (int i = 0; i < c->player_count; i++)
        if (c->players[i].authority == LL_AUTHORITY_POSITION)
            return true;
    return false;
}

/* Of the server's and the clients' parts then, behind the history. */
static inline size_t ll_netgame_reports_size(int players)
{
    return ll_reports_size(players) + (size_t)players * sizeof(ll_reporter);
}

/* NULL: all players send controls alone. */
static inline ll_reports *ll_netgame_reports(const ll_netgame *g)
{
    int entities = ll_server_world_const(ll_netgame_server(g))->entities;
    return ll_netgame_config_reports(&g->config)
               ? (ll_reports *)((char *)g + g->history + ll_history_size(entities))
               : NULL;
}

/* NULL: the player sends controls alone. */
static inline ll_reporter *ll_netgame_reporter(const ll_netgame *g, int i)
{
    return g->config.players[i].authority == LL_AUTHORITY_POSITION
               ? (ll_reporter *)((char *)ll_netgame_reports(g) + ll_reports_size(g->config.player_count)) + i
               : NULL;
}

static inline int ll_netgame_entities(const ll_netgame *g)
{
    return ll_server_world_const(ll_netgame_server(g))->entities;
}

static inline const ll_game *ll_netgame_game(const ll_netgame *g)
{
    return ll_games[g->config.game];
}

static inline const ll_sync_mode *ll_netgame_sync(const ll_netgame *g)
{
    return ll_syncs[g->config.server.sync];
}

/* Whether a client waits for the input of another. */
static inline bool ll_netgame_stalled(const ll_netgame *g, int i)
{
    return ll_netgame_sync(g)->observe && ll_client_peer(ll_netgame_client(g, i))->waiting != 0;
}

/* report.c: reports of a block */
struct cJSON *ll_netgame_state(const void *block);
struct cJSON *ll_netgame_layout(const void *config);
/* report.c: sentences that explain why metrics are null: reasons in the configuration, for any run of it;
 * and, added to the `metrics` of a block as `notices`, also events that have not happened in it so far */
struct cJSON *ll_netgame_notices(const void *config);
void ll_netgame_add_notices(const ll_netgame *game, struct cJSON *metrics);
extern const ll_metric_table *const ll_netgame_trace_tables[];
void ll_netgame_trace(const void *block, ll_trace_line *trace);

/* numbers.c */
double ll_netgame_ratio(double part, double whole); /* NaN when `whole` is 0 */
double ll_netgame_measured_s(const ll_netgame *g,
                             const ll_client_metrics *in); /* s, over which rates count */

/* Readings of a distribution; of a latency, with `lost` infinite values; and of a gauge, multiplied by
 * `scale`. */
ll_metric_reading ll_netgame_distribution(ll_summary summary);
ll_metric_reading ll_netgame_latency(ll_summary summary, int64_t lost);
ll_metric_reading ll_netgame_gauge(const ll_running_stats *gauge, double scale);

/* Path of a table of metrics. */
#define LL_OF_RUN(path_) .path = path_, .short_numbers = true
#define LL_OF_PLAYERS(path_) LL_OF_RUN("players.*" path_)

/* Tables of metrics, NULL-terminated (metrics.c), and the functions that add metrics of a player to its
 * object. */
extern const ll_metric_table *const ll_netgame_metric_tables[];
struct cJSON *ll_netgame_metrics(const void *block);
/* observe.c: what must be observed for the metric at `path`: bits of ll_observation */
uint32_t ll_netgame_observed_for(const char *path);

/* views.c: inconsistency, smoothness and buffers of a player's view, added to its metrics; its buffers,
 * streamed */
void ll_netgame_view_metrics(const ll_netgame *game, int player, struct cJSON *object);
extern const ll_metric_table ll_netgame_smoothness_table, ll_netgame_animation_table,
    ll_netgame_interpolation_table, ll_netgame_dejitter_table, ll_netgame_excursion_table;
#define LL_NETGAME_VIEW_TABLES                                                                               \
    &ll_netgame_smoothness_table, &ll_netgame_animation_table, &ll_netgame_interpolation_table,              \
        &ll_netgame_dejitter_table, &ll_netgame_excursion_table

extern const ll_record ll_netgame_buffer_record, ll_netgame_buffered_record;
void ll_netgame_fill_buffers(const ll_netgame *game, ll_row_set *rows);
void ll_netgame_fill_buffered(const ll_netgame *game, ll_row_set *rows);

/* inputs.c: adds the results of its inputs to the metrics of `player` */
void ll_netgame_inputs_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_input_result_table, ll_netgame_timed_table, ll_netgame_cause_table,
    ll_netgame_replay_table, ll_netgame_validation_table, ll_netgame_report_table, ll_netgame_ack_table;
#define LL_NETGAME_INPUT_TABLES                                                                              \
    &ll_netgame_input_result_table, &ll_netgame_timed_table, &ll_netgame_cause_table,                        \
        &ll_netgame_replay_table, &ll_netgame_validation_table, &ll_netgame_report_table,                    \
        &ll_netgame_ack_table

/* traffic.c: adds the player's bandwidth, snapshots and the measured behaviour of its links */
void ll_netgame_traffic_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_message_table, ll_netgame_bandwidth_table, ll_netgame_snapshot_table,
    ll_netgame_reckoning_table, ll_netgame_up_table, ll_netgame_down_table;

/* traffic.c: messages and losses, streamed */
extern const ll_record ll_netgame_traffic_record, ll_netgame_link_record;
void ll_netgame_fill_traffic(const ll_netgame *game, ll_row_set *rows);

/* transport.c: adds what the player's transport did; nothing where messages are packets */
void ll_netgame_transport_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_transport_up_table, ll_netgame_transport_down_table;

/* traffic.c: adds which entities its snapshots contain; nothing where they contain every one */
void ll_netgame_selection_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_selection_table;

/* traffic.c: adds the state of its connection to the metrics of `player` */
void ll_netgame_connection_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_connection_table;

/* inputs.c: adds the statistics against cheats of `player`; nothing where the server detects nothing */
void ll_netgame_detection_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_rate_table, ll_netgame_reaction_table, ll_netgame_aim_table;
#define LL_NETGAME_DETECTION_TABLES &ll_netgame_rate_table, &ll_netgame_reaction_table, &ll_netgame_aim_table

/* inputs.c: the last inputs of the players, streamed */
extern const ll_record ll_netgame_input_history_record;
void ll_netgame_fill_input_history(const ll_netgame *game, ll_row_set *rows);

/* fairness.c: fairness between the `players`, added to the metrics of the server */
extern const ll_metric_table ll_netgame_fairness_table;
void ll_netgame_add_fairness(const ll_netgame *g, struct cJSON *server, const struct cJSON *players);

/* peers.c: of the peer-to-peer syncs */
void ll_netgame_peer_metrics(struct cJSON *player, const ll_netgame *g, int i);
/* The player that the server or the clients waited for longest, and how long; -1: no player. */
int ll_netgame_slowest(const ll_netgame *g, double *waited_s);
extern const ll_metric_table ll_netgame_desync_table, ll_netgame_stall_table, ll_netgame_rollback_table,
    ll_netgame_sync_test_table, ll_netgame_pacing_table;
#define LL_NETGAME_PEER_TABLES                                                                               \
    &ll_netgame_stall_table, &ll_netgame_rollback_table, &ll_netgame_pacing_table,                           \
        &ll_netgame_sync_test_table, &ll_netgame_desync_table
extern const ll_record ll_netgame_peer_record;
void ll_netgame_fill_peers(const ll_netgame *game, ll_row_set *rows);

/* shots.c: shot statistics of `player`, the last shots and the projectiles; nothing in a game without
 * weapons */
void ll_netgame_shots_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_tally_table, ll_netgame_projectile_table, ll_netgame_shot_table,
    ll_netgame_neglect_table, ll_netgame_peek_table;
#define LL_NETGAME_SHOT_TABLES                                                                               \
    &ll_netgame_tally_table, &ll_netgame_projectile_table, &ll_netgame_shot_table,                           \
        &ll_netgame_neglect_table, &ll_netgame_peek_table
extern const ll_record ll_netgame_shot_record, ll_netgame_shot_body_record, ll_netgame_projectile_record;
void ll_netgame_fill_shots(const ll_netgame *game, ll_row_set *rows);
void ll_netgame_fill_projectiles(const ll_netgame *game, ll_row_set *rows);

/* frame.c: streamed rows of a block */
extern const ll_record *const ll_netgame_records[];
void ll_netgame_fill(const void *block, ll_row_set *rows);

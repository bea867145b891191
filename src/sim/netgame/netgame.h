/* Simulations of kind `netgame`: a server, its clients and the links between them, under one virtual clock.
 *
 * The actors share nothing: only packets pass between them. This room carries the packets, keeps the clocks,
 * and, since it sees all actors, measures every view against the truth. */
#pragma once

#include "link/line/link.h"
#include "netcode/metrics/client_metrics.h"
#include "netcode/metrics/shots.h"
#include "netcode/observe/desync.h"
#include "netcode/protocol/config.h"
#include "netcode/server/admission.h"
#include "netcode/server/server.h"
#include "netcode/state/client.h"
#include "sim/core/sim.h"

typedef struct ll_netgame_config {
    ll_scenario_head head;
    double tick_hz, warmup_s;
    int32_t game; /* index into ll_games */
    int32_t player_count;
    double params[16]; /* the game's */
    ll_server_config server;
    ll_player_config players[LL_PLAYERS_MAX];
} ll_netgame_config;

extern const ll_param_table ll_netgame_table;

/* The start of a block. Offsets are from here. */
typedef struct ll_netgame {
    int64_t size;
    ll_game_env env;
    ll_time now;
    int64_t server, history;
    int64_t shots;    /* 0 in a game without weapons */
    int64_t observed; /* from here on the observer's, which no actor reads: not part of the hash */
    struct {
        int64_t client, up, down, dejitter, client_metrics, desync, weapon_prediction;
    } at[LL_PLAYERS_MAX];
    ll_netgame_config config; /* last member: a block contains only the configured players of it */
} ll_netgame;

static inline ll_server *ll_netgame_server(const ll_netgame *g)
{
    return (ll_server *)((char *)g + g->server);
}

static inline ll_history *ll_netgame_history(const ll_netgame *g)
{
    return (ll_history *)((char *)g + g->history);
}

static inline ll_client *ll_netgame_client(const ll_netgame *g, int i)
{
    return (ll_client *)((char *)g + g->at[i].client);
}

static inline ll_link *ll_netgame_up(const ll_netgame *g, int i)
{
    return (ll_link *)((char *)g + g->at[i].up);
}

static inline ll_link *ll_netgame_down(const ll_netgame *g, int i)
{
    return (ll_link *)((char *)g + g->at[i].down);
}

static inline ll_dejitter *ll_netgame_dejitter(const ll_netgame *g, int i)
{
    return (ll_dejitter *)((char *)g + g->at[i].dejitter);
}

static inline ll_client_metrics *ll_netgame_client_metrics(const ll_netgame *g, int i)
{
    return (ll_client_metrics *)((char *)g + g->at[i].client_metrics);
}

static inline ll_desync *ll_netgame_desync(const ll_netgame *g, int i)
{
    return (ll_desync *)((char *)g + g->at[i].desync);
}

static inline ll_shots *ll_netgame_shots(const ll_netgame *g)
{
    return g->shots != 0 ? (ll_shots *)((char *)g + g->shots) : NULL;
}

static inline ll_weapon_prediction *ll_netgame_weapon_prediction(const ll_netgame *g, int i)
{
    return g->at[i].weapon_prediction != 0 ? (ll_weapon_prediction *)((char *)g + g->at[i].weapon_prediction)
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
/* notices.c: sentences that explain why metrics are null: reasons in the configuration, for any run of it;
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
    ll_netgame_replay_table, ll_netgame_validation_table, ll_netgame_ack_table;
#define LL_NETGAME_INPUT_TABLES                                                                              \
    &ll_netgame_input_result_table, &ll_netgame_timed_table, &ll_netgame_cause_table,                        \
        &ll_netgame_replay_table, &ll_netgame_validation_table, &ll_netgame_ack_table

/* traffic.c: adds the player's bandwidth, snapshots and the measured behaviour of its links */
void ll_netgame_traffic_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_message_table, ll_netgame_bandwidth_table, ll_netgame_snapshot_table,
    ll_netgame_up_table, ll_netgame_down_table;

/* connection.c: adds the state of its connection to the metrics of `player` */
void ll_netgame_connection_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_connection_table;

/* input_history.c: the last inputs of the players, streamed */
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
    ll_netgame_sync_test_table;
#define LL_NETGAME_PEER_TABLES                                                                               \
    &ll_netgame_stall_table, &ll_netgame_rollback_table, &ll_netgame_sync_test_table, &ll_netgame_desync_table
extern const ll_record ll_netgame_peer_record;
void ll_netgame_fill_peers(const ll_netgame *game, ll_row_set *rows);

/* shots.c: shot statistics of `player`, the last shots and the projectiles; nothing in a game without
 * weapons */
void ll_netgame_shots_metrics(const ll_netgame *g, int player, struct cJSON *metrics);
extern const ll_metric_table ll_netgame_tally_table, ll_netgame_projectile_table, ll_netgame_shot_table,
    ll_netgame_peek_table;
#define LL_NETGAME_SHOT_TABLES                                                                               \
    &ll_netgame_tally_table, &ll_netgame_projectile_table, &ll_netgame_shot_table, &ll_netgame_peek_table
extern const ll_record ll_netgame_shot_record, ll_netgame_shot_body_record, ll_netgame_projectile_record;
void ll_netgame_fill_shots(const ll_netgame *game, ll_row_set *rows);
void ll_netgame_fill_projectiles(const ll_netgame *game, ll_row_set *rows);

/* frame.c: streamed rows of a block */
extern const ll_record *const ll_netgame_records[];
void ll_netgame_fill(const void *block, ll_row_set *rows);

/* Whether a block is sound: its server, its clients, and what one may know of another. The first invariant
 * that does not hold, as a sentence; NULL: all do. Nothing changes. For tests, after any step. */
const char *ll_netgame_broken(const ll_netgame *game);

/* Metrics of a netgame: of the players and the server, and the list of all tables. */
#include <cjson/cJSON.h>
#include <math.h>

#include "game/games/games.h"
#include "sim/netgame/netgame.h"

/* ---- a player ---- */

#define NAME(X) X(text, name, NULL, g->config.players[i].name, "name of the player", NULL)

static ll_metric_reading distribution_of(const ll_client_metrics *in, ll_metric metric)
{
    return ll_netgame_latency(ll_histogram_summary(&in->histogram[metric]),
                              metric < (int)LL_LATENCIES ? in->changes.lost[metric] : 0);
}

#define DISTRIBUTION_FIELD(id, type, name, unit, bucket, help, null)                                         \
    LL_METRIC_FIELD(type, name, unit, , help, null)
#define DISTRIBUTION_READING(id, type, name, unit, bucket, help, null)                                       \
    LL_METRIC_READING(type, name, unit, distribution_of(in, LL_METRIC_##id), help, null)

#define PICTURES(X)                                                                                          \
    X(gauge, own_lead_ms, "ms", ll_netgame_gauge(&in->rendered_views.leads_ms, 1),                           \
      "time by which the own entity is drawn ahead of the server: server time of the drawn tick less the "   \
      "time of the frame; negative: drawn behind the server",                                                \
      "No drawn tick of the own entity was compared with the server's.")                                     \
    X(count, own_displays_void, NULL, in->rendered_views.voided,                                             \
      "frames that were never compared with the server, because it did not make the drawn tick of the own "  \
      "entity",                                                                                              \
      NULL)

#define CORRECTIONS(X)                                                                                       \
    X(count, corrections, NULL, in->corrections.count,                                                       \
      "snapshots and rollbacks that changed the predicted position of the own entity", NULL)                 \
    X(rate, corrections_per_s, "1/s", ll_netgame_ratio((double)in->corrections.count, seconds),              \
      "snapshots and rollbacks per second that changed the predicted position of the own entity",            \
      "The run has not reached warmup_s.")                                                                   \
    X(events, visible_corrections, NULL, in->corrections.visible_m_all.count,                                \
      "frames with a visible correction: it moved a drawn position by more than a pixel, and by more than "  \
      "a tenth of the distance that the entity covers at its drawn speed in that frame",                     \
      NULL)                                                                                                  \
    X(event_rate, visible_corrections_per_s, "1/s",                                                          \
      ll_netgame_ratio((double)in->corrections.visible_m_all.count, seconds),                                \
      "frames with a visible correction per second", "The run has not reached warmup_s.")                    \
    X(extreme_gauge, visible_correction_m, "m", ll_netgame_gauge(&in->corrections.visible_m_all, 1),         \
      "size of a visible correction: the farthest distance that it moved an entity in the frame",            \
      "There was no visible correction.")                                                                    \
    X(extreme_gauge, visible_correction_px, "px", ll_netgame_gauge(&in->corrections.visible_m_all, px),      \
      "size of a visible correction in pixels; the scene is 1920 pixels wide",                               \
      "There was no visible correction.")                                                                    \
    X(extreme_gauge, visible_correction_arcmin, "arcmin",                                                    \
      ll_netgame_gauge(&in->corrections.visible_m_all, px *ARCMIN_PER_PX),                                   \
      "size of a visible correction in minutes of arc: 1.59 per pixel, as on a display of 24 inches with "   \
      "1920 pixels at a distance of 0.6 m",                                                                  \
      "There was no visible correction.")

#define INPUTS(X)                                                                                            \
    X(count, accepted, NULL, client_slot->counts.accepted,                                                   \
      "inputs that the server accepted for a step that it had not made yet", NULL)                           \
    X(count, duplicate, NULL, client_slot->counts.duplicate,                                                 \
      "repetitions of inputs that the server had received before", NULL)                                     \
    X(count, starved_steps, NULL, client_slot->counts.starved,                                               \
      "steps of the server without an input of the player; counted from the player's first input on, while " \
      "it is connected",                                                                                     \
      NULL)                                                                                                  \
    X(number, slack_ticks, "ticks",                                                                          \
      client_slot->snapshots.last_slack == LL_SLACK_UNKNOWN ? NAN                                            \
                                                            : (double)client_slot->snapshots.last_slack,     \
      "input slack of the newest input: ticks from its arrival to its step", "No input has arrived.")        \
    X(by_name, refused, NULL, rules_of(client_slot, counts),                                                 \
      "inputs that the server refused, by the rule that they broke; an input counts each time that it "      \
      "arrives",                                                                                             \
      NULL)

static const ll_metric_table name_table = {LL_OF_PLAYERS(""), .help = "The player.", LL_METRICS_FROM(NAME)};
static const ll_metric_table distribution_table = {
    LL_OF_PLAYERS(""),
    .help = "Latencies, ages, errors and corrections of the player's view, from warmup_s on.",
    .fields = (const ll_metric_field[]){LL_CLIENT_METRICS(DISTRIBUTION_FIELD)}, .count = LL_METRICS};
static const ll_metric_table picture_table = {
    LL_OF_PLAYERS(""), .help = "Drawn ticks of the own entity compared with the server's, from warmup_s on.",
    LL_METRICS_FROM(PICTURES)};
static const ll_metric_table correction_table = {LL_OF_PLAYERS(""), .help = "Corrections, from warmup_s on.",
                                                 LL_METRICS_FROM(CORRECTIONS)};
static const ll_metric_table input_table = {LL_OF_PLAYERS(".inputs"),
                                            .help = "The player's inputs at the server, from time 0 on.",
                                            LL_METRICS_FROM(INPUTS)};

/* Assumed display for visible corrections: 24 inches, 1920 pixels, at a distance of 0.6 m. */
#define ARCMIN_PER_PX 1.59

static void view(cJSON *o, const ll_client_metrics *in, double seconds)
{
    double px = in->corrections.pixel_m > 0 ? 1 / in->corrections.pixel_m : NAN;
    const ll_metric_reading readings[] = {LL_CLIENT_METRICS(DISTRIBUTION_READING)};
    ll_metrics_put(o, &distribution_table, readings);
    LL_METRICS_PUT(o, &picture_table, PICTURES);
    LL_METRICS_PUT(o, &correction_table, CORRECTIONS);
}

static ll_metric_reading rules_of(const ll_client_slot *client_slot, double counts[LL_RULES])
{
    for (int rule = 1; rule < LL_RULES; rule++)
        counts[rule] = (double)client_slot->counts.refused[rule];
    return (ll_metric_reading){.number = LL_RULES - 1, .numbers = counts + 1, .names = ll_rule_names + 1};
}

static void game(cJSON *o, const ll_netgame *g, int i)
{
    const ll_game *game = ll_netgame_game(g);
    double values[LL_GAME_VALUES];
    ll_metric_reading readings[LL_GAME_VALUES];
    game->describe(ll_server_world_const(ll_netgame_server(g)), &g->env, i, values);
    for (int k = 0; k < game->metrics->count; k++)
        readings[k] = ll_metric_number(values[k]);
    ll_metrics_put(o, game->metrics, readings);
}

static cJSON *player_metrics(const ll_netgame *g, int i)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[i];
    double counts[LL_RULES];
    cJSON *o = cJSON_CreateObject();
    LL_METRICS_PUT(o, &name_table, NAME);
    view(o, in, ll_netgame_measured_s(g, in));
    ll_netgame_view_metrics(g, i, o);
    ll_netgame_peer_metrics(o, g, i);
    ll_netgame_connection_metrics(g, i, o);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "inputs"), &input_table, INPUTS);
    ll_netgame_inputs_metrics(g, i, o);
    ll_netgame_detection_metrics(g, i, o);
    ll_netgame_shots_metrics(g, i, o);
    ll_netgame_traffic_metrics(g, i, o);
    ll_netgame_transport_metrics(g, i, o);
    ll_netgame_selection_metrics(g, i, o);
    game(cJSON_AddObjectToObject(o, "game"), g, i);
    return o;
}

/* ---- the server ---- */

#define SERVER(X)                                                                                            \
    X(text, sync, NULL, ll_netgame_sync(g)->name, "parameter sync: how server and clients keep time", NULL)  \
    X(count, steps, NULL, server->step, "steps that the server has made", NULL)                              \
    X(number, steps_per_s, "1/s", ll_netgame_ratio((double)server->step, ll_to_s(g->now)),                   \
      "steps of the server per second of virtual time", "Virtual time is 0.")                                \
    X(number, stalled_s, "s", ll_to_s(server->stalled + stalling(g)),                                        \
      "time that the server waited for inputs (lockstep, deterministic, rollback) beyond one step interval " \
      "per step; includes a wait that has not ended",                                                        \
      NULL)                                                                                                  \
    X(count, slowest_player, NULL, slowest,                                                                  \
      "index of the player that was waited for longest from warmup_s on: in the locksteps by the server, "   \
      "for the input that came last; otherwise by the clients together; of equal players the first; -1: no " \
      "player",                                                                                              \
      NULL)                                                                                                  \
    X(number, slowest_waited_s, "s", slowest_s,                                                              \
      "time that server or clients waited for the slowest player, from warmup_s on", NULL)                   \
    X(text, snapshot, NULL, ll_codec_names[server->codec],                                                   \
      "parameter snapshot_encoding: the encoding of snapshots", NULL)                                        \
    X(distribution, rounding_m, "m",                                                                         \
      ll_netgame_distribution(ll_rounding_summary(ll_server_baseline_history(server))),                      \
      "distance of a quantised position in a snapshot from the position before quantisation; a value per "   \
      "quantised position",                                                                                  \
      "No position was quantised.")

static const ll_metric_table server_table = {LL_OF_RUN("server"), .help = "The server, from time 0 on.",
                                             LL_METRICS_FROM(SERVER)};
#define NOTICES(X)                                                                                           \
    X(notices, notices, NULL, , "sentences that say why metrics are null or without meaning", NULL)

static const ll_metric_table notice_table = {LL_OF_RUN(""), .help = "Notices about the metrics.",
                                             LL_METRICS_FROM(NOTICES)};

/* Length of the present wait. */
static ll_time stalling(const ll_netgame *g)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    const ll_server *server = ll_netgame_server(g);
    ll_time beyond = g->now - server->stepped - ll_tick_time(1, server->clock.freq);
    return (sync->waits || sync->observe) && beyond > 0 ? beyond : 0;
}

cJSON *ll_netgame_metrics(const void *block)
{
    const ll_netgame *g = block;
    const ll_server *server = ll_netgame_server(g);
    double slowest_s;
    int slowest = ll_netgame_slowest(g, &slowest_s);
    cJSON *metrics = cJSON_CreateObject(), *s = cJSON_AddObjectToObject(metrics, "server");
    LL_METRICS_PUT(s, &server_table, SERVER);
    cJSON *players = cJSON_AddArrayToObject(metrics, "players");
    for (int i = 0; i < server->players; i++)
        cJSON_AddItemToArray(players, player_metrics(g, i));
    ll_netgame_add_fairness(g, s, players);
    ll_netgame_add_notices(g, metrics);
    return metrics;
}

/* ---- all tables ---- */

const ll_metric_table *const ll_netgame_metric_tables[] = {&server_table,
                                                           &ll_netgame_fairness_table,
                                                           &notice_table,
                                                           &name_table,
                                                           &distribution_table,
                                                           &picture_table,
                                                           &correction_table,
                                                           LL_NETGAME_VIEW_TABLES,
                                                           LL_NETGAME_PEER_TABLES,
                                                           &ll_netgame_connection_table,
                                                           &input_table,
                                                           LL_NETGAME_INPUT_TABLES,
                                                           LL_NETGAME_DETECTION_TABLES,
                                                           LL_NETGAME_SHOT_TABLES,
                                                           &ll_netgame_message_table,
                                                           &ll_netgame_bandwidth_table,
                                                           &ll_netgame_snapshot_table,
                                                           &ll_netgame_reckoning_table,
                                                           &ll_netgame_up_table,
                                                           &ll_netgame_down_table,
                                                           &ll_netgame_selection_table,
                                                           &ll_netgame_transport_up_table,
                                                           &ll_netgame_transport_down_table,
                                                           LL_GAME_METRIC_TABLES NULL};

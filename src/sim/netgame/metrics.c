/* The metrics of a netgame: of each player, of the server, and the tables of all. */
#include <cjson/cJSON.h>
#include <math.h>

#include "game/games/games.h"
#include "sim/netgame/netgame.h"

/* ---- a player ---- */

#define NAME(X) X(text, name, NULL, g->config.players[i].name, "of the player", NULL)

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
      "how far ahead of the server the own entity is drawn: from the server time of its tick to now; "       \
      "negative: behind",                                                                                    \
      "None was compared.")                                                                                  \
    X(count, own_pictures_void, NULL, in->rendered_views.voided,                                             \
      "rendered views of ticks that were never made", NULL)

#define CORRECTIONS(X)                                                                                       \
    X(count, corrections, NULL, in->corrections, "states that moved the own entity", NULL)                   \
    X(number, corrections_per_s, "1/s", ll_netgame_ratio((double)in->corrections, seconds), "these",         \
      "It is before warmup_s.")                                                                              \
    X(events, visible_corrections, NULL, in->visible_m_all.count,                                            \
      "displays with a correction that can be seen: what is drawn of an entity moved by more than a "        \
      "pixel and more than a tenth of the way that it goes by its drawn speed in the same frame",            \
      NULL)                                                                                                  \
    X(event_rate, visible_corrections_per_s, "1/s",                                                          \
      ll_netgame_ratio((double)in->visible_m_all.count, seconds), "these", "It is before warmup_s.")         \
    X(gauge, visible_correction_m, "m", ll_netgame_gauge(&in->visible_m_all, 1),                             \
      "the farthest of such a display", "There was none.")                                                   \
    X(gauge, visible_correction_px, "px", ll_netgame_gauge(&in->visible_m_all, px),                          \
      "in pixels: the scene's width is 1920", "There was none.")                                             \
    X(gauge, visible_correction_arcmin, "arcmin", ll_netgame_gauge(&in->visible_m_all, px *ARCMIN_PER_PX),   \
      "in minutes of arc: 1.59 a pixel, as 24 inches of 1920 pixels have from 0.6 m", "There was none.")

#define INPUTS(X)                                                                                            \
    X(count, accepted, NULL, client_slot->accepted, "taken for a step to come", NULL)                        \
    X(count, duplicate, NULL, client_slot->duplicate, "repetitions", NULL)                                   \
    X(count, starved_steps, NULL, client_slot->starved,                                                      \
      "steps without an input, from the player's first on and while it is connected", NULL)                  \
    X(number, slack_ticks, "ticks",                                                                          \
      client_slot->last_slack == LL_SLACK_UNKNOWN ? NAN : (double)client_slot->last_slack,                   \
      "how early the last came", "None has come.")                                                           \
    X(by_name, refused, NULL, rules_of(client_slot, counts),                                                 \
      "inputs that broke a rule, by rule, once for each time that they came", NULL)

static const ll_metric_table name_table = {LL_OF_PLAYERS(""), .help = "Who it is.", LL_METRICS_FROM(NAME)};
static const ll_metric_table distribution_table = {
    LL_OF_PLAYERS(""), .help = "What the player's view is like, from warmup_s on.",
    .fields = (const ll_metric_field[]){LL_CLIENT_METRICS(DISTRIBUTION_FIELD)}, .count = LL_METRICS};
static const ll_metric_table picture_table = {
    LL_OF_PLAYERS(""), .help = "The rendered views of the own entity, from warmup_s on.",
    LL_METRICS_FROM(PICTURES)};
static const ll_metric_table correction_table = {LL_OF_PLAYERS(""), .help = "corrections, from warmup_s on.",
                                                 LL_METRICS_FROM(CORRECTIONS)};
static const ll_metric_table input_table = {
    LL_OF_PLAYERS(".inputs"), .help = "inputs at the server, from 0 on.", LL_METRICS_FROM(INPUTS)};

/* The display that corrections are seen on: 24 inches of 1920 pixels, from 0.6 m. */
#define ARCMIN_PER_PX 1.59

static void view(cJSON *o, const ll_client_metrics *in, double seconds)
{
    double px = in->pixel_m > 0 ? 1 / in->pixel_m : NAN;
    const ll_metric_reading readings[] = {LL_CLIENT_METRICS(DISTRIBUTION_READING)};
    ll_metrics_put(o, &distribution_table, readings);
    LL_METRICS_PUT(o, &picture_table, PICTURES);
    LL_METRICS_PUT(o, &correction_table, CORRECTIONS);
}

static ll_metric_reading rules_of(const ll_client_slot *client_slot, double counts[LL_RULES])
{
    for (int rule = 1; rule < LL_RULES; rule++)
        counts[rule] = (double)client_slot->refused[rule];
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
    ll_netgame_shots_metrics(g, i, o);
    ll_netgame_traffic_metrics(g, i, o);
    game(cJSON_AddObjectToObject(o, "game"), g, i);
    return o;
}

/* ---- the server ---- */

#define SERVER(X)                                                                                            \
    X(text, sync, NULL, ll_netgame_sync(g)->name, "how it keeps time", NULL)                                 \
    X(count, steps, NULL, server->step, "that it made", NULL)                                                \
    X(number, steps_per_s, "1/s", ll_netgame_ratio((double)server->step, ll_to_s(g->now)), "these",          \
      "It is time 0.")                                                                                       \
    X(number, stalled_s, "s", ll_to_s(server->stalled + stalling(g)),                                        \
      "how long it waited for inputs (lockstep, deterministic, rollback) beyond one interval a step, the "   \
      "wait that has not ended included",                                                                    \
      NULL)                                                                                                  \
    X(count, slowest_player, NULL, slowest,                                                                  \
      "whom the server (in the locksteps, whose input came last) or the clients together, from warmup_s "    \
      "on, waited for longest; of equal ones the first; -1: no player",                                      \
      NULL)                                                                                                  \
    X(number, slowest_waited_s, "s", slowest_s, "how long", NULL)                                            \
    X(text, snapshot, NULL, ll_codec_names[server->codec], "the encoding of snapshots", NULL)                \
    X(distribution, rounding_m, "m",                                                                         \
      ll_netgame_distribution(ll_rounding_summary(ll_server_baseline_history(server))),                      \
      "from a position as sent to the true one, of every position that went onto the grid", "None did.")

static const ll_metric_table server_table = {LL_OF_RUN("server"), .help = "The server, from 0 on.",
                                             LL_METRICS_FROM(SERVER)};
#define NOTICES(X) X(notices, notices, NULL, , "why metrics are null or mean nothing", NULL)

static const ll_metric_table notice_table = {LL_OF_RUN(""), .help = "What to know of it.",
                                             LL_METRICS_FROM(NOTICES)};

/* Of the wait that has not ended. */
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
                                                           LL_NETGAME_SHOT_TABLES,
                                                           &ll_netgame_message_table,
                                                           &ll_netgame_bandwidth_table,
                                                           &ll_netgame_snapshot_table,
                                                           &ll_netgame_up_table,
                                                           &ll_netgame_down_table,
                                                           LL_GAME_METRIC_TABLES,
                                                           NULL};

/* Reports of the peer-to-peer syncs: stalls, desync and rollbacks, and the ticks of their worlds,
 * streamed. */
#include <cjson/cJSON.h>
#include <stddef.h>

#include "netcode/state/peer.h"
#include "sim/netgame/netgame.h"

static double per_s(const ll_netgame *g, int i, double count)
{
    double seconds = ll_to_s(g->now - ll_netgame_client_metrics(g, i)->from);
    return ll_netgame_ratio(count, seconds > 0 ? seconds : 0);
}

static int64_t waited_frames(const ll_netgame *g, int i, int for_player)
{
    bool may_wait = for_player < LL_PEERS_MAX; /* no sync in which clients wait has more */
    return may_wait ? ll_netgame_client_metrics(g, i)->stepping.waited_frames[for_player] : 0;
}

static double waited_s(const ll_netgame *g, int i, int for_player)
{
    return (double)waited_frames(g, i, for_player) * g->env.dt;
}

#define DESYNC(X)                                                                                            \
    X(count, tick, NULL, d->tick,                                                                            \
      "first confirmed tick at which the client's world differs from the server's; -1: none", NULL)          \
    X(count, reported_tick, NULL, ll_netgame_server(g)->client_slots[i].peer.desync,                         \
      "first confirmed tick at which the server finds a different hash of the client's world; -1: none",     \
      NULL)                                                                                                  \
    X(count, entity, NULL, d->entity,                                                                        \
      "first entity that differs from the server's at the tick of the desync; -1: only the game's own "      \
      "state differs",                                                                                       \
      NULL)                                                                                                  \
    X(text, field, NULL, d->tick < 0 ? "" : ll_field_names[d->field],                                        \
      "field that differs from the server's at the tick of the desync; empty: none", NULL)                   \
    X(number, ulps, "ulps", d->ulps,                                                                         \
      "distance of the differing field from the server's at the tick of the desync, in steps between "       \
      "neighbouring doubles",                                                                                \
      "The distance is not finite.")                                                                         \
    X(number, ulps_1s, "ulps", d->ulps_1s,                                                                   \
      "distance of the differing field from the server's one second after the tick of the desync, in steps " \
      "between neighbouring doubles",                                                                        \
      "The distance is not finite.")                                                                         \
    X(number, ulps_10s, "ulps", d->ulps_10s,                                                                 \
      "distance of the differing field from the server's ten seconds after the tick of the desync, in "      \
      "steps between neighbouring doubles",                                                                  \
      "The distance is not finite.")                                                                         \
    X(number, ulps_max, "ulps", d->ulps_max,                                                                 \
      "largest distance of the differing field from the server's, in steps between neighbouring doubles",    \
      "The distance is not finite.")                                                                         \
    X(number, error_m, "m", d->error,                                                                        \
      "distance from the server's position now, of the entity that is farthest from it",                     \
      "The distance is not finite.")                                                                         \
    X(number, error_max_m, "m", d->error_max,                                                                \
      "largest distance of an entity from the server's position so far", "The distance is not finite.")

#define STALLS(X)                                                                                            \
    X(count, count, NULL, n->stalls,                                                                         \
      "stalls: waits for the inputs of other players; a stall counts at its first frame", NULL)              \
    X(number, stalled_s, "s", (double)n->stalled_frames * g->env.dt,                                         \
      "time that the client waited for inputs of other players; a frame counts 1 / tick_hz", NULL)           \
    X(number, time_sync_wait_s, "s", (double)n->time_sync_frames * g->env.dt,                                \
      "time that the client waited for peers that are behind (time sync), or was held; a frame counts 1 / "  \
      "tick_hz",                                                                                             \
      NULL)                                                                                                  \
    X(numbers, waited_s, "s", ll_metric_numbers(waited, g->config.player_count),                             \
      "time that the client waited for the input of each player, by index of the player; it may wait for "   \
      "several at once",                                                                                     \
      NULL)

#define ROLLBACK(X)                                                                                          \
    X(count, count, NULL, n->rollbacks, "rollbacks", NULL)                                                   \
    X(rate, count_per_s, "1/s", per_s(g, i, (double)n->rollbacks), "rollbacks per second",                   \
      "The run has not reached warmup_s.")                                                                   \
    X(count, ticks, NULL, n->rollback_ticks, "ticks that rollbacks resimulated", NULL)                       \
    X(rate, ticks_per_s, "1/s", per_s(g, i, (double)n->rollback_ticks),                                      \
      "ticks per second that rollbacks resimulated", "The run has not reached warmup_s.")                    \
    X(count, ticks_max, NULL, n->rollback_ticks_max,                                                         \
      "largest number of ticks that one rollback resimulated", NULL)

#define SYNC_TEST(X)                                                                                         \
    X(count, count, NULL, n->sync_tests, "sync tests that were made", NULL)                                  \
    X(events, mismatches, NULL, n->sync_test_mismatches, "sync tests whose checksums differ", NULL)

#define PACING(X)                                                                                            \
    X(count, input_delay_ticks, NULL, ll_peer_delay(&s), "present input delay", NULL)                        \
    X(events, input_delay_changes, NULL, choices->delay_changes, "changes of the input delay", NULL)         \
    X(number, lead_ticks, "ticks", ll_pacing_lead(ll_netgame_client(g, i), choices),                         \
      "lead over the player farthest behind, as the client has it; 0: it is not ahead", NULL)                \
    X(number, stretched_s, "s", choices->stretched * g->env.dt,                                              \
      "time by which frames were lengthened since the game began", NULL)                                     \
    X(number, deep_rollback_ratio, NULL, ll_netgame_ratio((double)choices->deep, (double)n->rollbacks),      \
      "share of rollbacks that resimulated more than peers.delay_budget_ticks", "There was no rollback.")

const ll_metric_table ll_netgame_pacing_table = {
    LL_OF_PLAYERS(".pacing"), .when = "Only with a mesh, stretched frames or an adaptive delay.",
    .help = "Pace of a client that simulates the world itself, from warmup_s on.", LL_METRICS_FROM(PACING)};

static void pacing(cJSON *player, const ll_netgame *g, int i)
{
    const ll_stepping *n = &ll_netgame_client_metrics(g, i)->stepping;
    const ll_peer_choices *choices = ll_netgame_choices(g, i);
    const ll_client_setup s = {
        .config = &g->config.players[i], .rules = &g->config.server, .choices = ll_netgame_choices(g, i)};
    if (choices && ll_netgame_sync(g)->observe)
        LL_METRICS_PUT(cJSON_AddObjectToObject(player, "pacing"), &ll_netgame_pacing_table, PACING);
}

const ll_metric_table ll_netgame_desync_table = {
    LL_OF_PLAYERS(".desync"),
    .help = "Desync since the last resync, of a client that simulates the world itself (deterministic, "
            "rollback); other clients have none.",
    LL_METRICS_FROM(DESYNC)};

const ll_metric_table ll_netgame_stall_table = {
    LL_OF_PLAYERS(".stalls"),
    .help = "Stalls from warmup_s on, of a client that simulates the world itself (deterministic, rollback); "
            "0 of other clients.",
    LL_METRICS_FROM(STALLS)};

const ll_metric_table ll_netgame_rollback_table = {
    LL_OF_PLAYERS(".rollback"),
    .help = "Rollbacks from warmup_s on, of a client that simulates the world itself (deterministic, "
            "rollback); 0 of other clients.",
    LL_METRICS_FROM(ROLLBACK)};

const ll_metric_table ll_netgame_sync_test_table = {
    LL_OF_PLAYERS(".sync_test"), .help = "Sync tests, with sync_test_ticks.", LL_METRICS_FROM(SYNC_TEST)};

void ll_netgame_peer_metrics(cJSON *player, const ll_netgame *g, int i)
{
    const ll_stepping *n = &ll_netgame_client_metrics(g, i)->stepping;
    const ll_desync *d = ll_netgame_desync(g, i);
    double waited[LL_PLAYERS_MAX];
    for (int p = 0; p < g->config.player_count; p++)
        waited[p] = waited_s(g, i, p);
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "stalls"), &ll_netgame_stall_table, STALLS);
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "rollback"), &ll_netgame_rollback_table, ROLLBACK);
    pacing(player, g, i);
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "sync_test"), &ll_netgame_sync_test_table, SYNC_TEST);
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "desync"), &ll_netgame_desync_table, DESYNC);
}

int ll_netgame_slowest(const ll_netgame *g, double *waited_s)
{
    int slowest = -1;
    double most = 0;
    for (int p = 0; p < g->config.player_count; p++) {
        int64_t frames = 0; /* integers, so that equal sums are equal */
        for (int i = 0; i < g->config.player_count; i++)
            frames += waited_frames(g, i, p);
        double sum =
            ll_to_s(ll_netgame_server(g)->client_slots[p].counts.waited) + (double)frames * g->env.dt;
        if (sum > most) {
            most = sum;
            slowest = p;
        }
    }
    *waited_s = most;
    return slowest;
}

/* ---- streamed ---- */

typedef struct peer {
    uint8_t player;
    int64_t confirmed, tick, desync_tick;
    uint32_t waiting, stalls;
    float stalled_s;
    uint32_t rollbacks, rollback_ticks;
    int32_t desync_entity;
    uint32_t desync_field;
    float desync_m;
    double desync_ulps;
} peer;

static const ll_record_field peer_fields[] = {
    LL_INT(peer, player, NULL, "index of the player"),
    LL_INT(peer, confirmed, NULL, "confirmed tick: all inputs up to it have arrived"),
    LL_INT(peer, tick, NULL, "tick that is drawn"),
    LL_INT(peer, desync_tick, NULL, "the first that differs from the server's; -1: none"),
    LL_INT(peer, waiting, NULL, "bit p: waits for the input of player p"),
    LL_INT(peer, stalls, NULL, "number of waits"),
    LL_STEP(peer, stalled_s, LL_BITS_RATIO, "s", "total time of waits"),
    LL_INT(peer, rollbacks, NULL, "number of rollbacks"),
    LL_INT(peer, rollback_ticks, NULL, "resimulated ticks"),
    LL_INT(peer, desync_entity, NULL, "entity that differs; -1: the game's tail"),
    LL_ENUM(peer, desync_field, ll_field_names, "field of it that differs"),
    LL_STEP(peer, desync_m, LL_BITS_M, "m", "present distance from the server's world"),
    LL_REAL(peer, desync_ulps, 23, "ulps", "of that field at that tick"),
};

const ll_record ll_netgame_peer_record = {
    .id = 8,
    .name = "peers",
    .channel = LL_CHANNEL_GAUGES,
    .help = "Clients with worlds of their own (deterministic, rollback); no rows with other syncs.",
    .form = LL_FORM_BY_INDEX,
    LL_ROWS_OF(peer, peer_fields)};

static peer peer_of(const ll_netgame *g, int i)
{
    const ll_peer *world = ll_client_peer(ll_netgame_client(g, i));
    const ll_stepping *n = &ll_netgame_client_metrics(g, i)->stepping;
    const ll_desync *d = ll_netgame_desync(g, i);
    return (peer){.player = (uint8_t)i,
                  .confirmed = world->confirmed,
                  .tick = world->tick,
                  .desync_tick = d->tick,
                  .waiting = world->waiting,
                  .stalls = (uint32_t)n->stalls,
                  .stalled_s = (float)((double)n->stalled_frames * g->env.dt),
                  .rollbacks = (uint32_t)n->rollbacks,
                  .rollback_ticks = (uint32_t)n->rollback_ticks,
                  .desync_entity = d->entity,
                  .desync_field = (uint32_t)d->field,
                  .desync_m = (float)d->error,
                  .desync_ulps = d->ulps};
}

void ll_netgame_fill_peers(const ll_netgame *g, ll_row_set *rows)
{
    peer all[LL_PLAYERS_MAX];
    int count = ll_netgame_sync(g)->observe ? g->config.player_count : 0;
    for (int i = 0; i < count; i++)
        all[i] = peer_of(g, i);
    ll_row_set_put(rows, &ll_netgame_peer_record, all, count);
}

/* Reports of the peer-to-peer syncs: stalls, desync and rollbacks, and the ticks of their worlds,
 * streamed. */
#include <cjson/cJSON.h>
#include <stddef.h>

#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

static double per_s(const ll_netgame *g, int i, double count)
{
    double seconds = ll_to_s(g->now - ll_netgame_client_metrics(g, i)->from);
    return ll_netgame_ratio(count, seconds > 0 ? seconds : 0);
}

static int64_t waited_frames(const ll_netgame *g, int i, int for_player)
{
    return ll_netgame_client_metrics(g, i)->stepping.waited_frames[for_player];
}

static double waited_s(const ll_netgame *g, int i, int for_player)
{
    return (double)waited_frames(g, i, for_player) * g->env.dt;
}

static void desync(cJSON *player, const ll_netgame *g, int i)
{
    const ll_desync *d = ll_netgame_desync(g, i);
    cJSON *o = cJSON_AddObjectToObject(player, "desync");
    number(o, "tick", (double)d->tick);
    number(o, "reported_tick", (double)ll_netgame_server(g)->client_slots[i].peer.desync);
    number(o, "entity", d->entity);
    cJSON_AddStringToObject(o, "field", d->tick < 0 ? "" : ll_field_names[d->field]);
    number(o, "ulps", d->ulps);
    number(o, "ulps_1s", d->ulps_1s);
    number(o, "ulps_10s", d->ulps_10s);
    number(o, "ulps_max", d->ulps_max);
    number(o, "error_m", d->error);
    number(o, "error_max_m", d->error_max);
}

void ll_netgame_peer_metrics(cJSON *player, const ll_netgame *g, int i)
{
    const ll_stepping *n = &ll_netgame_client_metrics(g, i)->stepping;
    cJSON *stalls = cJSON_AddObjectToObject(player, "stalls");
    number(stalls, "count", (double)n->stalls);
    number(stalls, "stalled_s", (double)n->stalled_frames * g->env.dt);
    number(stalls, "time_sync_wait_s", (double)n->time_sync_frames * g->env.dt);
    cJSON *waited = cJSON_AddArrayToObject(stalls, "waited_s");
    for (int p = 0; p < g->config.player_count; p++)
        cJSON_AddItemToArray(waited, cJSON_CreateNumber(waited_s(g, i, p)));
    cJSON *rollback = cJSON_AddObjectToObject(player, "rollback");
    number(rollback, "count", (double)n->rollbacks);
    number(rollback, "count_per_s", per_s(g, i, (double)n->rollbacks));
    number(rollback, "ticks", (double)n->rollback_ticks);
    number(rollback, "ticks_per_s", per_s(g, i, (double)n->rollback_ticks));
    number(rollback, "ticks_max", (double)n->rollback_ticks_max);
    cJSON *sync_test = cJSON_AddObjectToObject(player, "sync_test");
    number(sync_test, "count", (double)n->sync_tests);
    number(sync_test, "mismatches", (double)n->sync_test_mismatches);
    desync(player, g, i);
}

void ll_netgame_slowest(cJSON *server, const ll_netgame *g)
{
    int slowest = -1;
    double most = 0;
    for (int p = 0; p < g->config.player_count; p++) {
        int64_t frames = 0; /* integers, so that equal sums are equal */
        for (int i = 0; i < g->config.player_count; i++)
            frames += waited_frames(g, i, p);
        double sum = ll_to_s(ll_netgame_server(g)->client_slots[p].waited) + (double)frames * g->env.dt;
        if (sum > most) {
            most = sum;
            slowest = p;
        }
    }
    number(server, "slowest_player", slowest);
    number(server, "slowest_waited_s", most);
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

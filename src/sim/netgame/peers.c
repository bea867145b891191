/* What is told of the peer-to-peer syncs: M12, M14, and section 5 of a frame. */
#include <cjson/cJSON.h>
#include <stddef.h>

#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

static double per_s(const ll_netgame *g, int i, double count)
{
    double seconds = ll_to_s(g->now - ll_netgame_instruments(g, i)->from);
    return ll_netgame_ratio(count, seconds > 0 ? seconds : 0);
}

static int64_t waited_frames(const ll_netgame *g, int i, int for_player)
{
    return ll_netgame_instruments(g, i)->stepping.waited_frames[for_player];
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
    number(o, "reported_tick", (double)ll_netgame_server(g)->seats[i].peer.desync);
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
    const ll_stepping *n = &ll_netgame_instruments(g, i)->stepping;
    cJSON *stalls = cJSON_AddObjectToObject(player, "stalls");
    number(stalls, "count", (double)n->stalls);
    number(stalls, "stalled_s", (double)n->stalled_frames * g->env.dt);
    number(stalls, "rested_s", (double)n->rested_frames * g->env.dt);
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
        int64_t frames = 0; /* whole ones, so that equal sums are equal */
        for (int i = 0; i < g->config.player_count; i++)
            frames += waited_frames(g, i, p);
        double sum = ll_to_s(ll_netgame_server(g)->seats[p].waited) + (double)frames * g->env.dt;
        if (sum > most) {
            most = sum;
            slowest = p;
        }
    }
    number(server, "slowest_player", slowest);
    number(server, "slowest_waited_s", most);
}

/* ---- section 5 ---- */

enum { SECTION_PEERS = 5 };

typedef struct peer_record {
    int64_t confirmed, tick, desync_tick;
    uint32_t waiting, stalls;
    float stalled_s;
    uint32_t rollbacks, rollback_ticks;
    int32_t desync_entity;
    uint32_t desync_field;
    float desync_m;
    double desync_ulps;
} peer_record;

_Static_assert(sizeof(peer_record) == 64, "the layout of session/frame.h");

static peer_record record_of(const ll_netgame *g, int i)
{
    const ll_peer *peer = ll_client_peer(ll_netgame_client(g, i));
    const ll_stepping *n = &ll_netgame_instruments(g, i)->stepping;
    const ll_desync *d = ll_netgame_desync(g, i);
    return (peer_record){.confirmed = peer->confirmed,
                         .tick = peer->tick,
                         .desync_tick = d->tick,
                         .waiting = peer->waiting,
                         .stalls = (uint32_t)n->stalls,
                         .stalled_s = (float)((double)n->stalled_frames * g->env.dt),
                         .rollbacks = (uint32_t)n->rollbacks,
                         .rollback_ticks = (uint32_t)n->rollback_ticks,
                         .desync_entity = d->entity,
                         .desync_field = (uint32_t)d->field,
                         .desync_m = (float)d->error,
                         .desync_ulps = d->ulps};
}

/* Only where clients have worlds of their own. */
static int count(const ll_netgame *g)
{
    return ll_netgame_sync(g)->observe ? g->config.player_count : 0;
}

void ll_netgame_peer_section(const ll_netgame *g,
                             void (*section)(void *context, int type, int count, const void *bytes,
                                             size_t size),
                             void *context)
{
    peer_record records[LL_PLAYERS_MAX];
    for (int i = 0; i < count(g); i++)
        records[i] = record_of(g, i);
    section(context, SECTION_PEERS, count(g), records, (size_t)count(g) * sizeof records[0]);
}

void ll_netgame_peer_section_json(const ll_netgame *g, cJSON *frame)
{
    cJSON *peers = cJSON_AddArrayToObject(frame, "peers");
    for (int i = 0; i < count(g); i++) {
        peer_record r = record_of(g, i);
        cJSON *o = cJSON_CreateObject();
        number(o, "confirmed", (double)r.confirmed);
        number(o, "tick", (double)r.tick);
        number(o, "desync_tick", (double)r.desync_tick);
        number(o, "waiting", r.waiting);
        number(o, "stalls", r.stalls);
        number(o, "stalled_s", (double)r.stalled_s);
        number(o, "rollbacks", r.rollbacks);
        number(o, "rollback_ticks", r.rollback_ticks);
        number(o, "desync_entity", r.desync_entity);
        number(o, "desync_field", r.desync_field);
        number(o, "desync_m", (double)r.desync_m);
        number(o, "desync_ulps", r.desync_ulps);
        cJSON_AddItemToArray(peers, o);
    }
}

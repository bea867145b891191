#include "netcode/observe/desync.h"

#include <string.h>

#include "base/detmath.h"
#include "netcode/server/relay_server.h"

const char *const ll_field_names[LL_FIELDS + 2] = {"x",     "y",    "vx", "vy", "angle", "angular_velocity",
                                                   "flags", "tail", NULL};

_Static_assert(sizeof(ll_entity) == LL_FIELDS * 8, "one name per field");

size_t ll_desync_size(size_t world_size)
{
    return sizeof(ll_desync) + world_size;
}

void ll_desync_start(ll_desync *d, int64_t step)
{
    *d = (ll_desync){.compared = step, .tick = -1, .entity = -1};
}

/* Maps doubles in their order to integers: upwards from zero, and downwards for negative ones. */
static int64_t ordinal(double x)
{
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits < 0 ? INT64_MIN - bits : bits;
}

double ll_ulps(double a, double b)
{
    int64_t p = ordinal(a), q = ordinal(b);
    return p > q ? (double)((uint64_t)p - (uint64_t)q) : (double)((uint64_t)q - (uint64_t)p);
}

static void find_field(ll_desync *d, const ll_world *truth, const ll_world *world)
{
    for (d->entity = 0; d->entity < world->entities; d->entity++)
        for (d->field = 0; d->field < LL_FIELDS; d->field++)
            if (memcmp((const char *)&truth->entity[d->entity] + d->field * 8,
                       (const char *)&world->entity[d->entity] + d->field * 8, 8) != 0)
                return;
    d->entity = -1;
}

static double field_ulps(const ll_desync *d, const ll_world *truth, const ll_world *world)
{
    double a, b;
    if (d->entity < 0)
        return 0;
    memcpy(&a, (const char *)&truth->entity[d->entity] + d->field * 8, sizeof a);
    memcpy(&b, (const char *)&world->entity[d->entity] + d->field * 8, sizeof b);
    return ll_ulps(a, b);
}

static double furthest(const ll_world *truth, const ll_world *world)
{
    double most = 0;
    for (int i = 0; i < world->entities; i++) {
        double dx = world->entity[i].x - truth->entity[i].x, dy = world->entity[i].y - truth->entity[i].y;
        double square = dx * dx + dy * dy;
        most = square > most ? square : most;
    }
    return ll_sqrt(most);
}

static void measure(ll_desync *d, const ll_world *truth, const ll_world *world, int64_t tick, ll_freq freq)
{
    double ulps = field_ulps(d, truth, world);
    if (tick == d->tick)
        d->ulps = ulps;
    if (tick == d->tick + ll_tick_at(LL_SECOND, freq))
        d->ulps_1s = ulps;
    if (tick == d->tick + ll_tick_at(10 * LL_SECOND, freq))
        d->ulps_10s = ulps;
    d->ulps_max = ulps > d->ulps_max ? ulps : d->ulps_max;
    d->error = furthest(truth, world);
    d->error_max = d->error > d->error_max ? d->error : d->error_max;
}

static void step_truth(ll_world *truth, const ll_client_setup *s, const ll_server *server, int64_t tick)
{
    ll_action actions[LL_PLAYERS_MAX];
    for (int i = 0; i < server->players; i++)
        actions[i] = server->client_slots[i].inputs.ring[tick & (LL_INPUT_RING - 1)].action;
    s->game->step(truth, s->env, actions, ll_clock_time(&server->clock, tick), NULL);
}

/* The first tick that differs: up to the tick before, both worlds were equal. */
static void record_first_difference(ll_desync *d, const ll_client *c, const ll_client_setup *s,
                                    const ll_server *server)
{
    ll_world *truth = (ll_world *)(d + 1);
    const ll_world *world = ll_peer_world(c, d->compared);
    d->tick = d->compared;
    memcpy(truth, ll_peer_world(c, d->tick - 1), (size_t)c->layout.world_size);
    step_truth(truth, s, server, d->tick);
    find_field(d, truth, world);
    if (s->recorder)
        s->recorder->record(s->recorder->context, &(ll_event){.type = LL_EVENT_DESYNC,
                                                              .player = (uint8_t)c->self,
                                                              .begin = c->ticks.last,
                                                              .end = c->ticks.last,
                                                              .number = (uint32_t)d->tick,
                                                              .value = (float)field_ulps(d, truth, world)});
}

/* A client that plays alone may be further ahead of the server than its ring of worlds is long. The server
 * may be further ahead of a dropped client than its ring of hashes is long. Missing worlds are not compared.
 * `record_first_difference` also needs the world before. */
static bool is_kept(const ll_peer *peer, int64_t tick)
{
    return tick - 1 > peer->tick - LL_PEER_RING;
}

static bool same(const ll_peer *peer, const ll_server *server, int64_t tick)
{
    return !ll_server_has_hash(server, tick) ||
           peer->hashes[tick & (LL_PEER_RING - 1)] == server->hashes[tick & (LL_HASH_RING - 1)];
}

void ll_desync_observe(ll_desync *d, const ll_client *c, const ll_client_setup *s, const ll_server *server)
{
    const ll_peer *peer = ll_client_peer(c);
    ll_world *truth = (ll_world *)(d + 1);
    int64_t upto = peer->confirmed < server->step ? peer->confirmed : server->step;
    while (d->compared < upto) {
        int64_t tick = ++d->compared;
        if (d->tick >= 0)
            step_truth(truth, s, server, tick);
        if (!is_kept(peer, tick))
            continue;
        if (d->tick < 0) {
            if (same(peer, server, tick))
                continue;
            record_first_difference(d, c, s, server);
        }
        measure(d, truth, ll_peer_world(c, tick), tick, server->clock.freq);
    }
}

#include "netcode/spectate/feed.h"

#include <string.h>

_Static_assert(LL_FEED_RING % 2 == 0, "a feed is a multiple of 8 bytes");

static ll_controls *inputs_of(ll_feed *f, int64_t tick)
{
    return &f->inputs[(tick & (LL_FEED_RING - 1)) * f->players];
}

size_t ll_feed_size(int players)
{
    return sizeof(ll_feed) + (size_t)players * LL_FEED_RING * sizeof(ll_controls);
}

void ll_feed_start(ll_feed *f, int players, uint16_t epoch, int64_t step)
{
    memset(f, 0, ll_feed_size(players));
    f->players = players;
    f->epoch = epoch;
    f->begun = f->newest = f->settled = f->acked = step;
    f->joins = -1;
}

/* ---- what the sender knows ---- */

void ll_feed_follow_client(ll_feed *f, const ll_client *c)
{
    ll_peer *peer = ll_client_peer(c);
    if (f->joins != c->connection.joins) {
        f->joins = c->connection.joins;
        f->begun = f->newest = f->settled = peer->start;
    }
    /* At each tick: a peer keeps the inputs of a confirmed tick as long. */
    while (f->newest < peer->confirmed) {
        int64_t tick = ++f->newest;
        for (int p = 0; p < f->players; p++)
            inputs_of(f, tick)[p] = *ll_peer_input(peer, p, tick);
    }
    int64_t own = peer->first + c->inputs.acked, settled = own < f->newest ? own : f->newest;
    f->settled = settled > f->settled ? settled : f->settled;
}

void ll_feed_follow_server(ll_feed *f, const ll_server *server)
{
    if (server->step - f->newest > LL_FEED_RING) /* earlier ones would be overwritten */
        f->newest = f->begun = server->step - LL_FEED_RING;
    while (f->newest < server->step) {
        int64_t tick = ++f->newest;
        for (int p = 0; p < f->players; p++) {
            const ll_action *a = &server->client_slots[p].inputs.ring[tick & (LL_INPUT_RING - 1)].action;
            inputs_of(f, tick)[p] = (ll_controls){{a->axis[0], a->axis[1]}, a->buttons};
        }
    }
    f->settled = f->newest;
}

const ll_world *ll_feed_client_world(const ll_feed *f, const ll_client *c)
{
    const ll_peer *peer = ll_client_peer(c);
    bool kept = f->settled >= peer->start && f->settled > peer->tick - LL_PEER_RING;
    return kept ? ll_peer_world(c, f->settled) : NULL;
}

/* ---- packets ---- */

void ll_feed_receive(ll_feed *f, const ll_watch_message *m)
{
    if (m->head.epoch != f->epoch)
        return;
    f->acked = m->known > f->acked ? m->known : f->acked;
    if (m->request != 0 && m->request >= f->answered) /* equal: the answer was lost, or is on its way */
        f->request = m->request;
}

/* Inputs follow the first world that answers a request: a second one, sent since the request was repeated,
 * leaves no gap between them. */
static int answer(ll_feed *f, const ll_world *world, void *packet)
{
    size_t size = ll_world_size(world);
    ll_feed_message m = {.head = {LL_MESSAGE_RELAY, 0, (uint16_t)f->epoch, (uint32_t)f->settled},
                         .tick = (int32_t)(f->settled + 1),
                         .world = 1};
    if (f->request != f->answered)
        f->acked = f->settled;
    f->answered = f->request;
    f->request = 0;
    memcpy(packet, &m, sizeof m);
    memcpy((char *)packet + sizeof m, world, size);
    return (int)(sizeof m + size);
}

/* Of one player; the runs must hold all that fits. Returns the number of ticks that do. */
static int write_runs(ll_feed *f, int player, int64_t first, int64_t last, ll_input_run *runs, int *count)
{
    int64_t tick = first;
    for (*count = 0; tick <= last; tick++)
        if (!ll_run_add(runs, count, &inputs_of(f, tick)[player]))
            break;
    return (int)(tick - first);
}

int ll_feed_compose(ll_feed *f, const ll_world *world, void *packet)
{
    if (f->request != 0 && world)
        return answer(f, world, packet);
    const int64_t oldest = f->newest - LL_FEED_RING > f->begun ? f->newest - LL_FEED_RING : f->begun;
    const int64_t first = (f->acked > oldest ? f->acked : oldest) + 1;
    if (first > f->settled)
        return 0;
    ll_feed_message *m = packet;
    ll_input_run most[LL_RUNS_MAX];
    int count, ticks = (int)(f->settled - first + 1);
    for (int p = 0; p < f->players; p++)
        ticks = write_runs(f, p, first, first + ticks - 1, most, &count);
    char *at = (char *)(m + 1);
    for (int p = 0; p < f->players; p++) {
        uint32_t *runs = (uint32_t *)(void *)at;
        ll_input_run *run = (ll_input_run *)(runs + 1);
        write_runs(f, p, first, first + ticks - 1, run, &count);
        *runs = (uint32_t)count;
        at = (char *)(run + count);
    }
    *m = (ll_feed_message){.head = {LL_MESSAGE_RELAY, 0, (uint16_t)f->epoch, (uint32_t)f->settled},
                           .tick = (int32_t)first,
                           .count = ticks};
    return (int)(at - (char *)packet);
}

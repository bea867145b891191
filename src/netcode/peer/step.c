/* The worlds of a peer: stepped, resimulated, and compared with earlier results. */
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "netcode/peer/float_mode.h"
#include "netcode/protocol/world_hash.h"
#include "netcode/state/peer.h"

/* A player whose input for `tick` has not arrived keeps its last controls, including presses (GGPO). */
static void guess(ll_peer *peer, int players, int64_t tick)
{
    for (int p = 0; p < players; p++) {
        int64_t known = peer->player[p].known;
        if (known >= tick)
            continue;
        *ll_peer_input(peer, p, tick) =
            known > peer->start ? *ll_peer_input(peer, p, known) : (ll_controls){0};
    }
}

static void step(ll_client *c, const ll_client_setup *s, ll_world *world, int64_t tick)
{
    ll_peer *peer = ll_client_peer(c);
    ll_action actions[LL_PLAYERS_MAX];
    for (int p = 0; p < world->players; p++) {
        const ll_controls *input = ll_peer_input(peer, p, tick);
        actions[p] = (ll_action){{input->axis[0], input->axis[1]}, input->buttons, 0};
    }
    ll_float_mode_step(s, c->self, world, actions, tick, ll_clock_time(&peer->ticks, tick));
}

static void make_tick(ll_client *c, const ll_client_setup *s, int64_t tick)
{
    ll_world *world = ll_peer_world(c, tick);
    LL_ASSERT(tick - ll_client_peer(c)->confirmed < LL_PEER_RING); /* confirmed worlds are kept */
    memcpy(world, ll_peer_world(c, tick - 1), (size_t)c->layout.world_size);
    guess(ll_client_peer(c), world->players, tick);
    step(c, s, world, tick);
}

void ll_peer_step(ll_client *c, const ll_client_setup *s)
{
    make_tick(c, s, ++ll_client_peer(c)->tick);
}

/* Reports every moved entity to the view; as elsewhere only the own entity's move counts as a correction. */
static void correct(ll_client *c, const ll_client_setup *s, const ll_world *before, const ll_world *after,
                    ll_time now)
{
    for (int i = 0; i < after->entities; i++) {
        const ll_entity *from = &before->entity[i], *to = &after->entity[i];
        double dx = to->x - from->x, dy = to->y - from->y, size = ll_sqrt(dx * dx + dy * dy);
        if (size == 0)
            continue;
        ll_smooth_correct(c, i, from, to);
        if (i == c->self)
            ll_note_correction(c, s, LL_CAUSE_CONTACT, dx < 0 ? -size : size, now);
    }
}

void ll_peer_roll_back(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    int64_t first = peer->wrong, ticks = peer->tick - first + 1;
    if (first == LL_NEVER)
        return;
    LL_ASSERT(first > peer->confirmed && first <= peer->tick); /* only guessed ticks are resimulated */
    ll_world *before = ll_client_predicted(c);
    memcpy(before, ll_peer_world(c, peer->tick), (size_t)c->layout.world_size);
    for (int64_t tick = first; tick <= peer->tick; tick++)
        make_tick(c, s, tick);
    peer->wrong = LL_NEVER;
    correct(c, s, before, ll_peer_world(c, peer->tick), now);

    ll_stepping *n = &s->client_metrics->stepping;
    if (now >= s->client_metrics->from) {
        n->rollbacks++;
        n->rollback_ticks += ticks;
        n->rollback_ticks_max = ticks > n->rollback_ticks_max ? ticks : n->rollback_ticks_max;
        if (s->choices)
            s->choices->deep += ticks > s->choices->budget;
    }
    if (s->recorder)
        s->recorder->record(s->recorder->context, &(ll_event){.type = LL_EVENT_ROLLBACK,
                                                              .player = (uint8_t)c->self,
                                                              .begin = now,
                                                              .end = now,
                                                              .number = (uint32_t)first,
                                                              .value = (float)ticks});
}

void ll_peer_confirm(ll_client *c)
{
    ll_peer *peer = ll_client_peer(c);
    int64_t certain = peer->tick;
    for (int p = 0; p < ll_client_rendered(c)->players; p++)
        certain = peer->player[p].known < certain ? peer->player[p].known : certain;
    while (peer->confirmed < certain) {
        int64_t tick = ++peer->confirmed;
        peer->hashes[tick & (LL_PEER_RING - 1)] = ll_world_hash(ll_peer_world(c, tick));
    }
}

/* The saved world must contain all that a step depends on: the same world and inputs must give the same
 * result. */
void ll_peer_sync_test(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    int64_t back = s->rules->sync_test_ticks, first = peer->tick - back;
    ll_world *world = ll_client_predicted(c);
    bool counts = now >= s->client_metrics->from;
    if (back == 0 || first < peer->start)
        return;
    memcpy(world, ll_peer_world(c, first), (size_t)c->layout.world_size);
    for (int64_t tick = first + 1; tick <= peer->tick; tick++)
        step(c, s, world, tick);
    s->client_metrics->stepping.sync_tests += counts;
    s->client_metrics->stepping.sync_test_mismatches +=
        counts && ll_world_hash(world) != ll_world_hash(ll_peer_world(c, peer->tick));
}

#include "netcode/snapshot/replica.h"

#include <string.h>

#include "base/assert.h"

static size_t replica_size(int entities)
{
    return sizeof(ll_replica) + (size_t)entities * sizeof(ll_replica_entity);
}

size_t ll_replicas_size(int players, int entities)
{
    return sizeof(ll_replicas) + (size_t)players * replica_size(entities);
}

ll_replica *ll_replicas_of(const ll_replicas *all, int player)
{
    return (ll_replica *)((char *)(all + 1) + (size_t)player * replica_size(all->entities));
}

void ll_replicas_init(ll_replicas *all, int players, int entities)
{
    LL_ASSERT(entities <= LL_ENTITIES_MAX);
    memset(all, 0, ll_replicas_size(players, entities));
    all->players = players;
    all->entities = entities;
    all->tick = -1;
}

static void restart(ll_replica *r, int entities)
{
    r->begun = r->ended = 0;
    memset(r->tick, 0, sizeof r->tick);
    memset(r->entity, 0, (size_t)entities * sizeof r->entity[0]);
}

void ll_replica_restart(ll_replica *r, int entities, uint16_t epoch)
{
    restart(r, entities);
    if (r->epoch == 0) /* otherwise it still has what it had */
        memset(r->known, 0, sizeof r->known);
    memset(r->scope, 0, sizeof r->scope);
    r->epoch = epoch;
}

void ll_replicas_forget(ll_replicas *all)
{
    for (int i = 0; i < all->players; i++) {
        ll_replica *r = ll_replicas_of(all, i);
        restart(r, all->entities);
        for (int e = 0; e < all->entities; e++)
            r->known[e >> 6] |= UINT64_C(1) << (e & 63);
    }
}

/* ---- the area of interest ---- */

static int64_t square_of(double x, double side)
{
    double n = x / side;
    if (!(n > -1e15 && n < 1e15)) /* a far one shares a square; NaN too */
        return 0;
    int64_t whole = (int64_t)n;
    return whole - ((double)whole > n);
}

static unsigned bucket_of(int64_t column, int64_t row)
{
    uint64_t n = (uint64_t)column * 0x9E3779B97F4A7C15u + (uint64_t)row * 0xC2B2AE3D27D4EB4Fu;
    return (unsigned)(n >> 54);
}
_Static_assert(LL_GRID_BUCKETS == 1 << 10, "the highest ten bits are a bucket");

/* An entity is looked for up to radius + margin away: squares are that wide, so that nine are enough. */
static double side_of(const ll_selection *s)
{
    return s->radius_m + s->margin_m;
}

void ll_replicas_begin(ll_replicas *all, const ll_world *world, int64_t tick)
{
    if (all->tick == tick)
        return;
    all->tick = tick;
    all->update++;
    if (all->selection.radius_m == 0)
        return;
    memset(all->bucket, 0, sizeof all->bucket);
    for (int e = all->entities - 1; e >= 0; e--) {
        const ll_entity *at = &world->entity[e];
        const double side = side_of(&all->selection);
        uint16_t *bucket = &all->bucket[bucket_of(square_of(at->x, side), square_of(at->y, side))];
        all->next[e] = *bucket;
        *bucket = (uint16_t)(e + 1);
    }
}

static bool has(const uint64_t *bits, int e)
{
    return bits[e >> 6] >> (e & 63) & 1;
}

static void add_square(const ll_replicas *all, const ll_world *world, int self, unsigned bucket,
                       const uint64_t *before, uint64_t *scope)
{
    const ll_entity *own = &world->entity[self];
    const double enters = all->selection.radius_m, leaves = side_of(&all->selection);
    for (int n = all->bucket[bucket]; n != 0; n = all->next[n - 1]) {
        const int e = n - 1;
        double dx = world->entity[e].x - own->x, dy = world->entity[e].y - own->y;
        double limit = has(before, e) ? leaves : enters;
        if (dx * dx + dy * dy <= limit * limit)
            scope[e >> 6] |= UINT64_C(1) << (e & 63);
    }
}

void ll_replicas_find_scope(const ll_replicas *all, ll_replica *r, const ll_world *world, int player,
                            bool interest)
{
    uint64_t before[LL_ENTITY_WORDS];
    memcpy(before, r->scope, sizeof before);
    memset(r->scope, 0, sizeof r->scope);
    if (!interest || all->selection.radius_m == 0) {
        for (int e = 0; e < all->entities; e++)
            r->scope[e >> 6] |= UINT64_C(1) << (e & 63);
    } else {
        const ll_entity *own = &world->entity[player];
        const double side = side_of(&all->selection);
        const int64_t column = square_of(own->x, side), row = square_of(own->y, side);
        for (int i = 0; i < 9; i++)
            add_square(all, world, player, bucket_of(column + i % 3 - 1, row + i / 3 - 1), before, r->scope);
    }
    r->scope[player >> 6] &= ~(UINT64_C(1) << (player & 63));
}

/* ---- acknowledgements ---- */

static void received(ll_replica *r, const ll_sent_snapshot *s, const ll_baseline *sent)
{
    for (int64_t i = 0; i < s->count; i++) {
        ll_fetch(&r->entity[s->entity[i]], sizeof r->entity[0]);
        ll_fetch(&sent->cell[s->entity[i]], sizeof sent->cell[0]);
    }
    for (int64_t i = 0; i < s->count; i++) {
        const int e = s->entity[i];
        ll_replica_entity *entity = &r->entity[e];
        if (entity->has_acked && sent->tick <= entity->acked_tick)
            continue;
        entity->has_acked = 1;
        entity->acked_tick = sent->tick;
        entity->acked_update = s->update;
        entity->acked_gone = s->gone[i];
        entity->acked = sent->cell[e];
        if (s->gone[i] && entity->sent_tick == sent->tick)
            r->known[e >> 6] &= ~(UINT64_C(1) << (e & 63));
    }
}

/* the count of a snapshot that was lost before its result was known: its step was sent again */
#define VOID (-1)

static void lost(ll_replica *r, const ll_sent_snapshot *s, int64_t tick)
{
    if (s->count == VOID)
        return;
    r->counts.lost += r->counts_now;
    for (int64_t i = 0; i < s->count; i++) {
        ll_replica_entity *entity = &r->entity[s->entity[i]];
        entity->accumulated += s->accumulated[i];
        if (entity->sent_tick == tick)
            entity->has_sent = 0;
    }
}

void ll_replica_acknowledge(ll_replica *r, const ll_baseline_history *history, int64_t newest, uint32_t mask)
{
    for (; r->ended < r->begun; r->ended++) {
        const int64_t tick = r->tick[r->ended % LL_SENT_RING], age = newest - tick;
        const ll_sent_snapshot *s = &r->sent[r->ended % LL_SENT_RING];
        if (age < 0)
            return;
        const bool came = age == 0 || (age <= 32 && (mask >> (age - 1) & 1));
        const ll_baseline *sent = came ? ll_baseline_history_find(history, tick) : NULL;
        if (sent)
            received(r, s, sent);
        else
            lost(r, s, tick);
    }
}

ll_sent_snapshot *ll_replica_record(ll_replica *r, const ll_replicas *all)
{
    const int64_t last = r->begun - 1;
    if (last >= 0 && r->tick[last % LL_SENT_RING] == all->tick) {
        if (last >= r->ended) {
            lost(r, &r->sent[last % LL_SENT_RING], all->tick);
            r->sent[last % LL_SENT_RING].count = VOID;
        }
        return NULL;
    }
    if (r->begun - r->ended == LL_SENT_RING) {
        lost(r, &r->sent[r->ended % LL_SENT_RING], r->tick[r->ended % LL_SENT_RING]);
        r->ended++;
    }
    ll_sent_snapshot *s = &r->sent[r->begun % LL_SENT_RING];
    r->tick[r->begun % LL_SENT_RING] = all->tick;
    r->begun++;
    s->update = all->update;
    s->count = 0;
    return s;
}

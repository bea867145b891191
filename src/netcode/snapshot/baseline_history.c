#include "netcode/snapshot/baseline_history.h"

#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

static size_t record_size(int entities)
{
    return sizeof(ll_baseline) + (size_t)entities * sizeof(ll_cell);
}

size_t ll_baseline_history_size(ll_extent extent)
{
    return sizeof(ll_baseline_history) + LL_BASELINES * record_size(extent.entities) + (size_t)extent.tail;
}

void ll_baseline_history_init(ll_baseline_history *b, ll_extent extent)
{
    memset(b, 0, ll_baseline_history_size(extent));
    b->entities = extent.entities;
    b->tail = extent.tail;
}

void ll_baseline_history_clear(ll_baseline_history *b)
{
    b->count = 0;
}

static ll_baseline *record_at(const ll_baseline_history *b, int64_t i)
{
    _Static_assert((LL_BASELINES & (LL_BASELINES - 1)) == 0, "a mask finds the place");
    return (ll_baseline *)((char *)(b + 1) + (size_t)(i & (LL_BASELINES - 1)) * record_size(b->entities));
}

static char *tail_of(const ll_baseline_history *b)
{
    return (char *)(b + 1) + LL_BASELINES * record_size(b->entities);
}

/* ---- rounding errors ---- */

#define PARTS 64 /* of a step */

static void measure(ll_rounding *rounding, const ll_quantization *grid, const ll_entity *e,
                    const ll_cell *cell)
{
    ll_entity sent = ll_cell_entity(cell, grid);
    double dx = sent.x - e->x, dy = sent.y - e->y, error = ll_sqrt(dx * dx + dy * dy);
    int part = (int)(error / (double)grid->m * PARTS);
    rounding->sum += error;
    rounding->sum_squares += error * error;
    rounding->max = error > rounding->max ? error : rounding->max;
    rounding->count++;
    rounding->bucket[part < LL_ROUNDING_BUCKETS ? part : LL_ROUNDING_BUCKETS - 1]++;
}

static double quantile(const ll_baseline_history *b, double q)
{
    const ll_rounding *r = &b->rounding;
    int64_t seen = 0;
    for (int i = 0; i < LL_ROUNDING_BUCKETS; i++) {
        seen += r->bucket[i];
        double middle = (i + 0.5) / PARTS * (double)b->grid.m;
        if ((double)seen >= q * (double)r->count)
            return middle < r->max ? middle : r->max;
    }
    return r->max;
}

ll_summary ll_rounding_summary(const ll_baseline_history *b)
{
    const ll_rounding *r = &b->rounding;
    if (r->count == 0)
        return (ll_summary){NAN, NAN, NAN, NAN, NAN, NAN, 0, 0};
    return (ll_summary){
        .mean = r->sum / (double)r->count,
        .rms = ll_sqrt(r->sum_squares / (double)r->count),
        .p50 = quantile(b, 0.5),
        .p95 = quantile(b, 0.95),
        .p99 = quantile(b, 0.99),
        .max = r->max,
        .count = r->count,
    };
}

/* ---- the ring ---- */

static bool same_grid(const ll_quantization *a, const ll_quantization *b)
{
    return a->m == b->m && a->mps == b->mps && a->rad == b->rad && a->radps == b->radps;
}

static void take_tail(ll_baseline_history *b, const ll_world *world)
{
    if (memcmp(tail_of(b), ll_world_tail_const(world), (size_t)b->tail) == 0)
        return;
    memcpy(tail_of(b), ll_world_tail_const(world), (size_t)b->tail);
    b->tail_version++;
}

const ll_baseline *ll_baseline_history_take(ll_baseline_history *b, const ll_world *world, int64_t tick,
                                            const ll_quantization *grid, bool counts)
{
    if (!same_grid(&b->grid, grid))
        ll_baseline_history_clear(b);
    if (b->count > 0 && record_at(b, b->count - 1)->tick == tick)
        return record_at(b, b->count - 1);
    LL_ASSERT(b->count == 0 || tick > record_at(b, b->count - 1)->tick); /* in the order of ticks */
    b->grid = *grid;
    take_tail(b, world);
    ll_baseline *record = record_at(b, b->count++);
    record->tick = tick;
    record->tail_version = b->tail_version;
    for (int i = 0; i < b->entities; i++) {
        record->cell[i] = ll_cell_of(&world->entity[i], grid);
        if (counts && ll_cell_fits(&record->cell[i]))
            measure(&b->rounding, grid, &world->entity[i], &record->cell[i]);
    }
    return record;
}

/* Skips the first: a client may hold the world of that tick on the previous grid. */
const ll_baseline *ll_baseline_history_find(const ll_baseline_history *b, int64_t tick)
{
    for (int64_t i = b->count - 1; i > 0 && i >= b->count - LL_BASELINES; i--)
        if (record_at(b, i)->tick == tick)
            return record_at(b, i);
    return NULL;
}

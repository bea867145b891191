#include "rigid/broad/broad.h"
#include "rigid/broad/heap_sort.h"

#include <stddef.h>
#include <string.h>

#define PHASE(KIND, NAME) &ll_broad_##NAME,
#define NAMED(KIND, NAME) #NAME,
const ll_broad_phase *const ll_broad_phases[LL_BROADS] = {LL_BROAD_PHASES(PHASE)};
const char *const ll_broad_names[LL_BROADS + 1] = {LL_BROAD_PHASES(NAMED) NULL};

typedef struct gather {
    const uint8_t *moved;
    int32_t self;
    ll_pair_list *out;
} gather;

/* If both proxies moved, the one with the smaller index reports the pair. */
static void found(void *context, int32_t other)
{
    const gather *g = context;
    if (other != g->self && (!g->moved[other] || g->self < other))
        ll_pair_emit(g->out, g->self, other);
}

static inline uint64_t key(ll_proxy_pair p)
{
    return (uint64_t)(uint32_t)p.a << 32 | (uint32_t)p.b;
}

static inline bool before(ll_proxy_pair a, ll_proxy_pair b)
{
    return key(a) < key(b);
}

LL_HEAP_SORT(heap_sort, ll_proxy_pair, before)

/* Quicksort that falls back to heapsort when partitions are too uneven: n log n for every input. */
static void sort(ll_proxy_pair *at, int32_t count, int depth)
{
    while (count > 24 && depth-- > 0) {
        uint64_t a = key(at[0]), b = key(at[count / 2]), c = key(at[count - 1]);
        uint64_t middle = a < b ? (b < c ? b : a < c ? c : a) : (a < c ? a : b < c ? c : b);
        int32_t i = 0, j = count - 1;
        while (i <= j) {
            while (key(at[i]) < middle)
                i++;
            while (key(at[j]) > middle)
                j--;
            if (i <= j) {
                ll_proxy_pair swap = at[i];
                at[i++] = at[j];
                at[j--] = swap;
            }
        }
        sort(at, j + 1, depth);
        at += i;
        count -= i;
    }
    if (count > 24) {
        heap_sort(at, count);
        return;
    }
    for (int32_t i = 1; i < count; i++) {
        ll_proxy_pair value = at[i];
        int32_t k = i;
        for (; k > 0 && key(at[k - 1]) > key(value); k--)
            at[k] = at[k - 1];
        at[k] = value;
    }
}

/* Accepts the pairs that wait in the queue. */
static void flush(ll_pair_list *out)
{
    int32_t waiting = out->queued < ll_pair_queue ? (int32_t)out->queued : ll_pair_queue;
    for (int32_t i = 0; i < waiting; i++)
        if (out->accept(out->context, out->queue[i].a, out->queue[i].b))
            ll_pair_keep(out, out->queue[i]);
    out->queued = 0;
}

static bool run_in_parts(ll_pair_list *out, int parts, ll_team_job *job, ll_pair_parts *all)
{
    bool overflowed = false;
    int32_t count = out->count;
    for (int k = 0; k < parts; k++) {
        ll_share of = ll_share_of(out->capacity - count, k, parts);
        ll_pair_list *part = &all->part[k];
        part->at = out->at + count + of.begin;
        part->count = 0;
        part->capacity = of.end - of.begin;
        part->overflowed = false;
        part->accept = out->accept;
        part->announce = out->announce;
        part->context = out->context;
        part->queued = 0;
    }
    if (parts > 1)
        out->team->run(out->team, job, all);
    else
        job(all, 0, 1);
    for (int k = 0; k < parts; k++) {
        ll_pair_list *part = &all->part[k];
        flush(part);
        overflowed |= part->overflowed;
        memmove(out->at + out->count, part->at, (size_t)part->count * sizeof *part->at);
        out->count += part->count;
    }
    if (overflowed && parts > 1)
        out->count = count;
    else
        out->overflowed |= overflowed;
    return !overflowed;
}

void ll_pair_run(ll_pair_list *out, int32_t count, int32_t least, ll_team_job *job, void *context)
{
    ll_pair_parts all; /* not all of it is used, nor cleared */
    int parts = count < least ? 1 : ll_team_parts(out->team);
    all.context = context;
    if (!run_in_parts(out, parts, job, &all) && parts > 1)
        run_in_parts(out, 1, job, &all);
}

typedef struct queries {
    const ll_broad_phase *phase;
    void *state;
    const ll_aabb *boxes;
    const uint8_t *moved;
    const int32_t *list;
    int32_t count;
} queries;

static void query_part(void *context, int part, int parts)
{
    ll_pair_parts *all = context;
    const queries *q = all->context;
    ll_share of = ll_share_of(q->count, part, parts);
    for (int32_t i = of.begin; i < of.end; i++)
        q->phase->query(q->state, q->boxes, q->boxes[q->list[i]], found,
                        &(gather){.moved = q->moved, .self = q->list[i], .out = &all->part[part]});
}

void ll_broad_pairs(const ll_broad_phase *phase, void *state, const ll_aabb *boxes, const uint8_t *moved,
                    const int32_t *list, int32_t count, ll_pair_list *out)
{
    enum { least = 64 }; /* a query takes about 200 ns */
    if (count == 0)
        return;
    if (phase->pairs == NULL || !phase->pairs(state, boxes, moved, count, out)) {
        queries q = {phase, state, boxes, moved, list, count};
        ll_pair_run(out, count, least, query_part, &q);
    }
    flush(out);
    sort(out->at, out->count, 48);
}

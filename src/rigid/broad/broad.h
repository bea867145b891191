/* Broad phases: find overlapping boxes without testing all against all.
 *
 * Each is one file and one row of a table. All find the same pairs: proxies whose boxes overlap and of which
 * at least one has moved since the last call. A proxy is an index into the caller's `boxes`. The state is
 * part of the caller's block and holds no pointers. */
#pragma once

#include <stddef.h>

#include "base/team.h"
#include "rigid/shape/vec.h"

typedef struct ll_proxy_pair {
    int32_t a, b; /* a < b */
} ll_proxy_pair;

enum { ll_pair_queue = 16 };

typedef struct ll_pair_list {
    ll_proxy_pair *at;
    int32_t count, capacity;
    bool overflowed;                                           /* more pairs than capacity */
    bool (*accept)(const void *context, int32_t a, int32_t b); /* filters pairs; NULL: all are accepted */
    void (*announce)(
        const void *context, int32_t a,
        int32_t b); /* announces a later call of accept, for prefetching; set together with accept */
    const void *context;
    ll_team *team; /* finds the pairs in parts; NULL: the caller alone */
    void *scratch; /* for broad phases that need it */
    size_t scratch_size;
    ll_proxy_pair queue[ll_pair_queue]; /* announced and not yet accepted: gives the prefetch time */
    uint32_t queued;                    /* pairs queued so far */
} ll_pair_list;

typedef void ll_broad_visit(void *context, int32_t proxy);

typedef struct ll_broad_phase {
    const char *name;
    const char *help;                 /* method and cost */
    size_t (*size)(int32_t capacity); /* bytes, a multiple of 64 */
    void (*init)(void *state, int32_t capacity);
    void (*insert)(void *state, const ll_aabb *boxes, int32_t proxy);
    void (*remove)(void *state, int32_t proxy);
    void (*move)(void *state, const ll_aabb *boxes, int32_t proxy); /* its box has changed */
    /* Visits every proxy whose box overlaps `box`, in unspecified but repeatable order. */
    void (*query)(const void *state, const ll_aabb *boxes, ll_aabb box, ll_broad_visit *visit, void *context);
    /* All pairs at once, when `count` proxies have moved. Returns false if it did nothing; the caller then
     * queries each proxy. NULL: not supported. */
    bool (*pairs)(void *state, const ll_aabb *boxes, const uint8_t *moved, int32_t count, ll_pair_list *out);
} ll_broad_phase;

/* The broad phases. Stored configurations hold the index: a new one is the last. */
/* clang-format off */
#define LL_BROAD_PHASES(ROW) \
    ROW(BRUTE, brute) \
    ROW(SAP, sap) \
    ROW(GRID, grid) \
    ROW(TREE, tree)
/* clang-format on */

#define LL_BROAD_KIND(KIND, NAME) LL_BROAD_##KIND,
typedef enum ll_broad_kind { LL_BROAD_PHASES(LL_BROAD_KIND) LL_BROADS } ll_broad_kind;
#undef LL_BROAD_KIND

#define LL_BROAD_DECLARE(KIND, NAME) extern const ll_broad_phase ll_broad_##NAME;
LL_BROAD_PHASES(LL_BROAD_DECLARE)
#undef LL_BROAD_DECLARE
extern const ll_broad_phase *const ll_broad_phases[LL_BROADS];
extern const char *const ll_broad_names[LL_BROADS + 1]; /* NULL-terminated */

/* The overlapping pairs with a moved proxy, sorted: the same list from every broad phase. `moved` has a byte
 * per proxy, `list` holds the indices of those that are set. */
void ll_broad_pairs(const ll_broad_phase *phase, void *state, const ll_aabb *boxes, const uint8_t *moved,
                    const int32_t *list, int32_t count, ll_pair_list *out);

/* strips.c: the pairs of `count` proxies. False without enough scratch, or when too many are too tall. */
bool ll_broad_strips(const ll_aabb *boxes, const uint8_t *moved, const int32_t *live, int32_t count,
                     ll_pair_list *out);

/* table.c: runs a job that emits pairs, over `count` elements. Each part has the list `part[its number]` with
 * its own part of the room, and the lists are joined afterwards: their order does not matter, since pairs are
 * sorted in the end. When a part has too little room, one part does the job again with all of it. */
typedef struct ll_pair_parts {
    void *context;
    ll_pair_list part[LL_TEAM_PARTS_MAX];
} ll_pair_parts;

void ll_pair_run(ll_pair_list *out, int32_t count, int32_t least, ll_team_job *job, void *context);

static inline void ll_pair_keep(ll_pair_list *out, ll_proxy_pair p)
{
    if (out->count < out->capacity)
        out->at[out->count++] = p;
    else
        out->overflowed = true;
}

static inline void ll_pair_emit(ll_pair_list *out, int32_t a, int32_t b)
{
    ll_proxy_pair p = a < b ? (ll_proxy_pair){a, b} : (ll_proxy_pair){b, a};
    if (out->accept == NULL) {
        ll_pair_keep(out, p);
        return;
    }
    ll_proxy_pair *place = &out->queue[out->queued % ll_pair_queue];
    if (out->queued++ >= ll_pair_queue && out->accept(out->context, place->a, place->b))
        ll_pair_keep(out, *place);
    *place = p;
    out->announce(out->context, p.a, p.b);
}

/* Hierarchy of uniform grids. A box is stored in the cell of its centre, on the finest level whose cells are
 * at least as large as the box. A query visits the neighbouring cells on every used level. Cells are lists in
 * a hash table. A move within a cell is free. (Ericson, Real-Time Collision Detection, 7.2.)
 *
 * Costs n + pairs for bodies of any sizes, unless they are piled up at one position. */
#include "rigid/broad/broad.h"

#include "base/assert.h"
#include "base/mix.h"

#define LEVELS 48
#define LEAST_CELL (1.0 / 64) /* m; level k has cells of LEAST_CELL * 2^k */

typedef struct node {
    int32_t next, previous; /* in the bucket's list; -1: last, -2 - bucket: first */
    int32_t x, y;           /* cell */
    int32_t level, pad;
} node;

typedef struct grid {
    int32_t capacity, buckets; /* buckets is a power of two */
    int32_t end;               /* one more than the largest proxy ever inserted */
    int32_t used[LEVELS];      /* proxies on each level */
    int32_t pad[13];
    /* then int32_t head[buckets], node at[capacity] */
} grid;

static int32_t bucket_count(int32_t capacity)
{
    int32_t n = 16;
    while (n < capacity)
        n *= 2;
    return n;
}

static int32_t *heads(const grid *g)
{
    return (int32_t *)(g + 1);
}

static node *nodes(const grid *g)
{
    return (node *)(heads(g) + g->buckets);
}

static size_t size(int32_t capacity)
{
    return (sizeof(grid) + (size_t)bucket_count(capacity) * sizeof(int32_t) +
            (size_t)capacity * sizeof(node) + 63) &
           ~(size_t)63;
}

static void init(void *state, int32_t capacity)
{
    grid *g = state;
    *g = (grid){.capacity = capacity, .buckets = bucket_count(capacity)};
    LL_ASSERT((g->buckets & (g->buckets - 1)) == 0); /* a mask finds the bucket */
    for (int32_t i = 0; i < g->buckets; i++)
        heads(g)[i] = -1;
}

static inline double cell_size(int level)
{
    return LEAST_CELL * (double)(INT64_C(1) << level);
}

/* The largest cells are 2^47 / 64 m, and coordinates are at most 1e9 m plus a box: cell numbers of the finest
 * level stay below 2^37 and are cut to 32 bits. Two cells may then share a number; the box test separates
 * them. */
static inline int32_t cell_number(double x, double per_cell)
{
    double scaled = x * per_cell;
    int64_t whole = (int64_t)scaled;
    return (int32_t)(uint32_t)(uint64_t)(whole - (scaled < (double)whole));
}

static inline uint32_t bucket_of(const grid *g, int32_t x, int32_t y, int level)
{
    uint64_t cell = (uint64_t)(uint32_t)x << 32 | (uint32_t)y;
    cell = (cell + (uint64_t)level) * LL_MIX_STEP;
    return (uint32_t)((cell ^ cell >> 29) * LL_MIX_STEP >> 32) & (uint32_t)(g->buckets - 1);
}

static node place_of(const ll_aabb *box)
{
    double width = ll_max(box->upper.x - box->lower.x, box->upper.y - box->lower.y);
    int level = 0;
    while (level < LEVELS - 1 && cell_size(level) < width)
        level++;
    double per_cell = 1 / cell_size(level);
    return (node){.x = cell_number(0.5 * (box->lower.x + box->upper.x), per_cell),
                  .y = cell_number(0.5 * (box->lower.y + box->upper.y), per_cell),
                  .level = level};
}

static void link_in(grid *g, int32_t proxy, node place)
{
    int32_t *head = heads(g);
    node *at = nodes(g);
    uint32_t bucket = bucket_of(g, place.x, place.y, place.level);
    place.next = head[bucket];
    place.previous = -2 - (int32_t)bucket;
    if (place.next >= 0)
        at[place.next].previous = proxy;
    head[bucket] = proxy;
    at[proxy] = place;
    g->used[place.level]++;
}

static void insert(void *state, const ll_aabb *boxes, int32_t proxy)
{
    grid *g = state;
    LL_ASSERT(proxy >= 0 && proxy < g->capacity);
    for (; g->end <= proxy; g->end++)
        nodes(g)[g->end].level = -1;
    link_in(g, proxy, place_of(&boxes[proxy]));
}

static void remove_proxy(void *state, int32_t proxy)
{
    grid *g = state;
    node *at = nodes(g), old = at[proxy];
    LL_ASSERT(old.level >= 0 && g->used[old.level] > 0); /* it was inserted */
    if (old.previous >= 0)
        at[old.previous].next = old.next;
    else
        heads(g)[-2 - old.previous] = old.next;
    if (old.next >= 0)
        at[old.next].previous = old.previous;
    g->used[old.level]--;
    at[proxy].level = -1;
}

static void move(void *state, const ll_aabb *boxes, int32_t proxy)
{
    grid *g = state;
    const node *old = &nodes(g)[proxy];
    node place = place_of(&boxes[proxy]);
    if (place.x == old->x && place.y == old->y && place.level == old->level)
        return;
    remove_proxy(g, proxy);
    link_in(g, proxy, place);
}

static void query_all(const grid *g, const ll_aabb *boxes, ll_aabb box, int level, ll_broad_visit *visit,
                      void *context)
{
    const node *at = nodes(g);
    for (int32_t i = 0; i < g->end; i++)
        if (at[i].level == level && ll_aabb_overlap(boxes[i], box))
            visit(context, i);
}

/* The centre of an overlapping box is at most half a cell outside. */
static void query_level(const grid *g, const ll_aabb *boxes, ll_aabb box, int level, ll_broad_visit *visit,
                        void *context)
{
    double half = 0.5 * cell_size(level), per_cell = 1 / cell_size(level);
    double columns = (box.upper.x - box.lower.x) * per_cell + 3,
           rows = (box.upper.y - box.lower.y) * per_cell + 3;
    if (!(columns * rows < (double)g->end)) {
        query_all(g, boxes, box, level, visit, context);
        return;
    }
    int32_t x0 = cell_number(box.lower.x - half, per_cell), x1 = cell_number(box.upper.x + half, per_cell);
    int32_t y0 = cell_number(box.lower.y - half, per_cell), y1 = cell_number(box.upper.y + half, per_cell);
    const node *at = nodes(g);
    for (int32_t y = y0;; y++) {
        for (int32_t x = x0;; x++) {
            for (int32_t i = heads(g)[bucket_of(g, x, y, level)]; i >= 0; i = at[i].next)
                if (at[i].x == x && at[i].y == y && at[i].level == level && ll_aabb_overlap(boxes[i], box))
                    visit(context, i);
            if (x == x1)
                break;
        }
        if (y == y1)
            break;
    }
}

static void query(const void *state, const ll_aabb *boxes, ll_aabb box, ll_broad_visit *visit, void *context)
{
    const grid *g = state;
    for (int level = 0; level < LEVELS; level++)
        if (g->used[level] > 0)
            query_level(g, boxes, box, level, visit, context);
}

/* If most proxies have moved, one pass over all is faster than a query for each. */
static bool pairs(void *state, const ll_aabb *boxes, const uint8_t *moved, int32_t count, ll_pair_list *out)
{
    const grid *g = state;
    int32_t *live = out->scratch, lives = 0;
    size_t taken = ((size_t)g->end * sizeof(int32_t) + 63) & ~(size_t)63;
    if (3 * (int64_t)count < g->end || taken > out->scratch_size)
        return false;
    for (int32_t i = 0; i < g->end; i++)
        if (nodes(g)[i].level >= 0)
            live[lives++] = i;
    out->scratch = (char *)out->scratch + taken;
    out->scratch_size -= taken;
    return ll_broad_strips(boxes, moved, live, lives, out);
}

const ll_broad_phase ll_broad_grid = {
    .name = "grid",
    .help = "Grids of cells by size of box; sweeps by strips when most have moved: n + pairs.",
    .size = size,
    .init = init,
    .insert = insert,
    .remove = remove_proxy,
    .move = move,
    .query = query,
    .pairs = pairs};

/* Sweep and prune along x (Baraff 1992): the boxes are sorted by their left side, and each is compared with
 * those that begin before it ends.
 *
 * The order is kept from step to step, and small moves need few exchanges. After large moves everything is
 * sorted again. Costs n log n + the pairs that overlap in x. */
#include "rigid/broad/broad.h"
#include "rigid/broad/heap_sort.h"

#include "base/assert.h"

typedef struct entry {
    double left;
    int32_t proxy, pad;
} entry;

typedef struct sap {
    int32_t count;
    int32_t pad[15];
    entry at[];
} sap;

static size_t size(int32_t capacity)
{
    return (sizeof(sap) + (size_t)capacity * sizeof(entry) + 63) & ~(size_t)63;
}

static void init(void *state, int32_t capacity)
{
    (void)capacity;
    *(sap *)state = (sap){0};
}

static inline bool before(entry a, entry b)
{
    return a.left < b.left || (a.left == b.left && a.proxy < b.proxy);
}

LL_HEAP_SORT(heap_sort, entry, before)

/* Insertion sort, as long as that takes fewer exchanges than a full sort. */
static void put_in_order(entry *at, int32_t count)
{
    int64_t budget = 16 * (int64_t)count;
    for (int32_t i = 1; i < count; i++) {
        entry value = at[i];
        int32_t k = i;
        for (; k > 0 && before(value, at[k - 1]); k--)
            at[k] = at[k - 1];
        at[k] = value;
        budget -= i - k;
        if (budget < 0) {
            heap_sort(at, count);
            return;
        }
    }
}

static void insert(void *state, const ll_aabb *boxes, int32_t proxy)
{
    sap *s = state;
    s->at[s->count++] = (entry){boxes[proxy].lower.x, proxy, 0};
}

static void remove_proxy(void *state, int32_t proxy)
{
    sap *s = state;
    int32_t kept = 0;
    for (int32_t i = 0; i < s->count; i++)
        if (s->at[i].proxy != proxy)
            s->at[kept++] = s->at[i];
    LL_ASSERT(kept == s->count - 1); /* each proxy once */
    s->count = kept;
}

static void move(void *state, const ll_aabb *boxes, int32_t proxy)
{
    (void)state, (void)boxes, (void)proxy;
}

static void query(const void *state, const ll_aabb *boxes, ll_aabb box, ll_broad_visit *visit, void *context)
{
    const sap *s = state;
    for (int32_t i = 0; i < s->count; i++)
        if (ll_aabb_overlap(boxes[s->at[i].proxy], box))
            visit(context, s->at[i].proxy);
}

static bool pairs(void *state, const ll_aabb *boxes, const uint8_t *moved, int32_t count, ll_pair_list *out)
{
    (void)count;
    sap *s = state;
    for (int32_t i = 0; i < s->count; i++)
        s->at[i].left = boxes[s->at[i].proxy].lower.x;
    put_in_order(s->at, s->count);
    for (int32_t i = 0; i < s->count; i++) {
        int32_t p = s->at[i].proxy;
        ll_aabb box = boxes[p];
        for (int32_t k = i + 1; k < s->count && s->at[k].left <= box.upper.x; k++) {
            int32_t q = s->at[k].proxy;
            if ((moved[p] | moved[q]) && boxes[q].lower.y <= box.upper.y && box.lower.y <= boxes[q].upper.y)
                ll_pair_emit(out, p, q);
        }
    }
    return true;
}

const ll_broad_phase ll_broad_sap = {
    .name = "sap",
    .help = "Sweep and prune: sorted by the left side, kept sorted; n log n + overlaps in x.",
    .size = size,
    .init = init,
    .insert = insert,
    .remove = remove_proxy,
    .move = move,
    .query = query,
    .pairs = pairs};

/* All pairs at once: the boxes are sorted into horizontal strips and swept along x within each. Memory is
 * read in order, which queries one by one do not; so this is faster as soon as most boxes have moved. A box
 * that reaches into several strips is in each, and a pair belongs to the strip in which the higher one
 * begins. */
#include "rigid/broad.h"

typedef struct entry {
    double left, right, low, high;
    int32_t proxy, strip;
    int64_t moved;
} entry;

typedef struct strips {
    entry *at;
    int32_t count, capacity;
    double per_height; /* strips a metre */
    int32_t tall[64];  /* boxes of too many strips: each is compared with all */
    int32_t tall_count;
} strips;

/* Boxes of up to this many strips are sorted in. */
enum { most_strips = 6 };

static inline double strip_of(const strips *s, double y)
{
    double scaled = y * s->per_height;
    double whole = (double)(int64_t)scaled;
    return whole > scaled ? whole - 1 : whole;
}

static bool before(const entry *a, const entry *b)
{
    return a->strip < b->strip || (a->strip == b->strip && a->left < b->left) ||
           (a->strip == b->strip && a->left == b->left && a->proxy < b->proxy);
}

/* Shell's sort with Ciura's gaps: in place, and quick where the order is nearly right. */
static void sort(entry *at, int32_t count)
{
    static const int32_t gaps[] = {143500, 63778, 28345, 12597, 5598, 2488, 1106, 491,
                                   218,    97,    43,    19,    10,   4,    1};
    for (size_t g = 0; g < sizeof gaps / sizeof gaps[0]; g++)
        for (int32_t i = gaps[g]; i < count; i++) {
            entry value = at[i];
            int32_t k = i;
            for (; k >= gaps[g] && before(&value, &at[k - gaps[g]]); k -= gaps[g])
                at[k] = at[k - gaps[g]];
            at[k] = value;
        }
}

static bool sort_in(strips *s, ll_aabb box, int32_t proxy, bool moved)
{
    double first = strip_of(s, box.lower.y), last = strip_of(s, box.upper.y);
    if (last - first >= most_strips) {
        s->tall[s->tall_count++] = proxy;
        return s->tall_count < 64;
    }
    if (!(fabs(first) < 1e9) || s->count + most_strips > s->capacity)
        return false;
    for (double strip = first; strip <= last; strip++)
        s->at[s->count++] =
            (entry){box.lower.x, box.upper.x, box.lower.y, box.upper.y, proxy, (int32_t)strip, moved};
    return true;
}

static void sweep(const strips *s, ll_pair_list *out)
{
    for (int32_t i = 0; i < s->count; i++) {
        const entry *a = &s->at[i];
        for (const entry *b = a + 1; b < s->at + s->count && b->strip == a->strip && b->left <= a->right; b++)
            if ((a->moved | b->moved) && a->low <= b->high && b->low <= a->high &&
                (int32_t)strip_of(s, ll_max(a->low, b->low)) == a->strip)
                ll_pair_emit(out, a->proxy, b->proxy);
    }
}

static void compare_tall(const strips *s, const ll_aabb *boxes, const uint8_t *moved, const int32_t *live,
                         int32_t count, ll_pair_list *out)
{
    for (int32_t t = 0; t < s->tall_count; t++) {
        int32_t p = s->tall[t];
        for (int32_t i = 0; i < count; i++) {
            int32_t q = live[i];
            if ((moved[p] | moved[q]) == 0 || p == q || !ll_aabb_overlap(boxes[p], boxes[q]))
                continue;
            bool both_tall = false;
            for (int32_t k = 0; k < s->tall_count; k++)
                both_tall |= s->tall[k] == q;
            if (!both_tall || p < q)
                ll_pair_emit(out, p, q);
        }
    }
}

/* Twice the mean height, without what is ten times as high as the first guess. */
static double strip_height(const ll_aabb *boxes, const int32_t *live, int32_t count)
{
    double least = INFINITY, sum = 0;
    int32_t counted = 0;
    for (int32_t i = 0; i < count; i += 1 + count / 64)
        least = ll_min(least, boxes[live[i]].upper.y - boxes[live[i]].lower.y);
    for (int32_t i = 0; i < count; i++) {
        double height = boxes[live[i]].upper.y - boxes[live[i]].lower.y;
        if (height > 10 * least)
            continue;
        sum += height;
        counted++;
    }
    return counted > 0 ? 2 * sum / counted : 1;
}

bool ll_broad_strips(const ll_aabb *boxes, const uint8_t *moved, const int32_t *live, int32_t count,
                     ll_pair_list *out)
{
    strips s = {.at = out->scratch, .capacity = (int32_t)(out->scratch_size / sizeof(entry))};
    s.per_height = 1 / ll_max(strip_height(boxes, live, count), 1e-6);
    for (int32_t i = 0; i < count; i++)
        if (!sort_in(&s, boxes[live[i]], live[i], moved[live[i]] != 0))
            return false;
    sort(s.at, s.count);
    sweep(&s, out);
    compare_tall(&s, boxes, moved, live, count, out);
    return true;
}

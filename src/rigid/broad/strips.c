/* All pairs at once: the boxes are sorted into horizontal strips and swept along x within each. This reads
 * memory in order, which single queries do not, so it is faster as soon as most boxes have moved. Sorting
 * uses integers (radix sort), the tests use the boxes. A box that reaches into several strips is in each of
 * them; a pair belongs to the strip in which the higher box begins. */
#include "rigid/broad/broad.h"

#include "base/assert.h"

typedef struct entry {
    double left, right, low, high;
    uint32_t begin, end; /* left and right, as integers relative to the width of all; used for sorting */
    int32_t proxy;
    uint16_t strip, moved;
} entry;

typedef struct strips {
    const ll_aabb *boxes;
    const uint8_t *moved;
    const int32_t *live;
    int32_t lives;
    entry *at;
    const entry *sorted;
    uint64_t *keys; /* strip, begin and index */
    int32_t count, capacity;
    double per_height; /* strips per metre */
    double middle;     /* m: start of the middle strip */
    double least, per_part;
    int32_t tall[64]; /* boxes of too many strips: each is compared with all others */
    int32_t tall_count;
} strips;

enum {
    most_strips = 6, /* boxes of up to this many strips are sorted into them */
    strip_bits = 16,
    part_bits = 20,
    place_bits = 28,
    digit_bits = 9
};

_Static_assert((int)strip_bits + (int)part_bits + (int)place_bits == 64, "a key is a word");

/* Integer from 0 to `most`. Values outside are clamped, which keeps the order. */
static inline uint32_t cut(double x, double most)
{
    return (uint32_t)ll_min(ll_max(x, 0), most);
}

static inline uint32_t strip_of(const strips *s, double y)
{
    return cut((y - s->middle) * s->per_height + (1 << (strip_bits - 1)), (1 << strip_bits) - 1);
}

static inline uint32_t part_of(const strips *s, double x)
{
    return cut((x - s->least) * s->per_part, (1 << part_bits) - 1);
}

static bool sort_in(strips *s, ll_aabb box, int32_t proxy, bool moved)
{
    uint32_t first = strip_of(s, box.lower.y), last = strip_of(s, box.upper.y);
    LL_VALIDATE(last >= first); /* cutting keeps the order */
    if (last - first >= most_strips) {
        s->tall[s->tall_count++] = proxy;
        return s->tall_count < 64;
    }
    if (s->count + most_strips > s->capacity)
        return false;
    uint32_t begin = part_of(s, box.lower.x), end = part_of(s, box.upper.x);
    for (uint32_t strip = first; strip <= last; strip++) {
        s->keys[s->count] =
            (uint64_t)strip << (part_bits + place_bits) | (uint64_t)begin << place_bits | (uint32_t)s->count;
        s->at[s->count++] = (entry){box.lower.x, box.upper.x, box.lower.y,     box.upper.y, begin,
                                    end,         proxy,       (uint16_t)strip, moved};
    }
    return true;
}

/* Radix sort, lowest digit first; a digit that is the same in all keys is skipped. Returns the array that
 * holds the result. */
static const uint64_t *sort(uint64_t *keys, uint64_t *other, int32_t count)
{
    for (int shift = place_bits; shift < 64; shift += digit_bits) {
        int32_t start[1 << digit_bits] = {0};
        for (int32_t i = 0; i < count; i++)
            start[keys[i] >> shift & ((1 << digit_bits) - 1)]++;
        if (start[keys[0] >> shift & ((1 << digit_bits) - 1)] == count)
            continue;
        for (int32_t d = 0, sum = 0; d < 1 << digit_bits; d++) {
            int32_t size = start[d];
            start[d] = sum;
            sum += size;
        }
        for (int32_t i = 0; i < count; i++)
            other[start[keys[i] >> shift & ((1 << digit_bits) - 1)]++] = keys[i];
        uint64_t *swap = keys;
        keys = other;
        other = swap;
    }
    return keys;
}

static void sweep(const strips *s, ll_share of, ll_pair_list *out)
{
    const entry *end = s->sorted + s->count;
    for (const entry *a = s->sorted + of.begin; a < s->sorted + of.end; a++)
        for (const entry *b = a + 1; b < end && b->strip == a->strip && b->begin <= a->end; b++)
            if ((a->moved | b->moved) && a->low <= b->high && b->low <= a->high && b->left <= a->right &&
                a->left <= b->right && strip_of(s, ll_max(a->low, b->low)) == a->strip)
                ll_pair_emit(out, a->proxy, b->proxy);
}

static void compare_tall(const strips *s, ll_share of, ll_pair_list *out)
{
    for (int32_t t = 0; t < s->tall_count; t++) {
        int32_t p = s->tall[t];
        for (int32_t i = of.begin; i < of.end; i++) {
            int32_t q = s->live[i];
            if ((s->moved[p] | s->moved[q]) == 0 || p == q || !ll_aabb_overlap(s->boxes[p], s->boxes[q]))
                continue;
            bool both_tall = false;
            for (int32_t k = 0; k < s->tall_count; k++)
                both_tall |= s->tall[k] == q;
            if (!both_tall || p < q)
                ll_pair_emit(out, p, q);
        }
    }
}

static void find_part(void *context, int part, int parts)
{
    ll_pair_parts *all = context;
    const strips *s = all->context;
    sweep(s, ll_share_of(s->count, part, parts), &all->part[part]);
    compare_tall(s, ll_share_of(s->lives, part, parts), &all->part[part]);
}

/* Twice the mean height, without boxes ten times as high as the first estimate. */
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

/* Origin of the strips (mean height) and of the integers (leftmost box). */
static void span(strips *s, const ll_aabb *boxes, const int32_t *live, int32_t count)
{
    double least = INFINITY, most = -INFINITY, sum = 0;
    for (int32_t i = 0; i < count; i++) {
        least = ll_min(least, boxes[live[i]].lower.x);
        most = ll_max(most, boxes[live[i]].lower.x);
        sum += boxes[live[i]].lower.y;
    }
    s->middle = sum / count;
    s->least = least;
    s->per_part = most > least ? (1 << part_bits) / (most - least) : 0;
}

bool ll_broad_strips(const ll_aabb *boxes, const uint8_t *moved, const int32_t *live, int32_t count,
                     ll_pair_list *out)
{
    enum { least = 256 }; /* an entry takes about 30 ns */
    size_t each = 2 * sizeof(entry) + 2 * sizeof(uint64_t);
    strips s = {.boxes = boxes,
                .moved = moved,
                .live = live,
                .lives = count,
                .at = out->scratch,
                .capacity = (int32_t)ll_min((double)(out->scratch_size / each), 1 << place_bits)};
    s.per_height = 1 / ll_max(strip_height(boxes, live, count), 1e-6);
    entry *sorted = s.at + s.capacity;
    s.keys = (uint64_t *)(sorted + s.capacity);
    span(&s, boxes, live, count);
    for (int32_t i = 0; i < count; i++)
        if (!sort_in(&s, boxes[live[i]], live[i], moved[live[i]] != 0))
            return false;
    const uint64_t *keys = sort(s.keys, s.keys + s.capacity, s.count);
    for (int32_t i = 0; i < s.count; i++)
        sorted[i] = s.at[keys[i] & ((1 << place_bits) - 1)];
    s.sorted = sorted;
    ll_pair_run(out, s.count, least, find_part, &s);
    return true;
}

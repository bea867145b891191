/* A link is four parts in a row: the struct, the queue, the ring of the rate's stage and the store.
 *
 * The queue holds the messages in flight, sorted by due time. Most are due after all others, so that a sorted
 * array is as good as appending and cheaper than a heap: with 20 ms of jitter at 60 Hz one in eight packets
 * moves another by one position. The array slides to its front when it reaches the end.
 *
 * The store holds the packets' bytes in the order of sending, each after a header. A delivery out of order
 * leaves a hole until the store is full; then it is packed. So a packet is refused only if the data in flight
 * really exceeds the limits.
 *
 * Packets held for a receiver are at the end of the queue, never due, with their id in `took`.
 *
 * Headers are short because a session keeps several copies of every link. */
#include "link/line/core.h"

#include <string.h>

#include "base/assert.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct entry {
    ll_time due;
    int32_t at;    /* of its parcel in the store */
    uint32_t took; /* ns since it was sent; if held: its id */
} entry;

/* Header of a packet's bytes in the store; the bytes follow, rounded up to 4. */
typedef struct parcel {
    int32_t size;    /* of the packet; ~size when delivered */
    uint32_t number; /* of the message, modulo 2^32; a copy has its original's. While packing: the index of
                        its entry */
} parcel;

#pragma GCC diagnostic pop

static int32_t round_up(int32_t n, int32_t to) /* a power of two */
{
    return (n + to - 1) & ~(to - 1);
}

static int32_t queue_capacity(int32_t slots)
{
    return slots + (int32_t)((uint32_t)slots / 8) + 1; /* a full one slides once per slots / 8 messages */
}

/* A message has one packet and, with mtu_bytes of 1200 or more, at most one more per 1200 bytes. */
static int32_t ring_places(int32_t slots, int32_t arena)
{
    int32_t places = slots + arena / 1200;
    return places < LL_QUEUE_MAX ? places : LL_QUEUE_MAX;
}

static int32_t ring_capacity(int32_t places)
{
    return places + (places & 1); /* the next part starts at a multiple of 8 */
}

/* Fits `slots` packets of `arena` bytes in total, including rounding. */
static int32_t store_capacity(int32_t slots, int32_t arena)
{
    return round_up(arena + slots * ((int32_t)sizeof(parcel) + 3), 8);
}

static entry *queue_of(const ll_link *l)
{
    return (entry *)(l + 1);
}

uint32_t *ll_link_ring(const ll_link *l)
{
    return (uint32_t *)(queue_of(l) + queue_capacity(l->slots));
}

static char *store_of(const ll_link *l)
{
    return (char *)(ll_link_ring(l) + ring_capacity(l->places));
}

static parcel *parcel_at(const ll_link *l, int32_t at)
{
    return (parcel *)(void *)(store_of(l) + (uint32_t)at);
}

static bool in_flight(const parcel *p)
{
    return p->size >= 0;
}

static int32_t size_of(const parcel *p)
{
    return in_flight(p) ? p->size : ~p->size;
}

static int32_t stride_of(int32_t size)
{
    return (int32_t)sizeof(parcel) + round_up(size, 4);
}

size_t ll_link_size(int slots, int arena_bytes)
{
    return sizeof(ll_link) + (size_t)queue_capacity(slots) * sizeof(entry) +
           (size_t)ring_capacity(ring_places(slots, arena_bytes)) * sizeof(uint32_t) +
           (size_t)store_capacity(slots, arena_bytes);
}

void ll_link_init(ll_link *l, int slots, int arena_bytes, uint64_t seed, uint64_t stream)
{
    LL_ASSERT(slots > 0 && slots <= 1 << 24 && arena_bytes > 0 && arena_bytes <= 1 << 28);
    memset(l, 0, ll_link_size(slots, arena_bytes));
    l->seed = seed;
    l->stream = stream * LL_STREAMS;
    l->slots = slots;
    l->arena = arena_bytes;
    l->places = ring_places(slots, arena_bytes);
    l->delivered = -1;
    l->delay_number = LL_NO_NUMBER;
    l->memory = (ll_memory){.loss_number = LL_NO_NUMBER,
                            .lost = LL_NO_NUMBER,
                            .duplicated = LL_NO_NUMBER,
                            .reordered = LL_NO_NUMBER,
                            .corrupted = LL_NO_NUMBER,
                            .deviate_number = LL_NO_NUMBER};
    l->stats.delay.min_ms = 1e9;
    l->latest = l->memory.entrance = l->memory.exit = LL_LONG_AGO;
}

/* ---- queue ---- */

/* Position after all that are due at `due` or before: equal due times keep the order of sending. The last is
 * due later. Linear search near the end, binary search elsewhere. */
static int32_t place_of(const entry *queue, int32_t first, int32_t end, ll_time due)
{
    int32_t low = first, high = end - 1;
    for (int32_t steps = 7; high > first && queue[high - 1].due > due; high--)
        if (steps-- == 0)
            break;
    if (high == first || queue[high - 1].due <= due)
        return high;
    while (low < high) {
        int32_t middle = low + (high - low) / 2;
        if (queue[middle].due > due)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Makes room in the middle and returns the place. */
static int32_t open_place(ll_link *l, entry *queue, ll_time due)
{
    int32_t place = place_of(queue, l->first, l->end, due);
    LL_VALIDATE(place >= l->first && queue[place].due > due);
    memmove(queue + place + 1, queue + place, (size_t)(l->end - place) * sizeof *queue);
    return place;
}

static void slide(ll_link *l, entry *queue)
{
    memmove(queue, queue + l->first, (size_t)(l->end - l->first) * sizeof *queue);
    l->end -= l->first;
    l->first = 0;
}

/* The queue has more places than there are slots: most messages find one without this. */
static __attribute__((noinline)) void make_place(ll_link *l, entry *queue)
{
    const int32_t capacity = queue_capacity(l->slots);
    if (l->end == capacity)
        slide(l, queue);
    LL_ASSERT(l->end < capacity); /* sliding has made room */
}

static inline void enqueue(ll_link *l, entry e)
{
    entry *queue = queue_of(l);
    if (l->end >= l->slots)
        make_place(l, queue);
    int32_t place = l->end;
    if (place > l->first && queue[place - 1].due > e.due)
        place = open_place(l, queue, e.due);
    queue[place] = e;
    l->end++;
}

/* ---- store ---- */

/* Closes the holes from the front, in order. Meanwhile each parcel stores its entry's index, and the entry
 * the number. Before the first in flight, most of a full store, there are only holes. */
static void pack(ll_link *l)
{
    entry *queue = queue_of(l);
    int32_t from = l->top;
    for (int32_t i = l->first; i < l->end; i++) {
        parcel *p = parcel_at(l, queue[i].at);
        from = queue[i].at < from ? queue[i].at : from;
        queue[i].at = (int32_t)p->number;
        p->number = (uint32_t)i;
    }
    int32_t top = 0;
    for (int32_t at = from, stride; at < l->top; at += stride) {
        parcel *p = parcel_at(l, at);
        stride = stride_of(size_of(p));
        if (!in_flight(p))
            continue;
        entry *e = &queue[p->number];
        p->number = (uint32_t)e->at;
        e->at = top;
        memmove(parcel_at(l, top), p, (size_t)stride);
        top += stride;
    }
    LL_ASSERT(top <= l->top); /* parcels only move to the front */
    l->top = top;
}

/* The limits were checked: after packing there is room. The store is longer than the arena: most messages
 * find room without this. */
static __attribute__((noinline)) void make_room(ll_link *l, int32_t stride)
{
    const int32_t capacity = store_capacity(l->slots, l->arena);
    if (l->top + stride > capacity)
        pack(l);
    LL_ASSERT(l->top + stride <= capacity);
}

static inline int32_t store(ll_link *l, int64_t number, const void *bytes, int32_t size)
{
    const int32_t stride = stride_of(size);
    if (l->top + stride > l->arena)
        make_room(l, stride);
    int32_t at = l->top;
    parcel *p = parcel_at(l, at);
    *p = (parcel){.size = size, .number = (uint32_t)number};
    if (size > 0)
        memcpy(p + 1, bytes, (size_t)size);
    l->top = at + stride;
    l->bytes += size;
    return at;
}

static inline void put(ll_link *l, ll_time now, ll_time due, const void *bytes, int32_t size)
{
    LL_ASSERT((uint64_t)(due - now) <= UINT32_MAX); /* no packet arrives before it is sent */
    LL_VALIDATE(ll_link_has_room(l, size));
    enqueue(l, (entry){.due = due, .at = store(l, l->number, bytes, size), .took = (uint32_t)(due - now)});
}

void ll_link_put(ll_link *l, ll_time now, ll_time due, const void *bytes, int32_t size)
{
    put(l, now, due, bytes, size);
}

bool ll_link_send_plain(ll_link *l, const ll_link_plan *plan, ll_time now, const void *bytes, int size,
                        ll_time *due)
{
    const int64_t mtu = plan->params->mtu_bytes;
    if (plan->stages != 0 || plan->tap || (mtu > 0 && size > mtu) || !ll_link_has_room(l, size))
        return false;
    LL_ASSERT(size >= 0);
    l->stats.sent++;
    l->stats.bytes += size;
    l->packet++;
    *due = ll_link_arrival(l, (ll_order)plan->params->order, now, now + plan->delay, plan->delay_ms);
    put(l, now, *due, bytes, size);
    l->number++;
    LL_VALIDATE(ll_link_valid(l));
    return true;
}

void ll_link_mark(ll_link *l, int32_t size, uint32_t at)
{
    uint8_t *bytes = (uint8_t *)(parcel_at(l, l->top - stride_of(size)) + 1);
    LL_ASSERT(at < (uint32_t)size);
    bytes[at] |= LL_ECN_MARK;
}

/* ---- receiving ---- */

ll_time ll_link_next_due(const ll_link *l)
{
    return l->first < l->end ? queue_of(l)[l->first].due : LL_NEVER;
}

static void drop_all(ll_link *l)
{
    l->first = l->end = l->held = l->bytes = l->top = 0;
}

static void count_delivery(ll_link *l, uint32_t number)
{
    int32_t ahead = (int32_t)(number - (uint32_t)l->delivered);
    l->stats.delivered++;
    if (ahead < 0)
        l->stats.reordered++;
    else
        l->delivered += ahead;
}

/* The message of a removed entry is no longer in the link. Its bytes stay where they are until there is
 * another. */
static inline int let_go(ll_link *l, parcel *p)
{
    int32_t size = p->size;
    LL_ASSERT(size >= 0);
    p->size = ~size;
    l->bytes -= size;
    LL_ASSERT(l->bytes >= 0 && l->first <= l->end - l->held);
    if (l->first == l->end)
        drop_all(l);
    LL_VALIDATE(ll_link_valid(l));
    return size;
}

static void copy_out(const parcel *p, int size, void *bytes, int capacity)
{
    LL_ASSERT(size <= capacity);
    if (size > 0)
        memcpy(bytes, p + 1, (size_t)size);
}

static inline parcel *next_parcel(ll_link *l, entry e)
{
    parcel *p = parcel_at(l, e.at);
    count_delivery(l, p->number);
    return p;
}

const void *ll_link_next(ll_link *l, ll_time now, int *size)
{
    if (ll_link_next_due(l) > now)
        return NULL;
    parcel *p = next_parcel(l, queue_of(l)[l->first++]);
    *size = let_go(l, p);
    return p + 1;
}

int ll_link_receive(ll_link *l, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due)
{
    if (ll_link_next_due(l) > now)
        return -1;
    entry e = queue_of(l)[l->first++];
    *sent = e.due - e.took;
    *due = e.due;
    parcel *p = next_parcel(l, e);
    int size = let_go(l, p);
    copy_out(p, size, bytes, capacity);
    return size;
}

bool ll_link_room(const ll_link *l, int size)
{
    return ll_link_has_room(l, size);
}

void ll_link_hold(ll_link *l, uint32_t id, const void *bytes, int size)
{
    LL_ASSERT(l->number > 0 && ll_link_has_room(l, size));
    enqueue(l, (entry){.due = LL_NEVER, .at = store(l, l->number - 1, bytes, size), .took = id});
    l->held++;
    LL_VALIDATE(ll_link_valid(l));
}

int ll_link_take_held(ll_link *l, uint32_t id, void *bytes, int capacity)
{
    entry *queue = queue_of(l);
    int32_t i = l->end - l->held;
    while (i < l->end && queue[i].took != id)
        i++;
    LL_ASSERT(i < l->end && queue[i].due == LL_NEVER);
    parcel *p = parcel_at(l, queue[i].at);
    memmove(queue + i, queue + i + 1, (size_t)(l->end - i - 1) * sizeof *queue);
    l->end--;
    l->held--;
    int size = let_go(l, p);
    copy_out(p, size, bytes, capacity);
    return size;
}

int ll_link_in_flight(const ll_link *l)
{
    return l->end - l->first - l->held;
}

void ll_link_restart_stats(ll_link *l)
{
    l->stats = (ll_link_stats){.carried = ll_link_in_flight(l), .delay.min_ms = 1e9};
}

const ll_link_stats *ll_link_get_stats(const ll_link *l)
{
    return &l->stats;
}

int64_t ll_link_put_on_way(const ll_link_stats *s)
{
    return s->sent - s->lost - s->overflowed - s->queue_drops - s->corrupted + s->duplicated;
}

int64_t ll_link_messages(const ll_link_stats *s)
{
    return s->sent - s->fragments.count + s->fragments.split;
}

double ll_link_loss_pct(const ll_link_stats *s)
{
    int64_t draws = s->sent + s->duplicated - s->rescued;
    return draws > 0 ? 100 * (double)s->lost / (double)draws : 0;
}

/* By differences, which need no mean: the mean of all packets differs slightly from that of the pairs. */
double ll_link_delay_correlation(const ll_link_stats *s)
{
    double n = (double)ll_link_put_on_way(s), mean = s->delay.sum_ms / n;
    double variance = s->delay.sum_squares / n - mean * mean;
    if (s->delay.pairs == 0 || s->delay.step_squares <= 0 || variance <= 0)
        return 0;
    return 1 - s->delay.step_squares / (double)s->delay.pairs / (2 * variance);
}

/* ---- validation ---- */

static bool queue_valid(const ll_link *l)
{
    const entry *queue = queue_of(l);
    if (l->first < 0 || l->first > l->end || l->end > queue_capacity(l->slots) ||
        l->end - l->first > l->slots)
        return false;
    for (int32_t i = l->first; i < l->end; i++) {
        if (i > l->first && queue[i].due < queue[i - 1].due)
            return false;
        if ((queue[i].due == LL_NEVER) != (i >= l->end - l->held))
            return false;
        if (queue[i].at < 0 || queue[i].at >= l->top || queue[i].at % 4 != 0)
            return false;
        const parcel *p = parcel_at(l, queue[i].at);
        if (!in_flight(p) || (int32_t)(p->number - (uint32_t)l->number) >= 0)
            return false;
    }
    return true;
}

/* Checks that the parcels fill the store up to the top, in the order of sending, and that those in flight are
 * queued. */
static bool store_valid(const ll_link *l)
{
    int32_t packets = 0, bytes = 0, at = 0;
    const parcel *before = NULL;
    while (at < l->top) {
        const parcel *p = parcel_at(l, at);
        if (size_of(p) > l->arena || (before && (int32_t)(p->number - before->number) < 0))
            return false;
        packets += in_flight(p);
        bytes += in_flight(p) ? p->size : 0;
        at += stride_of(size_of(p));
        before = p;
    }
    return at == l->top && at <= store_capacity(l->slots, l->arena) && packets == l->end - l->first &&
           bytes == l->bytes && bytes <= l->arena;
}

static bool ring_valid(const ll_link *l)
{
    const ll_memory *m = &l->memory;
    return m->queue_first >= 0 && m->queue_first < l->places && m->queue_count >= 0 &&
           m->queue_count <= l->places;
}

bool ll_link_valid(const ll_link *l)
{
    return queue_valid(l) && ring_valid(l) && store_valid(l) &&
           l->stats.delivered + ll_link_in_flight(l) <= ll_link_put_on_way(&l->stats) + l->stats.carried;
}

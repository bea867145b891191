/* A link is three things in a row: this struct, the queue and the store.
 *
 * The queue holds the packets in flight, sorted by due time. Most packets are due after all others, so a
 * sorted array is as good as appending and costs less than a heap: with 20 ms of jitter at 60 Hz one in eight
 * packets moves another by one place. It slides to the front of its array when it reaches the end.
 *
 * The store holds the packets' bytes in the order of sending, each behind a head. What is delivered out of
 * order leaves a hole, which stays until the store is full; then it is packed. So a packet is refused only
 * when what is in flight really exceeds the limits. */
#include "link/link.h"

#include <string.h>

#include "base/assert.h"
#include "base/rng.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct entry {
    ll_time due;
    int32_t at; /* of its parcel in the store */
    int32_t size;
} entry;

/* The head of a packet's bytes in the store, which follow rounded up to 8. */
typedef struct parcel {
    ll_time sent;
    int64_t number; /* of the sending: a copy has that of its original */
    int32_t size;
    int32_t state; /* DELIVERED; or in flight, and while packing the place where it goes */
} parcel;

struct ll_link {
    uint64_t seed, stream;
    int64_t number;     /* of the next sending: the counter of all draws */
    int64_t delivered;  /* the highest number delivered so far */
    ll_time latest;     /* due time of the packet due last so far: for fifo */
    int32_t slots;      /* limit of packets in flight */
    int32_t arena;      /* limit of their bytes */
    int32_t first, end; /* of the queue */
    int32_t bytes;      /* in flight */
    int32_t top;        /* the store is in use up to here */
    ll_link_stats stats;
};

#pragma GCC diagnostic pop

/* One stream of random numbers per stage. */
enum { STAGE_LOSS, STAGE_DUPLICATE, STAGE_DELAY, STAGE_COPY_DELAY, STAGES = 8 };

#define DELIVERED (-1)

static int32_t round8(int32_t n)
{
    return (n + 7) & ~7;
}

static int32_t queue_capacity(int32_t slots)
{
    return 2 * slots; /* so that it slides at most once in `slots` sendings */
}

/* Fits `slots` packets of `arena` bytes together, whatever their rounding. */
static int32_t store_capacity(int32_t slots, int32_t arena)
{
    return round8(arena) + slots * ((int32_t)sizeof(parcel) + 8);
}

static entry *queue_of(const ll_link *l)
{
    return (entry *)(l + 1);
}

static char *store_of(const ll_link *l)
{
    return (char *)(queue_of(l) + queue_capacity(l->slots));
}

static parcel *parcel_at(const ll_link *l, int32_t at)
{
    return (parcel *)(void *)(store_of(l) + at);
}

static int32_t stride_of(int32_t size)
{
    return (int32_t)sizeof(parcel) + round8(size);
}

size_t ll_link_size(int slots, int arena_bytes)
{
    return sizeof(ll_link) + (size_t)queue_capacity(slots) * sizeof(entry) +
           (size_t)store_capacity(slots, arena_bytes);
}

void ll_link_init(ll_link *l, int slots, int arena_bytes, uint64_t seed, uint64_t stream)
{
    LL_ASSERT(slots > 0 && slots <= 1 << 24 && arena_bytes > 0 && arena_bytes <= 1 << 28);
    memset(l, 0, ll_link_size(slots, arena_bytes));
    l->seed = seed;
    l->stream = stream * STAGES;
    l->slots = slots;
    l->arena = arena_bytes;
    l->delivered = -1;
    l->stats.delay_min_ms = 1e9;
}

/* ---- draws ---- */

static bool happens(const ll_link *l, int stage, double percent)
{
    return percent > 0 &&
           100 * ll_rng_unit(l->seed, l->stream + (uint64_t)stage, (uint64_t)l->number) < percent;
}

static double draw_delay_ms(const ll_link *l, int stage, const ll_link_params *p, double lag_ms)
{
    double delay = lag_ms + p->delay_ms;
    uint64_t stream = l->stream + (uint64_t)stage, counter = (uint64_t)l->number;
    if (p->jitter_ms > 0)
        delay += p->jitter_ms * (p->distribution == LL_DISTRIBUTION_NORMAL
                                     ? ll_rng_normal(l->seed, stream, counter)
                                     : 2 * ll_rng_unit(l->seed, stream, counter) - 1);
    return delay > 0 ? delay : 0;
}

/* ---- queue ---- */

/* The place behind all that are due at `due` or before: equal due times keep the order of sending. Near the
 * end one looks, further away one halves. */
static int32_t place_of(const entry *queue, int32_t first, int32_t end, ll_time due)
{
    int32_t low = first, high = end;
    for (int32_t steps = 8; high > first && queue[high - 1].due > due; high--)
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

static void enqueue(ll_link *l, entry e)
{
    entry *queue = queue_of(l);
    if (l->end == queue_capacity(l->slots)) {
        memmove(queue, queue + l->first, (size_t)(l->end - l->first) * sizeof *queue);
        l->end -= l->first;
        l->first = 0;
    }
    int32_t place = place_of(queue, l->first, l->end, e.due);
    if (place < l->end)
        memmove(queue + place + 1, queue + place, (size_t)(l->end - place) * sizeof *queue);
    queue[place] = e;
    l->end++;
}

/* ---- store ---- */

/* Closes the holes: decides the new places, tells the queue, moves. The order in the store stays, so no move
 * overtakes. */
static void pack(ll_link *l)
{
    int32_t top = 0;
    for (int32_t at = 0, stride; at < l->top; at += stride) {
        parcel *p = parcel_at(l, at);
        stride = stride_of(p->size);
        if (p->state != DELIVERED) {
            p->state = top;
            top += stride;
        }
    }
    entry *queue = queue_of(l);
    for (int32_t i = l->first; i < l->end; i++)
        queue[i].at = parcel_at(l, queue[i].at)->state;
    for (int32_t at = 0, stride; at < l->top; at += stride) {
        const parcel *p = parcel_at(l, at);
        stride = stride_of(p->size);
        if (p->state != DELIVERED)
            memmove(store_of(l) + p->state, p, (size_t)stride);
    }
    l->top = top;
}

/* The limits are checked: after packing there is room. */
static int32_t store(ll_link *l, ll_time now, const void *bytes, int32_t size)
{
    int32_t stride = stride_of(size);
    if (l->top + stride > store_capacity(l->slots, l->arena))
        pack(l);
    int32_t at = l->top;
    *parcel_at(l, at) = (parcel){.sent = now, .number = l->number, .size = size};
    if (size > 0)
        memcpy(parcel_at(l, at) + 1, bytes, (size_t)size);
    l->top += stride;
    l->bytes += size;
    return at;
}

/* ---- sending ---- */

static bool has_room(const ll_link *l, int32_t size)
{
    return l->end - l->first < l->slots && l->bytes + size <= l->arena;
}

static void count_delay(ll_link_stats *s, double delay_ms)
{
    s->delay_min_ms = delay_ms < s->delay_min_ms ? delay_ms : s->delay_min_ms;
    s->delay_max_ms = delay_ms > s->delay_max_ms ? delay_ms : s->delay_max_ms;
    s->delay_sum_ms += delay_ms;
    s->delay_sum_squares += delay_ms * delay_ms;
}

/* Puts a packet or its copy on its way; returns when it is due. */
static ll_time dispatch(ll_link *l, int stage, const ll_link_params *p, double lag_ms, ll_time now,
                        const void *bytes, int32_t size)
{
    double delay_ms = draw_delay_ms(l, stage, p, lag_ms);
    ll_time due = now + ll_ms(delay_ms);
    if (p->order == LL_ORDER_FIFO && due < l->latest) {
        due = l->latest;
        delay_ms = ll_to_ms(due - now);
    }
    l->latest = due > l->latest ? due : l->latest;
    count_delay(&l->stats, delay_ms);
    enqueue(l, (entry){.due = due, .at = store(l, now, bytes, size), .size = size});
    return due;
}

ll_sending ll_link_send(ll_link *l, const ll_link_params *p, double lag_ms, ll_time now, const void *bytes,
                        int size)
{
    LL_ASSERT(size >= 0 && size <= l->arena);
    ll_sending sending = {.fate = LL_FATE_DELIVERED, .due = now, .copy_due = now};
    l->stats.sent++;
    l->stats.bytes += size;
    if (happens(l, STAGE_LOSS, p->loss_pct)) {
        sending.fate = LL_FATE_LOST;
        l->stats.lost++;
    } else if (!has_room(l, size)) {
        sending.fate = LL_FATE_OVERFLOW;
        l->stats.overflowed++;
    } else {
        sending.due = dispatch(l, STAGE_DELAY, p, lag_ms, now, bytes, size);
        if (happens(l, STAGE_DUPLICATE, p->duplicate_pct)) {
            l->stats.duplicated++;
            sending.duplicated = has_room(l, size);
            if (sending.duplicated)
                sending.copy_due = dispatch(l, STAGE_COPY_DELAY, p, lag_ms, now, bytes, size);
            else
                l->stats.overflowed++;
        }
    }
    l->number++;
    LL_VALIDATE(ll_link_valid(l));
    return sending;
}

/* ---- receiving ---- */

ll_time ll_link_next_due(const ll_link *l)
{
    return l->first < l->end ? queue_of(l)[l->first].due : LL_NEVER;
}

static void drop_all(ll_link *l)
{
    l->first = l->end = l->bytes = l->top = 0;
}

int ll_link_receive(ll_link *l, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due)
{
    if (ll_link_next_due(l) > now)
        return -1;
    entry e = queue_of(l)[l->first++];
    parcel *p = parcel_at(l, e.at);
    LL_ASSERT(e.size <= capacity);
    if (e.size > 0)
        memcpy(bytes, p + 1, (size_t)e.size);
    *sent = p->sent;
    *due = e.due;
    l->stats.delivered++;
    l->stats.reordered += p->number < l->delivered;
    l->delivered = p->number > l->delivered ? p->number : l->delivered;
    p->state = DELIVERED;
    l->bytes -= e.size;
    if (l->first == l->end)
        drop_all(l);
    LL_VALIDATE(ll_link_valid(l));
    return e.size;
}

void ll_link_clear(ll_link *l)
{
    drop_all(l);
    l->latest = 0;
}

int ll_link_in_flight(const ll_link *l)
{
    return l->end - l->first;
}

const ll_link_stats *ll_link_get_stats(const ll_link *l)
{
    return &l->stats;
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
        if (queue[i].at < 0 || queue[i].at >= l->top || queue[i].at % 8 != 0)
            return false;
        const parcel *p = parcel_at(l, queue[i].at);
        if (p->size != queue[i].size || p->state == DELIVERED || p->number >= l->number ||
            queue[i].due < p->sent)
            return false;
    }
    return true;
}

/* Walks the parcels: they must fill the store up to the top, in the order of sending, and those in flight be
 * those queued. */
static bool store_valid(const ll_link *l)
{
    int32_t in_flight = 0, bytes = 0, at = 0;
    int64_t number = 0;
    while (at < l->top) {
        const parcel *p = parcel_at(l, at);
        if (p->size < 0 || p->size > l->arena || p->number < number)
            return false;
        number = p->number;
        in_flight += p->state != DELIVERED;
        bytes += p->state != DELIVERED ? p->size : 0;
        at += stride_of(p->size);
    }
    return at == l->top && at <= store_capacity(l->slots, l->arena) && in_flight == l->end - l->first &&
           bytes == l->bytes && bytes <= l->arena;
}

bool ll_link_valid(const ll_link *l)
{
    const ll_link_stats *s = &l->stats;
    int64_t accepted = s->sent - s->lost - s->overflowed + s->duplicated;
    return queue_valid(l) && store_valid(l) && s->delivered + ll_link_in_flight(l) <= accepted;
}

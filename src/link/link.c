#include "link/link.h"

#include <string.h>

#include "base/assert.h"
#include "base/rng.h"

static const char *const distributions[] = {"uniform", "normal", NULL};
static const char *const orders[] = {"free", "fifo", NULL};

static const ll_param rows[] = {
    {.name = "delay_ms", .type = LL_PARAM_REAL, .offset = offsetof(ll_link_params, delay_ms), .max = 1000, .unit = "ms",
     .live = true, .help = "Delay of this direction, added to the player's lag_ms."},
    {.name = "jitter_ms", .type = LL_PARAM_REAL, .offset = offsetof(ll_link_params, jitter_ms), .max = 500, .unit = "ms",
     .live = true, .help = "Variation of the delay: half-width of the uniform, standard deviation of the normal distribution."},
    {.name = "distribution", .type = LL_PARAM_CHOICE, .offset = offsetof(ll_link_params, distribution),
     .choices = distributions, .live = true, .help = "How the delay varies."},
    {.name = "order", .type = LL_PARAM_CHOICE, .offset = offsetof(ll_link_params, order), .choices = orders, .live = true,
     .help = "free lets a packet overtake an earlier one; fifo holds it until the earlier one is through."},
    {.name = "loss_pct", .type = LL_PARAM_REAL, .offset = offsetof(ll_link_params, loss_pct), .max = 100, .unit = "%",
     .live = true, .help = "Packets that are lost, each by itself."},
    {.name = "duplicate_pct", .type = LL_PARAM_REAL, .offset = offsetof(ll_link_params, duplicate_pct), .max = 100,
     .unit = "%", .live = true, .help = "Packets that arrive twice; the copy has a delay of its own."},
};

const ll_param_table ll_link_table = {.name = "link", .help = "One direction of a network path, in netem's terms.",
                                      .rows = rows, .count = sizeof rows / sizeof rows[0], .size = sizeof(ll_link_params)};

/* ---- layout ---- */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct slot {
    ll_time sent, due;
    int64_t number; /* of sending: breaks ties of `due` */
    int32_t offset; /* of its bytes in the arena */
    int32_t size;   /* rounded up to 8 it is the room taken; 0 once delivered */
} slot;

/* Packets in flight lie in the order of sending: slots and bytes are rings that are freed from the oldest on. A heap of
 * slot indices gives the order of delivery. */
struct ll_link {
    uint64_t seed, stream;
    int32_t slots, arena;
    int32_t first, used;  /* ring of slots; some of them may be delivered already */
    int32_t heap_count;   /* packets in flight */
    int32_t write, oldest; /* ring of bytes: where the next goes, and where the oldest begins */
    int32_t reserved;
    int64_t number;    /* of the next sending; the counter of all draws */
    int64_t delivered; /* highest number delivered so far */
    ll_time latest;    /* due time of the packet due last: for fifo */
    ll_link_stats stats;
};

#pragma GCC diagnostic pop

/* One stream of random numbers per stage. */
enum { STAGE_LOSS, STAGE_DUPLICATE, STAGE_DELAY, STAGE_COPY_DELAY, STAGES = 8 };

static int32_t round8(int32_t n)
{
    return (n + 7) & ~7;
}

static slot *slots_of(const ll_link *l)
{
    return (slot *)(l + 1);
}

static int32_t *heap_of(const ll_link *l)
{
    return (int32_t *)(slots_of(l) + l->slots);
}

static char *arena_of(const ll_link *l)
{
    return (char *)heap_of(l) + round8(l->slots * (int32_t)sizeof(int32_t));
}

size_t ll_link_size(int slots, int arena_bytes)
{
    return sizeof(ll_link) + (size_t)slots * sizeof(slot) + (size_t)round8(slots * (int)sizeof(int32_t)) + (size_t)round8(arena_bytes);
}

void ll_link_init(ll_link *l, int slots, int arena_bytes, uint64_t seed, uint64_t stream)
{
    memset(l, 0, ll_link_size(slots, arena_bytes));
    l->seed = seed;
    l->stream = stream * STAGES;
    l->slots = slots;
    l->arena = round8(arena_bytes);
    l->delivered = -1;
    l->stats.delay_min_ms = 1e9;
}

/* ---- draws ---- */

static bool happens(const ll_link *l, int stage, double percent)
{
    return percent > 0 && 100 * ll_rng_unit(l->seed, l->stream + (uint64_t)stage, (uint64_t)l->number) < percent;
}

static double draw_delay_ms(const ll_link *l, int stage, const ll_link_params *p, double lag_ms)
{
    double delay = lag_ms + p->delay_ms;
    uint64_t stream = l->stream + (uint64_t)stage, counter = (uint64_t)l->number;
    if (p->jitter_ms > 0)
        delay += p->jitter_ms * (p->distribution == LL_DISTRIBUTION_NORMAL ? ll_rng_normal(l->seed, stream, counter)
                                                                          : 2 * ll_rng_unit(l->seed, stream, counter) - 1);
    return delay > 0 ? delay : 0;
}

/* ---- heap ---- */

static bool earlier(const slot *a, const slot *b)
{
    return a->due < b->due || (a->due == b->due && a->number < b->number);
}

static void push(ll_link *l, int32_t index)
{
    slot *s = slots_of(l);
    int32_t *heap = heap_of(l), i = l->heap_count++;
    while (i > 0 && earlier(&s[index], &s[heap[(i - 1) / 2]])) {
        heap[i] = heap[(i - 1) / 2];
        i = (i - 1) / 2;
    }
    heap[i] = index;
}

static int32_t pop(ll_link *l)
{
    slot *s = slots_of(l);
    int32_t *heap = heap_of(l), top = heap[0], moved = heap[--l->heap_count], i = 0;
    for (;;) {
        int32_t child = 2 * i + 1;
        if (child >= l->heap_count)
            break;
        if (child + 1 < l->heap_count && earlier(&s[heap[child + 1]], &s[heap[child]]))
            child++;
        if (!earlier(&s[heap[child]], &s[moved]))
            break;
        heap[i] = heap[child];
        i = child;
    }
    heap[i] = moved;
    heap[l->heap_count] = 0; /* what is free is zero: equal states have equal bytes */
    return top;
}

/* ---- sending ---- */

/* Room for `size` bytes in one piece: behind the newest, or again at the start. -1 when there is none. */
static int32_t find_room(const ll_link *l, int32_t size)
{
    if (l->used == 0)
        return size <= l->arena ? 0 : -1;
    if (l->write > l->oldest) {
        if (l->write + size <= l->arena)
            return l->write;
        return size < l->oldest ? 0 : -1; /* never quite full: write == oldest means empty */
    }
    return l->write + size < l->oldest ? l->write : -1;
}

static bool enqueue(ll_link *l, ll_time now, ll_time due, const void *bytes, int32_t size)
{
    int32_t room = find_room(l, round8(size));
    if (l->used == l->slots || room < 0)
        return false;
    if (l->used == 0)
        l->oldest = room;
    int32_t index = l->first + l->used++;
    if (index >= l->slots)
        index -= l->slots;
    slots_of(l)[index] = (slot){now, due, l->number, room, size};
    memcpy(arena_of(l) + room, bytes, (size_t)size);
    l->write = room + round8(size);
    push(l, index);
    return true;
}

static ll_time due_time(ll_link *l, int stage, const ll_link_params *p, double lag_ms, ll_time now)
{
    double delay_ms = draw_delay_ms(l, stage, p, lag_ms);
    ll_time due = now + ll_ms(delay_ms);
    if (p->order == LL_ORDER_FIFO && due < l->latest) {
        due = l->latest;
        delay_ms = ll_to_ms(due - now);
    }
    ll_link_stats *s = &l->stats;
    s->delay_min_ms = delay_ms < s->delay_min_ms ? delay_ms : s->delay_min_ms;
    s->delay_max_ms = delay_ms > s->delay_max_ms ? delay_ms : s->delay_max_ms;
    s->delay_sum_ms += delay_ms;
    s->delay_sum_squares += delay_ms * delay_ms;
    if (due > l->latest)
        l->latest = due;
    return due;
}

ll_sending ll_link_send(ll_link *l, const ll_link_params *p, double lag_ms, ll_time now, const void *bytes, int size)
{
    ll_sending sending = {.fate = LL_FATE_DELIVERED};
    LL_ASSERT(size > 0 && size <= l->arena);
    l->stats.sent++;
    l->stats.bytes += size;
    if (happens(l, STAGE_LOSS, p->loss_pct)) {
        l->stats.lost++;
        sending.fate = LL_FATE_LOST;
    } else {
        sending.due = due_time(l, STAGE_DELAY, p, lag_ms, now);
        if (!enqueue(l, now, sending.due, bytes, size)) {
            l->stats.overflowed++;
            sending.fate = LL_FATE_OVERFLOW;
        }
    }
    if (sending.fate == LL_FATE_DELIVERED && happens(l, STAGE_DUPLICATE, p->duplicate_pct)) {
        sending.copy_due = due_time(l, STAGE_COPY_DELAY, p, lag_ms, now);
        sending.duplicated = enqueue(l, now, sending.copy_due, bytes, size);
        l->stats.duplicated += sending.duplicated;
    }
    l->number++;
    LL_VALIDATE(ll_link_valid(l));
    return sending;
}

/* ---- receiving ---- */

ll_time ll_link_next_due(const ll_link *l)
{
    return l->heap_count > 0 ? slots_of(l)[heap_of(l)[0]].due : LL_NEVER;
}

static void free_delivered(ll_link *l)
{
    slot *s = slots_of(l);
    while (l->used > 0 && s[l->first].size == 0) {
        s[l->first] = (slot){0};
        l->first = l->first + 1 == l->slots ? 0 : l->first + 1;
        l->used--;
    }
    l->oldest = l->used > 0 ? s[l->first].offset : 0;
    if (l->used == 0)
        l->write = 0;
}

int ll_link_receive(ll_link *l, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due)
{
    if (ll_link_next_due(l) > now)
        return -1;
    slot *packet = &slots_of(l)[pop(l)];
    int32_t size = packet->size;
    LL_ASSERT(size <= capacity);
    memcpy(bytes, arena_of(l) + packet->offset, (size_t)size);
    *sent = packet->sent;
    *due = packet->due;
    l->stats.delivered++;
    l->stats.reordered += packet->number < l->delivered;
    if (packet->number > l->delivered)
        l->delivered = packet->number;
    packet->size = 0;
    free_delivered(l);
    LL_VALIDATE(ll_link_valid(l));
    return size;
}

void ll_link_clear(ll_link *l)
{
    memset(slots_of(l), 0, (size_t)l->slots * sizeof(slot));
    memset(heap_of(l), 0, (size_t)l->slots * sizeof(int32_t));
    l->first = l->used = l->heap_count = l->write = l->oldest = 0;
    l->latest = 0;
}

int ll_link_in_flight(const ll_link *l)
{
    return l->heap_count;
}

const ll_link_stats *ll_link_get_stats(const ll_link *l)
{
    return &l->stats;
}

bool ll_link_valid(const ll_link *l)
{
    const slot *s = slots_of(l);
    const int32_t *heap = heap_of(l);
    int in_flight = 0;
    if (l->used < 0 || l->used > l->slots || l->heap_count < 0 || l->heap_count > l->used)
        return false;
    for (int32_t k = 0, index = l->first; k < l->used; k++, index = index + 1 == l->slots ? 0 : index + 1) {
        in_flight += s[index].size > 0;
        if (s[index].size > 0 && (s[index].offset < 0 || s[index].offset + s[index].size > l->arena))
            return false;
    }
    for (int32_t i = 1; i < l->heap_count; i++)
        if (earlier(&s[heap[i]], &s[heap[(i - 1) / 2]]))
            return false;
    return in_flight == l->heap_count;
}

/* The packets are stored after the struct in the order of play-out. They are few, so that removing one moves
 * the others. */
#include "link/dejitter/dejitter.h"

#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

/* ---- policies ---- */

/* Updates a running average. */
static void average(double *mean, double value, double weight)
{
    *mean += weight * (value - *mean);
}

/* Moves the current delay towards `want`: it grows by at most the fraction `up` of the time since the last
 * packet, which slows play-out by as much, and shrinks by at most the fraction `down`. */
static ll_time approach(const ll_dejitter_history *h, const ll_dejitter_arrival *packet, double want_ms,
                        double up, double down)
{
    double passed = (double)(packet->arrived - h->arrived);
    ll_time want = ll_ms(want_ms), most = h->delay + (ll_time)(up * passed),
            least = h->delay - (ll_time)(down * passed);
    return want > most ? most : want < least ? least : want;
}

static ll_time no_delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                        const ll_dejitter_arrival *packet)
{
    (void)h, (void)params, (void)packet;
    return 0;
}

/* arrival: each packet is held for a fixed time after its arrival, as in the paper. Jitter remains.
 *
 * send_time: each is due at a fixed time after sending: the transit time of the fastest packet plus delay_ms.
 * If transit times are uniform over a width w, 1 - delay / w of the packets are late, and delay^2 / 2w is
 * added on average. */
static ll_time fixed_delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                           const ll_dejitter_arrival *packet)
{
    (void)h, (void)packet;
    return ll_ms(params->delay_ms);
}

/* Mirror's snapshot interpolation (SnapshotInterpolation.cs): interval * (1 + deviation / interval + 1), with
 * the deviation of the times between arrivals over 2 s, and a tolerance of 1. Mirror counts from an average
 * packet, over 1 s; here time counts from the fastest one, so the average lateness relative to it is added.
 * Play-out runs 4 % slower or 2 % faster to adapt. */

/* Weight of a value in an average over `seconds`. */
static double weight_of(double seconds, double interval_ms)
{
    LL_ASSERT(interval_ms > 0);
    return 2 / (seconds * 1000 / interval_ms + 1);
}

static ll_time mirror_delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                            const ll_dejitter_arrival *packet)
{
    double interval = params->interval_ms;
    if (h->packets == 0) {
        h->gap_ms = interval;
        h->spread_ms = 0;
        h->late_ms = 0;
        return ll_ms(2 * interval);
    }
    double weight = weight_of(2, interval), off = ll_to_ms(packet->arrived - h->arrived) - h->gap_ms;
    h->gap_ms += weight * off;
    h->spread_ms = (1 - weight) * (h->spread_ms + weight * off * off); /* a variance */
    average(&h->late_ms, packet->late_ms, weight_of(1, interval));
    return approach(h, packet, 2 * interval + ll_sqrt(h->spread_ms) + h->late_ms, 0.04, 0.02);
}

/* Unity's Netcode for Entities (NetworkTimeSystem.cs): the larger of the average time between arrivals and
 * the average gap between send times + 1.25 of its mean deviation, each with a weight of 0.25; at most six
 * intervals, at least the configured delay. The gaps show loss and reordering, not jitter. It counts from an
 * average packet, with a weight of 1/8; here time counts from the fastest one, so the average lateness
 * relative to it is added. The delay changes by at most a tenth of the time. */
#define NFE_WEIGHT 0.25

static ll_time nfe_delay(ll_dejitter_history *h, const ll_dejitter_params *params,
                         const ll_dejitter_arrival *packet)
{
    double interval = params->interval_ms, least = params->delay_ms;
    if (h->packets == 0) {
        h->gap_ms = h->arrivals_ms = interval;
        h->spread_ms = h->late_ms = 0;
        return ll_ms(interval > least ? interval : least);
    }
    double gap = ll_to_ms(packet->sent - h->sent);
    average(&h->gap_ms, gap, NFE_WEIGHT);
    average(&h->spread_ms, ll_abs(gap - h->gap_ms), NFE_WEIGHT);
    average(&h->arrivals_ms, ll_to_ms(packet->arrived - h->arrived), NFE_WEIGHT);
    average(&h->late_ms, packet->late_ms, 1.0 / 8);
    double want = h->gap_ms + 1.25 * h->spread_ms;
    want = want > h->arrivals_ms ? want : h->arrivals_ms;
    want = want < 6 * interval ? want : 6 * interval;
    want = (want > least ? want : least) + h->late_ms;
    return approach(h, packet, want, 0.1, 0.1);
}

/* X(kind, name, members) */
#define POLICIES(X)                                                                                          \
    X(NONE, none, .delay = no_delay)                                                                         \
    X(ARRIVAL, arrival, .delay = fixed_delay)                                                                \
    X(SEND_TIME, send_time, .delay = fixed_delay, .by_sending = true)                                        \
    X(MIRROR, mirror, .delay = mirror_delay, .by_sending = true)                                             \
    X(NFE, nfe, .delay = nfe_delay, .by_sending = true)

#define ROW(kind, name, ...) [LL_DEJITTER_##kind] = {__VA_ARGS__},
#define NAME(kind, name, ...) [LL_DEJITTER_##kind] = #name,

const ll_dejitter_policy ll_dejitter_policies[] = {POLICIES(ROW)};
const char *const ll_dejitter_names[] = {POLICIES(NAME)[LL_DEJITTER_CHOICES] = NULL};

/* ---- the buffer ---- */

#define WINDOW 8             /* parts of the window of the fastest packet */
#define PART (LL_SECOND / 4) /* length of a part */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

struct ll_dejitter {
    int32_t capacity, depth;
    int32_t policy; /* to which `history` belongs */
    int32_t reserved;
    int64_t part;            /* the current one */
    ll_time fastest[WINDOW]; /* least transit time per part, by its number modulo WINDOW */
    ll_time played;          /* due time of the last packet played out */
    ll_dejitter_history history;
    ll_dejitter_stats stats;
};

#pragma GCC diagnostic pop

static ll_dejitter_packet *packets_of(const ll_dejitter *b)
{
    return (ll_dejitter_packet *)(b + 1);
}

size_t ll_dejitter_size(int capacity)
{
    return sizeof(ll_dejitter) + (size_t)capacity * sizeof(ll_dejitter_packet);
}

void ll_dejitter_init(ll_dejitter *b, int capacity)
{
    LL_ASSERT(capacity > 0);
    memset(b, 0, ll_dejitter_size(capacity));
    b->capacity = capacity;
    ll_dejitter_clear(b);
}

void ll_dejitter_clear(ll_dejitter *b)
{
    b->depth = 0;
    b->part = 0;
    b->played = INT64_MIN;
    b->history = (ll_dejitter_history){0};
    for (int i = 0; i < WINDOW; i++)
        b->fastest[i] = LL_NEVER;
}

/* ---- time ---- */

/* Least transit time of the window, including the current packet's. */
static ll_time fastest_way(ll_dejitter *b, ll_time transit, ll_time arrived)
{
    int64_t part = arrived / PART;
    LL_ASSERT(arrived >= 0 && part >= b->part); /* packets come in the order of time */
    for (int64_t p = part - b->part > WINDOW ? part - WINDOW + 1 : b->part + 1; p <= part; p++)
        b->fastest[p % WINDOW] = LL_NEVER;
    b->part = part;
    ll_time least = transit;
    for (int i = 0; i < WINDOW; i++)
        least = b->fastest[i] < least ? b->fastest[i] : least;
    ll_time *present = &b->fastest[part % WINDOW];
    *present = transit < *present ? transit : *present;
    return least;
}

/* Play-out time by the policy, late or not. */
static ll_time schedule(ll_dejitter *b, const ll_dejitter_params *params, ll_time sent, ll_time arrived)
{
    const ll_dejitter_policy *policy = &ll_dejitter_policies[params->policy];
    ll_dejitter_history *h = &b->history;
    if (b->policy != params->policy)
        *h = (ll_dejitter_history){0};
    b->policy = params->policy;
    ll_time fastest = fastest_way(b, arrived - sent, arrived);
    ll_dejitter_arrival packet = {sent, arrived, ll_to_ms(arrived - sent - fastest)};
    h->delay = policy->delay(h, params, &packet);
    h->sent = sent;
    h->arrived = arrived;
    h->packets++;
    return policy->by_sending ? sent + fastest + h->delay : arrived + h->delay;
}

/* ---- order ---- */

/* After all that were sent earlier, or after all; never before one that is due. */
static int place_of(const ll_dejitter *b, ll_time sent, ll_time arrived)
{
    const ll_dejitter_packet *packets = packets_of(b);
    int place = b->depth;
    if (ll_dejitter_policies[b->policy].by_sending)
        while (place > 0 && packets[place - 1].sent > sent && packets[place - 1].due > arrived)
            place--;
    return place;
}

/* A changed delay must not change the order: not before earlier packets, not after later ones. */
static ll_time in_order(const ll_dejitter *b, int place, ll_time due)
{
    const ll_dejitter_packet *packets = packets_of(b);
    ll_time least = place > 0 ? packets[place - 1].due : b->played;
    if (due < least)
        due = least;
    return place < b->depth && packets[place].due < due ? packets[place].due : due;
}

static void count(ll_dejitter *b, const ll_dejitter_packet *packet)
{
    ll_dejitter_stats *s = &b->stats;
    double added = ll_to_ms(packet->due - packet->arrived);
    s->added_sum_ms += added;
    s->added_max_ms = added > s->added_max_ms ? added : s->added_max_ms;
    s->depth_sum += b->depth;
    s->depth_max = b->depth > s->depth_max ? b->depth : s->depth_max;
}

bool ll_dejitter_push(ll_dejitter *b, const ll_dejitter_params *params, int64_t id, ll_time sent,
                      ll_time arrived)
{
    ll_time scheduled = schedule(b, params, sent, arrived);
    b->stats.pushed++;
    if (b->depth == b->capacity) {
        b->stats.overflowed++;
        return false;
    }
    int place = place_of(b, sent, arrived);
    ll_time due = in_order(b, place, scheduled);
    if (due < arrived) {
        due = arrived;
        b->stats.late++;
        b->stats.underruns += b->depth == 0;
    }
    ll_dejitter_packet *packets = packets_of(b);
    memmove(packets + place + 1, packets + place, (size_t)(b->depth - place) * sizeof *packets);
    packets[place] = (ll_dejitter_packet){id, sent, arrived, due};
    b->depth++;
    count(b, &packets[place]);
    LL_VALIDATE(ll_dejitter_valid(b));
    return true;
}

ll_time ll_dejitter_next_due(const ll_dejitter *b)
{
    return b->depth > 0 ? packets_of(b)[0].due : LL_NEVER;
}

bool ll_dejitter_pop(ll_dejitter *b, ll_time now, ll_dejitter_packet *packet)
{
    if (ll_dejitter_next_due(b) > now)
        return false;
    ll_dejitter_packet *packets = packets_of(b);
    *packet = packets[0];
    LL_ASSERT(packet->due >= b->played); /* play-out keeps the order */
    b->played = packet->due;
    b->depth--;
    memmove(packets, packets + 1, (size_t)b->depth * sizeof *packets);
    return true;
}

/* ---- reported values ---- */

int ll_dejitter_depth(const ll_dejitter *b)
{
    return b->depth;
}

const ll_dejitter_packet *ll_dejitter_packets(const ll_dejitter *b)
{
    return packets_of(b);
}

ll_time ll_dejitter_delay(const ll_dejitter *b)
{
    return b->history.delay;
}

const ll_dejitter_stats *ll_dejitter_get_stats(const ll_dejitter *b)
{
    return &b->stats;
}

bool ll_dejitter_valid(const ll_dejitter *b)
{
    const ll_dejitter_packet *packets = packets_of(b);
    if (b->depth < 0 || b->depth > b->capacity)
        return false;
    for (int i = 0; i < b->depth; i++)
        if (packets[i].due < packets[i].arrived || (i > 0 && packets[i].due < packets[i - 1].due))
            return false;
    return true;
}

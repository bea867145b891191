#include "link/bottleneck/bottleneck.h"

#include "base/assert.h"
#include "base/detmath.h"
#include "base/rng.h"

/* Time that `bytes` take at the rate. At rates near 0 it is no number of ns: then longer than any limit and
 * any run. */
static ll_time transmission(const ll_bottleneck_params *params, int64_t bytes)
{
    const double most_ms = 1e9;
    double ms = 8.0 * (double)bytes / params->rate_kbps;
    return ll_ms(ms < most_ms ? ms : most_ms);
}

/* ---- disciplines: whether a packet is dropped that enters at `now` and would be served at `served` ---- */

static bool tail_drop_drops(ll_bottleneck *queue, ll_time now, ll_time served)
{
    (void)queue, (void)now, (void)served;
    return false; /* the queue's limit drops */
}

/* CoDel judges a packet when it is served: by how long it waited, not by how many are in the queue. After an
 * interval above the target it drops one, and the next ones after interval / sqrt(n), until the wait is below
 * the target. The queue is first in, first out: what is decided when the packet enters is the same.
 *
 * RFC 8289 also spares a queue of at most one full packet, by what is behind the one served; here that is
 * what was before it when it came. */
enum { FULL_PACKET = 1500 };

/* Whether the wait has been above the target for an interval. */
static bool has_stayed_above(ll_bottleneck *b, ll_time now, ll_time served)
{
    ll_time wait = served - now;
    if (wait < ll_ms(b->params.codel_target_ms) || wait <= transmission(&b->params, FULL_PACKET)) {
        b->first_above = LL_NEVER;
        return false;
    }
    if (b->first_above == LL_NEVER)
        b->first_above = served + ll_ms(b->params.codel_interval_ms);
    return served >= b->first_above;
}

static ll_time spacing(const ll_bottleneck *b)
{
    return ll_ms(b->params.codel_interval_ms / ll_sqrt((double)b->drop_count));
}

/* Soon after the last time, it goes on at about the rate of drops that was right then. */
static void begin_dropping(ll_bottleneck *b, ll_time served)
{
    int64_t more = b->drop_count - b->count_before;
    bool soon = served - b->drop_next < 16 * ll_ms(b->params.codel_interval_ms);
    b->dropping = 1;
    b->drop_count = more > 1 && soon ? more : 1;
    b->count_before = b->drop_count;
    b->drop_next = served + spacing(b);
}

static bool codel_drops(ll_bottleneck *b, ll_time now, ll_time served)
{
    bool above = has_stayed_above(b, now, served);
    if (!above) {
        b->dropping = 0;
        return false;
    }
    if (!b->dropping) {
        begin_dropping(b, served);
        return true;
    }
    if (served < b->drop_next)
        return false;
    b->drop_count++;
    b->drop_next += spacing(b);
    return true;
}

/* RED drops with a probability that grows with the average wait from the lower to the upper threshold, three
 * times as high, above which all are dropped. Between two drops their number is uniform, not geometric. The
 * average is of waits in time, not of packets. The pseudo-code of the paper counts one packet more after a
 * drop than its formula, which is used here. */
#define WEIGHT 0.002                            /* of a new wait in the average */
enum { TYPICAL_BYTES = 500, IDLE_MAX = 10000 }; /* a packet of an idle time; more of them leave nothing */

/* An empty queue counts as a wait of zero for each packet that could have passed. */
static void average(ll_bottleneck *b, ll_time now, ll_time served)
{
    ll_time typical = transmission(&b->params, TYPICAL_BYTES) + 1;
    int64_t idle = now > b->leaves ? (now - b->leaves) / typical : 0;
    for (int64_t i = 0; i < idle && i < IDLE_MAX && b->average_ms > 0; i++)
        b->average_ms *= 1 - WEIGHT;
    b->average_ms += WEIGHT * (ll_to_ms(served - now) - b->average_ms);
}

static bool red_drops(ll_bottleneck *b, ll_time now, ll_time served)
{
    const double min = b->params.red_min_ms, max = 3 * min;
    average(b, now, served);
    if (b->average_ms < min) {
        b->since_drop = -1;
        return false;
    }
    if (b->average_ms >= max) {
        b->since_drop = -1;
        return true;
    }
    double share = b->params.red_drop_pct / 100 * (b->average_ms - min) / (max - min);
    b->since_drop++;
    double left = 1 - (double)b->since_drop * share;
    bool drop = left <= 0 || ll_rng_unit(b->seed, b->stream + 1, (uint64_t)b->arrivals) < share / left;
    b->since_drop = drop ? -1 : b->since_drop;
    return drop;
}

#define ROW(KIND, NAME) NAME##_drops,
static bool (*const drops_by[])(ll_bottleneck *queue, ll_time now, ll_time served) = {LL_DISCIPLINES(ROW)};

/* ---- the queue ---- */

void ll_bottleneck_init(ll_bottleneck *b, const ll_bottleneck_params *params, uint64_t seed, uint64_t stream)
{
    *b = (ll_bottleneck){.params = *params,
                         .seed = seed,
                         .stream = stream,
                         .leaves = LL_LONG_AGO,
                         .next_cross = LL_NEVER,
                         .first_above = LL_NEVER};
}

/* With ECN the discipline marks at the instants at which it would drop; the limit drops all the same. */
static ll_bottleneck_fate enter(ll_bottleneck *b, ll_time now, int64_t bytes, bool capable)
{
    ll_time served = b->leaves > now ? b->leaves : now;
    ll_bottleneck_fate fate = {.served = served, .leaves = served + transmission(&b->params, bytes)};
    b->arrivals++;
    bool full = fate.leaves - now > ll_ms(b->params.limit_ms),
         judged = !full && drops_by[b->params.discipline](b, now, served);
    fate.marked = judged && capable && b->params.ecn;
    fate.dropped = full || (judged && !fate.marked);
    if (!fate.dropped)
        b->leaves = fate.leaves;
    return fate;
}

/* To the next packet of cross traffic: exponential. */
static ll_time gap(ll_bottleneck *b)
{
    double mean = (double)transmission(&b->params, b->params.cross_bytes) * 100 / b->params.cross_load_pct;
    double u = ll_rng_unit(b->seed, b->stream, (uint64_t)b->crossed);
    double ns = -mean * ll_detmath_log(1 - u), most = 1e17; /* later than any run: at loads near 0 */
    return (ll_time)(ns < most ? ns : most) + 1;
}

/* All that entered before `now`. */
static void cross(ll_bottleneck *b, ll_time now)
{
    if (b->params.cross_load_pct <= 0)
        return;
    if (b->next_cross == LL_NEVER)
        b->next_cross = now + gap(b);
    while (b->next_cross < now) {
        enter(b, b->next_cross, b->params.cross_bytes, false);
        b->crossed++;
        b->next_cross += gap(b);
    }
}

ll_bottleneck_fate ll_bottleneck_enter(ll_bottleneck *b, ll_time now, int64_t bytes, bool capable)
{
    LL_ASSERT(b->params.rate_kbps > 0);
    cross(b, now);
    return enter(b, now, bytes, capable);
}

/* ---- parameters ---- */

#define NAMED(KIND, NAME) #NAME,
static const char *const disciplines[] = {LL_DISCIPLINES(NAMED) NULL};

#define AT(NAME) .name = #NAME, .offset = offsetof(ll_bottleneck_params, NAME)
#define REAL(NAME) AT(NAME), .type = LL_PARAM_REAL

static const ll_param rows[] = {
    {REAL(rate_kbps), .max = 1000000, .unit = "kbit/s",
     .help = "Rate of the queue of each direction, which all players share: they are before it, at one "
             "access line. "
             "0: there is none."},
    {REAL(limit_ms), .min = 1, .max = 1250, .default_value = 200, .unit = "ms",
     .help = "Packets that would leave the queue later than this are dropped."},
    {AT(discipline), .type = LL_PARAM_CHOICE, .choices = disciplines,
     .help =
         "What is dropped before the limit. tail_drop: nothing. codel: some of those that wait longer than "
         "codel_target_ms, once they have for codel_interval_ms. red: at random, more the longer the average "
         "wait is."},
    {REAL(cross_load_pct), .max = 99, .unit = "%",
     .help = "Cross traffic: share of the rate that packets of others take, which come at random times."},
    {AT(cross_bytes), .type = LL_PARAM_INT, .min = 40, .max = 9000, .default_value = 1500, .unit = "B",
     .help = "Size of a packet of the cross traffic, headers included."},
    {REAL(codel_target_ms), .min = 0.1, .max = 100, .default_value = 5, .unit = "ms",
     .help = "codel: wait that is not yet too long."},
    {REAL(codel_interval_ms), .min = 1, .max = 1000, .default_value = 100, .unit = "ms",
     .help = "codel: time above the target until the first drop; the n-th follows after this over the root "
             "of n."},
    {REAL(red_min_ms), .min = 0.1, .max = 400, .default_value = 20, .unit = "ms",
     .help = "red: average wait from which packets are dropped; at three times this all are."},
    {REAL(red_drop_pct), .min = 0.1, .max = 100, .default_value = 10, .unit = "%",
     .help = "red: share that is dropped at an average wait of three times red_min_ms."},
    {AT(ecn), .type = LL_PARAM_BOOL,
     .help = "ECN: codel and red mark packets of transports that react to marks (tcp, quic) instead of "
             "dropping them."},
};

const ll_param_table ll_bottleneck_table = {.name = "bottleneck",
                                            .help = "A queue in each direction that all players share.",
                                            LL_PARAM_ROWS(rows, ll_bottleneck_params)};

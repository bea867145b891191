/* Drops with a probability that grows with the average wait from the lower to the upper threshold, three
 * times as high, above which all are dropped. Between two drops their number is uniform, not geometric. The
 * average is of waits in time, not of packets. The pseudo-code
 * of the paper counts one packet more after a drop than its formula, which is used here. */
#include "base/rng.h"
#include "link/bottleneck/bottleneck.h"

#define WEIGHT 0.002                            /* of a new wait in the average */
enum { TYPICAL_BYTES = 500, IDLE_MAX = 10000 }; /* a packet of an idle time; more of them leave nothing */

/* An empty queue counts as a wait of zero for each packet that could have passed. */
static void average(ll_bottleneck *b, ll_time now, ll_time served)
{
    ll_time typical = ll_bottleneck_transmission(&b->params, TYPICAL_BYTES) + 1;
    int64_t idle = now > b->leaves ? (now - b->leaves) / typical : 0;
    for (int64_t i = 0; i < idle && i < IDLE_MAX && b->average_ms > 0; i++)
        b->average_ms *= 1 - WEIGHT;
    b->average_ms += WEIGHT * (ll_to_ms(served - now) - b->average_ms);
}

static bool drops(ll_bottleneck *b, ll_time now, ll_time served)
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

const ll_discipline_rule ll_discipline_red = {.name = "red", .drops = drops};

#include "link/bottleneck/bottleneck.h"

#include "base/assert.h"
#include "base/detmath.h"
#include "base/rng.h"

#define ROW(KIND, NAME) &ll_discipline_##NAME,
static const ll_discipline_rule *const rules[] = {LL_DISCIPLINES(ROW)};

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
    ll_bottleneck_fate fate = {.served = served,
                               .leaves = served + ll_bottleneck_transmission(&b->params, bytes)};
    b->arrivals++;
    bool full = fate.leaves - now > ll_ms(b->params.limit_ms),
         judged = !full && rules[b->params.discipline]->drops(b, now, served);
    fate.marked = judged && capable && b->params.ecn;
    fate.dropped = full || (judged && !fate.marked);
    if (!fate.dropped)
        b->leaves = fate.leaves;
    return fate;
}

/* To the next packet of cross traffic: exponential. */
static ll_time gap(ll_bottleneck *b)
{
    double mean = (double)ll_bottleneck_transmission(&b->params, b->params.cross_bytes) * 100 /
                  b->params.cross_load_pct;
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

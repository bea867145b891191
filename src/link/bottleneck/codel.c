/* CoDel judges a packet when it is served: by how long it waited, not by how many are in the queue. After an
 * interval above the target it drops one, and the next ones after interval / sqrt(n), until the wait is below
 * the target. The queue is first in, first out: what is decided when the packet enters is the same.
 *
 * RFC 8289 also spares a queue of at most one full packet, by what is behind the one served; here that is
 * what was before it when it came. */
#include "base/detmath.h"
#include "link/bottleneck/bottleneck.h"

enum { FULL_PACKET = 1500 };

/* Whether the wait has been above the target for an interval. */
static bool has_stayed_above(ll_bottleneck *b, ll_time now, ll_time served)
{
    ll_time wait = served - now;
    if (wait < ll_ms(b->params.codel_target_ms) ||
        wait <= ll_bottleneck_transmission(&b->params, FULL_PACKET)) {
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
static void begin(ll_bottleneck *b, ll_time served)
{
    int64_t more = b->drop_count - b->count_before;
    bool soon = served - b->drop_next < 16 * ll_ms(b->params.codel_interval_ms);
    b->dropping = 1;
    b->drop_count = more > 1 && soon ? more : 1;
    b->count_before = b->drop_count;
    b->drop_next = served + spacing(b);
}

static bool drops(ll_bottleneck *b, ll_time now, ll_time served)
{
    bool above = has_stayed_above(b, now, served);
    if (!above) {
        b->dropping = 0;
        return false;
    }
    if (!b->dropping) {
        begin(b, served);
        return true;
    }
    if (served < b->drop_next)
        return false;
    b->drop_count++;
    b->drop_next += spacing(b);
    return true;
}

const ll_discipline_rule ll_discipline_codel = {.name = "codel", .drops = drops};

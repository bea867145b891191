/* Shared by the stages: whether an event happens to a packet. */
#include "link/stages/stage.h"

bool ll_chance(const ll_passage *p, ll_stream stream, double percent, double corr_pct, int64_t *last)
{
    bool happens = 100 * ll_draw(p, stream) < ll_chain_percent(percent, corr_pct, *last == ll_draw_before(p));
    if (happens && !p->is_copy)
        *last = p->number;
    return happens;
}

bool ll_window_open(double at_ms, double every_ms, double length_ms, ll_time now)
{
    if (length_ms <= 0)
        return false;
    ll_time since = now - ll_ms(at_ms), every = ll_ms(every_ms);
    if (since < 0)
        return false;
    return (every > 0 ? since % every : since) < ll_ms(length_ms);
}

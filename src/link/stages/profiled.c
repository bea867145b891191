/* Stages of profiles, which few links have: cells, traces, slots. */
#include "link/stages/stage.h"

/* ---- cells: packets travel in whole ones, each with its own overhead, as netem's `rate` has it for ATM: the
 * queue sends ceil((size + overhead) / cell) * (cell + cell overhead) bytes ---- */

void ll_stage_cells(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)m;
    (void)stats;
    int64_t cell = p->profile->cell_bytes, size = p->size + p->params->packet_overhead_bytes;
    int64_t cells = (size + cell - 1) / cell;
    p->size = (int32_t)(cells * (cell + p->profile->cell_overhead_bytes) - p->params->packet_overhead_bytes);
}

/* ---- a measured delay and loss: a row holds from its stamp to the next one's, the last as long as the one
 * before it; then the trace begins again ---- */

static ll_time period_of(const int64_t *times, int32_t count)
{
    return count < 2 ? 0 : times[count - 1] + (times[count - 1] - times[count - 2]);
}

/* The last row whose stamp is not after `now`. The first stamp is 0. */
static int32_t row_at(const int64_t *times, int32_t count, ll_time now)
{
    ll_time period = period_of(times, count), at = period > 0 ? now % period : 0;
    int32_t low = 0, high = count - 1;
    at += at < 0 ? period : 0;
    while (low < high) {
        int32_t middle = high - (high - low) / 2;
        if (times[middle] <= at)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

void ll_stage_trace(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_profile *profile = p->profile;
    int32_t row = row_at(ll_profile_trace_times(profile), profile->trace_count, p->now);
    p->delay_ms += ll_profile_trace_delays(profile)[row];
    if (p->fate != LL_FATE_DELIVERED || ll_profile_trace_losses(profile)[row] == 0)
        return;
    p->fate = LL_FATE_LOST;
    p->state->trace_lost++;
    ll_count_loss(p, m, stats);
}

/* ---- netem's slots: nothing leaves before a slot begins, then up to slot_packets or slot_bytes at once, as
 * links do that wait for their turn (Wi-Fi, cable). netem begins to count a slot when a packet comes to an
 * idle link, so that it waits a whole one; on a grid of fixed times it waits half in the mean. Packets leave
 * in the order of sending ---- */

static ll_time later(ll_time a, ll_time b)
{
    return a > b ? a : b;
}

static void open_slot(const ll_link_profile *profile, ll_profile_state *s, ll_time at)
{
    s->slot = at;
    s->slot_packets = profile->slot_packets;
    s->slot_bytes = profile->slot_bytes;
}

static bool is_full(const ll_profile_state *s)
{
    return s->slot_packets <= 0 || s->slot_bytes <= 0;
}

/* A slot that is full is followed by another; one for which no packet waits ends. */
static void open_after_idle(const ll_passage *p, ll_profile_state *s, ll_time ready)
{
    const ll_link_profile *profile = p->profile;
    double length_ms =
        profile->slot_min_ms + (profile->slot_max_ms - profile->slot_min_ms) * ll_draw(p, LL_STREAM_SLOT);
    ll_time length = ll_ms(length_ms);
    if (s->slot >= ready && is_full(s))
        open_slot(profile, s, s->slot + length);
    else if (s->slot < ready) {
        bool follows = is_full(s) && s->slot + length >= ready;
        open_slot(profile, s, (follows ? s->slot : ready) + length);
    }
}

/* The first multiple of the slot's length that is not before `ready`, or the next if that is full. */
static void open_on_grid(const ll_passage *p, ll_profile_state *s, ll_time ready)
{
    ll_time length = ll_ms(p->profile->slot_max_ms), begin = ready / length * length;
    begin += begin < ready ? length : 0;
    if (begin > s->slot)
        open_slot(p->profile, s, begin);
    else if (is_full(s))
        open_slot(p->profile, s, s->slot + length);
}

void ll_stage_slot(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)m;
    ll_profile_state *s = p->state, before = *s;
    if (p->fate != LL_FATE_DELIVERED || p->reordered)
        return;
    ll_time comes = p->now + ll_ms(p->delay_ms) + p->queued, ready = later(comes, s->last);
    (p->profile->slot_start == LL_SLOT_GRID ? open_on_grid : open_after_idle)(p, s, ready);
    if (s->slot - comes > ll_ms(p->params->limit_ms)) {
        *s = before;
        p->fate = LL_FATE_OVERFLOW;
        stats->queue_drops++;
        return;
    }
    s->slot_packets--;
    s->slot_bytes -= p->size + p->params->packet_overhead_bytes;
    s->last = s->slot;
    p->queued += s->slot - comes;
}

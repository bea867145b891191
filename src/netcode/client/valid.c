#include "netcode/client/valid.h"

#include <stddef.h>

static const char *broken_inputs(const ll_client *c)
{
    if (c->inputs.acked > c->inputs.seq || c->inputs.newest_sent > c->inputs.seq)
        return "an input is acknowledged or sent that was not made";
    uint32_t open =
        c->inputs.seq - c->inputs.acked < LL_PENDING_RING ? c->inputs.seq - c->inputs.acked : LL_PENDING_RING;
    for (uint32_t i = 0; i < open; i++) {
        const ll_pending_input *p = &c->pending[(c->inputs.seq - i) & (LL_PENDING_RING - 1)];
        if (p->seq != 0 && p->seq != c->inputs.seq - i)
            return "an open input is not in its place of the ring";
    }
    for (int i = 0; i < LL_PENDING_RING; i++)
        if (c->pending[i].seq > c->inputs.seq || c->pending[i].state > LL_INPUT_SKIPPED)
            return "the ring has an input that was not made, or an unknown state of one";
    return c->inputs.refused < 0 || c->ticks.skipped < 0 ? "a count is negative" : NULL;
}

static const char *broken_snapshots(const ll_client *c, bool in_order)
{
    if (c->snapshots.used < 0 || c->snapshots.used > c->snapshots.received ||
        c->drawing.received > c->snapshots.received)
        return "more snapshots are used than were received";
    int64_t at = ll_client_oldest(c);
    for (int64_t i = at + 1; i < c->snapshots.received; i++) {
        const ll_snapshot_entry *before = ll_client_state((ll_client *)(uintptr_t)c, i - 1);
        const ll_snapshot_entry *entry = ll_client_state((ll_client *)(uintptr_t)c, i);
        if (in_order && entry->tick <= before->tick)
            return "snapshots are not in the order of their ticks";
        if (entry->arrived < before->arrived)
            return "snapshots are not in the order of their arrival";
    }
    return c->snapshots.stale < 0 || c->snapshots.unreadable < 0 ? "a count is negative" : NULL;
}

static const char *broken_layout(const ll_client *c)
{
    const int64_t at[] = {sizeof *c,          c->layout.latest,     c->layout.predicted, c->layout.checked,
                          c->layout.rendered, c->layout.draw_infos, c->layout.errors,    c->layout.states};
    for (size_t i = 1; i < sizeof at / sizeof at[0]; i++)
        if (at[i] < at[i - 1] || at[i] % 8 != 0)
            return "the parts of the block overlap, or are not aligned";
    return (int64_t)ll_world_size(ll_client_rendered_const(c)) != c->layout.world_size
               ? "the rendered world has another size than the game's"
               : NULL;
}

const char *ll_client_broken(const ll_client *c, bool in_order)
{
    const char *broken = broken_layout(c);
    if (c->self < 0 || c->self >= LL_PLAYERS_MAX)
        return "the client is no player's";
    if (c->view.state > LL_VIEW_EXTRAPOLATING || c->view.has_render > 1 || c->view.underrun > 1 ||
        c->view.held > 1)
        return "a state of the view is unknown";
    if (broken == NULL)
        broken = broken_inputs(c);
    return broken ? broken : broken_snapshots(c, in_order);
}

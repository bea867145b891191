#include "netcode/state/client.h"

/* `now`: the frame that draws the snapshot. */
void ll_client_close(ll_client *c, const ll_client_setup *s, uint32_t seq, ll_input_state how,
                     const ll_snapshot_entry *state, ll_time now)
{
    ll_pending_input *p = ll_client_pending(c, seq);
    if (p->seq != seq)
        return; /* no such input: the clock snapped beyond it, or a newer input overwrote it */
    p->state = (uint8_t)how;
    if (p->closed_once)
        return;
    p->closed_once = 1;
    if (!(s->client_metrics->observes & LL_OBSERVE_INPUTS))
        return;
    if (now >= s->client_metrics->from)
        ll_input_history_closed(&s->client_metrics->input_history, seq, how == LL_INPUT_APPLIED, state->tick);
    if (how == LL_INPUT_APPLIED)
        ll_client_metrics_acknowledged(s->client_metrics, seq, state->tick, p->made, state->arrived, now);
}

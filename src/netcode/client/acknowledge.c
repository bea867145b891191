#include "netcode/state/client.h"

/* `now` is the frame that draws the state. */
void ll_client_close(ll_client *c, const ll_client_setup *s, uint32_t seq, ll_input_state how,
                     const ll_snapshot_entry *state, ll_time now)
{
    ll_pending_input *p = ll_client_pending(c, seq);
    if (p->seq != seq)
        return; /* none was made, the clock having snapped, or it gave way to a newer one */
    p->state = (uint8_t)how;
    if (p->told)
        return;
    p->told = 1;
    if (now >= s->client_metrics->from)
        ll_input_history_closed(&s->client_metrics->input_history, seq, how == LL_INPUT_APPLIED, state->tick);
    if (how == LL_INPUT_APPLIED)
        ll_client_metrics_acknowledged(s->client_metrics, seq, state->tick, p->made, state->arrived, now);
}

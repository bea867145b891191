/* Prediction and reconciliation of a client's own entity (paper, "Working Around Lockstep Delay"; Figure 12).
 *
 * Each input remembers where it had put the entity. A state of the server tells where the acknowledged input
 * really put it: when the two are equal to the bit nothing has to be done; otherwise the inputs that the
 * server has not seen are applied again on top of its state. Cost: one entity step per open input and
 * correction. */
#include <string.h>

#include "base/detmath.h"
#include "netcode/client.h"

void ll_predict_input(ll_client *c, const ll_client_setup *s, ll_pending *input)
{
    ll_world *world = ll_client_predicted(c);
    s->game->step_own(world, s->env, c->self, &input->action);
    input->after = world->entity[c->self];
}

void ll_predict_again(ll_client *c, const ll_client_setup *s, const ll_world *from)
{
    memcpy(ll_client_predicted(c), from, (size_t)c->world_size);
    for (uint32_t seq = c->acked + 1; seq <= c->seq; seq++)
        ll_predict_input(c, s, ll_client_pending(c, seq));
}

static bool as_predicted(ll_client *c, const ll_client_setup *s, const ll_world *truth, uint32_t acked)
{
    const ll_pending *p = ll_client_pending(c, acked);
    return acked > 0 && !s->game->own_reads_tail && p->seq == acked &&
           memcmp(&p->after, &truth->entity[c->self], sizeof p->after) == 0;
}

static void note_correction(ll_client *c, const ll_client_setup *s, const ll_entity *before,
                            const ll_entity *after, int64_t tick, ll_time now)
{
    ll_instruments *in = s->instruments;
    double dx = after->x - before->x, dy = after->y - before->y;
    double size = ll_sqrt(dx * dx + dy * dy);
    if (size == 0)
        return;
    ll_smooth_correct(c, c->self, before, after);
    ll_measure(in, LL_METRIC_CORRECTION, now, size);
    in->corrections += now >= in->from;
    in->last_correction = dx < 0 ? -size : size;
    if (s->recorder)
        s->recorder->record(s->recorder->context, &(ll_event){.type = LL_EVENT_CORRECTION,
                                                              .player = (uint8_t)c->self,
                                                              .begin = now,
                                                              .end = now,
                                                              .number = (uint32_t)tick,
                                                              .value = (float)in->last_correction});
}

void ll_reconcile(ll_client *c, const ll_client_setup *s, ll_received *state, ll_time now)
{
    const ll_world *truth = ll_received_world(state);
    ll_world *predicted = ll_client_predicted(c);
    if (!c->predicting)
        return; /* this frame starts to predict, from the same state */
    ll_entity before = predicted->entity[c->self];
    if (!s->config->reconciliation)
        memcpy(predicted, truth,
               (size_t)c->world_size); /* the paper's plain prediction: back to what the server says */
    else if (!as_predicted(c, s, truth, state->acked))
        ll_predict_again(c, s, truth);
    note_correction(c, s, &before, &predicted->entity[c->self], state->tick, now);
}

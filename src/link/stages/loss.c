/* As in netem, one draw takes one of two. The remaining one goes on as the packet, and there is no copy; a
 * copy that comes here has its own draw. A blackout takes all. */
#include "link/stages/stage.h"

#define ROW(KIND, NAME) &ll_loss_##NAME,
const ll_loss_model *const ll_loss_models[] = {LL_LOSS_MODELS(ROW) NULL};

/* A model that did not decide about the last packet starts in its first state. A copy continues from its
 * original's state and leaves its own to the next packet. */
static bool model_loses(const ll_passage *p, ll_memory *m)
{
    if (p->is_copy) {
        int32_t state = m->loss_state;
        return ll_loss_models[m->loss_model]->lost(p, &state);
    }
    if (m->loss_number != p->number - 1 || m->loss_model != p->params->loss_model)
        m->loss_state = 0;
    m->loss_number = p->number;
    m->loss_model = p->params->loss_model;
    return ll_loss_models[m->loss_model]->lost(p, &m->loss_state);
}

void ll_count_loss(const ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    stats->lost++;
    stats->lost_copies += p->is_copy;
    if (p->is_copy)
        return;
    stats->loss_bursts += m->lost != p->number - 1;
    m->lost = p->number;
}

void ll_mark(ll_passage *p)
{
    p->marked = true;
    p->state->marked++;
}

void ll_stage_loss(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    bool lost = model_loses(p, m);
    bool blackout =
        ll_window_open(params->blackout_at_ms, params->blackout_every_ms, params->blackout_length_ms, p->now);
    if (!lost && !blackout)
        return;
    if (!blackout && p->profile && p->profile->ecn) { /* a loss is a mark, as in netem */
        ll_mark(p);
        return;
    }
    p->rescued = p->duplicated && !p->is_copy && !blackout;
    p->fate = p->rescued ? LL_FATE_DELIVERED : LL_FATE_LOST;
    stats->rescued += p->rescued;
    stats->lost_in_blackouts += blackout;
    ll_count_loss(p, m, stats);
}

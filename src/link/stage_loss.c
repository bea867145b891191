#include "link/stage.h"

const ll_loss_model *const ll_loss_models[] = {&ll_loss_random, &ll_loss_gemodel, &ll_loss_state, NULL};

/* A model that has not decided about the packet before begins in its first state. */
static bool model_loses(const ll_passage *p, ll_memory *m)
{
    if (m->loss_number != p->number - 1 || m->loss_model != p->params->loss_model)
        m->loss_state = 0;
    m->loss_number = p->number;
    m->loss_model = p->params->loss_model;
    return ll_loss_models[m->loss_model]->lost(p, &m->loss_state);
}

void ll_stage_loss(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    bool lost = model_loses(p, m);
    bool blackout =
        ll_window_open(params->blackout_at_ms, params->blackout_every_ms, params->blackout_length_ms, p->now);
    if (!lost && !blackout)
        return;
    p->fate = LL_FATE_LOST;
    stats->lost++;
    stats->lost_in_blackouts += blackout;
    stats->loss_bursts += m->lost != p->number - 1;
    m->lost = p->number;
}

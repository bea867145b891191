/* Loss, by one of the models of parameters.h. As in netem, one draw takes one of two. The remaining one goes
 * on as the packet, and there is no copy; a copy that comes here has its own draw. A blackout takes all. */
#include "link/stages/stage.h"

/* ---- models: whether a packet is lost; the state starts at 0 ---- */

/* Independent losses, or a two-state chain (see ll_link_params): mean burst length 1 / ((1 - p) (1 - corr)).
 * One draw per packet. State 1: after a lost packet. */
static bool lost_by_random(const ll_passage *p, int32_t *state)
{
    const ll_link_params *params = p->params;
    *state =
        100 * ll_draw(p, LL_STREAM_LOSS) < ll_chain_percent(params->loss_pct, params->loss_corr_pct, *state);
    return *state;
}

/* E. N. Gilbert, "Capacity of a burst-noise channel", Bell Syst. Tech. J. 39, 1960; E. O. Elliott, "Estimates
 * of error rates for codes on burst-noise channels", 42, 1963. In the long run p / (p + r) of the packets are
 * sent in the bad state, in runs of 1 / r. Two draws per packet. State 1: bad. */
static bool lost_by_gemodel(const ll_passage *p, int32_t *state)
{
    const ll_link_params *params = p->params;
    bool bad = *state;
    double leave = bad ? params->ge_r_pct : params->ge_p_pct;
    if (100 * ll_draw(p, LL_STREAM_TRANSITION) < leave)
        *state = !bad;
    return 100 * ll_draw(p, LL_STREAM_LOSS) < (bad ? params->ge_1h_pct : params->ge_1k_pct);
}

/* S. Salsano, F. Ludovici, A. Ordine, "Definition of a general and intuitive loss model for packet networks
 * and its implementation in the Netem module in the Linux kernel", 2009. With pi the fraction of a state: pi1
 * p13 = pi3 p31, pi4 = pi1 p14, pi2 p23 = pi3 p32. One draw per packet. */
enum { RECEIVED, RECEIVED_IN_BURST, LOST_IN_BURST, LOST }; /* states 1 to 4 */

static bool lost_by_state(const ll_passage *p, int32_t *state)
{
    const ll_link_params *params = p->params;
    double percent = 100 * ll_draw(p, LL_STREAM_TRANSITION);
    switch (*state) {
    case RECEIVED:
        *state = percent < params->p14_pct                     ? LOST
                 : percent < params->p14_pct + params->p13_pct ? LOST_IN_BURST
                                                               : RECEIVED;
        break;
    case RECEIVED_IN_BURST:
        *state = percent < params->p23_pct ? LOST_IN_BURST : RECEIVED_IN_BURST;
        break;
    case LOST_IN_BURST:
        *state = percent < params->p32_pct                     ? RECEIVED_IN_BURST
                 : percent < params->p32_pct + params->p31_pct ? RECEIVED
                                                               : LOST_IN_BURST;
        break;
    default:
        *state = RECEIVED;
        break;
    }
    return *state == LOST_IN_BURST || *state == LOST;
}

#define ROW(KIND, NAME) lost_by_##NAME,
static bool (*const lost_by[])(const ll_passage *passage, int32_t *state) = {LL_LOSS_MODELS(ROW)};

/* ---- the stage ---- */

/* A model that did not decide about the last packet starts in its first state. A copy continues from its
 * original's state and leaves its own to the next packet. */
static bool model_loses(const ll_passage *p, ll_memory *m)
{
    if (p->is_copy) {
        int32_t state = m->loss_state;
        return lost_by[m->loss_model](p, &state);
    }
    if (m->loss_number != p->number - 1 || m->loss_model != p->params->loss_model)
        m->loss_state = 0;
    m->loss_number = p->number;
    m->loss_model = p->params->loss_model;
    return lost_by[m->loss_model](p, &m->loss_state);
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

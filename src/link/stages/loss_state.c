/* S. Salsano, F. Ludovici, A. Ordine, "Definition of a general and intuitive loss model for packet networks
 * and its implementation in the Netem module in the Linux kernel", 2009. With pi the fraction of a state: pi1
 * p13 = pi3 p31, pi4 = pi1 p14, pi2 p23 = pi3 p32. One draw per packet. */
#include "link/stages/stage.h"

enum { RECEIVED, RECEIVED_IN_BURST, LOST_IN_BURST, LOST }; /* states 1 to 4 */

static bool lost(const ll_passage *p, int32_t *state)
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

const ll_loss_model ll_loss_state = {.name = "state", .lost = lost};

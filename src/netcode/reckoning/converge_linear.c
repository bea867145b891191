/* Linear: the deviation shrinks evenly. The drawn speed is at most that of the model + deviation / tau, and
 * jumps at both ends. */
#include "netcode/reckoning/reckoning.h"

static double left(double e, double u, double tau, double t, double *rate)
{
    (void)u;
    *rate = -e / tau;
    return e * (1 - t / tau);
}

const ll_convergence ll_convergence_linear = {
    .name = "linear", .help = "The deviation shrinks evenly.", .left = left};

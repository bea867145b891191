/* Cubic: a cubic of the deviation that begins with its value and rate and ends with neither: the drawn
 * velocity has no jump. It may swing out further than the deviation where the rate is large. */
#include "netcode/reckoning/reckoning.h"

static double left(double e, double u, double tau, double t, double *rate)
{
    double s = t / tau, r = 1 - s;
    *rate = e * 6 * s * (s - 1) / tau + u * r * (1 - 3 * s);
    return e * r * r * (1 + 2 * s) + u * tau * s * r * r;
}

const ll_convergence ll_convergence_cubic = {
    .name = "cubic", .help = "A cubic, without a jump of the velocity.", .left = left};

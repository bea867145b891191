/* Projective velocity blending (Murphy, "Believable Dead Reckoning for Networked Games", Game Engine Gems 2,
 * 2011): the drawn entity goes on at a velocity that is blended from its old to the new one, and its place is
 * blended with the model's. In terms of the deviation: (1 - s) (e + (1 - s) u t), s = t / tau. */
#include "netcode/reckoning/reckoning.h"

static double left(double e, double u, double tau, double t, double *rate)
{
    double s = t / tau, r = 1 - s;
    *rate = -e / tau + u * r * (1 - 3 * s);
    return r * (e + r * u * t);
}

const ll_convergence ll_convergence_projective = {
    .name = "projective", .help = "Old and new motion continue and are blended.", .left = left};

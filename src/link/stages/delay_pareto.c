/* Pareto of shape 3 and minimum 1, truncated at B = 10. With c = 1 - B^-3 its moments are mean = 3/2 (1 -
 * B^-2) / c and 3 (1 - B^-1) / c for the square: a mean of 55/37 and a variance of 100/37 - mean^2. Without
 * truncation the fourth moment, and with it a measured variance, would not converge. */
#include "base/detmath.h"
#include "link/stages/stage.h"

#define C 0.999
#define MEAN (55.0 / 37)
#define SD 0.702182759825220524

static double variate(double u)
{
    return (ll_exp(ll_detmath_log(1 - u * C) * (-1.0 / 3)) - MEAN) / SD;
}

/* Inverse of corr = sum of c_k^2 deviate_corr^k, with c_k the coefficients of the variate in normalised
 * Hermite polynomials of the deviate: a fit; correlations are off by at most 1.4e-4. */
static double deviate_corr(double corr)
{
    return corr * (1.63449 + corr * (-1.24896 + corr * (1.10949 + corr * (-0.678146 + corr * 0.183126))));
}

const ll_delay_model ll_delay_pareto = {
    .name = "pareto", .variate = variate, .deviate_corr = deviate_corr, .max = (10 - MEAN) / SD};

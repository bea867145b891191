/* A quarter normal and three quarters pareto at the same quantile. Both have variance 1 and their covariance
 * is c = 0.78050503 (by quadrature), so that of the sum is (10 + 6 c) / 16. */
#include "link/stages/stage.h"

#define SD 0.957961055882941

static double variate(double u)
{
    return (ll_delay_normal.variate(u) + 3 * ll_delay_pareto.variate(u)) / (4 * SD);
}

/* A fit as for pareto, off by at most 1e-5. */
static double deviate_corr(double corr)
{
    return corr * (1.3142 + corr * (-0.4234 + corr * (0.140642 + corr * -0.031442)));
}

const ll_delay_model ll_delay_paretonormal = {
    .name = "paretonormal", .variate = variate, .deviate_corr = deviate_corr, .max = 10.5367566487743540};

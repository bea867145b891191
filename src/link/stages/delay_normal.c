/* Standard normal within 4 standard deviations, like netem's table. With a = Phi(-4) its variance is 1 - 8
 * phi(4) / (1 - 2 a) = 0.99892929; the variates are scaled to 1. */
#include "link/stages/stage.h"

#define A 3.16712418331199e-05
#define SD 0.999464501807080

static double variate(double u)
{
    return ll_normal_quantile(A + u * (1 - 2 * A)) / SD;
}

/* Truncation changes the correlation by less than 1.1e-5. */
static double deviate_corr(double corr)
{
    return corr;
}

const ll_delay_model ll_delay_normal = {
    .name = "normal", .variate = variate, .deviate_corr = deviate_corr, .max = 4 / SD};

#include "base/detmath.h"
#include "link/stages/stage.h"

static double variate(double u)
{
    return 2 * u - 1;
}

/* K. Pearson's relation of rank and product-moment correlation, 1907: corr = 6/pi asin(deviate_corr / 2). */
static double deviate_corr(double corr)
{
    return 2 * ll_sin(corr * (3.14159265358979323846 / 6));
}

const ll_delay_model ll_delay_uniform = {
    .name = "uniform", .variate = variate, .deviate_corr = deviate_corr, .max = 1};

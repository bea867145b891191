/* Distributions against SciPy 1.10 and closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "experiment/statistics/distributions.h"
#include "support/near.h"

#define NEAR(got, wanted, relative) assert_near(got, wanted, (relative)*fabs(wanted))

static void functions_are_scipys(void **state)
{
    (void)state;
    static const double beta[][4] = {
        {0.3, 2, 5, 0.57982500000000015},      {0.01, 0.5, 0.5, 0.063768560858519868},
        {0.999, 0.5, 3, 0.99999999968738273},  {0.5, 250, 260, 0.67118356207101593},
        {1e-6, 1, 99, 9.8995149156845251e-05}, {0.02, 1.5, 40, 0.34654713215022043}};
    static const double gamma[][3] = {{0.1, 0.5, 0.34527915398142317},   {1, 1, 0.63212055882855767},
                                      {3.7, 4, 0.50584675584958161},     {120, 100, 0.97213626010947929},
                                      {1e-4, 0.05, 0.64812693926266873}, {30, 2.25, 0.99999999999395761}};
    for (int i = 0; i < 6; i++) {
        NEAR(ll_beta_cdf(beta[i][0], beta[i][1], beta[i][2]), beta[i][3], 1e-10);
        NEAR(ll_gamma_cdf(gamma[i][0], gamma[i][1]), gamma[i][2], 1e-10);
    }
}

static void quantiles_are_scipys(void **state)
{
    (void)state;
    static const double student[][3] = {{0.025, 1, 12.706204736432102},   {0.025, 2, 4.3026527299112765},
                                        {0.025, 4, 2.7764451051977996},   {0.025, 9, 2.262157162740992},
                                        {0.025, 199, 1.9719565442493954}, {0.005, 3, 5.8409093097333527},
                                        {0.1, 7.5, 1.4052118464151127},   {0.0025, 30, 3.0297982236469334}};
    static const double gamma[][3] = {{0.025, 1, 0.025317807984289876},
                                      {0.975, 1, 3.6888794541139354},
                                      {0.975, 3.5, 8.0063821373146631},
                                      {0.025, 0.3, 3.1856790317391693e-06},
                                      {0.5, 50, 49.667064617994228}};
    for (int i = 0; i < 8; i++)
        NEAR(ll_t_quantile(student[i][0], student[i][1]), student[i][2], 1e-9);
    for (int i = 0; i < 5; i++)
        NEAR(ll_gamma_quantile(gamma[i][0], gamma[i][1]), gamma[i][2], 1e-9);
}

/* Student's t with 3 degrees of freedom (where SciPy's inverse has an error of 2e-9) has a closed form. */
static void student_of_3_is_known(void **state)
{
    (void)state;
    for (double tail = 0.4; tail > 1e-4; tail *= 0.7) {
        double t = ll_t_quantile(tail, 3) / sqrt(3);
        NEAR(0.5 - (t / (1 + t * t) + atan(t)) / 3.14159265358979324, tail, 1e-9);
    }
}

/* I_x(1, b) = 1 - (1 - x)^b and P(1, x) = 1 - exp(-x); inverses give back the argument. */
static void closed_forms_hold(void **state)
{
    (void)state;
    for (double b = 0.25; b < 300; b *= 1.7)
        for (double p = 0.001; p < 1; p += 0.0499) {
            NEAR(ll_beta_quantile(p, 1, b), -expm1(log1p(-p) / b), 1e-9);
            NEAR(ll_beta_cdf(ll_beta_quantile(p, b, 3), b, 3), p, 1e-9);
            NEAR(ll_gamma_cdf(ll_gamma_quantile(p, b), b), p, 1e-9);
            NEAR(ll_gamma_quantile(p, 1), -log1p(-p), 1e-9);
        }
    assert_true(ll_t_quantile(0.5, 3) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_are_scipys),
        cmocka_unit_test(quantiles_are_scipys),
        cmocka_unit_test(student_of_3_is_known),
        cmocka_unit_test(closed_forms_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

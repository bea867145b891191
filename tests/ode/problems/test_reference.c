/* The published problems to ten digits, against references of 18 digits from two methods in quadruple
 * precision. */
#include "ode/harness.h"
#include "support/near.h"

static double relative_error(const double *y, const double *reference, int dim, bool by_component)
{
    double most = 0, size = 0;
    for (int i = 0; i < dim; i++)
        size = larger(size, fabs(reference[i]));
    for (int i = 0; i < dim; i++)
        most = larger(most, fabs(y[i] - reference[i]) / (by_component ? fabs(reference[i]) : size));
    return most;
}

typedef struct published {
    const char *name;
    ll_ode ode;
    double y0[28], T, reference[28];
    double absolute; /* the absolute tolerance over the relative one: the smallest component's size */
    bool stiff;
    double wanted;
} published;

static void reaches(const published *p, const char *method, double tolerance)
{
    ll_ode_control control = {.t_end = p->T, .tolerance = tolerance, .absolute = tolerance * p->absolute};
    setting s = begin(method, &p->ode, p->y0, &control);
    while (step(&s) == LL_ODE_RUNNING)
        ;
    assert_int_equal(s.run->state, LL_ODE_FINISHED);
    assert_true(s.run->t == p->T);
    double error = relative_error(ll_ode_y(s.run), p->reference, p->ode.dim, p->stiff);
    if (!(error <= p->wanted))
        fail_msg("%s by %s: error %.3g, wanted %.3g", p->name, method, error, p->wanted);
    end(&s);
}

static published pleiades(void)
{
    published p = {"pleiades",
                   {.dim = 28, .acceleration = pleiades_a, .autonomous = true},
                   .T = 3,
                   .absolute = 1,
                   .wanted = 1e-10};
    memcpy(p.y0, pleiades_y0, sizeof pleiades_y0);
    memcpy(p.reference, pleiades_y3, sizeof pleiades_y3);
    return p;
}

static const double mu = 1000;

static void smooth_problems_by_dop853(void **state)
{
    (void)state;
    const published problems[] = {
        /* The answer moves by 1.4e-11 when the start is rounded to doubles, and rounding is amplified as
           much. */
        {"arenstorf",
         {.dim = 4, .acceleration = arenstorf_a, .velocity_dependent = true, .autonomous = true},
         {0.994, 0, 0, -2.00158510637908252240537862224},
         17.0652165601579625588917206249,
         {0.994, 0, 0, -2.00158510637908252240537862224},
         .absolute = 1,
         .wanted = 1e-9},
        {"kepler e=0.6",
         {.dim = 4, .acceleration = kepler_a, .autonomous = true},
         {0.4, 0, 0, 2},
         10,
         {-1.5350235919098136943, -0.28366840649978086186, 0.22715073207749833769, -0.47918775820321956529},
         .absolute = 1,
         .wanted = 1e-12},
        {"kepler e=0.9",
         {.dim = 4, .acceleration = kepler_a, .autonomous = true},
         {0.1, 0, 0, 4.358898943540673552},
         20,
         {-1.2952662509875743677, 0.40039389637923215273, -0.67753909247075658875, -0.12708381542786861877},
         .absolute = 1,
         .wanted = 1e-11},
        {"pendulum",
         {.dim = 2, .acceleration = pendulum_a, .autonomous = true},
         {2, 0},
         10,
         {0.51543622699413608293, 5.0719318194344523706},
         .absolute = 1,
         .wanted = 1e-12},
        {"double pendulum",
         {.dim = 4, .acceleration = double_pendulum_a, .velocity_dependent = true, .autonomous = true},
         {2, 2, 0, 0},
         5,
         {-1.50603586835282372, -4.31058980967322825, -1.98117844326947505, -5.79165359773206454},
         .absolute = 1,
         .wanted = 1e-11},
        pleiades(),
    };
    for (size_t i = 0; i < sizeof problems / sizeof problems[0]; i++)
        reaches(&problems[i], "dop853", 1e-14);
}

/* Every component to ten digits of its own, down to the 8e-14 of Robertson's second. */
static void stiff_problems_by_radau(void **state)
{
    (void)state;
    published problems[] = {
        {"van der pol",
         {.dim = 2, .f = van_der_pol_f, .jacobian = van_der_pol_j, .params = &mu, .autonomous = true},
         {2, 0},
         2000,
         {1.70616773217046501, -8.92809701024816548e-4},
         .absolute = 1e-3,
         .stiff = true,
         .wanted = 1e-10},
        {"robertson to 40",
         {.dim = 3, .f = robertson_f, .jacobian = robertson_j, .autonomous = true},
         {1, 0, 0},
         40,
         {0.715827068719405090, 9.18553476455776390e-6, 0.284163745745830352},
         .absolute = 1e-6,
         .stiff = true,
         .wanted = 1e-10},
        {"robertson to 1e5",
         {.dim = 3, .f = robertson_f, .jacobian = robertson_j, .autonomous = true},
         {1, 0, 0},
         1e5,
         {0.0178659211420994650, 7.27475146843631877E-8, 0.982134006110385851},
         .absolute = 1e-8,
         .stiff = true,
         .wanted = 1e-10},
        {"robertson to 1e11",
         {.dim = 3, .f = robertson_f, .jacobian = robertson_j, .autonomous = true},
         {1, 0, 0},
         1e11,
         {2.08334014970129423E-8, 8.33336077033478340E-14, 0.999999979166515169},
         .absolute = 1e-14,
         .stiff = true,
         .wanted = 1e-10},
        {"hires",
         {.dim = 8, .f = hires_f, .autonomous = true},
         {1, 0, 0, 0, 0, 0, 0, 0.0057},
         321.8122,
         .absolute = 1e-4,
         .stiff = true,
         .wanted = 1e-10},
    };
    memcpy(problems[4].reference, hires_y, sizeof hires_y);
    for (size_t i = 0; i < sizeof problems / sizeof problems[0]; i++) {
        reaches(&problems[i], "radau5", 1e-13);
        reaches(&problems[i], "radau9", 1e-13);
        reaches(&problems[i], "radau13", 1e-14);
    }
    problems[0].wanted = problems[1].wanted = 1e-9;
    reaches(&problems[0], "rodas5p", 1e-9);
    reaches(&problems[1], "rodas5p", 1e-9);
    reaches(&problems[0], "rodas4", 1e-10);
    reaches(&problems[1], "rodas4", 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smooth_problems_by_dop853),
        cmocka_unit_test(stiff_problems_by_radau),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

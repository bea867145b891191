/* Errors of the oscillator at T = 10 after 1024 steps: known to four digits for every method, so that a wrong
 * coefficient, time or order of operations shows. */
#include "ode/harness.h"
#include "support/near.h"

static const ll_ode oscillator = {.dim = 2, .acceleration = oscillator_a, .autonomous = true};
static const double start[2] = {1, 0};

static double error_after(const char *method, int n, double tolerance)
{
    double y[2];
    solve(method, &oscillator, start, 10, n, tolerance, y);
    return hypot(y[0] - cos(10), y[1] + sin(10));
}

static void errors_of_the_oscillator_are_as_known(void **state)
{
    (void)state;
    static const struct {
        const char *method;
        double error;
    } known[] = {
        {"explicit_euler", 5.004e-2},  {"semi_implicit_euler", 2.678e-3},
        {"implicit_euler", 4.765e-2},  {"stormer_verlet", 3.448e-5},
        {"velocity_verlet", 3.448e-5}, {"leapfrog_kdk", 3.448e-5},
        {"leapfrog_dkd", 4.532e-5},    {"rk2", 1.589e-4},
        {"ralston", 1.589e-4},         {"implicit_midpoint", 7.947e-5},
        {"trapezoid", 7.947e-5},       {"rk4", 7.579e-10},
        {"yoshida4", 6.175e-9},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double error = error_after(known[i].method, 1024, 0),
               unit = pow(10, floor(log10(known[i].error)) - 3);
        if (!is_near(error, known[i].error, unit))
            fail_msg("%s: error %.4g, known %.4g", known[i].method, error, known[i].error);
    }
}

/* dopri5 held at the step of 10 / 1024. */
static void dopri5_at_a_fixed_step(void **state)
{
    (void)state;
    double dt = 10.0 / 1024;
    ll_ode_control control = {.t_end = 10, .tolerance = 0.1, .first_step = dt, .largest_step = dt};
    setting s = begin("dopri5", &oscillator, start, &control);
    while (step(&s) == LL_ODE_RUNNING)
        ;
    const double *y = ll_ode_y(s.run);
    double error = hypot(y[0] - cos(10), y[1] + sin(10));
    assert_int_equal(s.run->counters.steps, 1024);
    assert_near(error, 2.506e-13, 1e-14); /* the rest is rounding */
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_of_the_oscillator_are_as_known),
        cmocka_unit_test(dopri5_at_a_fixed_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

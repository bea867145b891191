/* Where methods stop being stable, to a thousandth, and what they do to an oscillation before that. Each
 * limit is looked for from both sides, so that a method that is always stable, or never, fails. */
#include <math.h>

#include "ode/core/problem.h"
#include "ode/harness.h"
#include "support/near.h"

static const ll_ode oscillator = {.dim = 2, .acceleration = oscillator_a, .autonomous = true};
static const double start[2] = {1, 0.3};

/* Whether the state stays below 1e6 for that many steps of dt. */
static bool stays(const char *method, const ll_ode *ode, double dt, int steps)
{
    ll_ode_control control = {.t_end = 1e6, .dt = dt};
    setting s = begin(method, ode, start, &control);
    bool bounded = true;
    for (int i = 0; i < steps && bounded; i++)
        bounded = step(&s) == LL_ODE_RUNNING && fabs(ll_ode_y(s.run)[0]) < 1e6;
    end(&s);
    return bounded;
}

/* The largest stable step in (low, high), by bisection. */
static double limit(const char *method, const ll_ode *ode, double low, double high)
{
    enum { STEPS = 40000 };
    if (!stays(method, ode, low, STEPS))
        fail_msg("%s is not stable at %g", method, low);
    if (stays(method, ode, high, STEPS))
        fail_msg("%s is stable at %g", method, high);
    while (high - low > 1e-4) {
        double middle = (low + high) / 2;
        if (stays(method, ode, middle, STEPS))
            low = middle;
        else
            high = middle;
    }
    return (low + high) / 2;
}

static void limits_of_the_undamped_oscillator(void **state)
{
    (void)state;
    static const struct {
        const char *method;
        double limit;
    } known[] = {
        {"semi_implicit_euler", 2},
        {"stormer_verlet", 2},
        {"velocity_verlet", 2},
        {"leapfrog_kdk", 2},
        {"leapfrog_dkd", 2},
        {"rk3", 1.7321},
        {"rk4", 2.8284},
        {"yoshida4", 1.5734},
        {"ab3", 0.724},
        {"ab4", 0.430},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double found = limit(known[i].method, &oscillator, 0.9 * known[i].limit, 1.1 * known[i].limit);
        if (!is_near(found, known[i].limit, 1e-3))
            fail_msg("%s: limit %.5f, known %.5f", known[i].method, found, known[i].limit);
    }
}

/* Damping shrinks the limit of semi-implicit Euler to (2 / w) (sqrt(1 + zeta^2) - zeta). */
static void limits_of_the_damped_oscillator(void **state)
{
    (void)state;
    static const double zeta[5] = {0.01, 0.1, 0.5, 1, 5};
    static const struct {
        const char *method;
        double limit[5];
    } known[] = {
        {"semi_implicit_euler", {1.980, 1.810, 1.236, 0.828, 0.198}},
        {"velocity_verlet_predicted", {1.980, 1.844, 2, 1, 0.2}},
        {"leapfrog_kdk", {1.990, 1.913, 2, 2, 0.4}},
        {"rk4", {2.849, 2.951, 2.623, 2.785, 0.281}},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        for (int j = 0; j < 5; j++) {
            ll_ode damped = {.dim = 2,
                             .acceleration = damped_a,
                             .velocity_dependent = true,
                             .autonomous = true,
                             .params = &zeta[j]};
            double want = known[i].limit[j], found = limit(known[i].method, &damped, 0.9 * want, 1.1 * want);
            if (!is_near(found, want, 1e-3))
                fail_msg("%s at %g: limit %.5f, known %.5f", known[i].method, zeta[j], found, want);
        }
    for (int j = 0; j < 5; j++) {
        double formula = 2 * (sqrt(1 + zeta[j] * zeta[j]) - zeta[j]);
        assert_near(formula, known[0].limit[j], 5e-4);
    }
}

/* The factor of the amplitude in one step, by the root of the energy's after many. */
static double factor(const char *method, double dt, int steps)
{
    ll_ode_control control = {.t_end = 2 * steps * dt, .dt = dt};
    setting s = begin(method, &oscillator, start, &control);
    for (int i = 0; i < steps; i++)
        step(&s);
    const double *y = ll_ode_y(s.run);
    double size = hypot(y[0], y[1]) / hypot(start[0], start[1]);
    end(&s);
    return pow(size, 1. / steps);
}

static void amplitudes_per_step(void **state)
{
    (void)state;
    static const double steps[] = {0.1, 1, 10};
    for (int i = 0; i < 3; i++) {
        double z = steps[i];
        int n = i == 2 ? 20 : 100;
        assert_near(factor("explicit_euler", z, n) / sqrt(1 + z * z), 1, 1e-12);
        assert_near(factor("rk2", z, n) / sqrt(1 + z * z * z * z / 4), 1, 1e-12);
        assert_near(factor("implicit_euler", z, n) * sqrt(1 + z * z), 1, 1e-12);
        assert_near(factor("implicit_midpoint", z, n), 1, 1e-13);
        assert_near(factor("trapezoid", z, n), 1, 1e-13);
    }
    assert_near(factor("rk4", 1, 100), 0.9939, 1e-4);
    assert_true(factor("ab2", 0.1, 20000) > 1); /* always unstable, weakly */
}

/* Energy over 1e5 s of the oscillator at dt = 0.1: bounded, growing or dying. */
static void energy_of_a_million_steps(void **state)
{
    (void)state;
    enum { N = 1000000 };
    static const char *const bounded[] = {"velocity_verlet", "leapfrog_kdk", "semi_implicit_euler",
                                          "stormer_verlet", "yoshida4"};
    for (size_t i = 0; i < sizeof bounded / sizeof bounded[0]; i++) {
        double most = 0;
        ll_ode_control control = {.t_end = 1e5, .dt = 0.1};
        setting s = begin(bounded[i], &oscillator, (const double[]){1, 0}, &control);
        for (int n = 0; n < N; n++) {
            step(&s);
            const double *y = ll_ode_y(s.run);
            most = larger(most, fabs(y[0] * y[0] + y[1] * y[1] - 1));
        }
        end(&s);
        assert_true(most < 0.11);
    }
    double y[2];
    solve("rk4", &oscillator, (const double[]){1, 0}, 1e5, N, 0, y);
    double kept = y[0] * y[0] + y[1] * y[1];
    assert_near(log(kept) / (N * -1e-6 / 72), 1, 0.01); /* |R|^2 = 1 - z^6 / 72 + z^8 / 576 */
    solve("implicit_euler", &oscillator, (const double[]){1, 0}, 1e4, N / 10, 0, y);
    assert_true(y[0] * y[0] + y[1] * y[1] < 1e-300);
}

/* y' = -lambda (y - cos t) - sin t with lambda = 1e4 and y(0) = 1: A-stability by its effect. */
static void prothero_robinson(void **state)
{
    (void)state;
    const ll_ode_problem *problem = ll_ode_problem_find("prothero_robinson");
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_param_defaults(problem->params, params);
    ll_ode ode;
    problem->system(params, &ode);
    double y0[1], y[1];
    problem->start(params, y0);
    solve("implicit_euler", &ode, y0, 10, 40, 0, y);
    assert_near(y[0], cos(10), 2e-5);
    solve("implicit_midpoint", &ode, y0, 10, 40, 0, y);
    assert_near(y[0], cos(10), 2e-2);
    static const char *const overflow[] = {"explicit_euler", "rk4"};
    for (int i = 0; i < 2; i++) {
        ll_ode_control control = {.t_end = 10, .dt = 1e-3};
        setting s = begin(overflow[i], &ode, y0, &control);
        while (step(&s) == LL_ODE_RUNNING)
            ;
        assert_int_equal(s.run->state, LL_ODE_DIVERGED);
        assert_int_equal(s.run->reason, LL_ODE_NOT_FINITE);
        end(&s);
    }
    static const char *const adaptive[] = {"rodas4", "rodas5p", "radau5", "radau9", "radau13"};
    for (int i = 0; i < 5; i++) {
        ll_ode_counters c = solve(adaptive[i], &ode, y0, 10, 0, 1e-8, y);
        assert_near(y[0], cos(10), 5e-6);
        assert_true(c.steps < 5000);
    }
    assert_true(solve("dopri5", &ode, y0, 10, 0, 1e-8, y).steps > 20000); /* stiffness is cost */
}

/* The 16-mass chain holds just below its limit and is lost just above it. */
static void the_spring_chain_holds_to_its_limit(void **state)
{
    (void)state;
    const ll_ode_problem *problem = ll_ode_problem_find("spring_chain");
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_param_defaults(problem->params, params);
    ll_ode ode;
    problem->system(params, &ode);
    double y0[LL_ODE_DIM_MAX];
    problem->start(params, y0);
    static const struct {
        const char *method;
        double limit;
    } known[] = {{"velocity_verlet", 0.010042840989156744},
                 {"semi_implicit_euler", 0.010042840989156744},
                 {"rk4", 0.014202721931621896}};
    for (int i = 0; i < 3; i++)
        for (int side = -1; side <= 1; side += 2) {
            ll_ode_control control = {.t_end = 1e4, .dt = known[i].limit * (1 + 0.01 * side)};
            setting s = begin(known[i].method, &ode, y0, &control);
            double most = 0;
            for (int n = 0; n < 4000 && step(&s) == LL_ODE_RUNNING; n++)
                most = larger(most, fabs(ll_ode_y(s.run)[0]));
            assert_true(side < 0 ? most < 10 : s.run->state == LL_ODE_DIVERGED || most > 1e10);
            end(&s);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_of_the_undamped_oscillator),
        cmocka_unit_test(limits_of_the_damped_oscillator),
        cmocka_unit_test(amplitudes_per_step),
        cmocka_unit_test(energy_of_a_million_steps),
        cmocka_unit_test(prothero_robinson),
        cmocka_unit_test(the_spring_chain_holds_to_its_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

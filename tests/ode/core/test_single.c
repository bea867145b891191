/* Single precision, fixed point and the saving up of frame time: figures of the reference page, to their last
 * digit. */
#include <math.h>

#include "ode/core/accumulator.h"
#include "ode/core/problem.h"
#include "ode/core/single.h"
#include "ode/harness.h"
#include "support/near.h"

static double clock_after(int64_t ticks, float *lost)
{
    float t = 0;
    for (int64_t i = 0; i < ticks; i++)
        ll_single_clock_add(&t, lost, 1.f / 60);
    return (double)t;
}

static void float_clocks_drift_and_stop(void **state)
{
    (void)state;
    static const struct {
        double hours, off;
    } known[] = {{1. / 60, -0.0007}, {1, -2.79}, {6, 229}, {24, -2605}, {96, 45846}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double s = known[i].hours * 3600, off = clock_after(llround(s * 60), NULL) - s;
        double unit = fabs(known[i].off) < 1 ? 1e-4 : fabs(known[i].off) < 100 ? 0.01 : 1;
        assert_near(off, known[i].off, 0.5 * unit);
    }
    float lost = 0;
    double kept = clock_after(24 * 3600 * 60, &lost) - 24 * 3600;
    assert_true(kept > 0.007 && kept < 0.0085);
    float t = 524288;
    assert_true(t + 1.f / 60 == t && nextafterf(t, 0) + 1.f / 60 != nextafterf(t, 0));
}

static void far_from_the_origin_motion_dies(void **state)
{
    (void)state;
    static const struct {
        float place;
        double spacing;
    } known[] = {{1e4f, 0x1p-10}, {1e5f, 0x1p-7}, {1e6f, 0x1p-4}, {1e7f, 1}};
    for (int i = 0; i < 4; i++) {
        assert_true((double)ll_single_spacing(known[i].place) == known[i].spacing);
        /* A body at just less than this speed stays where it is. */
        float v = (float)(known[i].spacing / 2 * 60 * 0.999), x = known[i].place;
        assert_true(x + v / 60 == x && x + 1.01f * v / 60 != x);
    }
}

/* x'' = x - x^3. */
static void duffing_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)v;
    a[0] = q[0] - q[0] * q[0] * q[0];
}

static const ll_ode oscillator = {.dim = 2, .acceleration = oscillator_a, .autonomous = true};
static const ll_ode duffing = {.dim = 2, .acceleration = duffing_a, .autonomous = true};

/* N steps forward and N back with -dt; how far from the start. */
static double there_and_back(const char *method, const ll_ode *ode, const double *y0, int n)
{
    double there[2], T = n * 0.01;
    solve(method, ode, y0, T, n, 0, there);
    ll_ode_control back = {.t0 = T, .t_end = 0, .dt = 0.01};
    setting s = begin(method, ode, there, &back);
    while (step(&s) == LL_ODE_RUNNING)
        ;
    assert_int_equal(s.run->counters.steps, n);
    assert_true(s.run->t == 0);
    double off = hypot(ll_ode_y(s.run)[0] - y0[0], ll_ode_y(s.run)[1] - y0[1]);
    end(&s);
    return off;
}

static void a_million_steps_and_back(void **state)
{
    (void)state;
    enum { N = 1000000 };
    static const double circle[2] = {1, 0}, well[2] = {1.25, 0.5};
    /* To the last bit of the lattice. */
    assert_true(there_and_back("verlet_lattice", &oscillator, circle, N) == 0);
    assert_true(there_and_back("verlet_lattice", &duffing, well, N) == 0);
    /* In floating point to rounding, which grows; never to the bit. */
    double stormer = there_and_back("stormer_verlet", &duffing, well, N);
    assert_true(stormer > 0 && stormer < 1e-7);
    double kdk = there_and_back("leapfrog_kdk", &duffing, well, N);
    assert_true(kdk > 0 && kdk < 1e-8);
    assert_true(there_and_back("leapfrog_kdk", &oscillator, circle, N) < 1e-12);
    /* Methods that are not their own inverse. */
    /* rk4 loses z^6 / 144 of the amplitude a step, both ways. */
    assert_near(there_and_back("rk4", &oscillator, circle, N) / 1.389e-8, 1, 0.01);
    double rk4 = there_and_back("rk4", &duffing, well, N);
    assert_true(rk4 > 3e-4 && rk4 < 3e-3);
    assert_true(there_and_back("semi_implicit_euler", &duffing, well, N) > 0.05);
}

/* The lattice is a method like others: of second order until its spacing shows. */
static void the_lattice_follows_the_solution(void **state)
{
    (void)state;
    double y[2], start[2] = {1, 0};
    solve("verlet_lattice", &oscillator, start, 10, 1024, 0, y);
    assert_near(hypot(y[0] - cos(10), y[1] + sin(10)), 3.448e-5, 1e-7);
    assert_true(y[0] * 0x1p32 == floor(y[0] * 0x1p32));
    static const double far[2] = {2e6, 0};
    ll_ode_control control = {.t_end = 1, .dt = 0.01};
    setting s = begin("verlet_lattice", &oscillator, far, &control);
    assert_int_equal(step(&s), LL_ODE_DIVERGED);
    end(&s);
}

static void frame_time_is_spent_in_whole_steps(void **state)
{
    (void)state;
    ll_accumulator a = {.step = 16666667, .most = 5};
    int64_t steps = 0;
    ll_time total = 0;
    for (int frame = 0; frame < 1000; frame++) {
        ll_time t = frame % 2 ? 16666667 : 33333333;
        steps += ll_accumulator_add(&a, t);
        total += t;
        assert_true(a.rest >= 0 && a.rest < a.step);
    }
    assert_true(steps * a.step + a.rest == total && a.dropped == 0);
    assert_int_equal(ll_accumulator_add(&a, 10 * LL_SECOND), 5);
    assert_true(a.dropped > 500 && a.rest < a.step);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(float_clocks_drift_and_stop),
        cmocka_unit_test(far_from_the_origin_motion_dies),
        cmocka_unit_test(a_million_steps_and_back),
        cmocka_unit_test(the_lattice_follows_the_solution),
        cmocka_unit_test(frame_time_is_spent_in_whole_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

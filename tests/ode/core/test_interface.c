/* The interface by itself: a system's two forms give the same f. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "ode/core/method.h"
#include "ode/core/ode.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"

static void oscillator_f(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = y[1];
    dy[1] = -y[0];
}

static void oscillator_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)v;
    a[0] = -q[0];
}

static void both_forms_of_a_system_have_the_same_f(void **state)
{
    (void)state;
    ll_ode first_order = {.dim = 2, .f = oscillator_f};
    ll_ode mechanical = {.dim = 2, .acceleration = oscillator_a};
    assert_false(ll_ode_mechanical(&first_order));
    assert_true(ll_ode_mechanical(&mechanical));
    double y[2] = {0.25, -3}, a[2], b[2];
    ll_ode_eval(&first_order, 0, y, a);
    ll_ode_eval(&mechanical, 0, y, b);
    assert_memory_equal(a, b, sizeof a);
    assert_true(a[0] == -3 && a[1] == -0.25);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_forms_of_a_system_have_the_same_f),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

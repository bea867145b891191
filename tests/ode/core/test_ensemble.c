/* Every member of an ensemble has the bits of a run of it alone. */
#include "ode/core/ensemble.h"
#include "ode/harness.h"

enum { MEMBERS = 1024, STEPS = 300 };

static void stiff_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)t, (void)v;
    a[0] = -*(const double *)params * q[0];
}

static double k[MEMBERS], x[MEMBERS], v[MEMBERS], a[MEMBERS];

static void compare(const char *method, void (*advance)(const ll_ensemble *, double, int64_t))
{
    const double dt = 0.01;
    ll_ensemble e = {MEMBERS, k, x, v, a};
    double start[MEMBERS][2];
    for (int i = 0; i < MEMBERS; i++) {
        k[i] = 0.5 + i * 0.37;
        start[i][0] = x[i] = 1 - i * 1.7e-3;
        start[i][1] = v[i] = -2 + i * 0.01;
    }
    ll_ensemble_accelerate(&e);
    advance(&e, dt, STEPS - 1);
    advance(&e, dt, 1);
    for (int i = 0; i < MEMBERS; i++) {
        ll_ode alone = {.dim = 2, .acceleration = stiff_a, .params = &k[i], .autonomous = true};
        double y[2], both[2] = {x[i], v[i]};
        ll_ode_control control = {.t_end = STEPS * dt, .dt = dt};
        setting s = begin(method, &alone, start[i], &control);
        for (int n = 0; n < STEPS; n++)
            step(&s);
        memcpy(y, ll_ode_y(s.run), sizeof y);
        assert_memory_equal(y, both, sizeof y);
        end(&s);
    }
}

static void semi_implicit_euler(void **state)
{
    (void)state;
    compare("semi_implicit_euler", ll_ensemble_semi_implicit_euler);
}

static void velocity_verlet(void **state)
{
    (void)state;
    compare("velocity_verlet", ll_ensemble_velocity_verlet);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(semi_implicit_euler),
        cmocka_unit_test(velocity_verlet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The front against the definition, levels, and the cheapest within a level. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "experiment/statistics/front.h"
#include "support/near.h"

/* By the definition, which takes the square of the number of points. */
static bool on_front(const ll_front_point *points, int count, int i)
{
    const ll_front_point *p = &points[i];
    if (!isfinite(p->cost) || !isfinite(p->error))
        return false;
    for (int k = 0; k < count; k++) {
        const ll_front_point *q = &points[k];
        if (isfinite(q->cost) && isfinite(q->error) && q->cost <= p->cost && q->error <= p->error &&
            (q->cost < p->cost || q->error < p->error))
            return false;
    }
    return true;
}

/* Few different values make equal costs, equal errors and equal points; some are unknown. */
static void the_front_is_that_of_the_definition(void **state)
{
    (void)state;
    enum { COUNT = 60, CASES = 400 };
    ll_front_point points[COUNT];
    uint64_t counter = 0;
    for (int n = 0; n < CASES; n++) {
        int count = 1 + n % COUNT, values = 2 + n % 37;
        for (int i = 0; i < count; i++) {
            double cost = floor(values * ll_rng_unit(7, 0, counter)),
                   error = floor(values * ll_rng_unit(7, 1, counter));
            double unknown = ll_rng_unit(7, 2, counter++);
            points[i] = (ll_front_point){.cost = unknown < 0.05 ? NAN : cost,
                                         .error = unknown > 0.95 ? INFINITY : error,
                                         .front = true};
        }
        assert_false(ll_front_mark(points, count).code);
        for (int i = 0; i < count; i++)
            assert_int_equal(points[i].front, on_front(points, count, i));
    }
}

static void levels_are_equal_steps_of_the_logarithm(void **state)
{
    (void)state;
    double levels[LL_FRONT_LEVELS];
    const double bounds[] = {1e-8, 0, NAN, 1e-3, INFINITY, 1};
    assert_int_equal(ll_front_levels(bounds, 6, levels), 3);
    assert_near(levels[0] / 0.01, 1, 1e-9);
    assert_near(levels[1] / 1e-4, 1, 1e-9);
    assert_near(levels[2] / 1e-6, 1, 1e-9);
    const double close[] = {0.0301, 0.0302};
    assert_int_equal(ll_front_levels(close, 2, levels), 1);
    assert_near(levels[0], 0.031, 1e-12); /* rounded up: within it is what the level came from */
    const double two[] = {3, 48};         /* 48 / 2, / 4, / 8 */
    assert_int_equal(ll_front_levels(two, 2, levels), 3);
    assert_true(levels[0] == 24 && levels[1] == 12 && levels[2] == 6);
    assert_int_equal(ll_front_levels(bounds + 1, 2, levels), 0);
    assert_int_equal(ll_front_levels(NULL, 0, levels), 0);
}

static void the_cheapest_has_its_bound_within_the_level(void **state)
{
    (void)state;
    const ll_front_point points[] = {
        {.cost = 1, .error = 0.9, .error_high = 1.1, .method = 0},
        {.cost = 2, .error = 0.2, .error_high = 1.0, .method = 1}, /* the bound counts, not the error */
        {.cost = 2, .error = 0.1, .error_high = 0.9, .method = 0},
        {.cost = 0.5, .error = 0.1, .error_high = NAN, .method = 2},
        {.cost = NAN, .error = 0.1, .error_high = 0.1, .method = 2},
        {.cost = 9, .error = 0.01, .error_high = 0.02, .method = 2},
    };
    assert_int_equal(ll_front_cheapest(points, 6, 2), 0);
    assert_int_equal(ll_front_cheapest(points, 6, 1), 2);
    assert_int_equal(ll_front_cheapest(points, 6, 0.5), 5);
    assert_int_equal(ll_front_cheapest(points, 6, 0.01), -1);
    assert_int_equal(ll_front_cheapest_of(points, 6, 1, 1), 1);
    assert_int_equal(ll_front_cheapest_of(points, 6, 0.9, 1), -1);
    const ll_front_point a = {.cost_low = 1, .cost_high = 2}, b = {.cost_low = 2, .cost_high = 3},
                         c = {.cost_low = 2.5, .cost_high = NAN};
    assert_false(ll_front_certainly_cheaper(&a, &b)); /* they touch */
    assert_true(ll_front_certainly_cheaper(&a, &c));
    assert_false(ll_front_certainly_cheaper(&c, &a));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_front_is_that_of_the_definition),
        cmocka_unit_test(levels_are_equal_steps_of_the_logarithm),
        cmocka_unit_test(the_cheapest_has_its_bound_within_the_level),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

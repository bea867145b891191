/* Intervals cover the mean as often as stated, with distributions of known mean. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "experiment/statistics/coverage.h"

/* ---- draws ---- */

static double uniform(draws *d)
{
    return unit(d);
}

static double left(draws *d)
{
    return 5 - exponential(d);
}

static double gamma_2(draws *d)
{
    return exponential(d) + exponential(d);
}

static double student_5(draws *d)
{
    double z = normal(d) - 10, squares = 0;
    for (int i = 0; i < 5; i++) {
        double v = normal(d) - 10;
        squares += v * v;
    }
    return z / sqrt(squares / 5);
}

static double lognormal_half(draws *d)
{
    return exp((normal(d) - 10) / 2);
}

static double lognormal_1(draws *d)
{
    return exp(normal(d) - 10);
}

static double two_modes(draws *d)
{
    double z = (normal(d) - 10) / 5;
    return z + (unit(d) < 0.5);
}

/* Two different groups: `share` per cent are 5 standard deviations above the others. */
static double groups(draws *d, double share)
{
    double z = (normal(d) - 10) / 5;
    return z + (unit(d) < share);
}

static double groups_5(draws *d)
{
    return groups(d, 0.05);
}

static double groups_10(draws *d)
{
    return groups(d, 0.1);
}

static double groups_20(draws *d)
{
    return groups(d, 0.2);
}

static double groups_30(draws *d)
{
    return groups(d, 0.3);
}

static double poisson_of(draws *d, double mean)
{
    double product = unit(d), least = exp(-mean);
    int k = 0;
    for (; product > least; k++)
        product *= unit(d);
    return k;
}

static double event_1(draws *d)
{
    return unit(d) < 0.01;
}

static double event_5(draws *d)
{
    return unit(d) < 0.05;
}

static double event_20(draws *d)
{
    return unit(d) < 0.2;
}

static double poisson_2(draws *d)
{
    return poisson_of(d, 0.02);
}

static double poisson_30(draws *d)
{
    return poisson_of(d, 0.3);
}

static double poisson_300(draws *d)
{
    return poisson_of(d, 3);
}

static double poisson_2000(draws *d)
{
    return poisson_of(d, 20);
}

/* Of 100 runs 30, or 10, have an amount. */
static double rare_30(draws *d)
{
    double x = exponential(d);
    return unit(d) < 0.3 ? x : 0;
}

static double rare_10(draws *d)
{
    double x = exponential(d);
    return unit(d) < 0.1 ? x : 0;
}

/* ---- coverage ---- */

static coverage count(double (*next)(void *context), void *context, double mean, ll_metric_scale scale, int n,
                      double error)
{
    return count_of(next, context, mean, &(ll_interval_request){.scale = scale, .n = n, .error = error});
}

typedef struct known {
    const char *name;
    double (*draw)(draws *d);
    double mean;
    ll_metric_scale scale;
    double least, most; /* bounds of the coverage, in %, at every size */
    int first;          /* first of the sizes with intervals, and of those that are checked */
} known;

typedef struct source {
    const known *of;
    draws draws;
} source;

static double next_known(void *context)
{
    source *s = context;
    return s->of->draw(&s->draws);
}

static void check(const known *of, double error)
{
    char line[300];
    int used = snprintf(line, sizeof line, "%-16s", of->name);
    bool good = true;
    for (int k = 0; k < SIZES; k++) {
        source s = {of, {1234 + (uint64_t)k, 0}};
        coverage c = count(next_known, &s, of->mean, of->scale, sizes[k], error);
        if (sizes[k] < of->first)
            continue;
        used += snprintf(line + used, sizeof line - (size_t)used, " %4d: %5.1f", sizes[k], 100 * c.covered);
        double room = experiments < EXPERIMENTS ? 200 * sqrt(0.05 * 0.95 / experiments) : 0;
        good &= 100 * c.covered >= of->least - room && 100 * c.covered <= of->most + room;
    }
    print_message("%s\n", line);
    if (!good)
        fail_msg("%s is to be covered by %g to %g %%", of->name, of->least, of->most);
}

static const known amounts[] = {
    {"normal", normal, 10, LL_SCALE_AMOUNT, 93, 97, 20},
    {"uniform", uniform, 0.5, LL_SCALE_AMOUNT, 93, 97, 20},
    {"t, 5 df", student_5, 0, LL_SCALE_AMOUNT, 93, 97, 20},
    {"gamma 2", gamma_2, 2, LL_SCALE_AMOUNT, 93, 97, 20},
    {"exponential", exponential, 1, LL_SCALE_AMOUNT, 93, 97, 20},
    {"5 - exponential", left, 4, LL_SCALE_AMOUNT, 93, 97, 20},
    {"lognormal 0.5", lognormal_half, 1.1331484530668263, LL_SCALE_AMOUNT, 93, 97, 20},
    {"lognormal 1", lognormal_1, 1.6487212707001282, LL_SCALE_AMOUNT, 93, 97, 20},
    {"two modes", two_modes, 0.5, LL_SCALE_AMOUNT, 93, 97, 20},
    {"Poisson 20", poisson_2000, 20, LL_SCALE_COUNT, 93, 97, 20},
};

static void amounts_are_covered(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++)
        check(&amounts[i], 0.05);
}

/* With fewer than 20 values skewed distributions cannot be distinguished from flat ones: the interval is a
 * bound, which covers the former at least 93 % of the time, and the latter more often. */
static void few_amounts_are_covered_at_least(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++) {
        known few = amounts[i];
        few.first = 10;
        few.most = 100;
        check(&few, 0.05);
    }
}

/* The same, declared to have a long tail: also what has none, or one to the left, is covered. */
static void tailed_amounts_are_covered(void **state)
{
    (void)state;
    experiments = is_full ? EXPERIMENTS : QUICK;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++) {
        known tailed = amounts[i];
        if (tailed.scale == LL_SCALE_COUNT)
            continue;
        tailed.scale = LL_SCALE_TAILED;
        tailed.first = 10;
        tailed.most = 100;
        check(&tailed, 0.05);
    }
    experiments = EXPERIMENTS / LL_TEST_STRIDE;
}

/* With fewer there is none. */
static void fewer_than_10_amounts_have_no_interval(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++) {
        source s = {&amounts[i], {8, 0}};
        double told = count(next_known, &s, amounts[i].mean, amounts[i].scale, 9, 0.05).told;
        assert_true(told < 0.001); /* few Poisson counts by chance; these are treated as rare events */
    }
}

/* If a few runs dominate the mean, or two groups differ in size, coverage differs from the level, as
 * ll_interval_covers says. */
static void different_groups_are_covered_as_stated(void **state)
{
    (void)state;
    static const known all[] = {
        {"groups of 5 %", groups_5, 0.05, LL_SCALE_AMOUNT, 89, 98.5, 10},
        {"groups of 10 %", groups_10, 0.1, LL_SCALE_AMOUNT, 89, 98.5, 10},
        {"groups of 20 %", groups_20, 0.2, LL_SCALE_AMOUNT, 89, 98.5, 10},
        {"groups of 30 %", groups_30, 0.3, LL_SCALE_AMOUNT, 89, 100, 10},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        known many = all[i];
        check(&all[i], 0.05);
        many.least = 93;
        many.most = 97;
        many.first = 100;
        check(&many, 0.05);
    }
    double x[100] = {0};
    ll_interval_request order = {.values = x, .error = 0.05};
    static const struct {
        int n;
        const char *words;
    } told[] = {{19, "a bound: at least 93 %, down to 90 %"},
                {20, "93 to 97 %, down to 89 %"},
                {99, "up to 98 %"},
                {100, "93 to 97 %"}};
    for (size_t i = 0; i < sizeof told / sizeof told[0]; i++) {
        order.n = told[i].n;
        assert_non_null(strstr(ll_interval_covers(&order, LL_INTERVAL_BOOTSTRAP_T), told[i].words));
    }
    assert_string_equal(ll_interval_covers(&order, LL_INTERVAL_SKEWNESS_T), "93 to 97 %");
    assert_string_equal(ll_interval_covers(&order, LL_INTERVAL_NONE), "");
}

/* Exact bounds of whole numbers have at least the level; 0.7 % allows for 2000 experiments. */
static void rare_events_are_covered_at_least(void **state)
{
    (void)state;
    static const known all[] = {
        {"flag 1 %", event_1, 0.01, LL_SCALE_FLAG, 94.3, 100, 5},
        {"flag 5 %", event_5, 0.05, LL_SCALE_FLAG, 94.3, 100, 5},
        {"flag 20 %", event_20, 0.2, LL_SCALE_FLAG, 94.3, 100, 5},
        {"0 or 1, 1 %", event_1, 0.01, LL_SCALE_COUNT, 94.3, 100, 5},
        {"0 or 1, 20 %", event_20, 0.2, LL_SCALE_COUNT, 94.3, 100, 5},
        {"Poisson 0.02", poisson_2, 0.02, LL_SCALE_COUNT, 94.3, 100, 5},
        {"Poisson 0.3", poisson_30, 0.3, LL_SCALE_COUNT, 94.3, 100, 5},
        {"Poisson 3", poisson_300, 3, LL_SCALE_COUNT, 94, 100, 5},
        {"0 of 10, amount", rare_30, 0.3, LL_SCALE_AMOUNT, 93, 100, 10},
        {"0 of 100, amount", rare_10, 0.1, LL_SCALE_AMOUNT, 93, 100, 10},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        check(&all[i], 0.05);
}

/* For smaller errors, as repeated checks use them. */
static void other_levels_are_covered(void **state)
{
    (void)state;
    check(&(known){"normal, 99 %", normal, 10, LL_SCALE_AMOUNT, 98.2, 99.7, 20}, 0.01);
    check(&(known){"exponential, 99 %", exponential, 1, LL_SCALE_AMOUNT, 97, 99.7, 20}, 0.01);
    check(&(known){"normal, 90 %", normal, 10, LL_SCALE_AMOUNT, 88, 93, 20}, 0.1);
}

int main(int count, char **arguments)
{
    read_arguments(count, arguments);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(amounts_are_covered),
        cmocka_unit_test(few_amounts_are_covered_at_least),
        cmocka_unit_test(fewer_than_10_amounts_have_no_interval),
        cmocka_unit_test(different_groups_are_covered_as_stated),
        cmocka_unit_test(rare_events_are_covered_at_least),
        cmocka_unit_test(other_levels_are_covered),
        cmocka_unit_test(tailed_amounts_are_covered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

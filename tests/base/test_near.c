/* The comparisons of the tests themselves (support/near.h): each fails for NaN, infinity and wrong values,
 * and passes right ones. A failure ends a test, so each runs as a test of its own in a process of its own. */
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/near.h"

typedef struct numbers {
    double value, a, b;
} numbers;

static void near(void **state)
{
    const numbers *n = *state;
    assert_near(n->value, n->a, n->b);
}

static void near_or_fail(void **state)
{
    const numbers *n = *state;
    if (!is_near(n->value, n->a, n->b))
        fail_msg("is_near");
}

static void between(void **state)
{
    const numbers *n = *state;
    assert_between("value", n->value, n->a - n->b, n->a + n->b);
}

static void at_most(void **state)
{
    const numbers *n = *state;
    assert_at_most("value", n->value, n->a + n->b);
}

static void at_least(void **state)
{
    const numbers *n = *state;
    assert_at_least("value", -n->value, -n->a - n->b);
}

/* The worst of three errors, of which one is wrong: wherever it stands, it is not lost. */
static void worst_of(void **state)
{
    const numbers *n = *state;
    double of[] = {0, fabs(n->value - n->a), 0};
    for (int first = 0; first < 3; first++) {
        double worst = 0, least = 0;
        for (int i = 0; i < 3; i++) {
            worst = larger(worst, of[(first + i) % 3]);
            least = smaller(least, -of[(first + i) % 3]);
        }
        assert_at_most("largest", worst, n->b);
        assert_at_least("smallest", least, -n->b);
    }
}

static const struct {
    const char *name;
    CMUnitTestFunction run;
} comparisons[] = {{"assert_near", near},       {"is_near", near_or_fail},     {"assert_between", between},
                   {"assert_at_most", at_most}, {"assert_at_least", at_least}, {"larger", worst_of}};
enum { COMPARISONS = sizeof comparisons / sizeof comparisons[0] };

/* Whether the comparison lets the numbers pass. */
static bool passes(int comparison, numbers n)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        int null = open("/dev/null", O_WRONLY);
        dup2(null, STDOUT_FILENO);
        dup2(null, STDERR_FILENO);
        const struct CMUnitTest one[] = {
            {comparisons[comparison].name, comparisons[comparison].run, NULL, NULL, &n}};
        _exit(cmocka_run_group_tests(one, NULL, NULL) != 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status) == 0;
}

static void no_comparison_passes_what_is_wrong(void **state)
{
    (void)state;
    const double inf = INFINITY;
    const numbers wrong[] = {{NAN, 1, 0.5}, {1, NAN, 0.5}, {1, 1, NAN},   {NAN, NAN, 0.5}, {NAN, NAN, NAN},
                             {NAN, 1, inf}, {inf, 1, 0.5}, {1.6, 1, 0.5}, {1, 1, -0.1}};
    for (int c = 0; c < COMPARISONS; c++)
        for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
            if (passes(c, wrong[i]))
                fail_msg("%s passes %g for %g, %g", comparisons[c].name, wrong[i].value, wrong[i].a,
                         wrong[i].b);
    /* What a difference of infinities and an endless tolerance say nothing about. */
    assert_false(passes(0, (numbers){inf, inf, 1}));
    for (int c = 0; c < COMPARISONS; c++)
        assert_false(passes(c, (numbers){7, 1, inf}));
    assert_false(passes(0, (numbers){0.4, 1, 0.5}));
    assert_false(passes(2, (numbers){0.4, 1, 0.5}));
    assert_false(passes(4, (numbers){-inf, 1, 0.5})); /* inf is at least -1.5 */
}

static void right_values_pass(void **state)
{
    (void)state;
    const numbers right[] = {{1, 1, 0}, {1.25, 1, 0.25}, {0.75, 1, 0.25}, {-3, -3.0625, 0.125}};
    for (int c = 0; c < COMPARISONS; c++)
        for (size_t i = 0; i < sizeof right / sizeof right[0]; i++)
            if (!passes(c, right[i]))
                fail_msg("%s fails %g for %g, %g", comparisons[c].name, right[i].value, right[i].a,
                         right[i].b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_comparison_passes_what_is_wrong),
        cmocka_unit_test(right_values_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The lists of names follow the tables. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "ode/catalogue/catalogue.h"
#include "ode/core/method.h"
#include "ode/core/problem.h"

static void lists_follow_the_tables(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_ode_methods[n]; n++)
        assert_string_equal(ll_ode_method_names[n], ll_ode_methods[n]->name);
    assert_null(ll_ode_method_names[n]);
    for (n = 0; ll_ode_problems[n]; n++) {
        assert_string_equal(ll_ode_problem_names[n], ll_ode_problems[n]->name);
        assert_ptr_equal(ll_ode_problem_tables[n], ll_ode_problems[n]->params);
    }
    assert_null(ll_ode_problem_names[n]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists_follow_the_tables)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

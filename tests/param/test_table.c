#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

static void the_sample_is_sound(void **state)
{
    (void)state;
    assert_status(ll_param_table_valid(&sample_table), LL_OK, "", "");
}

/* What each of these authors got wrong, and the sentence about it. */
static void faults_are_named(void **state)
{
    (void)state;
    static const char *const none[] = {NULL};
    static const struct {
        ll_param row;
        const char *text;
    } cases[] = {
        {{.name = "Lag", .type = LL_PARAM_BOOL, .help = "h"}, "has no name of a-z, 0-9 and _"},
        {{.name = "a.b", .type = LL_PARAM_BOOL, .help = "h"}, "has no name of a-z, 0-9 and _"},
        {{.name = "x", .type = LL_PARAM_BOOL}, "has no help"},
        {{.name = "x", .type = LL_PARAM_REAL, .min = 1, .help = "h"}, "has no range"},
        {{.name = "x", .type = LL_PARAM_REAL, .min = 1, .max = 2, .help = "h"}, "has a default out of range"},
        {{.name = "x", .type = LL_PARAM_INT, .max = 2, .default_value = 0.5, .help = "h"},
         "has a default that is not whole"},
        {{.name = "x", .type = LL_PARAM_CHOICE, .choices = none, .help = "h"}, "has no choices"},
        {{.name = "x", .type = LL_PARAM_CHOICE, .choices = sample_orders, .default_value = 2, .help = "h"},
         "has no such default"},
        {{.name = "x", .type = LL_PARAM_TEXT, .help = "h"}, "has no length"},
        {{.name = "x", .type = LL_PARAM_TEXT, .max = 3, .text = "four", .help = "h"},
         "has a default of the wrong length"},
        {{.name = "x", .type = LL_PARAM_OBJECT, .help = "h"}, "lacks a table, or the choice before it"},
        {{.name = "x", .type = LL_PARAM_VARIANT, .variants = sample_variants, .help = "h"},
         "lacks a table, or the choice before it"},
        {{.name = "x", .type = LL_PARAM_BOOL, .offset = 64, .help = "h"}, "lies beyond its struct"},
        {{.name = "x", .type = LL_PARAM_REAL, .offset = 57, .max = 1, .help = "h"}, "lies beyond its struct"},
        {{.name = "x", .type = LL_PARAM_ARRAY, .max = 5, .child = &wire_table, .help = "h"},
         "lies beyond its struct"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ll_param_table table = {.name = "t", .rows = &cases[i].row, .count = 1, .size = 64};
        char want[200];
        snprintf(want, sizeof want, "row 0 (%s) of t %s", cases[i].row.name, cases[i].text);
        assert_string_equal(ll_param_table_valid(&table).text, want);
    }
    const ll_param twins[] = {cases[2].row, cases[2].row};
    ll_param named[2];
    memcpy(named, twins, sizeof named);
    named[0].help = named[1].help = "h";
    const ll_param_table table = {.name = "t", .rows = named, .count = 2, .size = 64};
    assert_string_equal(ll_param_table_valid(&table).text, "row 1 (x) of t has the name of another row");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sample_is_sound),
        cmocka_unit_test(faults_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

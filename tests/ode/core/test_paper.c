/* The listing against the paper's own lines. Figure 2 has two lines that the scan has damaged; Figure 3 is
 * whole. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ode/core/paper.h"

/* Everything for `dt`, as one text; returns how many lines. */
static int output(float dt, char *text, size_t size)
{
    ll_ode_listing l = {.dt = dt, .acceleration = 10.0f};
    int lines = 0;
    text[0] = '\0';
    for (char line[128]; ll_ode_listing_next(&l, 5.0, line, sizeof line); lines++)
        strncat(text, line, size - strlen(text) - 1);
    return lines;
}

static void figure_2_is_printed(void **state)
{
    (void)state;
    static const char want[] = "t = 0.000000, velocity = 0.000000, displacement = 0.000000\n"
                               "t = 0.500000, velocity = 5.000000, displacement = 2.500000\n"
                               "t = 1.000000, velocity = 10.000000, displacement = 7.500000\n"
                               "t = 1.500000, velocity = 15.000000, displacement = 15.000000\n"
                               "t = 2.000000, velocity = 20.000000, displacement = 25.000000\n"
                               "t = 2.500000, velocity = 25.000000, displacement = 37.500000\n"
                               "t = 3.000000, velocity = 30.000000, displacement = 52.500000\n"
                               "t = 3.500000, velocity = 35.000000, displacement = 70.000000\n"
                               "t = 4.000000, velocity = 40.000000, displacement = 90.000000\n"
                               "t = 4.500000, velocity = 45.000000, displacement = 112.500000\n"
                               "t = 5.000000, velocity = 50.000000, displacement = 137.500000\n";
    char text[16384];
    assert_int_equal(output(0.5f, text, sizeof text), 11);
    assert_string_equal(text, want);
}

/* The tails of single precision without fused multiply-add. */
static void figure_3_is_printed_float_for_float(void **state)
{
    (void)state;
    static const char *const tails[] = {"displacement = 25.200001\n", "displacement = 32.400002\n",
                                        "displacement = 59.400002\n", "displacement = 70.200005\n",
                                        "displacement = 81.900009\n", "displacement = 94.500008\n",
                                        "displacement = 108.000008\n"};
    static const char last[] = "t = 4.800000, velocity = 48.000000, displacement = 122.400009\n";
    char text[16384];
    assert_int_equal(output(0.3f, text, sizeof text), 17);
    for (size_t i = 0; i < sizeof tails / sizeof tails[0]; i++)
        assert_non_null(strstr(text, tails[i]));
    assert_string_equal(text + strlen(text) - strlen(last), last);
}

static void other_steps_have_their_lines(void **state)
{
    (void)state;
    static const struct {
        float dt;
        int lines;
    } known[] = {{0.5f, 11}, {0.3f, 17}, {0.1f, 51}, {0.033f, 152}};
    char text[16384];
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        assert_int_equal(output(known[i].dt, text, sizeof text), known[i].lines);
    output(0.1f, text, sizeof text);
    assert_non_null(strstr(text, "t = 2.999999, velocity = 30.000000, displacement = 46.500000\n"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figure_2_is_printed),
        cmocka_unit_test(figure_3_is_printed_float_for_float),
        cmocka_unit_test(other_steps_have_their_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

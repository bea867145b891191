#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/rng.h"
#include "param/sample.h"

static char *written(const sample *s)
{
    cJSON *json = ll_param_write(&sample_table, s);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    return text;
}

static void the_text_is_in_the_tables_order(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    s.count = 1;
    s.members[0].lag_ms = 10.5;
    char *text = written(&s);
    assert_string_equal(
        text, "{\"seed\":7,\"shape\":\"circle\",\"params\":{\"radius_m\":1},\"ratio\":0,\"level\":0.3,"
              "\"members\":[{\"name\":\"anna\",\"ready\":true,\"lag_ms\":10.5,\"tries\":0,"
              "\"up\":{\"jitter_ms\":0,\"order\":\"fifo\"},\"down\":{\"jitter_ms\":0,\"order\":\"fifo\"}}],"
              "\"loud\":false}");
    free(text);
}

static void a_variant_without_params_is_an_empty_object(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_int_equal(ll_param_set(&sample_table, &s, "shape", "point", false).code, LL_OK);
    char *text = written(&s);
    assert_non_null(strstr(text, "\"shape\":\"point\",\"params\":{},"));
    sample again;
    ll_param_defaults(&sample_table, &again);
    assert_string_equal(sample_parse(text, &again).text, "");
    assert_memory_equal(&again, &s, sizeof s);
    free(text);
}

/* The fewest of 15 to 17 digits that read back, as printf and strtod find them: of numbers of any size, of
 * few digits, and beside powers of two and of ten. */
static void numbers_have_the_fewest_digits(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 200000; i++) {
        double unit = ll_rng_unit(1, 2, i), value = 0;
        int power = (int)(i / 5 % 21) - 5;
        char text[32], wanted[32];
        switch (i % 5) {
        case 0:
            value = unit * pow(10, power + 1);
            break;
        case 1:
            value = -floor(unit * 1e6) / pow(10, i / 5 % 9);
            break;
        case 2:
            value = nextafter(pow(10, power), i / 5 % 2 ? 0 : 1e300);
            break;
        case 3:
            value = nextafter(ldexp(1, (int)(i / 5 % 60) - 14), i / 5 % 2 ? 0 : 1e300);
            break;
        default:
            value = ldexp(1, (int)(i / 5 % 2000) - 1000) * (1 + unit);
        }
        ll_number_text(value, text);
        for (int digits = 15; digits <= 17; digits++) {
            snprintf(wanted, sizeof wanted, "%.*g", digits, value);
            if (strtod(wanted, NULL) == value)
                break;
        }
        assert_string_equal(text, wanted);
    }
}

/* Any finite double survives the text, by the tree too. */
static void numbers_read_back_to_the_bit(void **state)
{
    (void)state;
    static const double hard[] = {0.1,
                                  0.1 + 0.2,
                                  1.0 / 3,
                                  5e-324,
                                  1.7976931348623157e308,
                                  -2.2250738585072014e-308,
                                  1e15,
                                  123456789012345680.0,
                                  9007199254740991,
                                  1e22,
                                  4.35,
                                  2.5,
                                  -0.0};
    sample s, again;
    sample_two(&s);
    for (uint64_t i = 0; i < 20000; i++) {
        uint64_t bits = ll_rng_u64(1, 1, i);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (i < sizeof hard / sizeof hard[0])
            value = hard[i];
        if (!(value >= -1e308 && value <= 1e308))
            continue;
        s.ratio = value;
        char *text = written(&s);
        ll_param_defaults(&sample_table, &again);
        assert_string_equal(sample_parse(text, &again).text, "");
        free(text);
        assert_memory_equal(&again, &s, sizeof s);

        cJSON *json = ll_param_write(&sample_table, &s);
        ll_param_defaults(&sample_table, &again);
        assert_string_equal(ll_param_parse(&sample_table, json, &again).text, "");
        cJSON_Delete(json);
        assert_memory_equal(&again, &s, sizeof s);
    }
}

static void numbers_are_short(void **state)
{
    (void)state;
    static const struct {
        double value;
        const char *text;
    } cases[] = {{0, "0"},
                 {250, "250"},
                 {-3, "-3"},
                 {0.1, "0.1"},
                 {0.1 + 0.2, "0.30000000000000004"},
                 {1.0 / 3, "0.3333333333333333"},
                 {9007199254740991, "9007199254740991"},
                 {100000, "100000"},
                 {1e-7, "1e-07"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cJSON *json = ll_param_number(cases[i].value);
        assert_true(json->valuedouble == cases[i].value);
        char *text = cJSON_PrintUnformatted(json);
        assert_string_equal(text, cases[i].text);
        free(text);
        cJSON_Delete(json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_text_is_in_the_tables_order),
        cmocka_unit_test(a_variant_without_params_is_an_empty_object),
        cmocka_unit_test(numbers_have_the_fewest_digits),
        cmocka_unit_test(numbers_read_back_to_the_bit),
        cmocka_unit_test(numbers_are_short),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "base/status.h"

static void ok_is_not_a_failure(void **state)
{
    (void)state;
    ll_status s = ll_ok();
    assert_false(ll_failed(&s));
    assert_string_equal(s.field, "");
    assert_string_equal(s.text, "");
}

static void an_error_says_what_and_where(void **state)
{
    (void)state;
    ll_status s = ll_error(LL_LIMIT, "at most %d sessions", 12);
    assert_true(ll_failed(&s));
    assert_int_equal(s.code, LL_LIMIT);
    assert_string_equal(s.text, "at most 12 sessions");
    assert_string_equal(s.field, "");

    s = ll_field_error(LL_BAD_INPUT, "players.1.lag_ms", "got %s", "5000");
    assert_int_equal(s.code, LL_BAD_INPUT);
    assert_string_equal(s.field, "players.1.lag_ms");
    assert_string_equal(s.text, "got 5000");
}

/* Whatever is cut off must stay valid UTF-8, or the answer that carries it is no JSON. The second letter's
 * two bytes begin at an odd or an even place, so that one of the cuts goes through it. */
static void cuts_spare_letters(void **state)
{
    (void)state;
    for (int ascii = 0; ascii < 4; ascii++) {
        static const char *const letters[] = {"x", "\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\x9a\x97"};
        for (size_t kind = 0; kind < 4; kind++) {
            size_t step = strlen(letters[kind]);
            char text[600] = "xxx";
            size_t length = (size_t)ascii;
            while (length + step < sizeof text - 1) {
                memcpy(text + length, letters[kind], step + 1);
                length += step;
            }
            ll_status s = ll_field_error(LL_IO, text, "%s", text);
            size_t kept = strlen(s.text), kept_field = strlen(s.field);
            assert_true(kept <= 255 && kept + step > 255);
            assert_true(kept_field <= 63 && kept_field + step > 63);
            assert_int_equal((kept - (size_t)ascii) % step, 0);
            assert_int_equal((kept_field - (size_t)ascii) % step, 0);
            assert_memory_equal(s.text, text, kept);
        }
    }
}

/* What a stranger wrote may be quoted with its control characters, and cut by a precision. */
static void what_is_quoted_becomes_text(void **state)
{
    (void)state;
    assert_string_equal(ll_error(LL_BAD_INPUT, "got %.2s", "a\xc3\xa4").text, "got a?");
    assert_string_equal(ll_error(LL_BAD_INPUT, "got %s.", "\x1b[0m\n\x7f\xff\xc2\x85").text,
                        "got ?[0m?????.");
    assert_string_equal(ll_error(LL_BAD_INPUT, "got %s", "\xf0\x9f\x9a\x97 \xc3\xa4").text,
                        "got \xf0\x9f\x9a\x97 \xc3\xa4");
    assert_string_equal(ll_field_error(LL_BAD_INPUT, "a\x01\xed\xa0\x80", "x").field, "a????");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ok_is_not_a_failure),
        cmocka_unit_test(an_error_says_what_and_where),
        cmocka_unit_test(cuts_spare_letters),
        cmocka_unit_test(what_is_quoted_becomes_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

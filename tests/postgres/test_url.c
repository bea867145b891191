/* Names of stores, which stand in messages and logs: without passwords. A server is in
 * tests/api/store.test.mjs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "postgres/url.h"

static void a_name_has_the_user_and_no_secret(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"postgresql://lab@db.example.org/lab", "postgresql://lab@db.example.org/lab"},
        {"postgresql://lab:secret@db:5433/lab?password=secret", "postgresql://lab@db:5433/lab"},
        {"postgresql://lab:se@cr@et@db/lab", "postgresql://lab@db/lab"},
        {"postgresql:///lab?host=/run&user=a@b", "postgresql:///lab"},
        {"postgresql://:secret@db", "postgresql://@db"},
        {"sqlite:rows.db", "sqlite:rows.db"},
        {"", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char name[160];
        ll_pg_name_url(cases[i][0], name, sizeof name);
        assert_string_equal(name, cases[i][1]);
    }
}

static void a_long_url_is_cut(void **state)
{
    (void)state;
    char name[12];
    ll_pg_name_url("postgresql://lab@db/lab", name, sizeof name);
    assert_string_equal(name, "postgresql:");
}

static void a_url_that_libpq_cannot_read_is_refused_without_its_text(void **state)
{
    (void)state;
    ll_status good = ll_pg_check_url("postgresql://lab:secret@db:5433/lab?connect_timeout=3", "it");
    assert_false(ll_failed(&good));
    static const char *const bad[] = {"postgresql://lab:secret%zz@db/lab", "postgresql://db/lab?secret=1",
                                      "postgresql://lab:secret@[::1/lab"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ll_status status = ll_pg_check_url(bad[i], "it");
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, "store");
        assert_non_null(strstr(status.text, "invalid URL of the store it: "));
        assert_null(strstr(status.text, "secret"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_name_has_the_user_and_no_secret),
        cmocka_unit_test(a_long_url_is_cut),
        cmocka_unit_test(a_url_that_libpq_cannot_read_is_refused_without_its_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

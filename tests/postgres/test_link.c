/* A connection that the server has cut, on a server of its own. Exits with 77 where there is none. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>

#include <cmocka.h>

#include "postgres/link.h"

static char server[200], url[400];

static int ask_server(char *answer, size_t size, const char *verb)
{
    char command[300];
    snprintf(command, sizeof command, "tests/support/postgres %s %s", verb, server);
    FILE *pipe = popen(command, "r");
    if (!fgets(answer, (int)size, pipe))
        answer[0] = '\0';
    answer[strcspn(answer, "\n")] = '\0';
    return WEXITSTATUS(pclose(pipe));
}

static int start_server(void **state)
{
    (void)state;
    return ask_server(url, sizeof url, "start");
}

static int remove_server(void **state)
{
    char answer[200];
    (void)state;
    return ask_server(answer, sizeof answer, "remove");
}

static void open_link(ll_pg_link *link, const char *session)
{
    static const ll_pg_patience patience = {"2", "5", "5", "3", "2000"};
    ll_pg_init(link, session);
    assert_true(ll_pg_connect(link, url, &patience));
}

static void cut(ll_pg_link *other, int backend)
{
    assert_true(ll_pg_query(other, "SELECT pg_terminate_backend($1::int, 5000)", "i", (int64_t)backend));
    assert_true(ll_pg_true(other, 0, 0));
}

static void a_connection_that_is_opened_again_has_its_settings(void **state)
{
    (void)state;
    char reason[LL_PG_REASON_MAX];
    ll_pg_link other, link;
    open_link(&other, "SET lock_timeout TO '5s'");
    assert_true(ll_pg_run(&other, "CREATE SCHEMA own; CREATE TABLE own.divisor(n int);"
                                  "INSERT INTO own.divisor VALUES(1)"));
    open_link(&link, "SET search_path TO own; SELECT 1/n FROM own.divisor");
    int first = PQbackendPID(link.db);
    cut(&other, first);
    ll_pg_lock(&link);
    assert_int_not_equal(PQbackendPID(link.db), first);
    assert_true(ll_pg_run(&link, "SHOW search_path"));
    assert_string_equal(ll_pg_text(&link, 0, 0), "own");
    ll_pg_unlock(&link, ll_ok());

    /* Where they fail, nothing is done without them, and the reason is theirs. */
    assert_true(ll_pg_run(&other, "UPDATE own.divisor SET n=0"));
    cut(&other, PQbackendPID(link.db));
    ll_pg_lock(&link);
    assert_int_equal(PQstatus(link.db), CONNECTION_OK);
    assert_false(ll_pg_run(&link, "CREATE TABLE stray(n int)"));
    assert_false(ll_pg_query(&link, "SELECT $1::bigint", "i", INT64_C(1)));
    assert_int_equal(ll_pg_fault_of(&link, reason), LL_PG_REFUSED);
    assert_string_equal(reason, "division by zero");
    ll_pg_unlock(&link, ll_ok());
    assert_true(ll_pg_run(&other, "SELECT to_regclass('public.stray') IS NULL"));
    assert_true(ll_pg_true(&other, 0, 0));

    /* They are tried again. */
    assert_true(ll_pg_run(&other, "UPDATE own.divisor SET n=1"));
    ll_pg_lock(&link);
    assert_true(ll_pg_run(&link, "SHOW search_path"));
    assert_string_equal(ll_pg_text(&link, 0, 0), "own");
    ll_pg_unlock(&link, ll_ok());
    ll_pg_close(&link);
    ll_pg_close(&other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_connection_that_is_opened_again_has_its_settings),
    };
    int made = ask_server(server, sizeof server, "make");
    if (made != 0)
        return made;
    return cmocka_run_group_tests(tests, start_server, remove_server);
}

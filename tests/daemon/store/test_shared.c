/* A store that daemons share, on a PostgreSQL server of its own: leases, claims, and what a daemon that was
 * marked as dead can no longer do. Exits with 77 where there is no server. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pthread.h>
#include <sqlite3.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <cmocka.h>

#include "daemon/store/import.h"
#include "daemon/store/shared.h"

static char server[200], url[400];

static int ask_server(char *answer, size_t size, const char *verb, const char *argument)
{
    char command[600];
    snprintf(command, sizeof command, "tests/support/postgres %s %s \"%s\"", verb, server, argument);
    FILE *pipe = popen(command, "r");
    if (!fgets(answer, (int)size, pipe))
        answer[0] = '\0';
    answer[strcspn(answer, "\n")] = '\0';
    return WEXITSTATUS(pclose(pipe));
}

static void tell_server(const char *verb, const char *argument)
{
    char answer[200];
    assert_int_equal(ask_server(answer, sizeof answer, verb, argument), 0);
}

static int start_server(void **state)
{
    (void)state;
    return ask_server(url, sizeof url, "start", "");
}

static int remove_server(void **state)
{
    char answer[200];
    (void)state;
    return ask_server(answer, sizeof answer, "remove", "");
}

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* ---- daemons and sessions ---- */

static ll_store *join_as(double lease_s, const char *engine)
{
    ll_store *store;
    must(ll_store_open_shared(
        &(ll_shared_config){
            .url = url, .address = "http://127.0.0.1:1", .engine = engine, .lease_s = lease_s},
        &store));
    assert_true(ll_store_is_shared(store) && ll_store_daemon(store) > 0);
    return store;
}

static ll_store *join(double lease_s)
{
    return join_as(lease_s, NULL);
}

static ll_stored make_session(ll_store *store)
{
    ll_stored row = {.key_count = 2,
                     .playing = true,
                     .speed = 0.5,
                     .tick = 7,
                     .head_tick = 9,
                     .created_ms = 1234567,
                     .hash_tick = 5,
                     .hash_lines = 2,
                     .hash = 0x9e3779b97f4a7c15u};
    ll_store_batch batch = {0};
    bool taken = true;
    must(ll_store_new_place(store, &row.place));
    assert_true(ll_new_id("", row.id));
    while (taken) {
        assert_true(ll_new_code("", row.code));
        must(ll_store_reserve_code(store, row.place.number, row.code, NULL, &taken));
    }
    for (size_t i = 0; i < 2 * sizeof row.keys[0]; i++)
        ((unsigned char *)row.keys)[i] = (unsigned char)(i * 37);
    ll_store_batch_line(&batch, row.place, 0, "{\"a\":\"\\\\\"}", 10);
    ll_store_batch_line(&batch, row.place, 1, "two", 3);
    ll_store_batch_put(&batch, &row);
    must(ll_store_wait(store, ll_store_submit(store, &batch)));
    return row;
}

static ll_claim claim(ll_store *store, const char *id)
{
    ll_claim got;
    must(ll_store_claim(store, id, &got));
    return got;
}

static void expect_log(ll_store *store, int64_t number, const char *wanted)
{
    char *text;
    size_t length;
    must(ll_store_read_log(store, number, &text, &length));
    assert_string_equal(text, wanted);
    assert_int_equal(length, strlen(wanted));
    free(text);
}

static const char first_lines[] = "{\"a\":\"\\\\\"}\ntwo\n";

/* Polls for at most five seconds. */
#define WAIT_FOR(condition)                                                                                  \
    for (int tries_ = 0; !(condition); tries_++) {                                                           \
        if (tries_ == 500)                                                                                   \
            fail_msg("waited for %s", #condition);                                                           \
        usleep(10000);                                                                                       \
    }

/* ---- tests ---- */

static void another_daemon_finds_all_of_a_session(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join(30);
    ll_stored made = make_session(a);
    char id[LL_ID_LENGTH + 1];
    must(ll_store_find_code(b, made.code, id));
    assert_string_equal(id, made.id);
    made.tick = 70;
    ll_store_put(a, &made);
    made.tick = 71;
    must(ll_store_wait(a, ll_store_put(a, &made)));

    ll_claim got = claim(b, made.id);
    assert_int_equal(got.result, LL_CLAIM_HELD);
    assert_int_equal(got.owner, ll_store_daemon(a));
    assert_false(got.over);
    assert_string_equal(got.url, "http://127.0.0.1:1");
    must(ll_store_mark_dead(b, got.owner, false, NULL)); /* its lease is not over */
    assert_int_equal(claim(b, made.id).result, LL_CLAIM_HELD);

    int64_t dead = ll_store_daemon(a);
    must(ll_store_mark_dead(b, dead, true, NULL));
    got = claim(b, made.id);
    assert_int_equal(got.result, LL_CLAIM_DONE);
    assert_int_equal(got.why, LL_CLAIM_DEAD);
    assert_int_equal(got.row.place.daemon, ll_store_daemon(b));
    assert_int_equal(got.row.place.number, made.place.number);
    assert_string_equal(got.row.code, made.code);
    assert_int_equal(got.row.key_count, 2);
    assert_memory_equal(got.row.keys, made.keys, 2 * sizeof made.keys[0]);
    assert_true(got.row.playing && got.row.speed == 0.5 && got.row.tick == 71 && got.row.head_tick == 9);
    assert_true(got.row.hash == made.hash && got.row.hash_tick == 5 && got.row.hash_lines == 2);
    assert_int_equal(got.row.created_ms, 1234567);
    assert_int_equal(got.row.lines, 2);
    assert_int_equal(got.row.log_bytes, strlen(first_lines));
    expect_log(b, made.place.number, first_lines);
    assert_int_equal(claim(b, made.id).why, LL_CLAIM_OWN);
    assert_int_equal(claim(b, "abcdefghijklmnopqrstuvwxyz").result, LL_CLAIM_UNKNOWN);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

static void a_dead_daemon_cannot_write(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join(30);
    ll_stored made = make_session(a);
    int64_t dead = ll_store_daemon(a);
    must(ll_store_mark_dead(b, dead, true, NULL));
    assert_int_equal(claim(b, made.id).result, LL_CLAIM_DONE);
    uint64_t ticket = ll_store_line(a, made.place, 2, "late", 4);
    ll_status status = ll_store_wait(a, ticket);
    assert_int_equal(status.code, LL_UNAVAILABLE);
    assert_int_equal(ll_store_get_outcome(a, ticket), LL_STORE_LOST);
    expect_log(b, made.place.number, first_lines);
    WAIT_FOR(ll_store_daemon(a) > dead);                 /* another incarnation */
    ticket = ll_store_line(a, made.place, 2, "late", 4); /* of the dead incarnation */
    assert_int_equal(ticket, LL_STORE_LOST_TICKET);
    assert_false(ll_store_failing(a, NULL));
    ll_stored next = make_session(a);
    expect_log(b, next.place.number, first_lines);
    expect_log(b, made.place.number, first_lines);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

typedef struct late_line {
    ll_store *store;
    ll_store_place place;
    ll_status status;
} late_line;

static void *write_line(void *context)
{
    late_line *l = context;
    l->status = ll_store_wait(l->store, ll_store_line(l->store, l->place, 2, "slow", 4));
    return NULL;
}

/* The row of the daemon is held until the commit has ended: a daemon that marks it as dead waits, and then
 * sees the line. Otherwise a line would be acknowledged that the next owner does not have. */
static void a_commit_under_way_is_seen_by_the_next_owner(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join(30);
    ll_stored made = make_session(a);
    tell_server("sql",
                "CREATE FUNCTION slow() RETURNS trigger LANGUAGE plpgsql AS 'BEGIN PERFORM pg_sleep(0.7); "
                "RETURN NEW; END'");
    tell_server("sql",
                "CREATE TRIGGER slow BEFORE INSERT ON laglab_sessions.line FOR EACH ROW EXECUTE FUNCTION "
                "slow()");
    late_line l = {.store = a, .place = made.place};
    pthread_t thread;
    pthread_create(&thread, NULL, write_line, &l);
    usleep(300000);
    must(ll_store_mark_dead(b, ll_store_daemon(a), true, NULL));
    ll_claim got = claim(b, made.id);
    assert_int_equal(got.result, LL_CLAIM_DONE);
    pthread_join(thread, NULL);
    tell_server("sql", "DROP TRIGGER slow ON laglab_sessions.line");
    must(l.status);
    assert_int_equal(got.row.lines, 3);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

static void count_calls(void *context)
{
    __atomic_fetch_add((int *)context, 1, __ATOMIC_SEQ_CST);
}

static void without_its_server_a_daemon_freezes_and_goes_on(void **state)
{
    (void)state;
    int calls = 0;
    ll_store *a = join(2);
    ll_stored made = make_session(a);
    int64_t daemon = ll_store_daemon(a);
    ll_store_on_commit(a, count_calls, &calls);
    double left = ll_store_lease_left_s(a);
    assert_true(left > 0 && left <= 2 * LL_LEASE_SAFE);
    must(ll_store_check_lease(a));
    tell_server("kill", "");
    uint64_t ticket = ll_store_line(a, made.place, 2, "three", 5);
    ll_status status = ll_store_wait(a, ticket);
    assert_int_equal(status.code, LL_UNAVAILABLE);
    assert_true(ll_store_failing(a, NULL));
    assert_int_equal(ll_store_get_outcome(a, ticket), LL_STORE_PENDING);
    WAIT_FOR(ll_store_lease_left_s(a) <= 0);
    status = ll_store_check_lease(a);
    assert_int_equal(status.code, LL_UNAVAILABLE);
    tell_server("start", "");
    WAIT_FOR(ll_store_lease_left_s(a) > 0);
    WAIT_FOR(ll_store_get_outcome(a, ticket) == LL_STORE_DURABLE);
    assert_int_equal(ll_store_daemon(a), daemon); /* no other daemon wanted its sessions */
    assert_true(__atomic_load_n(&calls, __ATOMIC_SEQ_CST) >= 2);
    expect_log(a, made.place.number, "{\"a\":\"\\\\\"}\ntwo\nthree\n");
    must(ll_store_close(a));
}

/* The clocks of this program: what the system says, and a time for which the machine was suspended. */
static _Atomic time_t suspended_s;

int clock_gettime(clockid_t clock, struct timespec *now)
{
    int result = (int)syscall(SYS_clock_gettime, clock, now);
    if (clock == CLOCK_BOOTTIME)
        now->tv_sec += suspended_s;
    return result;
}

static void a_lease_goes_on_while_the_machine_is_suspended(void **state)
{
    (void)state;
    ll_store *a = join(30); /* renewed every 6 s, which is the time for the lines up to the next check */
    must(ll_store_check_lease(a));
    suspended_s = 60;
    ll_status status = ll_store_check_lease(a);
    assert_int_equal(status.code, LL_UNAVAILABLE);
    must(ll_store_close(a));
}

static void a_lease_that_is_over_can_be_ended(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join(30);
    ll_stored made = make_session(a);
    int64_t owner = ll_store_daemon(a);
    tell_server("sql", "UPDATE laglab_sessions.daemon SET lease_until=now()-interval '1 s' WHERE state='up'");
    ll_claim got = claim(b, made.id);
    assert_int_equal(got.result, LL_CLAIM_HELD);
    assert_true(got.over);
    must(ll_store_mark_dead(b, owner, false, NULL));
    assert_int_equal(claim(b, made.id).result, LL_CLAIM_DONE);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

typedef struct wish {
    pthread_mutex_t lock;
    char id[LL_ID_LENGTH + 1];
} wish;

static void on_asked(void *context, const char *id)
{
    wish *w = context;
    pthread_mutex_lock(&w->lock);
    snprintf(w->id, sizeof w->id, "%s", id);
    pthread_mutex_unlock(&w->lock);
}

static bool is_asked(wish *w, const char *id)
{
    pthread_mutex_lock(&w->lock);
    bool asked = strcmp(w->id, id) == 0;
    pthread_mutex_unlock(&w->lock);
    return asked;
}

static void a_session_is_asked_for_and_released(void **state)
{
    (void)state;
    wish w = {.lock = PTHREAD_MUTEX_INITIALIZER};
    ll_store *a = join(30), *b = join(30);
    ll_store_on_asked(a, on_asked, &w);
    ll_stored made = make_session(a);
    must(ll_store_ask(b, ll_store_daemon(a), made.id));
    WAIT_FOR(is_asked(&w, made.id));
    ll_store_line(a, made.place, 2, "last", 4);
    must(ll_store_wait(a, ll_store_release(a, made.place)));
    ll_claim got = claim(b, made.id);
    assert_int_equal(got.result, LL_CLAIM_DONE);
    assert_int_equal(got.why, LL_CLAIM_FREE);
    assert_int_equal(got.row.lines, 3);
    must(ll_store_drain(a));
    assert_int_equal(claim(a, made.id).result, LL_CLAIM_REFUSED);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

static void another_engine_is_named(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join_as(30, "0123456789ab");
    ll_stored made = make_session(a);
    must(ll_store_wait(a, ll_store_release(a, made.place)));
    ll_claim got = claim(b, made.id);
    assert_int_equal(got.result, LL_CLAIM_ENGINE);
    assert_string_equal(got.engine, ll_engine);
    assert_int_equal(strlen(ll_engine), 12);
    assert_int_equal(claim(a, made.id).result, LL_CLAIM_DONE);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

static void codes_are_unique_and_deleted_with_their_session(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join(30);
    ll_stored made = make_session(a);
    char id[LL_ID_LENGTH + 1];
    bool taken;
    ll_store_place other;
    must(ll_store_new_place(b, &other));
    assert_true(other.number != made.place.number);
    must(ll_store_reserve_code(b, other.number, made.code, NULL, &taken));
    assert_true(taken);
    must(ll_store_wait(a, ll_store_delete(a, made.place)));
    ll_status status = ll_store_find_code(b, made.code, id);
    assert_int_equal(status.code, LL_NOT_FOUND);
    assert_int_equal(claim(b, made.id).result, LL_CLAIM_UNKNOWN);
    must(ll_store_reserve_code(b, other.number, made.code, NULL, &taken));
    assert_false(taken);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

static void old_sessions_without_a_living_owner_are_deleted(void **state)
{
    (void)state;
    ll_store *a = join(30), *b = join(30);
    ll_stored kept = make_session(a), old = make_session(a);
    int64_t deleted;
    must(ll_store_wait(a, ll_store_release(a, old.place)));
    tell_server("sql", "UPDATE laglab_sessions.session SET seen=now()-interval '1 hour'");
    must(ll_store_expire(b, 60, &deleted));
    assert_true(deleted >= 1); /* those of other tests too */
    assert_int_equal(claim(b, old.id).result, LL_CLAIM_UNKNOWN);
    assert_int_equal(claim(b, kept.id).result, LL_CLAIM_HELD);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

/* A daemon that is started again on its address does not wait for the lease of the one that was killed. */
static void a_daemon_replaces_the_one_before(void **state)
{
    (void)state;
    ll_store *a = join(30);
    ll_stored made = make_session(a);
    ll_store *b = join(30);
    assert_int_equal(claim(b, made.id).result, LL_CLAIM_HELD);
    must(ll_store_replace(b));
    assert_int_equal(claim(b, made.id).result, LL_CLAIM_DONE);
    must(ll_store_close(a));
    must(ll_store_close(b));
}

/* ---- tables ---- */

static void *hold_tables(void *context)
{
    char answer[20];
    (void)context;
    ask_server(
        answer, sizeof answer, "sql",
        "SET search_path TO laglab_sessions; BEGIN; LOCK TABLE session, line, code, class, answer, state,"
        " daemon IN ACCESS SHARE MODE; SELECT pg_sleep(60)");
    return NULL;
}

static bool has(const char *condition)
{
    char sql[300], answer[20] = "";
    snprintf(sql, sizeof sql, "SELECT (%s)::int", condition);
    assert_int_equal(ask_server(answer, sizeof answer, "sql", sql), 0);
    return answer[0] == '1';
}

/* As a dump of the database, or an import, holds them. */
static void a_daemon_starts_while_the_tables_are_read(void **state)
{
    (void)state;
    must(ll_store_close(join(30)));
    pthread_t thread;
    pthread_create(&thread, NULL, hold_tables, NULL);
    WAIT_FOR(has("EXISTS (SELECT 1 FROM pg_stat_activity WHERE wait_event='PgSleep')"));
    must(ll_store_close(join(30)));
    assert_true(has("SELECT count(*)=1 FROM (SELECT pg_cancel_backend(pid) FROM pg_stat_activity"
                    " WHERE wait_event='PgSleep') AS c"));
    pthread_join(thread, NULL);
}

static void tables_of_an_earlier_version_are_completed(void **state)
{
    (void)state;
    ll_store *a = join(30);
    ll_stored made = make_session(a);
    must(ll_store_close(a));
    tell_server("sql", "SET search_path TO laglab_sessions; DROP TABLE answer, class, state;"
                       " ALTER TABLE code DROP stem, DROP class_key, DROP log_bytes");
    a = join(30);
    assert_int_equal(claim(a, made.id).result, LL_CLAIM_DONE);
    make_session(a);
    must(ll_store_close(a));
    assert_true(has("to_regclass('laglab_sessions.code_stem') IS NOT NULL AND"
                    " to_regclass('laglab_sessions.code_class_key') IS NOT NULL"));
    assert_true(has("SELECT attstorage='e' FROM pg_attribute WHERE"
                    " attrelid='laglab_sessions.state'::regclass AND attname='body'"));
    tell_server("sql", "ALTER TABLE laglab_sessions.class DROP class_key;"
                       " ALTER TABLE laglab_sessions.state ALTER body SET STORAGE EXTENDED");
    must(ll_store_close(join(30)));
    assert_true(has("SELECT attstorage='e' FROM pg_attribute WHERE"
                    " attrelid='laglab_sessions.state'::regclass AND attname='body'"));
    tell_server("sql",
                "SELECT class_key, stem FROM laglab_sessions.class; SELECT * FROM laglab_sessions.answer;"
                " SELECT stem, class_key, log_bytes FROM laglab_sessions.code");
}

/* Of a laglab that stored neither classes nor their keys; one session has no log. */
static ll_stored make_folder(const char *folder, const char *line)
{
    ll_store *store;
    ll_stored row = {.code = "2345",
                     .key_count = LL_STORE_KEYS,
                     .speed = 0.25,
                     .tick = 3,
                     .head_tick = 5,
                     .created_ms = 77,
                     .seen_ms = INT64_MAX / 2},
              empty = row;
    must(ll_store_open(folder, &store));
    must(ll_store_new_place(store, &row.place));
    must(ll_store_new_place(store, &empty.place));
    assert_true(ll_new_id("", row.id) && ll_new_id("", empty.id));
    for (size_t i = 0; i < sizeof row.keys; i++)
        ((unsigned char *)row.keys)[i] = (unsigned char)(i * 31);
    ll_store_put(store, &empty);
    ll_store_put(store, &row);
    ll_store_line(store, row.place, 0, line, strlen(line));
    ll_store_line(store, row.place, 1, "", 0);
    ll_store_line(store, row.place, 2, "two", 3);
    must(ll_store_close(store));
    char path[100];
    sqlite3 *db;
    snprintf(path, sizeof path, "%s/laglab.db", folder);
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, "DROP TABLE classes; DROP TABLE class_keys", NULL, NULL, NULL),
                     SQLITE_OK);
    sqlite3_close(db);
    return row;
}

static void a_folder_is_imported(void **state)
{
    (void)state;
    static const char line[] = "\ta\\N\r\\.\"\\t' \xc3\xa9";
    char folder[] = "/tmp/laglab-import-XXXXXX", remove[100], wanted[100];
    assert_non_null(mkdtemp(folder));
    ll_stored row = make_folder(folder, line);
    ll_imported got;
    must(ll_store_import(folder, url, &got));
    assert_true(got.sessions == 1 && got.left_out == 1 && got.lines == 3 && got.classes == 0);
    ll_store *a = join(30);
    ll_claim claimed = claim(a, row.id);
    assert_int_equal(claimed.result, LL_CLAIM_DONE);
    assert_int_equal(claimed.why, LL_CLAIM_FREE);
    assert_string_equal(claimed.row.code, row.code);
    assert_int_equal(claimed.row.key_count, LL_STORE_KEYS);
    assert_memory_equal(claimed.row.keys, row.keys, sizeof row.keys);
    assert_true(!claimed.row.playing && claimed.row.speed == 0.25 && claimed.row.tick == 3);
    assert_true(claimed.row.head_tick == 5 && claimed.row.created_ms == 77 && claimed.row.lines == 3);
    assert_true(claimed.row.hash_lines == 0 && claimed.row.log_bytes == got.bytes);
    snprintf(wanted, sizeof wanted, "%s\n\ntwo\n", line);
    expect_log(a, claimed.row.place.number, wanted);
    ll_status status = ll_store_import(folder, url, &got);
    assert_true(status.code == LL_CONFLICT && strstr(status.text, row.id) && got.sessions == 0);
    must(ll_store_close(a));
    snprintf(remove, sizeof remove, "rm -r %s", folder);
    assert_int_equal(system(remove), 0);
}

static void bad_urls_and_newer_schemas_are_refused(void **state)
{
    (void)state;
    ll_store *store;
    ll_shared_config config = {.url = "postgresql://me:secret@127.0.0.1:1/lab", .address = "", .lease_s = 1};
    ll_status status = ll_store_open_shared(&config, &store);
    assert_int_equal(status.code, LL_UNAVAILABLE);
    assert_null(store);
    assert_true(strstr(status.text, "postgresql://me@127.0.0.1:1/lab") && !strstr(status.text, "secret"));
    config.url = "postgresql://me:secret@host/lab?nosuch=secret";
    status = ll_store_open_shared(&config, &store);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_null(strstr(status.text, "secret"));
    tell_server("sql", "UPDATE laglab_sessions.schema_version SET version=99");
    config.url = url;
    status = ll_store_open_shared(&config, &store);
    tell_server("sql", "UPDATE laglab_sessions.schema_version SET version=1");
    assert_true(status.code == LL_BAD_INPUT && strstr(status.text, "99") && strstr(status.text, "newer"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_daemon_finds_all_of_a_session),
        cmocka_unit_test(a_dead_daemon_cannot_write),
        cmocka_unit_test(a_commit_under_way_is_seen_by_the_next_owner),
        cmocka_unit_test(without_its_server_a_daemon_freezes_and_goes_on),
        cmocka_unit_test(a_lease_goes_on_while_the_machine_is_suspended),
        cmocka_unit_test(a_lease_that_is_over_can_be_ended),
        cmocka_unit_test(a_session_is_asked_for_and_released),
        cmocka_unit_test(another_engine_is_named),
        cmocka_unit_test(codes_are_unique_and_deleted_with_their_session),
        cmocka_unit_test(old_sessions_without_a_living_owner_are_deleted),
        cmocka_unit_test(a_daemon_replaces_the_one_before),
        cmocka_unit_test(a_daemon_starts_while_the_tables_are_read),
        cmocka_unit_test(tables_of_an_earlier_version_are_completed),
        cmocka_unit_test(a_folder_is_imported),
        cmocka_unit_test(bad_urls_and_newer_schemas_are_refused),
    };
    int made = ask_server(server, sizeof server, "make", "");
    if (made != 0)
        return made;
    return cmocka_run_group_tests(tests, start_server, remove_server);
}

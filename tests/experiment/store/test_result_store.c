/* Leases of the store: every row once, even with late workers. `test_experiment_result_store postgres` tests
 * a PostgreSQL server of its own, and exits with 77 if that is not installed. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <sqlite3.h>
#include <sys/wait.h>
#include <cmocka.h>

#include "experiment/format/table.h"
#include "experiment/spec/shard.h"
#include "experiment/store/result_store.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static const ll_experiment_record ten = {.id = "x", .to = 10};

static char url[200] = "sqlite::memory:";
static char server[100]; /* its folder */

static ll_result_store *fresh(void)
{
    ll_result_store *s;
    must(ll_result_store_open(url, &s));
    if (server[0])
        s->kind->remove(s, "x"); /* of the previous test */
    must(s->kind->create(s, &ten, "{}", 4));
    return s;
}

static ll_row row(int64_t run)
{
    ll_row r = {
        .run = run, .hash = (uint64_t)run * 0x9e3779b97f4a7c15u, .t_s = 1.5, .metrics = {run / 3.0, NAN}};
    return r;
}

static ll_row row_with_a_sentence(int64_t run)
{
    ll_row r = row(run);
    r.status = LL_ROW_DIVERGED;
    snprintf(r.error, sizeof r.error, "f\xc3\xbcr \"x\",\t\\N\n");
    return r;
}

static void hand_in(ll_result_store *s, const ll_lease *l, ll_code wanted)
{
    ll_row rows[4];
    for (int64_t i = l->from; i < l->to; i++)
        rows[i - l->from] = i == 5 ? row_with_a_sentence(i) : row(i);
    ll_status status = s->kind->finish(s, l, rows, l->to - l->from, 2);
    assert_int_equal(status.code, wanted);
}

static ll_experiment_record record(ll_result_store *s)
{
    ll_experiment_record r;
    must(s->kind->record(s, "x", &r));
    return r;
}

static void rows_come_back_whole(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_lease l;
    for (int k = 0; k < 3; k++) {
        must(s->kind->claim(s, "x", "me", 60, &l));
        assert_int_equal(l.chunk, k);
        assert_int_equal(record(s).leased, k < 2 ? 4 : 2);
        hand_in(s, &l, LL_OK);
    }
    must(s->kind->claim(s, "x", "me", 60, &l));
    assert_true(l.chunk < 0);
    assert_int_equal(record(s).state, LL_EXPERIMENT_DONE);
    ll_row rows[16];
    int count;
    must(s->kind->read(s, "x", 3, rows, 16, &count));
    assert_int_equal(count, 7);
    for (int i = 0; i < count; i++) {
        ll_row wanted = i == 2 ? row_with_a_sentence(5) : row(3 + i);
        assert_true(rows[i].run == wanted.run && rows[i].hash == wanted.hash && rows[i].t_s == wanted.t_s);
        assert_true(rows[i].metrics[0] == wanted.metrics[0] && isnan(rows[i].metrics[1]) &&
                    isnan(rows[i].metrics[2]));
        assert_true(rows[i].status == wanted.status);
        assert_string_equal(rows[i].error, wanted.error);
    }
    ll_result_store_close(s);
}

/* A worker freezes beyond its lease, another runs its chunk, then the first stores its rows: refused, and no
 * row twice. */
static void lost_leases_are_refused(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_lease frozen, other;
    must(s->kind->claim(s, "x", "frozen", -1, &frozen));
    must(s->kind->claim(s, "x", "other", 60, &other));
    assert_int_equal(other.chunk, frozen.chunk);
    assert_int_equal(other.attempt, frozen.attempt + 1);
    ll_status status = s->kind->renew(s, &frozen, 60);
    assert_int_equal(status.code, LL_CONFLICT);
    hand_in(s, &frozen, LL_CONFLICT);
    assert_int_equal(record(s).done, 0);
    must(s->kind->renew(s, &other, 60));
    hand_in(s, &other, LL_OK);
    hand_in(s, &frozen, LL_CONFLICT);
    hand_in(s, &other, LL_CONFLICT);
    assert_int_equal(record(s).done, 4);
    ll_result_store_close(s);
}

static void a_chunk_that_kills_its_workers_is_given_up(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_lease l;
    for (int k = 0; k < LL_ATTEMPTS_MAX; k++) {
        must(s->kind->claim(s, "x", "me", -1, &l));
        assert_int_equal(l.chunk, 0);
    }
    must(s->kind->claim(s, "x", "me", 60, &l));
    assert_int_equal(l.chunk, 1);
    assert_int_equal(record(s).state, LL_EXPERIMENT_FAILED);
    ll_result_store_close(s);
}

static void states_hold_claims_back(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_lease l;
    must(s->kind->set_state(s, "x", LL_EXPERIMENT_PAUSED));
    must(s->kind->claim(s, NULL, "me", 60, &l));
    assert_true(l.chunk < 0);
    must(s->kind->set_state(s, "x", LL_EXPERIMENT_RUNNING));
    must(s->kind->claim(s, NULL, "me", 60, &l));
    assert_int_equal(l.chunk, 0);
    must(s->kind->release(s));
    must(s->kind->claim(s, NULL, "me", 60, &l));
    assert_true(l.chunk == 0 && l.attempt == 1);
    must(s->kind->remove(s, "x"));
    hand_in(s, &l, LL_CONFLICT);
    ll_status status = s->kind->remove(s, "x");
    assert_int_equal(status.code, LL_NOT_FOUND);
    ll_result_store_close(s);
}

static void the_same_again_is_a_resume(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_lease l;
    must(s->kind->claim(s, "x", "me", 60, &l));
    hand_in(s, &l, LL_OK);
    must(s->kind->create(s, &ten, "{}", 4));
    assert_int_equal(record(s).done, 4);
    ll_status status = s->kind->create(s, &ten, "{\"other\":1}", 4);
    assert_int_equal(status.code, LL_CONFLICT);
    ll_result_store_close(s);
}

static void claim_nothing(ll_result_store *s)
{
    ll_lease l;
    must(s->kind->claim(s, "x", "me", 60, &l));
    assert_true(l.chunk < 0);
    must(s->kind->claim(s, NULL, "me", 60, &l));
    assert_true(l.chunk < 0);
}

static void another_version_adds_nothing(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    s->version = "9.9.9+other";
    claim_nothing(s);
    ll_experiment_record r = record(s);
    assert_string_equal(r.version, ll_version);
    ll_status status = ll_result_store_check_versions(s);
    assert_true(status.code == LL_CONFLICT && strstr(status.text, ll_version) &&
                strstr(status.text, "9.9.9+other") && strstr(status.text, "run the experiment again"));
    assert_int_equal(s->kind->create(s, &ten, "{}", 4).code, LL_CONFLICT);
    r.state = LL_EXPERIMENT_DONE;
    must(ll_result_store_check_version(s, &r));
    s->version = ll_version;
    ll_lease l;
    must(s->kind->claim(s, NULL, "me", 60, &l));
    assert_int_equal(l.chunk, 0);
    must(ll_result_store_check_versions(s));
    ll_result_store_close(s);
}

/* A store of the previous schema, without versions: its content can be read, but not continued. */
static void hold_to_no_version(const char *store)
{
    ll_result_store *s;
    ll_row rows[4];
    int count;
    must(ll_result_store_open(store, &s));
    ll_experiment_record r = record(s);
    assert_true(r.version[0] == '\0' && r.done == 4);
    must(s->kind->read(s, "x", 0, rows, 4, &count));
    assert_int_equal(count, 4);
    claim_nothing(s);
    ll_status status = ll_result_store_check_version(s, &r);
    assert_true(status.code == LL_CONFLICT && strstr(status.text, "an unknown version"));
    ll_result_store_close(s);
}

static void do_a_chunk(ll_result_store *s)
{
    ll_lease l;
    must(s->kind->claim(s, "x", "me", 60, &l));
    hand_in(s, &l, LL_OK);
}

static void a_file_of_the_schema_before_is_brought_up(void **state)
{
    (void)state;
    char path[] = "/tmp/laglab-store-XXXXXX";
    ll_result_store *s;
    sqlite3 *db;
    close(mkstemp(path));
    must(ll_result_store_open(path, &s));
    must(s->kind->create(s, &ten, "{}", 4));
    do_a_chunk(s);
    ll_result_store_close(s);
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, "ALTER TABLE experiment DROP COLUMN version; PRAGMA user_version=1",
                                  NULL, NULL, NULL),
                     SQLITE_OK);
    sqlite3_close(db);
    hold_to_no_version(path);
    unlink(path);
}

static void an_age_is_by_the_clock_of_the_store(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_experiment_record r = record(s);
    assert_true(r.age_s >= 0 && r.age_s < 60);
    ll_result_store_close(s);
}

static void note_id(void *seen, const ll_experiment_record *r)
{
    sprintf((char *)seen + strlen(seen), "%s%s ", r->id, r->owner_hash);
}

static void experiments_are_listed_as_they_were_made(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    static const ll_experiment_record first = {.id = "b", .from = 3, .to = 4, .owner_hash = "0a"},
                                      second = {.id = "a", .to = 1};
    char seen[100] = "", *text;
    ll_lease l;
    must(s->kind->create(s, &first, "{\"b\":1}", 4));
    must(s->kind->create(s, &second, "{}", 4));
    must(s->kind->list(s, note_id, seen));
    assert_string_equal(seen, "x b0a a ");
    must(s->kind->specification(s, "b", &text));
    assert_string_equal(text, "{\"b\":1}");
    free(text);
    must(s->kind->claim(s, "b", "me", 60, &l));
    assert_true(l.from == 3 && l.to == 4);
    must(s->kind->return_chunk(s, &l));
    assert_int_equal(s->kind->return_chunk(s, &l).code, LL_CONFLICT);
    assert_int_equal(s->kind->specification(s, "nosuch", &text).code, LL_NOT_FOUND);
    must(s->kind->remove(s, "a"));
    must(s->kind->remove(s, "b"));
    ll_result_store_close(s);
}

static void note_key(void *seen, const ll_experiment_record *r)
{
    sprintf((char *)seen + strlen(seen), "%s %s, ", r->id, r->class_key);
}

static void a_class_key_has_as_many_as_it_may(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_experiment_record a = {.id = "a", .to = 1, .class_key = "north", .most_of_key = 1}, b = a, c = a, got;
    char seen[100] = "";
    strcpy(b.id, "b");
    strcpy(c.id, "c");
    strcpy(c.class_key, "south");
    c.most_of_key = -1;
    must(s->kind->create(s, &a, "{}", 4));
    assert_int_equal(s->kind->create(s, &b, "{}", 4).code, LL_LIMIT);
    assert_int_equal(s->kind->record(s, "b", &got).code, LL_NOT_FOUND);
    must(s->kind->create(s, &c, "{}", 4));
    must(s->kind->list(s, note_key, seen));
    assert_string_equal(seen, "x , a north, c south, ");
    must(s->kind->remove(s, "a"));
    must(s->kind->create(s, &b, "{}", 4));
    must(s->kind->record(s, "b", &got));
    assert_string_equal(got.class_key, "north");
    must(s->kind->remove(s, "b"));
    must(s->kind->remove(s, "c"));
    ll_result_store_close(s);
}

/* Claims a chunk of any experiment and expects it of this one. */
static ll_lease claim_of(ll_result_store *s, const char *id)
{
    ll_lease l;
    must(s->kind->claim(s, NULL, "me", 60, &l));
    assert_string_equal(l.id, id);
    return l;
}

static void experiments_share_workers_equally(void **state)
{
    (void)state;
    ll_result_store *s = fresh(); /* x has three chunks */
    static const ll_experiment_record second = {.id = "y", .to = 30}, third = {.id = "z", .to = 30};
    must(s->kind->create(s, &second, "{}", 3));
    must(s->kind->create(s, &third, "{}", 3));
    /* Workers that come one after the other go to whom fewest work for. */
    ll_lease x = claim_of(s, "x"), y = claim_of(s, "y"), z = claim_of(s, "z");
    claim_of(s, "x");
    claim_of(s, "y");
    hand_in(s, &z, LL_OK);
    z = claim_of(s, "z");
    hand_in(s, &z, LL_OK);
    claim_of(s, "z");
    claim_of(s, "z");
    /* One that is paused has no turn; one that has no chunk left has none either. */
    must(s->kind->set_state(s, "y", LL_EXPERIMENT_PAUSED));
    hand_in(s, &y, LL_OK);
    hand_in(s, &x, LL_OK);
    claim_of(s, "x");
    claim_of(s, "z");
    must(s->kind->set_state(s, "y", LL_EXPERIMENT_RUNNING));
    claim_of(s, "y");
    must(s->kind->remove(s, "y"));
    must(s->kind->remove(s, "z"));
    ll_result_store_close(s);
}

/* A single worker takes them in turn, however long each is. */
static void a_single_worker_takes_turns(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    static const ll_experiment_record second = {.id = "y", .to = 30};
    must(s->kind->create(s, &second, "{}", 3));
    for (int k = 0; k < 6; k++) {
        ll_lease l = claim_of(s, k % 2 ? "y" : "x");
        assert_int_equal(l.chunk, k / 2);
        hand_in(s, &l, LL_OK);
        usleep(2000); /* leases end at different times, by a clock of milliseconds */
    }
    ll_lease l = claim_of(s, "y");
    hand_in(s, &l, LL_OK);
    must(s->kind->remove(s, "y"));
    ll_result_store_close(s);
}

static void bad_stores_are_reported(void **state)
{
    (void)state;
    char path[] = "/tmp/laglab-store-XXXXXX";
    ll_result_store *s;
    sqlite3 *db;
    close(mkstemp(path));
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    sqlite3_exec(db, "PRAGMA user_version=99", NULL, NULL, NULL);
    sqlite3_close(db);
    ll_status status = ll_result_store_open(path, &s);
    assert_true(status.code == LL_BAD_INPUT && strstr(status.text, "99") && strstr(status.text, "newer"));
    FILE *file = fopen(path, "w");
    fputs("run,point\r\n0,0\r\n this is no database but a text file, longer than the header of an SQLite "
          "file, by far",
          file);
    fclose(file);
    status = ll_result_store_open(path, &s);
    assert_true(status.code == LL_IO && strstr(status.text, "not an SQLite database"));
    unlink(path);
    status = ll_result_store_open("/nosuch/folder/x.db", &s);
    assert_true(status.code == LL_IO && strstr(status.text, "/nosuch/folder/x.db"));
    status = ll_result_store_open("mysql://me:secret@host/db?password=secret", &s);
    assert_true(status.code == LL_BAD_INPUT && strstr(status.text, "mysql://me@host/db"));
    assert_null(strstr(status.text, "secret"));
}

/* ---- shards ---- */

static const char *variables[10];

static const char *variable(const char *name)
{
    for (int i = 0; variables[i]; i += 2)
        if (strcmp(variables[i], name) == 0)
            return variables[i + 1];
    return NULL;
}

static void shards_share_all_runs(void **state)
{
    (void)state;
    int64_t from, to, end = 0;
    for (int i = 1; i <= 7; i++) {
        char shard[16];
        snprintf(shard, sizeof shard, "%d/7", i);
        must(ll_shard(shard, 100, &from, &to));
        assert_true(from == end && to - from >= 14 && to - from <= 15);
        end = to;
    }
    assert_int_equal(end, 100);
    static const char *const wrong[] = {"0/3", "4/3", "1", "1/", "/3", "a/b", "1/0"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_int_equal(ll_shard(wrong[i], 100, &from, &to).code, LL_BAD_INPUT);
}

static void engines_tell_their_index(void **state)
{
    (void)state;
    static const char *const cases[][10] = {
        {"SLURM_ARRAY_TASK_ID", "5", "SLURM_ARRAY_TASK_COUNT", "4", "SLURM_ARRAY_TASK_MIN", "3"},
        {"JOB_COMPLETION_INDEX", "2", "LAGLAB_SHARDS", "4"},
        {"AWS_BATCH_JOB_ARRAY_INDEX", "2", "LAGLAB_SHARDS", "4"},
        {"SGE_TASK_ID", "5", "SGE_TASK_LAST", "6", "SGE_TASK_FIRST", "3"},
        {"SLURM_ARRAY_TASK_ID", "14", "SLURM_ARRAY_TASK_COUNT", "4", "SLURM_ARRAY_TASK_MIN", "10",
         "SLURM_ARRAY_TASK_STEP", "2"},
        {"SGE_TASK_ID", "7", "SGE_TASK_LAST", "12", "SGE_TASK_FIRST", "1", "SGE_TASK_STEPSIZE", "3"},
    };
    int64_t index, count;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        memcpy(variables, cases[i], sizeof variables);
        must(ll_shard_from(variable, &index, &count));
        assert_true(index == 3 && count == 4);
    }
    variables[0] = NULL;
    assert_int_equal(ll_shard_from(variable, &index, &count).code, LL_BAD_INPUT);
}

/* ---- intervals ---- */

/* Quantiles of Student's t from tables: 12.706, 2.228, 2.042, 1.984 for 1, 10, 30, 100 degrees of freedom. */
static void intervals_are_students(void **state)
{
    (void)state;
    static const struct {
        int64_t df;
        double t;
    } known[] = {
        {1, 12.706204736}, {10, 2.228138852}, {11, 2.200985160}, {30, 2.042272456}, {100, 1.983971519}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double n = (double)known[i].df + 1;
        assert_true(fabs(ll_interval_95(known[i].df + 1, (n - 1) * n) / known[i].t - 1) < 1e-5);
    }
}

/* ---- PostgreSQL ---- */

/* Output of the script, without its final newline; returns its exit status. */
static int ask_server(char *answer, size_t size, const char *verb, const char *argument)
{
    char command[300];
    snprintf(command, sizeof command, "tests/support/postgres %s %s '%s'", verb, server, argument);
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

static void bad_servers_are_reported(void **state)
{
    (void)state;
    ll_result_store *s;
    char guarded[200];
    snprintf(guarded, sizeof guarded, "postgresql://guarded:secret@/lab?host=%s", server);
    const struct {
        const char *url, *words;
        ll_code code;
    } cases[] = {
        {guarded, "password authentication failed", LL_UNAVAILABLE},
        {"postgresql://me:secret@127.0.0.1:1/lab", "postgresql://me@127.0.0.1:1/lab", LL_UNAVAILABLE},
        {"postgresql://me:secret@127.0.0.1:1/lab", "refused", LL_UNAVAILABLE},
        {"postgresql://me:secret@host/lab?nosuch=secret", "query parameter", LL_BAD_INPUT},
        {"postgresql://me:secret%zz@host/lab", "postgresql://me@host/lab", LL_BAD_INPUT},
        {"postgres:secret", "postgresql://USER@HOST/DATABASE", LL_BAD_INPUT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_status status = ll_result_store_open(cases[i].url, &s);
        assert_int_equal(status.code, cases[i].code);
        if (!strstr(status.text, cases[i].words) || strstr(status.text, "secret"))
            fail_msg("%s", status.text);
    }
}

static void a_newer_schema_is_refused(void **state)
{
    (void)state;
    ll_result_store *s;
    ll_result_store_close(fresh());
    tell_server("sql", "UPDATE laglab.schema_version SET version=99");
    ll_status status = ll_result_store_open(url, &s);
    tell_server("sql", "UPDATE laglab.schema_version SET version=2");
    assert_true(status.code == LL_BAD_INPUT && strstr(status.text, "99") && strstr(status.text, "newer"));
}

static void a_database_of_the_schema_before_is_brought_up(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    do_a_chunk(s);
    ll_result_store_close(s);
    tell_server("sql", "ALTER TABLE laglab.experiment DROP COLUMN version; "
                       "UPDATE laglab.schema_version SET version=1");
    hold_to_no_version(url);
}

static void a_read_only_database_is_reported(void **state)
{
    (void)state;
    ll_result_store_close(fresh());
    tell_server("sql", "ALTER DATABASE lab SET default_transaction_read_only=on");
    ll_result_store *s;
    ll_lease l;
    must(ll_result_store_open(url, &s));
    ll_status status = s->kind->claim(s, "x", "me", 60, &l);
    ll_result_store_close(s);
    tell_server("sql", "ALTER DATABASE lab RESET default_transaction_read_only");
    assert_true(status.code == LL_IO && strstr(status.text, "cannot write to"));
}

/* An unreachable server gives a message; when it is back the store continues, and the lease is still
 * valid. */
static void a_server_that_died_is_found_again(void **state)
{
    (void)state;
    ll_lease l;
    ll_experiment_record r;
    ll_result_store *s = fresh();
    must(s->kind->claim(s, "x", "me", 60, &l));
    tell_server("kill", "");
    ll_status status = s->kind->record(s, "x", &r);
    assert_int_equal(status.code, LL_UNAVAILABLE);
    hand_in(s, &l, LL_UNAVAILABLE);
    tell_server("start", "");
    hand_in(s, &l, LL_OK);
    assert_int_equal(record(s).done, 4);
    ll_result_store_close(s);
}

static int start_server(void **state)
{
    (void)state;
    return ask_server(url, sizeof url, "start", "");
}

static int remove_server(void **state)
{
    (void)state;
    char answer[10];
    return ask_server(answer, sizeof answer, "remove", "");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest of_each_kind[] = {
        cmocka_unit_test(rows_come_back_whole),
        cmocka_unit_test(lost_leases_are_refused),
        cmocka_unit_test(a_chunk_that_kills_its_workers_is_given_up),
        cmocka_unit_test(states_hold_claims_back),
        cmocka_unit_test(the_same_again_is_a_resume),
        cmocka_unit_test(another_version_adds_nothing),
        cmocka_unit_test(an_age_is_by_the_clock_of_the_store),
        cmocka_unit_test(experiments_are_listed_as_they_were_made),
        cmocka_unit_test(a_class_key_has_as_many_as_it_may),
        cmocka_unit_test(experiments_share_workers_equally),
        cmocka_unit_test(a_single_worker_takes_turns),
    };
    const struct CMUnitTest of_postgres[] = {
        cmocka_unit_test(bad_servers_are_reported),
        cmocka_unit_test(a_newer_schema_is_refused),
        cmocka_unit_test(a_database_of_the_schema_before_is_brought_up),
        cmocka_unit_test(a_read_only_database_is_reported),
        cmocka_unit_test(a_server_that_died_is_found_again),
    };
    const struct CMUnitTest others[] = {
        cmocka_unit_test(bad_stores_are_reported),
        cmocka_unit_test(a_file_of_the_schema_before_is_brought_up),
        cmocka_unit_test(shards_share_all_runs),
        cmocka_unit_test(engines_tell_their_index),
        cmocka_unit_test(intervals_are_students),
    };
    if (argc == 1)
        return cmocka_run_group_tests(of_each_kind, NULL, NULL) + cmocka_run_group_tests(others, NULL, NULL);
    int made = ask_server(server, sizeof server, "make", "");
    if (made != 0)
        return made;
    return cmocka_run_group_tests_name(argv[1], of_each_kind, start_server, NULL) +
           cmocka_run_group_tests(of_postgres, NULL, remove_server);
}

/* The store: every row once, and chunks that are shared out. */
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
#include "experiment/store/read_only.h"
#include "experiment/store/result_store.h"
#include "support/near.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static const ll_experiment_record ten = {.id = "x", .to = 10};

static ll_result_store *fresh(void)
{
    ll_result_store *s;
    must(ll_result_store_open(":memory:", &s));
    must(ll_result_store_create(s, &ten, "{}", 4));
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

static void hand_in(ll_result_store *s, const ll_chunk *l, ll_code wanted)
{
    ll_row rows[4];
    for (int64_t i = l->from; i < l->to; i++)
        rows[i - l->from] = i == 5 ? row_with_a_sentence(i) : row(i);
    ll_status status = ll_result_store_finish(s, l, rows, 2);
    assert_int_equal(status.code, wanted);
}

static ll_experiment_record record(ll_result_store *s)
{
    ll_experiment_record r;
    must(ll_result_store_record(s, "x", &r));
    return r;
}

static void rows_come_back_whole(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_chunk l;
    for (int k = 0; k < 3; k++) {
        must(ll_result_store_claim(s, "x", &l));
        assert_int_equal(l.chunk, k);
        hand_in(s, &l, LL_OK);
    }
    must(ll_result_store_claim(s, "x", &l));
    assert_true(l.chunk < 0);
    assert_int_equal(record(s).state, LL_EXPERIMENT_DONE);
    ll_row rows[16];
    int count;
    must(ll_result_store_read(s, "x", 3, rows, 16, &count));
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

/* Two threads have different chunks; one that is returned, or whose rows cannot be stored, is free at once.
 */
static void a_chunk_is_claimed_once(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_chunk first, second, again;
    must(ll_result_store_claim(s, "x", &first));
    must(ll_result_store_claim(s, "x", &second));
    assert_true(first.chunk == 0 && second.chunk == 1);
    ll_result_store_return(s, &first);
    must(ll_result_store_claim(s, "x", &again));
    assert_int_equal(again.chunk, 0);
    hand_in(s, &again, LL_OK);
    ll_row there_already[4] = {row(0), row(1), row(2), row(3)};
    ll_status status = ll_result_store_finish(s, &second, there_already, 2);
    assert_int_equal(status.code, LL_IO);
    assert_int_equal(record(s).done, 4);
    must(ll_result_store_claim(s, "x", &again));
    assert_int_equal(again.chunk, 1);
    hand_in(s, &again, LL_OK);
    assert_int_equal(record(s).done, 8);
    ll_result_store_close(s);
}

static void states_hold_claims_back(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_chunk l;
    must(ll_result_store_set_state(s, "x", LL_EXPERIMENT_PAUSED));
    must(ll_result_store_claim(s, NULL, &l));
    assert_true(l.chunk < 0);
    must(ll_result_store_set_state(s, "x", LL_EXPERIMENT_RUNNING));
    must(ll_result_store_claim(s, NULL, &l));
    assert_int_equal(l.chunk, 0);
    must(ll_result_store_remove(s, "x"));
    hand_in(s, &l, LL_NOT_FOUND);
    ll_status status = ll_result_store_remove(s, "x");
    assert_int_equal(status.code, LL_NOT_FOUND);
    ll_result_store_close(s);
}

static void the_same_again_is_a_resume(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    ll_chunk l;
    must(ll_result_store_claim(s, "x", &l));
    hand_in(s, &l, LL_OK);
    must(ll_result_store_create(s, &ten, "{}", 4));
    assert_int_equal(record(s).done, 4);
    ll_status status = ll_result_store_create(s, &ten, "{\"other\":1}", 4);
    assert_int_equal(status.code, LL_CONFLICT);
    ll_result_store_close(s);
}

static void claim_nothing(ll_result_store *s)
{
    ll_chunk l;
    must(ll_result_store_claim(s, "x", &l));
    assert_true(l.chunk < 0);
    must(ll_result_store_claim(s, NULL, &l));
    assert_true(l.chunk < 0);
}

static void do_a_chunk(ll_result_store *s)
{
    ll_chunk l;
    must(ll_result_store_claim(s, "x", &l));
    hand_in(s, &l, LL_OK);
}

/* Makes a store with a stored chunk, and alters its file. */
static void make_altered(char *path, const char *sql)
{
    ll_result_store *s;
    sqlite3 *db;
    close(mkstemp(path));
    must(ll_result_store_open(path, &s));
    must(ll_result_store_create(s, &ten, "{}", 4));
    do_a_chunk(s);
    ll_result_store_close(s);
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    if (sqlite3_exec(db, sql, NULL, NULL, NULL) != SQLITE_OK)
        fail_msg("%s", sqlite3_errmsg(db));
    sqlite3_close(db);
}

static void another_version_adds_nothing(void **state)
{
    (void)state;
    char path[] = "/tmp/laglab-store-XXXXXX";
    ll_result_store *s;
    make_altered(path, "UPDATE experiment SET version='9.9.9+other'");
    must(ll_result_store_open(path, &s));
    claim_nothing(s);
    ll_experiment_record r = record(s);
    assert_string_equal(r.version, "9.9.9+other");
    ll_status status = ll_result_store_check_versions(s);
    assert_true(status.code == LL_CONFLICT && strstr(status.text, ll_version) &&
                strstr(status.text, "9.9.9+other") && strstr(status.text, "run the experiment again"));
    assert_int_equal(ll_result_store_create(s, &ten, "{}", 4).code, LL_CONFLICT);
    r.state = LL_EXPERIMENT_DONE;
    must(ll_result_store_check_version(&r));
    must(ll_result_store_remove(s, "x"));
    must(ll_result_store_check_versions(s));
    ll_result_store_close(s);
    unlink(path);
}

/* What a process that died had claimed is free again, and what it stored is there. */
static void what_was_claimed_is_free_after_a_death(void **state)
{
    (void)state;
    char path[] = "/tmp/laglab-store-XXXXXX";
    ll_result_store *s;
    close(mkstemp(path));
    pid_t child = fork();
    if (child == 0) {
        must(ll_result_store_open(path, &s));
        must(ll_result_store_create(s, &ten, "{}", 4));
        do_a_chunk(s);
        ll_chunk l;
        must(ll_result_store_claim(s, "x", &l));
        _exit(0);
    }
    int how;
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_int_equal(how, 0);
    must(ll_result_store_open(path, &s));
    ll_chunk l;
    must(ll_result_store_claim(s, "x", &l));
    assert_int_equal(l.chunk, 1);
    assert_int_equal(record(s).done, 4);
    ll_result_store_close(s);
    unlink(path);
}

static void a_store_is_of_one_process(void **state)
{
    (void)state;
    char path[] = "/tmp/laglab-store-XXXXXX";
    ll_result_store *s, *other;
    close(mkstemp(path));
    must(ll_result_store_open(path, &s));
    ll_status status = ll_result_store_open(path, &other);
    assert_true(status.code == LL_IO && strstr(status.text, "in use by another program"));
    ll_result_store_close(s);
    must(ll_result_store_open(path, &s));
    ll_result_store_close(s);
    unlink(path);
}

/* Stores of earlier schemas go on: 2 had leases, 1 had no versions either, so that its content can be read,
 * but not continued. */
#define SCHEMA_2                                                                                             \
    "ALTER TABLE chunk ADD COLUMN attempt INTEGER NOT NULL DEFAULT 0; ALTER TABLE chunk ADD COLUMN owner "   \
    "TEXT; ALTER TABLE chunk ADD COLUMN lease_until REAL; UPDATE chunk SET state=1 WHERE chunk=1; PRAGMA "   \
    "user_version=2;"

static void earlier_schemas_are_brought_up(void **state)
{
    (void)state;
    char second[] = "/tmp/laglab-store-XXXXXX", first[] = "/tmp/laglab-store-XXXXXX";
    ll_result_store *s;
    ll_row rows[4];
    ll_chunk l;
    int count;
    make_altered(second, SCHEMA_2);
    must(ll_result_store_open(second, &s));
    must(ll_result_store_claim(s, "x", &l));
    assert_int_equal(l.chunk, 1);
    hand_in(s, &l, LL_OK);
    do_a_chunk(s);
    assert_int_equal(record(s).state, LL_EXPERIMENT_DONE);
    ll_result_store_close(s);
    unlink(second);
    make_altered(first, SCHEMA_2 "ALTER TABLE experiment DROP COLUMN version; PRAGMA user_version=1");
    must(ll_result_store_open(first, &s));
    ll_experiment_record r = record(s);
    assert_true(r.version[0] == '\0' && r.done == 4);
    must(ll_result_store_read(s, "x", 0, rows, 4, &count));
    assert_int_equal(count, 4);
    claim_nothing(s);
    ll_status status = ll_result_store_check_version(&r);
    assert_true(status.code == LL_CONFLICT && strstr(status.text, "an unknown version"));
    ll_result_store_close(s);
    unlink(first);
}

static void an_age_is_that_since_its_creation(void **state)
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
    ll_chunk l;
    must(ll_result_store_create(s, &first, "{\"b\":1}", 4));
    must(ll_result_store_create(s, &second, "{}", 4));
    must(ll_result_store_list(s, note_id, seen));
    assert_string_equal(seen, "x b0a a ");
    must(ll_result_store_specification(s, "b", &text));
    assert_string_equal(text, "{\"b\":1}");
    free(text);
    must(ll_result_store_claim(s, "b", &l));
    assert_true(l.from == 3 && l.to == 4);
    ll_result_store_return(s, &l);
    assert_int_equal(ll_result_store_specification(s, "nosuch", &text).code, LL_NOT_FOUND);
    must(ll_result_store_remove(s, "a"));
    must(ll_result_store_remove(s, "b"));
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
    must(ll_result_store_create(s, &a, "{}", 4));
    assert_int_equal(ll_result_store_create(s, &b, "{}", 4).code, LL_LIMIT);
    assert_int_equal(ll_result_store_record(s, "b", &got).code, LL_NOT_FOUND);
    must(ll_result_store_create(s, &c, "{}", 4));
    must(ll_result_store_list(s, note_key, seen));
    assert_string_equal(seen, "x , a north, c south, ");
    must(ll_result_store_remove(s, "a"));
    must(ll_result_store_create(s, &b, "{}", 4));
    must(ll_result_store_record(s, "b", &got));
    assert_string_equal(got.class_key, "north");
    must(ll_result_store_remove(s, "b"));
    must(ll_result_store_remove(s, "c"));
    ll_result_store_close(s);
}

/* Claims a chunk of any experiment and expects it of this one. */
static ll_chunk claim_of(ll_result_store *s, const char *id)
{
    ll_chunk l;
    must(ll_result_store_claim(s, NULL, &l));
    assert_string_equal(l.id, id);
    return l;
}

static void experiments_share_threads_equally(void **state)
{
    (void)state;
    ll_result_store *s = fresh(); /* x has three chunks */
    static const ll_experiment_record second = {.id = "y", .to = 30}, third = {.id = "z", .to = 30};
    must(ll_result_store_create(s, &second, "{}", 3));
    must(ll_result_store_create(s, &third, "{}", 3));
    /* Threads that come one after the other go to whom fewest work for. */
    ll_chunk x = claim_of(s, "x"), y = claim_of(s, "y"), z = claim_of(s, "z");
    claim_of(s, "x");
    claim_of(s, "y");
    hand_in(s, &z, LL_OK);
    z = claim_of(s, "z");
    hand_in(s, &z, LL_OK);
    claim_of(s, "z");
    claim_of(s, "z");
    /* One that is paused has no turn; one that has no chunk left has none either. */
    must(ll_result_store_set_state(s, "y", LL_EXPERIMENT_PAUSED));
    hand_in(s, &y, LL_OK);
    hand_in(s, &x, LL_OK);
    claim_of(s, "x");
    claim_of(s, "z");
    must(ll_result_store_set_state(s, "y", LL_EXPERIMENT_RUNNING));
    claim_of(s, "y");
    must(ll_result_store_remove(s, "y"));
    must(ll_result_store_remove(s, "z"));
    ll_result_store_close(s);
}

/* A single thread takes them in turn, however long each is. */
static void a_single_thread_takes_turns(void **state)
{
    (void)state;
    ll_result_store *s = fresh();
    static const ll_experiment_record second = {.id = "y", .to = 30};
    must(ll_result_store_create(s, &second, "{}", 3));
    for (int k = 0; k < 6; k++) {
        ll_chunk l = claim_of(s, k % 2 ? "y" : "x");
        assert_int_equal(l.chunk, k / 2);
        hand_in(s, &l, LL_OK);
    }
    ll_chunk l = claim_of(s, "y");
    hand_in(s, &l, LL_OK);
    must(ll_result_store_remove(s, "y"));
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
        assert_near(ll_interval_95(known[i].df + 1, (n - 1) * n) / known[i].t, 1, 1e-5);
    }
}

/* A path of signs that are escaped, each as three, longer than any that is opened. */
static void a_path_without_end_is_not_opened(void **state)
{
    (void)state;
    static char path[20000];
    memset(path, '%', sizeof path - 1);
    sqlite3 *db = NULL;
    assert_false(ll_open_read_only(path, &db));
    sqlite3_close(db);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_come_back_whole),
        cmocka_unit_test(a_chunk_is_claimed_once),
        cmocka_unit_test(states_hold_claims_back),
        cmocka_unit_test(the_same_again_is_a_resume),
        cmocka_unit_test(another_version_adds_nothing),
        cmocka_unit_test(what_was_claimed_is_free_after_a_death),
        cmocka_unit_test(a_store_is_of_one_process),
        cmocka_unit_test(earlier_schemas_are_brought_up),
        cmocka_unit_test(an_age_is_that_since_its_creation),
        cmocka_unit_test(experiments_are_listed_as_they_were_made),
        cmocka_unit_test(a_class_key_has_as_many_as_it_may),
        cmocka_unit_test(experiments_share_threads_equally),
        cmocka_unit_test(a_single_thread_takes_turns),
        cmocka_unit_test(bad_stores_are_reported),
        cmocka_unit_test(shards_share_all_runs),
        cmocka_unit_test(engines_tell_their_index),
        cmocka_unit_test(intervals_are_students),
        cmocka_unit_test(a_path_without_end_is_not_opened),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

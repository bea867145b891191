/* The store's leases: every row once, whoever comes late. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <sqlite3.h>

#include "experiment/result_store.h"
#include "experiment/shard.h"
#include "experiment/table.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static const ll_experiment_record ten = {.id = "x", .to = 10};

static ll_result_store *memory(void)
{
    ll_result_store *s;
    must(ll_result_store_open("sqlite::memory:", &s));
    must(s->kind->create(s, &ten, "{}", 4));
    return s;
}

static ll_row row(int64_t run)
{
    ll_row r = {
        .run = run, .hash = (uint64_t)run * 0x9e3779b97f4a7c15u, .t_s = 1.5, .metrics = {run / 3.0, NAN}};
    return r;
}

static void hand_in(ll_result_store *s, const ll_lease *l, ll_code wanted)
{
    ll_row rows[4];
    for (int64_t i = l->from; i < l->to; i++)
        rows[i - l->from] = row(i);
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
    ll_result_store *s = memory();
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
        ll_row wanted = row(3 + i);
        assert_true(rows[i].run == wanted.run && rows[i].hash == wanted.hash && rows[i].t_s == wanted.t_s);
        assert_true(rows[i].metrics[0] == wanted.metrics[0] && isnan(rows[i].metrics[1]) &&
                    isnan(rows[i].metrics[2]));
    }
    ll_result_store_close(s);
}

/* A worker freezes beyond its lease, another does its chunk, it wakes and hands in: refused, and no row
 * twice. */
static void who_lost_its_lease_is_refused(void **state)
{
    (void)state;
    ll_result_store *s = memory();
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
    ll_result_store *s = memory();
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
    ll_result_store *s = memory();
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
    ll_result_store *s = memory();
    ll_lease l;
    must(s->kind->claim(s, "x", "me", 60, &l));
    hand_in(s, &l, LL_OK);
    must(s->kind->create(s, &ten, "{}", 4));
    assert_int_equal(record(s).done, 4);
    ll_status status = s->kind->create(s, &ten, "{\"other\":1}", 4);
    assert_int_equal(status.code, LL_CONFLICT);
    ll_result_store_close(s);
}

static void bad_stores_are_told(void **state)
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
    fputs("run,point\r\n0,0\r\n this is no database but a file of text, longer than a header of SQLite's, so "
          "much so",
          file);
    fclose(file);
    status = ll_result_store_open(path, &s);
    assert_true(status.code == LL_IO && strstr(status.text, "no SQLite database"));
    unlink(path);
    status = ll_result_store_open("/nosuch/folder/x.db", &s);
    assert_true(status.code == LL_IO && strstr(status.text, "/nosuch/folder/x.db"));
    status = ll_result_store_open("mysql://host/db", &s);
    assert_true(status.code == LL_BAD_INPUT && strstr(status.text, "mysql://host/db"));
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_come_back_whole),
        cmocka_unit_test(who_lost_its_lease_is_refused),
        cmocka_unit_test(a_chunk_that_kills_its_workers_is_given_up),
        cmocka_unit_test(states_hold_claims_back),
        cmocka_unit_test(the_same_again_is_a_resume),
        cmocka_unit_test(bad_stores_are_told),
        cmocka_unit_test(shards_share_all_runs),
        cmocka_unit_test(engines_tell_their_index),
        cmocka_unit_test(intervals_are_students),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The store: durable data is there again; errors of opening and writing have a message. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pthread.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>

#include "daemon/store/store.h"

typedef struct fixture {
    char folder[64];
    ll_stored found[8];
    int count;
} fixture;

static int make_folder(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/laglab-store-XXXXXX");
    *state = f;
    return mkdtemp(f->folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    static const char *const names[] = {"laglab.db", "laglab.db-wal", "laglab.db-shm", "lock"};
    fixture *f = *state;
    char path[128];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(path, sizeof path, "%s/%s", f->folder, names[i]);
        unlink(path);
    }
    rmdir(f->folder);
    free(f);
    return 0;
}

static ll_store *open_store(const fixture *f)
{
    ll_store *store = NULL;
    ll_status status = ll_store_open(f->folder, &store);
    assert_string_equal(status.text, "");
    assert_non_null(store);
    return store;
}

static ll_stored row(ll_store *store, const char *id)
{
    ll_stored stored = {.key_count = 2, .playing = true, .speed = 0.5, .tick = 7, .head_tick = 9};
    stored.number = ll_store_new_number(store);
    snprintf(stored.id, sizeof stored.id, "%s", id);
    snprintf(stored.code, sizeof stored.code, "ABCD");
    memset(stored.keys, 0x5a, 2 * sizeof stored.keys[0]);
    return stored;
}

static void keep(void *context, const ll_stored *stored)
{
    fixture *f = context;
    f->found[f->count++] = *stored;
}

static void list(fixture *f, ll_store *store)
{
    f->count = 0;
    ll_status status = ll_store_list(store, keep, f);
    assert_false(ll_failed(&status));
}

static void durable_data_is_restored(void **state)
{
    fixture *f = *state;
    ll_store *store = open_store(f);
    ll_stored one = row(store, "one"), two = row(store, "two");
    ll_store_put(store, &one);
    ll_store_put(store, &two);
    ll_store_line(store, one.number, 0, "{\"a\":1}", 7);
    ll_store_line(store, two.number, 0, "{\"b\":1}", 7);
    ll_store_line(store, one.number, 1, "{\"a\":2}", 7);
    one.tick = 70;
    ll_store_put(store, &one);
    uint64_t ticket = ll_store_delete(store, two.number);
    ll_status status = ll_store_wait(store, ticket);
    assert_false(ll_failed(&status));
    assert_true(ll_store_durable(store) >= ticket);
    status = ll_store_close(store);
    assert_false(ll_failed(&status));

    store = open_store(f);
    list(f, store);
    assert_int_equal(f->count, 1);
    assert_string_equal(f->found[0].id, "one");
    assert_int_equal(f->found[0].tick, 70);
    assert_int_equal(f->found[0].lines, 2);
    assert_int_equal(f->found[0].key_count, 2);
    assert_memory_equal(f->found[0].keys, one.keys, 2 * sizeof one.keys[0]);
    char *text;
    size_t length;
    status = ll_store_read_log(store, one.number, &text, &length);
    assert_false(ll_failed(&status));
    assert_string_equal(text, "{\"a\":1}\n{\"a\":2}\n");
    free(text);
    status = ll_store_read_log(store, two.number, &text, &length);
    assert_true(ll_failed(&status));
    assert_true(ll_store_new_number(store) > one.number);
    ll_store_close(store);
}

static void a_folder_belongs_to_one(void **state)
{
    fixture *f = *state;
    ll_store *store = open_store(f), *other;
    ll_status status = ll_store_open(f->folder, &other);
    assert_int_equal(status.code, LL_IO);
    assert_non_null(strstr(status.text, "in use"));
    assert_null(other);
    ll_store_close(store);
}

static void run_sql(const fixture *f, const char *sql)
{
    char path[128];
    sqlite3 *db;
    snprintf(path, sizeof path, "%s/laglab.db", f->folder);
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
}

static void refused(const fixture *f, const char *word)
{
    ll_store *store;
    ll_status status = ll_store_open(f->folder, &store);
    assert_int_equal(status.code, LL_IO);
    if (!strstr(status.text, word))
        fail_msg("`%s` lacks `%s`", status.text, word);
}

static void a_newer_schema_and_a_damaged_file_are_refused(void **state)
{
    fixture *f = *state;
    ll_store_close(open_store(f));
    run_sql(f, "PRAGMA user_version=99");
    refused(f, "newer laglab");
    char path[128];
    snprintf(path, sizeof path, "%s/laglab.db", f->folder);
    FILE *file = fopen(path, "w");
    fputs("this is no database, in spite of its name; it is long enough to be taken for one by its size "
          "alone ......",
          file);
    fclose(file);
    refused(f, "damaged");
    unlink(path);
}

static void a_folder_that_cannot_be_is_refused(void **state)
{
    (void)state;
    fixture no = {.folder = "/proc/nothing/here"};
    refused(&no, "Cannot create");
}

static void limit_files(rlim_t size)
{
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = size;
    setrlimit(RLIMIT_FSIZE, &limit);
}

static void count_told(void *context)
{
    __atomic_fetch_add((int *)context, 1, __ATOMIC_SEQ_CST);
}

static void a_disk_that_is_full_for_a_while(void **state)
{
    fixture *f = *state;
    int told = 0;
    signal(SIGXFSZ, SIG_IGN);
    ll_store *store = open_store(f);
    ll_store_on_commit(store, count_told, &told);
    ll_stored one = row(store, "one");
    ll_store_wait(store, ll_store_put(store, &one));
    assert_false(ll_store_failing(store, NULL));

    limit_files(0);
    uint64_t first = ll_store_line(store, one.number, 0, "first", 5);
    ll_status status = ll_store_wait(store, first), why;
    assert_int_equal(status.code, LL_IO);
    assert_non_null(strstr(status.text, f->folder));
    assert_true(ll_store_failing(store, &why));
    uint64_t second = ll_store_line(store, one.number, 1, "second", 6);
    status = ll_store_wait(store, second);
    assert_true(ll_failed(&status));
    assert_true(ll_store_durable(store) < first);
    status = ll_store_check(store);
    assert_int_equal(status.code, LL_IO);
    /* What is not tried again: a class, and a deletion that a client waits for. */
    assert_int_equal(ll_store_put_text(store, LL_STORE_CLASS, "class", 1, "{}"), 0);
    status = ll_store_wait_tried(store, ll_store_try_delete(store, one.number));
    assert_true(ll_failed(&status));

    limit_files(RLIM_INFINITY);
    for (int i = 0;
         i < 6000 && (ll_store_failing(store, NULL) || __atomic_load_n(&told, __ATOMIC_SEQ_CST) < 3); i++)
        usleep(10000);
    status = ll_store_wait(store, second);
    assert_false(ll_failed(&status));
    assert_true(__atomic_load_n(&told, __ATOMIC_SEQ_CST) >= 3);
    assert_true(ll_store_get_stats(store).failures >= 1);
    assert_int_equal(ll_store_get_stats(store).refused, 4);
    assert_int_equal(ll_store_get_stats(store).queued, 0);
    char *text;
    size_t length;
    status = ll_store_read_log(store, one.number, &text, &length);
    assert_string_equal(text, "first\nsecond\n");
    free(text);
    ll_store_close(store);
}

typedef struct texts {
    char ids[4][8], texts[4][32];
    int64_t seen_ms[4];
    int count;
} texts;

static void take_text(void *context, const char *id, int64_t seen_ms, const char *text)
{
    texts *t = context;
    assert_true(t->count < 4);
    snprintf(t->ids[t->count], sizeof t->ids[0], "%s", id);
    snprintf(t->texts[t->count], sizeof t->texts[0], "%s", text);
    t->seen_ms[t->count++] = seen_ms;
}

static texts list_texts(ll_store *store, ll_store_text kind)
{
    texts t = {0};
    ll_status status = ll_store_list_texts(store, kind, take_text, &t);
    assert_string_equal(status.text, "");
    return t;
}

static void texts_of_each_kind_are_there_again(void **state)
{
    fixture *f = *state;
    ll_store *store = open_store(f);
    ll_store_put_text(store, LL_STORE_CLASS, "a", 5, "class a");
    ll_store_put_text(store, LL_STORE_MEASUREMENT, "a", 6, "measurement a");
    ll_store_put_text(store, LL_STORE_MEASUREMENT, "b", 7, "measurement b");
    ll_store_put_text(store, LL_STORE_MEASUREMENT, "a", 8, "more of a");
    ll_store_delete_text(store, LL_STORE_CLASS, "b"); /* no class */
    ll_store_wait(store, ll_store_delete_text(store, LL_STORE_MEASUREMENT, "b"));
    ll_store_close(store);
    store = open_store(f);
    texts classes = list_texts(store, LL_STORE_CLASS), measurements = list_texts(store, LL_STORE_MEASUREMENT);
    assert_true(classes.count == 1 && measurements.count == 1);
    assert_string_equal(classes.texts[0], "class a");
    assert_string_equal(measurements.texts[0], "more of a");
    assert_true(classes.seen_ms[0] == 5 && measurements.seen_ms[0] == 8);
    ll_store_close(store);
}

enum { WRITERS = 4, LINES = 500 };

typedef struct writer {
    ll_store *store;
    int64_t number;
} writer;

static void *write_lines(void *argument)
{
    writer *w = argument;
    for (int i = 0; i < LINES; i++) {
        char line[32];
        int length = snprintf(line, sizeof line, "%d", i);
        uint64_t ticket = ll_store_line(w->store, w->number, i, line, (size_t)length);
        if (i % 10 == 0) {
            ll_status status = ll_store_wait(w->store, ticket);
            assert_false(ll_failed(&status));
        }
    }
    return NULL;
}

static void many_writers(void **state)
{
    fixture *f = *state;
    ll_store *store = open_store(f);
    pthread_t threads[WRITERS];
    writer writers[WRITERS];
    for (int i = 0; i < WRITERS; i++) {
        char id[16];
        snprintf(id, sizeof id, "w%d", i);
        ll_stored stored = row(store, id);
        ll_store_put(store, &stored);
        writers[i] = (writer){store, stored.number};
        pthread_create(&threads[i], NULL, write_lines, &writers[i]);
    }
    for (int i = 0; i < WRITERS; i++)
        pthread_join(threads[i], NULL);
    int64_t commits = ll_store_get_stats(store).commits;
    assert_true(commits < WRITERS * LINES); /* committed in groups */
    ll_store_close(store);
    store = open_store(f);
    list(f, store);
    assert_int_equal(f->count, WRITERS);
    for (int i = 0; i < WRITERS; i++)
        assert_int_equal(f->found[i].lines, LINES);
    ll_store_close(store);
}

static void a_batch_is_stored_as_one(void **state)
{
    fixture *f = *state;
    ll_store *store = open_store(f);
    ll_stored one = row(store, "one"), two = row(store, "two");
    ll_store_batch batch = {0};
    ll_store_batch_line(&batch, one.number, 0, "first", 5);
    ll_store_batch_line(&batch, one.number, 1, "second", 6);
    ll_store_batch_put(&batch, &one);
    uint64_t ticket = ll_store_submit(store, &batch);
    assert_null(batch.first);
    ll_status status = ll_store_wait(store, ticket);
    assert_false(ll_failed(&status));
    assert_true(ll_store_durable(store) >= ticket);
    ll_store_stats stats = ll_store_get_stats(store);
    int64_t timed = 0;
    for (int i = 0; i < LL_STORE_TIMES; i++)
        timed += stats.times[i];
    assert_int_equal(stats.commits, 1);
    assert_int_equal(timed, 1);
    assert_true(stats.commit_s > 0);
    ll_store_batch_line(&batch, two.number, 0, "dropped", 7);
    ll_store_batch_free(&batch);
    assert_int_equal(ll_store_submit(store, &batch), 0);
    list(f, store);
    assert_int_equal(f->count, 1);
    assert_int_equal(f->found[0].lines, 2);
    ll_store_close(store);
}

static void no_store_keeps_nothing_and_never_fails(void **state)
{
    (void)state;
    ll_stored stored = {.number = 1};
    ll_status status = ll_store_wait(NULL, ll_store_put(NULL, &stored));
    assert_false(ll_failed(&status));
    assert_false(ll_store_failing(NULL, NULL));
    status = ll_store_close(NULL);
    assert_false(ll_failed(&status));
}

int main(void)
{
#define WITH_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(durable_data_is_restored),
        WITH_FOLDER(a_folder_belongs_to_one),
        WITH_FOLDER(a_newer_schema_and_a_damaged_file_are_refused),
        cmocka_unit_test(a_folder_that_cannot_be_is_refused),
        WITH_FOLDER(a_disk_that_is_full_for_a_while),
        WITH_FOLDER(texts_of_each_kind_are_there_again),
        WITH_FOLDER(many_writers),
        WITH_FOLDER(a_batch_is_stored_as_one),
        cmocka_unit_test(no_store_keeps_nothing_and_never_fails),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

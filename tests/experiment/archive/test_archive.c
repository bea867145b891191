/* Archives: the same rows give the same bytes, another machine finds them equal, and damage and changes are
 * found. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "experiment/archive/internal.h"
#include "experiment/fixture.h"
#include "experiment/run/work.h"

enum { RUNS = 6, BYTES_MAX = 4 << 20 };

static const char specification[] =
    "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":1,\"methods\":[{\"method\":"
    "\"rk4\"}]},"
    "\"axes\":[{\"path\":\"methods.0.dt_s\",\"values\":[0.01,0.02,0.05]}],\"repeats\":2,\"title\":\"Kepler\","
    "\"windows\":[{\"name\":\"late\",\"from_s\":0.5}],"
    "\"metrics\":[\"methods.0.e_max\",\"0_error.max@late\",\"methods.0.evaluations\"]}";

#define CONTAINER "sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"

/* Stores the rows of the experiment; `change` alters one before. */
static ll_result_store *store_of(void (*change)(ll_row *row), char id[LL_EXPERIMENT_ID_MAX + 1])
{
    ll_result_store *store;
    ll_experiment *e = experiment(specification);
    ll_row rows[RUNS];
    ll_lease lease;
    must(ll_result_store_open(":memory:", &store));
    must(ll_experiment_register(store, e, 0, RUNS, 0, id));
    for (;;) {
        must(store->kind->claim(store, id, "test", 1e6, &lease));
        if (lease.chunk < 0)
            break;
        for (int64_t run = lease.from; run < lease.to; run++) {
            must(ll_experiment_run(e, run, NULL, NULL, &rows[run - lease.from]));
            if (change)
                change(&rows[run - lease.from]);
        }
        must(store->kind->finish(store, &lease, rows, lease.to - lease.from, e->metric_count));
    }
    ll_experiment_free(e);
    return store;
}

static char folder[] = "/tmp/laglab-archive-XXXXXX";
static char path[64], other[64];

static void write_archive(void (*change)(ll_row *row), const char *to)
{
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_result_store *store = store_of(change, id);
    must(ll_archive_write(store, id, CONTAINER, to));
    ll_result_store_close(store);
}

static size_t read_file(const char *from, char *bytes)
{
    FILE *file = fopen(from, "rb");
    assert_non_null(file);
    size_t size = fread(bytes, 1, BYTES_MAX, file);
    assert_true(size > 0 && size < BYTES_MAX);
    fclose(file);
    return size;
}

static void write_file(const char *to, const char *bytes, size_t size)
{
    FILE *file = fopen(to, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

typedef struct told {
    char text[2000];
} told;

static void note(void *context, const char *difference)
{
    told *t = context;
    size_t used = strlen(t->text);
    snprintf(t->text + used, sizeof t->text - used, "%s\n", difference);
}

static ll_status verify(const char *from, int64_t rows, told *t, ll_archive_result *result)
{
    t->text[0] = '\0';
    ll_archive_check check = {.rows = rows, .seed = 7, .tell = note, .context = t};
    return ll_archive_verify(from, &check, result);
}

static int set_up(void **state)
{
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a.tar", folder);
    snprintf(other, sizeof other, "%s/b.tar", folder);
    write_archive(NULL, path);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    unlink(path);
    unlink(other);
    return rmdir(folder);
}

static void a_good_archive_is_found_equal(void **state)
{
    (void)state;
    told t;
    ll_archive_result r;
    must(verify(path, 0, &t, &r));
    assert_string_equal(t.text, "");
    assert_true(r.rows == RUNS && r.compared == RUNS && r.equal == RUNS && r.differences == 0);
    assert_true(r.report_compared && r.skipped == 0 && r.measured == 0);
    assert_string_equal(r.version, ll_version);
    assert_string_equal(r.container, CONTAINER);
    must(verify(path, 2, &t, &r));
    assert_true(r.compared == 2 && r.equal == 2);
}

static void the_same_rows_give_the_same_bytes(void **state)
{
    (void)state;
    char *a = malloc(BYTES_MAX), *b = malloc(BYTES_MAX);
    write_archive(NULL, other);
    size_t size = read_file(path, a);
    assert_int_equal(read_file(other, b), size);
    assert_memory_equal(a, b, size);
    free(a);
    free(b);
}

static void off_by_a_bit(ll_row *row)
{
    if (row->run == 3)
        row->metrics[1] = nextafter(row->metrics[1], INFINITY);
}

/* All digests of it are right. */
static void a_row_with_another_bit_is_named(void **state)
{
    (void)state;
    told t;
    ll_archive_result r;
    write_archive(off_by_a_bit, other);
    must(verify(other, 0, &t, &r));
    assert_true(r.differences == 1 && r.equal == RUNS - 1 && r.compared == RUNS);
    assert_true(strncmp(t.text, "run 3: 0_error.max@late is ", 27) == 0);
}

static void another_end(ll_row *row)
{
    if (row->run == 2) {
        row->hash ^= 1;
        row->status = LL_ROW_STOPPED;
    }
}

static void a_row_with_another_end_is_named(void **state)
{
    (void)state;
    told t;
    ll_archive_result r;
    write_archive(another_end, other);
    must(verify(other, 0, &t, &r));
    assert_true(r.differences == 2 && r.equal == RUNS - 1);
    assert_non_null(strstr(t.text, "run 2: its status is stopped in the archive, ok here"));
    assert_non_null(strstr(t.text, "run 2: its hash is "));
}

/* ---- archives made by hand ---- */

typedef struct parts {
    FILE *files[LL_ARCHIVE_FILES];
    ll_archive_entry entries[LL_ARCHIVE_FILES];
} parts;

static parts take_apart(void)
{
    parts p = {{NULL}, {{0}}};
    ll_tar_member members[LL_TAR_MEMBERS_MAX];
    int count;
    FILE *archive = fopen(path, "rb");
    must(ll_tar_list(archive, members, &count));
    assert_int_equal(count, LL_ARCHIVE_FILES);
    for (int i = 0; i < count; i++) {
        char *bytes = malloc((size_t)members[i].size);
        fseeko(archive, members[i].offset, SEEK_SET);
        assert_int_equal(fread(bytes, 1, (size_t)members[i].size, archive), members[i].size);
        p.files[i] = tmpfile();
        fwrite(bytes, 1, (size_t)members[i].size, p.files[i]);
        free(bytes);
    }
    fclose(archive);
    return p;
}

/* With digests and a manifest that fit. Closes the files. */
static void put_together(parts *p, const char *version)
{
    ll_experiment *e = experiment(specification);
    static const ll_archive_file order[] = {
        LL_ARCHIVE_SPECIFICATION, LL_ARCHIVE_CSV,      LL_ARCHIVE_ROWS,   LL_ARCHIVE_REPORT,
        LL_ARCHIVE_CITATION,      LL_ARCHIVE_MANIFEST, LL_ARCHIVE_DIGESTS};
    for (int i = 0; i < LL_ARCHIVE_FILES; i++) {
        ll_archive_file k = order[i];
        const ll_archive_about about = {version, "", p->entries};
        if (k == LL_ARCHIVE_MANIFEST || k == LL_ARCHIVE_DIGESTS) {
            fclose(p->files[k]);
            p->files[k] = tmpfile();
        }
        if (k == LL_ARCHIVE_MANIFEST)
            must(ll_archive_put_manifest(e, &about, p->files[k]));
        if (k == LL_ARCHIVE_DIGESTS)
            ll_archive_put_digests(p->entries, p->files[k]);
        fflush(p->files[k]);
        fseeko(p->files[k], 0, SEEK_END);
        p->entries[k].size = ftello(p->files[k]);
        must(ll_sha256_file(p->files[k], 0, p->entries[k].size, p->entries[k].sha256));
    }
    FILE *archive = fopen(other, "wb");
    must(ll_tar_write(archive, ll_archive_names, p->files, LL_ARCHIVE_FILES));
    fclose(archive);
    for (int i = 0; i < LL_ARCHIVE_FILES; i++)
        fclose(p->files[i]);
    ll_experiment_free(e);
}

static void a_table_that_is_not_that_of_the_rows_is_found(void **state)
{
    (void)state;
    static const ll_archive_file derived[] = {LL_ARCHIVE_CSV, LL_ARCHIVE_REPORT};
    for (int i = 0; i < 2; i++) {
        told t;
        char name[64];
        ll_archive_result r;
        parts p = take_apart();
        fseeko(p.files[derived[i]], 100, SEEK_SET);
        int was = fgetc(p.files[derived[i]]);
        fseeko(p.files[derived[i]], 100, SEEK_SET);
        fputc(was ^ 1, p.files[derived[i]]);
        put_together(&p, ll_version);
        must(verify(other, 1, &t, &r));
        assert_int_equal(r.differences, 1);
        snprintf(name, sizeof name, "%s differs from what follows from rows.bin, from byte 100",
                 ll_archive_names[derived[i]]);
        assert_non_null(strstr(t.text, name));
    }
}

static void another_version_is_named(void **state)
{
    (void)state;
    told t;
    ll_archive_result r;
    parts p = take_apart();
    put_together(&p, "0.1.9+0123456789ab");
    must(verify(other, 0, &t, &r));
    assert_true(r.differences == 2 && r.equal == RUNS && !r.report_compared);
    assert_non_null(strstr(t.text, "the archive is of laglab 0.1.9+0123456789ab, this is "));
    assert_non_null(strstr(t.text, "rows.csv differs")); /* it has the version of its rows */
}

static void refused(const char *from, const char *said)
{
    told t;
    ll_archive_result r;
    ll_status status = verify(from, 1, &t, &r);
    assert_int_equal(status.code, LL_BAD_INPUT);
    if (!strstr(status.text, said))
        fail_msg("%s: not %s", status.text, said);
}

/* A file that is missing, and one that nothing lists. */
static void only_the_files_of_an_archive_are_in_it(void **state)
{
    (void)state;
    static const char *const names[] = {"manifest.json", "else.json"};
    FILE *archive = fopen(other, "wb"), *content = tmpfile();
    fputs("{}", content);
    must(ll_tar_write(archive, names, &content, 1));
    fclose(archive);
    refused(other, "must have experiment.json as file 2");
    archive = fopen(other, "wb");
    must(ll_tar_write(archive, names + 1, &content, 1));
    fclose(archive);
    fclose(content);
    refused(other, "must have manifest.json as file 1; has else.json");
}

/* A bit anywhere: in headers, paddings, the manifest, the digests, the end. */
static void every_damaged_byte_is_found(void **state)
{
    (void)state;
    told t;
    ll_archive_result r;
    char *bytes = malloc(BYTES_MAX);
    size_t size = read_file(path, bytes);
    for (uint64_t i = 0; i < 400; i++) {
        /* the first, small files more often than the report */
        size_t most = i % 2 ? size : size < 12000 ? size : 12000;
        size_t at = (size_t)(ll_rng_unit(1, 0, i) * (double)most);
        char bit = (char)(1 << (int)(ll_rng_unit(1, 1, i) * 7));
        bytes[at] = (char)(bytes[at] ^ bit);
        write_file(other, bytes, size);
        ll_status status = verify(other, 1, &t, &r);
        if (!ll_failed(&status) || status.code != LL_BAD_INPUT || !status.text[0])
            fail_msg("byte %zu of %zu: %s", at, size, ll_failed(&status) ? status.text : "found sound");
        bytes[at] = (char)(bytes[at] ^ bit);
    }
    free(bytes);
}

static void every_truncation_is_found(void **state)
{
    (void)state;
    told t;
    ll_archive_result r;
    char *bytes = malloc(BYTES_MAX);
    size_t size = read_file(path, bytes);
    for (uint64_t i = 0; i < 100; i++) {
        size_t left = i < 20 ? size - 1 - (size_t)i * 100 : (size_t)(ll_rng_unit(2, 0, i) * (double)size);
        write_file(other, bytes, left);
        ll_status status = verify(other, 1, &t, &r);
        if (!ll_failed(&status) || status.code != LL_BAD_INPUT)
            fail_msg("%zu of %zu bytes: found sound", left, size);
    }
    memset(bytes + size, 'x', 1);
    write_file(other, bytes, size + 1);
    refused(other, "only zeros behind the last member");
    free(bytes);
}

/* ---- tar ---- */

/* Sets a field of the first header, and its checksum. */
static void forge(char *bytes, int at, const char *text, size_t length)
{
    unsigned sum = 0;
    memcpy(bytes + at, text, length);
    memset(bytes + 148, ' ', 8);
    for (int i = 0; i < LL_TAR_BLOCK; i++)
        sum += (unsigned char)bytes[i];
    snprintf(bytes + 148, 8, "%06o", sum);
}

static void hostile_headers_are_refused(void **state)
{
    (void)state;
    static const struct {
        int at;
        const char *text;
        size_t length;
        const char *said;
    } forms[] = {
        {0, "../manifest.json", 17, "name must be letters"},
        {0, "/etc/passwd", 12, "name must be letters"},
        {0, "a/../../b", 10, "name must be letters"},
        {0, "\x1b[31m", 6, "name must be letters"},
        {0, "", 1, "name must be letters"},
        {124, "77777777777", 12, "manifest.json should have 8589934591 bytes, but the file ends before"},
        {124, "\x80\0\0\0\0\0\0\xff\xff\xff\xff\xff", 12, "bytes, but the file ends before"},
        {124, "-0000000001", 12, "no tar file"},
        {156, "2", 1, "must be a plain file"}, /* a symbolic link */
        {156, "5", 1, "must be a plain file"}, /* a folder */
        {156, "L", 1, "name must be letters"}, /* GNU's long name: of the next member */
        {257, "gnutar", 6, "format ustar"},
        {345, "/tmp", 4, "name must be letters"},
    };
    char *bytes = malloc(BYTES_MAX), *good = malloc(BYTES_MAX);
    size_t size = read_file(path, good);
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        memcpy(bytes, good, size);
        forge(bytes, forms[i].at, forms[i].text, forms[i].length);
        write_file(other, bytes, size);
        refused(other, forms[i].said);
    }
    free(bytes);
    free(good);
    write_file(other, "", 0);
    refused(other, "it is empty");
    write_file(other, "not a tar file at all", 21);
    refused(other, "no tar file");
    refused("/nowhere/a.tar", "cannot read");
}

static void a_tar_gives_back_what_it_got(void **state)
{
    (void)state;
    static const int sizes[] = {0, 1, 511, 512, 513, 100000};
    static const char *const names[] = {"f0", "f1", "f2", "f3", "f4", "f5"};
    FILE *archive = fopen(other, "wb+"), *contents[6];
    for (int i = 0; i < 6; i++) {
        contents[i] = tmpfile();
        for (int k = 0; k < sizes[i]; k++)
            fputc('a' + i, contents[i]);
    }
    must(ll_tar_write(archive, names, contents, 6));
    for (int i = 0; i < 6; i++)
        fclose(contents[i]);
    ll_tar_member members[LL_TAR_MEMBERS_MAX];
    int count;
    must(ll_tar_list(archive, members, &count));
    assert_int_equal(count, 6);
    for (int i = 0; i < 6; i++) {
        assert_int_equal(members[i].size, sizes[i]);
        fseeko(archive, members[i].offset, SEEK_SET);
        for (int k = 0; k < sizes[i]; k++)
            assert_int_equal(fgetc(archive), 'a' + i);
    }
    fclose(archive);
}

static void an_unfinished_experiment_is_not_written(void **state)
{
    (void)state;
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_result_store *store;
    ll_experiment *e = experiment(specification);
    must(ll_result_store_open(":memory:", &store));
    must(ll_experiment_register(store, e, 0, RUNS, 0, id));
    ll_status status = ll_archive_write(store, id, NULL, other);
    assert_non_null(strstr(status.text, "must be done; is running with 0 of 6 runs"));
    must(ll_experiment_register(store, e, 0, 2, 0, id));
    status = ll_archive_write(store, id, NULL, other);
    assert_non_null(strstr(status.text, "must have all runs, 0 to 5; is the shard 0 to 1"));
    status = ll_archive_write(store, id, "sha256:12", other);
    assert_non_null(
        strstr(status.text, "container: must be sha256: and 64 hexadecimal digits; got sha256:12"));
    ll_result_store_close(store);
    ll_experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_good_archive_is_found_equal),
        cmocka_unit_test(the_same_rows_give_the_same_bytes),
        cmocka_unit_test(a_row_with_another_bit_is_named),
        cmocka_unit_test(a_row_with_another_end_is_named),
        cmocka_unit_test(a_table_that_is_not_that_of_the_rows_is_found),
        cmocka_unit_test(another_version_is_named),
        cmocka_unit_test(only_the_files_of_an_archive_are_in_it),
        cmocka_unit_test(every_damaged_byte_is_found),
        cmocka_unit_test(every_truncation_is_found),
        cmocka_unit_test(hostile_headers_are_refused),
        cmocka_unit_test(a_tar_gives_back_what_it_got),
        cmocka_unit_test(an_unfinished_experiment_is_not_written),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

/* Any shards, up to four in one input separated by 0x1e, to `laglab merge`. It must accept what a second,
 * naive merge accepts, with the same output: the header, then each run's line once, which must be as `sweep`
 * writes the row of that run. In a shard that begins with `@` that is replaced by the right header. */
#include "check.h"

#include <sys/mman.h>
#include <unistd.h>

#include "base/version.h"
#include "cli/verbs.h"
#include "experiment/format/formats.h"
#include "experiment/format/table.h"
#include "experiment/spec/experiment.h"

#define SHARDS 4
#define RUNS 4
#define FIELDS 11 /* run, point, repeat, seed, dt_s, status, error, hash, t_s, e_max, version */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char specification[] = "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_"
                                    "s\":1,\"methods\":[{\"method\":\"rk4\"}]},"
                                    "\"axes\":[{\"path\":\"methods.0.dt_s\",\"values\":[0.01,0.02]}],"
                                    "\"repeats\":2,\"metrics\":[\"methods.0.e_max\"]}";

static char *header;

static bool no_rows(void *context, ll_row *row, ll_status *status)
{
    (void)context, (void)row, (void)status;
    return false;
}

static void make_header(void)
{
    cJSON *json = cJSON_Parse(specification);
    ll_experiment *experiment;
    ll_result_table *table;
    size_t size;
    ll_status status = ll_experiment_parse(json, "scenarios", NULL, &experiment);
    FUZZ_CHECK(!fuzz_failed(&status) && experiment->runs == RUNS);
    status = ll_result_table_rows(experiment, ll_version, no_rows, NULL, &table);
    FUZZ_CHECK(!fuzz_failed(&status));
    FILE *memory = open_memstream(&header, &size);
    status = ll_format_find("csv", 3)->write(ll_result_table_get(table), memory);
    FUZZ_CHECK(!fuzz_failed(&status) && fclose(memory) == 0);
    FUZZ_CHECK(ll_result_table_get(table)->column_count == FIELDS);
    ll_result_table_free(table);
    ll_experiment_free(experiment);
    cJSON_Delete(json);
}

static int file_of(const void *bytes, size_t size, char path[64])
{
    int fd = memfd_create("shard", MFD_CLOEXEC);
    FUZZ_CHECK(fd >= 0 && (size == 0 || write(fd, bytes, size) == (ssize_t)size));
    snprintf(path, 64, "/proc/self/fd/%d", fd);
    return fd;
}

/* ---- the naive merge ---- */

typedef struct shard {
    char *text;
    size_t size;
} shard;

typedef struct merged {
    const char *line[RUNS]; /* each with its line end */
    size_t size[RUNS];
} merged;

/* Cuts at the commas outside of quotes; false: not FIELDS fields. */
static bool cut_fields(char *line, char *fields[FIELDS])
{
    int count = 0;
    bool quoted = false;
    fields[count++] = line;
    for (char *p = line; *p != '\0'; p++) {
        quoted ^= *p == '"';
        if (*p != ',' || quoted)
            continue;
        if (count == FIELDS)
            return false;
        *p = '\0';
        fields[count++] = p + 1;
    }
    return count == FIELDS && !quoted;
}

static bool is_formula(const char *text)
{
    char *end;
    strtod(text, &end);
    return *text == '=' || *text == '@' || *text == '\t' ||
           ((*text == '+' || *text == '-') && text[1] != '\0' && *end != '\0');
}

/* Bytes of the text of a field; -1: `sweep` writes that text otherwise. */
static int text_size(const char *field)
{
    char text[1 << 13];
    int size = 0;
    bool quoted = field[0] == '"';
    size_t length = strlen(field);
    if (quoted && (length < 2 || field[length - 1] != '"'))
        return -1;
    for (const char *p = field + quoted; *p != '\0' && !(quoted && p == field + length - 1); p++) {
        if (*p == '"' && (!quoted || p + 1 == field + length - 1 || *++p != '"'))
            return -1;
        text[size++] = *p;
    }
    text[size] = '\0';
    if (quoted != (strpbrk(text, ",\"") != NULL) || is_formula(text))
        return -1;
    return size - (text[0] == '\'' && is_formula(text + 1));
}

static bool is_number(const char *field)
{
    char text[64] = "";
    FILE *memory = fmemopen(text, sizeof text, "w");
    FUZZ_CHECK(memory != NULL);
    double value = strtod(field, NULL);
    ll_format_number(memory, value);
    fclose(memory);
    return field[0] == '\0' || (value == value && strcmp(field, text) == 0);
}

static bool is_row(int run, const char *line, size_t size)
{
    char copy[1 << 13], first[32], *f[FIELDS];
    snprintf(copy, sizeof copy, "%.*s", (int)size - 2, line);
    snprintf(first, sizeof first, "%d,%d,%d,%d,0.0%d,", run, run / 2, run % 2, run % 2 + 1, run / 2 + 1);
    if (strncmp(line, first, strlen(first)) != 0 || !cut_fields(copy, f))
        return false;
    bool known = false;
    for (int i = 0; i <= LL_ROW_SKIPPED; i++)
        known |= strcmp(f[5], ll_row_status_names[i]) == 0;
    int error = text_size(f[6]), version = text_size(f[10]);
    return known && error >= 0 && error < 200 && strlen(f[7]) == 16 &&
           strspn(f[7], "0123456789abcdef") == 16 && is_number(f[8]) && is_number(f[9]) && version > 0 &&
           version <= LL_VERSION_MAX;
}

/* The line's run; -1: not a row. */
static int run_of(const char *line, size_t size)
{
    if (size < 3 || memcmp(line + size - 2, "\r\n", 2) != 0 || memchr(line, '\0', size) != NULL ||
        memchr(line, '\r', size - 2) != NULL)
        return -1;
    int run = line[0] - '0';
    return run >= 0 && run < RUNS && is_row(run, line, size) ? run : -1;
}

static bool take_shard(const shard *s, merged *m)
{
    size_t at = strlen(header);
    if (s->size < at || memcmp(s->text, header, at) != 0)
        return false;
    while (at < s->size) {
        const char *line = s->text + at, *end = memchr(line, '\n', s->size - at);
        size_t size = end != NULL ? (size_t)(end - line) + 1 : s->size - at;
        int run = run_of(line, size);
        if (run < 0 ||
            (m->line[run] != NULL && (m->size[run] != size || memcmp(m->line[run], line, size) != 0)))
            return false;
        m->line[run] = line;
        m->size[run] = size;
        at += size;
    }
    return true;
}

static bool same_version(char *a, char *b)
{
    char *of_a[FIELDS], *of_b[FIELDS];
    return cut_fields(a, of_a) && cut_fields(b, of_b) && strcmp(of_a[FIELDS - 1], of_b[FIELDS - 1]) == 0;
}

/* The expected output, or NULL. */
static char *expected(const shard *shards, int count, size_t *size)
{
    merged m = {{NULL}, {0}};
    char *text = NULL, first[1 << 13], again[1 << 13], other[1 << 13];
    for (int i = 0; i < count; i++)
        if (!take_shard(&shards[i], &m))
            return NULL;
    FILE *memory = open_memstream(&text, size);
    bool good = true;
    fputs(header, memory);
    for (int i = 0; i < RUNS; i++) {
        good = good && m.line[i] != NULL;
        if (!good)
            break;
        snprintf(i == 0 ? first : other, sizeof other, "%.*s", (int)m.size[i], m.line[i]);
        snprintf(again, sizeof again, "%s", first);
        good = i == 0 || same_version(again, other);
        fwrite(m.line[i], 1, m.size[i], memory);
    }
    fclose(memory);
    if (good)
        return text;
    free(text);
    return NULL;
}

/* ---- splitting an input ---- */

static int cut(const uint8_t *data, size_t size, shard shards[SHARDS])
{
    int count = 0;
    size_t at = 0;
    while (count < SHARDS && at <= size) {
        const uint8_t *end = count + 1 < SHARDS ? memchr(data + at, 0x1e, size - at) : NULL;
        size_t length = end != NULL ? (size_t)(end - data) - at : size - at;
        bool right = length > 0 && data[at] == '@';
        size_t head = right ? strlen(header) : 0, skip = right ? 1 : 0;
        shard *s = &shards[count++];
        s->size = head + length - skip;
        s->text = malloc(s->size + 1);
        FUZZ_CHECK(s->text != NULL);
        memcpy(s->text, header, head);
        memcpy(s->text + head, data + at + skip, length - skip);
        at += length + 1;
    }
    return count;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (header == NULL)
        make_header();
    if (size > 4096)
        return 0;
    shard shards[SHARDS];
    char paths[SHARDS + 2][64];
    char *arguments[SHARDS + 3] = {paths[SHARDS]};
    int fds[SHARDS + 2], count = cut(data, size, shards), n = 1;
    fds[SHARDS] = file_of(specification, strlen(specification), paths[SHARDS]);
    fds[SHARDS + 1] = file_of("", 0, paths[SHARDS + 1]);
    for (int i = 0; i < count; i++) {
        fds[i] = file_of(shards[i].text, shards[i].size, paths[i]);
        arguments[n++] = paths[i];
    }
    arguments[n++] = (char *)"--out";
    arguments[n++] = paths[SHARDS + 1];
    int status = ll_verb_merge(n, arguments);
    size_t want_size = 0;
    char *want = expected(shards, count, &want_size);
    FUZZ_CHECK((status == 0) == (want != NULL) && (status == 0 || status == 2));
    if (want != NULL) {
        char *got = malloc(want_size + 1);
        FUZZ_CHECK(got != NULL && pread(fds[SHARDS + 1], got, want_size + 1, 0) == (ssize_t)want_size);
        FUZZ_CHECK(memcmp(got, want, want_size) == 0);
        free(got);
    }
    free(want);
    for (int i = 0; i < count; i++) {
        close(fds[i]);
        free(shards[i].text);
    }
    close(fds[SHARDS]);
    close(fds[SHARDS + 1]);
    return 0;
}

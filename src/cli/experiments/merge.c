/* `laglab merge`: merges CSV shards into one file, ordered by run, each run once, all of one version of
 * laglab. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/version.h"
#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/verbs.h"
#include "experiment/format/table.h"

typedef struct merge {
    ll_experiment *experiment;
    char *header;
    int fields;
    char version[LL_VERSION_MAX + 1]; /* of the first row */
    char **lines;                     /* by run; owned */
} merge;

static bool no_rows(void *context, ll_row *row, ll_status *status)
{
    (void)context;
    (void)row;
    (void)status;
    return false;
}

/* Number of fields of a line (RFC 4180); 0: unclosed quote. */
static int fields_of(const char *line)
{
    int fields = 1;
    bool quoted = false;
    for (const char *p = line; *p != '\0'; p++) {
        quoted ^= *p == '"';
        fields += *p == ',' && !quoted;
    }
    return quoted ? 0 : fields;
}

/* The header that a sweep of this experiment writes. */
static ll_status make_header(merge *m)
{
    size_t size;
    ll_result_table *table = NULL;
    FILE *memory = open_memstream(&m->header, &size);
    if (!memory)
        return ll_error(LL_NO_MEMORY, "out of memory: header");
    ll_status status = ll_result_table_rows(m->experiment, ll_version, no_rows, NULL, &table);
    LL_THEN(status, ll_format_find("csv", 3)->write(ll_result_table_get(table), memory));
    ll_result_table_free(table);
    fclose(memory);
    m->fields = fields_of(m->header);
    return status;
}

/* A row ends with the version that computed it. */
static ll_status check_version(merge *m, const char *path, const char *line)
{
    const char *comma = strrchr(line, ','), *version = comma ? comma + 1 : "";
    int length = (int)strcspn(version, "\r\n");
    if (m->version[0] == '\0')
        snprintf(m->version, sizeof m->version, "%.*s", length, version);
    if (strlen(m->version) == (size_t)length && strncmp(m->version, version, (size_t)length) == 0)
        return ll_ok();
    return ll_error(LL_BAD_INPUT,
                    "%.60s has rows of laglab %.*s, an earlier shard of laglab %s; their results may differ: "
                    "run the shards of one of them again with the other",
                    path, length < LL_VERSION_MAX ? length : LL_VERSION_MAX, version, m->version);
}

/* Checks a row, which a truncated copy or an editor may have damaged. */
static ll_status check_row(const merge *m, const char *path, int64_t run, const char *line, size_t size)
{
    if (strlen(line) != size || fields_of(line) != m->fields)
        return ll_error(LL_BAD_INPUT,
                        "%.150s: the row of run %" PRId64 ": must have the %d fields of the header", path,
                        run, m->fields);
    if (strcspn(line, "\r\n") + 2 != size || strcmp(line + size - 2, "\r\n") != 0)
        return ll_error(LL_BAD_INPUT,
                        "%.150s: the row of run %" PRId64 " is incomplete: the file was truncated or changed",
                        path, run);
    return ll_ok();
}

/* A row without line ends in its fields, as laglab writes it. */
static ll_status take_line(merge *m, const char *path, char *line, size_t size)
{
    char *end;
    bool digit = line[0] >= '0' && line[0] <= '9', canonical = line[0] != '0' || line[1] == ',';
    int64_t run = digit && canonical ? strtoll(line, &end, 10) : -1;
    if (run < 0 || *end != ',' || run >= m->experiment->runs)
        return ll_error(LL_BAD_INPUT, "%.150s: a row must begin with its run, 0 to %" PRId64 "; got %.40s",
                        path, m->experiment->runs - 1, line);
    LL_TRY(check_row(m, path, run, line, size));
    LL_TRY(check_version(m, path, line));
    if (m->lines[run] && strcmp(m->lines[run], line) != 0)
        return ll_error(LL_BAD_INPUT, "%.150s: run %" PRId64 " differs between two shards", path, run);
    if (!m->lines[run])
        m->lines[run] = strdup(line);
    return m->lines[run] ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: rows");
}

static ll_status take_file(merge *m, const char *path)
{
    FILE *file = fopen(path, "rbe");
    char *line = NULL;
    size_t capacity = 0;
    bool header = true;
    ssize_t size;
    ll_status status = file ? ll_ok() : ll_error(LL_BAD_INPUT, "cannot read %.200s", path);
    while (!ll_failed(&status) && (size = getline(&line, &capacity, file)) > 0) {
        if (header && (strcmp(line, m->header) != 0 || strlen(line) != (size_t)size))
            status = ll_error(LL_BAD_INPUT, "%.200s: must have the header of this experiment", path);
        else if (!header)
            status = take_line(m, path, line, (size_t)size);
        header = false;
    }
    if (!ll_failed(&status) && header)
        status = ll_error(LL_BAD_INPUT, "%.200s is empty", path);
    free(line);
    if (file)
        fclose(file);
    return status;
}

static ll_status check_whole(const merge *m)
{
    int64_t missing = 0, first = -1;
    for (int64_t i = 0; i < m->experiment->runs; i++)
        if (!m->lines[i]) {
            first = first < 0 ? i : first;
            missing++;
        }
    return missing == 0 ? ll_ok()
                        : ll_error(LL_BAD_INPUT,
                                   "%" PRId64 " of %" PRId64 " runs are missing, the first is run %" PRId64,
                                   missing, m->experiment->runs, first);
}

static ll_status write_out(const merge *m, const char *out)
{
    FILE *file = out ? fopen(out, "wb") : stdout;
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s", out);
    fputs(m->header, file);
    for (int64_t i = 0; i < m->experiment->runs; i++)
        fputs(m->lines[i], file);
    bool good = fflush(file) == 0 && !ferror(file);
    good &= !out || fclose(file) == 0;
    return good ? ll_ok() : ll_error(LL_IO, "cannot write %.200s", out ? out : "the rows");
}

int ll_verb_merge(int argc, char **argv)
{
    merge m = {0};
    const char *out = NULL, *scenarios = NULL, *positional[LL_POSITIONAL_MAX];
    const ll_option options[] = {{"--out", "FILE", "Output file; default: standard output.", .value = &out},
                                 {"--scenarios", "DIR",
                                  "Folder of the scenario library; default: next to the program.",
                                  .value = &scenarios},
                                 {0}};
    int count;
    ll_status status =
        ll_arguments("merge EXPERIMENT SHARD.csv... [OPTION]...: merge the shards of an experiment", argc,
                     argv, options, positional, &count);
    LL_THEN(status, ll_experiment_load(count ? positional[0] : NULL, scenarios, &m.experiment));
    if (!ll_failed(&status) && !(m.lines = calloc((size_t)m.experiment->runs, sizeof *m.lines)))
        status = ll_error(LL_NO_MEMORY, "out of memory: rows");
    LL_THEN(status, make_header(&m));
    for (int i = 1; i < count && !ll_failed(&status); i++)
        status = take_file(&m, positional[i]);
    LL_THEN(status, check_whole(&m));
    LL_THEN(status, write_out(&m, out));
    for (int64_t i = 0; m.lines && i < m.experiment->runs; i++)
        free(m.lines[i]);
    free(m.lines);
    free(m.header);
    ll_experiment_free(m.experiment);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}

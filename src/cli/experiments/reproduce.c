/* `laglab reproduce`: makes rows of a result file again and compares them, byte by byte. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/version.h"
#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/output.h"
#include "cli/verbs.h"
#include "experiment/format/table.h"
#include "experiment/spec/metric_path.h"

typedef struct reproduction {
    const char *path;
    ll_experiment *experiment;
    const ll_format *format;
    bool csv;
    char *text, **lines; /* of the file; lines without their ends */
    int64_t count, compared, equal, skipped;
    char made_by[LL_VERSION_MAX + 1]; /* version of the last row */
    ll_kept_block kept;
} reproduction;

/* ---- a row made again ---- */

typedef struct one_row {
    reproduction *r;
    int64_t run;
    bool done;
} one_row;

static bool next_row(void *context, ll_row *row, ll_status *status)
{
    one_row *one = context;
    if (one->done)
        return false;
    one->done = true;
    ll_row_clear(row);
    *status = ll_experiment_run(one->r->experiment, one->run, NULL, &one->r->kept, row);
    return !ll_failed(status);
}

/* What a sweep writes of one run, by the version `made_by`; of `run` < 0 only the header. Caller frees. */
static ll_status write_run(reproduction *r, int64_t run, char **text)
{
    one_row one = {r, run, run < 0};
    size_t size;
    ll_result_table *table = NULL;
    FILE *memory = open_memstream(text, &size);
    if (!memory)
        return ll_error(LL_NO_MEMORY, "out of memory: row");
    ll_status status = ll_result_table_rows(r->experiment, r->made_by, next_row, &one, &table);
    LL_THEN(status, r->format->write(ll_result_table_get(table), memory));
    ll_result_table_free(table);
    fclose(memory);
    return status;
}

/* The line at `index` of a text, its end cut off. */
static char *line_at(char *text, int index)
{
    while (index-- > 0)
        text += strcspn(text, "\n") + 1;
    text[strcspn(text, "\r\n")] = '\0';
    return text;
}

/* ---- rows of the file ---- */

static ll_status read_version(reproduction *r, const char *line)
{
    const char *mark = r->csv ? "," : "\"version\":\"", *found = NULL;
    for (const char *at = line; (at = strstr(at, mark)) != NULL; at++)
        found = at + strlen(mark);
    size_t length = found ? strcspn(found, "\"") : 0;
    if (length == 0 || length > LL_VERSION_MAX)
        return ll_error(LL_BAD_INPUT, "%.150s: a row must end with the version that made it; got %.60s",
                        r->path, line);
    snprintf(r->made_by, sizeof r->made_by, "%.*s", (int)length, found);
    return ll_ok();
}

static ll_status read_run(const reproduction *r, const char *line, int64_t *run)
{
    const char *number = r->csv ? line : strncmp(line, "{\"run\":", 7) == 0 ? line + 7 : "";
    char *end;
    *run = number[0] >= '0' && number[0] <= '9' ? strtoll(number, &end, 10) : -1;
    if (*run >= 0 && *run < r->experiment->runs && *end == ',')
        return ll_ok();
    return ll_error(LL_BAD_INPUT, "%.150s: a row must begin with its run, 0 to %" PRId64 "; got %.40s",
                    r->path, r->experiment->runs - 1, line);
}

static ll_status compare_row(reproduction *r, const char *line)
{
    int64_t run;
    char *text = NULL;
    LL_TRY(read_run(r, line, &run));
    LL_TRY(read_version(r, line));
    if (strstr(line, r->csv ? ",skipped," : "\"status\":\"skipped\"")) {
        r->skipped++; /* by `until`: it was not run */
        return ll_ok();
    }
    ll_status status = write_run(r, run, &text);
    if (!ll_failed(&status)) {
        const char *made = line_at(text, r->csv ? 1 : 0);
        r->compared++;
        if (strcmp(made, line) == 0)
            r->equal++;
        else
            fprintf(stderr, "laglab: run %" PRId64 " differs\n  file %s\n  now  %s\n", run, line, made);
    }
    free(text);
    return status;
}

/* Splits the text, and checks the header. */
static ll_status read_lines(reproduction *r)
{
    char *header = NULL, *at = r->text;
    int64_t most = 1;
    for (const char *p = r->text; *p; p++)
        most += *p == '\n';
    r->lines = calloc((size_t)most, sizeof *r->lines);
    ll_status status = r->lines ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: rows");
    if (!ll_failed(&status) && r->csv) {
        status = write_run(r, -1, &header);
        char *end = at + strcspn(at, "\n");
        char *next = *end ? end + 1 : end;
        if (!ll_failed(&status) && strcmp(line_at(at, 0), line_at(header, 0)) != 0)
            status =
                ll_error(LL_BAD_INPUT, "%.200s: must have the header of this experiment's runs", r->path);
        at = next;
    }
    free(header);
    while (!ll_failed(&status) && *at) {
        char *end = at + strcspn(at, "\n"), *next = *end ? end + 1 : end;
        r->lines[r->count++] = line_at(at, 0);
        at = next;
    }
    if (!ll_failed(&status) && r->count == 0)
        status = ll_error(LL_BAD_INPUT, "%.200s: must have at least one row", r->path);
    return status;
}

static ll_status check(reproduction *r)
{
    r->csv = strcmp(r->format->name, "csv") == 0;
    if (!r->csv && strcmp(r->format->name, "ndjson") != 0)
        return ll_error(LL_BAD_INPUT, "--format: must be csv or ndjson to be compared; got %s",
                        r->format->name);
    for (int i = 0; i < r->experiment->metric_count; i++)
        if (ll_metric_is_cost(r->experiment->metrics[i]))
            return ll_error(LL_BAD_INPUT,
                            "metrics: %s is measured, so that its rows differ each time; it cannot be "
                            "compared",
                            r->experiment->metrics[i]);
    return ll_ok();
}

static void print_answer(const reproduction *r)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "rows", (double)r->count);
    cJSON_AddNumberToObject(o, "compared", (double)r->compared);
    cJSON_AddNumberToObject(o, "equal", (double)r->equal);
    cJSON_AddNumberToObject(o, "skipped", (double)r->skipped);
    cJSON_AddStringToObject(o, "made_by", r->made_by);
    cJSON_AddStringToObject(o, "version", ll_version);
    ll_print_json(o);
}

int ll_verb_reproduce(int argc, char **argv)
{
    reproduction r = {0};
    const char *rows = NULL, *format = NULL, *scenarios = NULL, *positional[LL_POSITIONAL_MAX];
    const ll_option options[] = {
        {"--rows", "N", "How many rows, spread over the file; 0: all. Default: 20.", .value = &rows},
        {"--format", "NAME", "csv or ndjson; default: by the ending of the file, else csv.",
         .value = &format},
        {"--scenarios", "DIR", "Folder of the scenario library; default: next to the program.",
         .value = &scenarios},
        {0}};
    int count;
    int64_t wanted = 20;
    ll_status status =
        ll_arguments("reproduce EXPERIMENT RESULTS [OPTION]...: make rows of a sweep's results "
                     "again and compare them; exit 1 where one differs",
                     argc, argv, options, positional, &count);
    if (!ll_failed(&status) && count != 2)
        status = ll_error(LL_BAD_INPUT, "reproduce: needs an experiment and a file of results");
    if (!ll_failed(&status) && rows)
        status = ll_argument_whole("--rows", rows, 0, LL_EXPERIMENT_RUNS_MAX, &wanted);
    LL_THEN(status, ll_experiment_load(positional[0], scenarios, &r.experiment));
    LL_THEN(status, ll_argument_format(format, positional[1], &r.format));
    LL_THEN(status, check(&r));
    r.path = count > 1 ? positional[1] : "";
    LL_THEN(status, ll_argument_text(r.path, &r.text));
    LL_THEN(status, read_lines(&r));
    if (wanted == 0 || wanted > r.count)
        wanted = r.count;
    for (int64_t i = 0; i < wanted && !ll_failed(&status); i++)
        status = compare_row(&r, r.lines[i * r.count / wanted]);
    if (!ll_failed(&status))
        print_answer(&r);
    ll_kept_block_free(&r.kept);
    free(r.lines);
    free(r.text);
    ll_experiment_free(r.experiment);
    return ll_failed(&status) ? ll_argument_fail(&status) : r.equal < r.compared;
}

/* The files of an archive. Verifying writes them again and compares. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/archive/citation_file.h"
#include "experiment/archive/internal.h"
#include "experiment/report/report.h"

const char *const ll_archive_names[LL_ARCHIVE_FILES] = {
    "manifest.json", "experiment.json", "rows.csv", "rows.bin", "report.html", "CITATION.cff", "SHA256SUMS"};

static const char *const about_files[LL_ARCHIVE_FILES] = {
    [LL_ARCHIVE_SPECIFICATION] = "specification, with its scenario: `laglab sweep experiment.json` runs it",
    [LL_ARCHIVE_CSV] = "a row per run",
    [LL_ARCHIVE_ROWS] = ("the same rows with all bits, little-endian: i64 run, u32 status, u32 bytes of the "
                         "error, u64 hash, f64 t_s, f64 per metric, error"),
    [LL_ARCHIVE_REPORT] = "report, to open in a browser",
    [LL_ARCHIVE_CITATION] = "how to cite the program",
};

static cJSON *files_json(const ll_archive_entry *entries)
{
    cJSON *files = cJSON_CreateArray();
    for (int i = LL_ARCHIVE_SPECIFICATION; i <= LL_ARCHIVE_CITATION; i++) {
        cJSON *file = cJSON_CreateObject();
        cJSON_AddStringToObject(file, "name", ll_archive_names[i]);
        cJSON_AddNumberToObject(file, "bytes", (double)entries[i].size);
        cJSON_AddStringToObject(file, "sha256", entries[i].sha256);
        cJSON_AddStringToObject(file, "about", about_files[i]);
        cJSON_AddItemToArray(files, file);
    }
    return files;
}

/* By the number in rows.bin. */
static cJSON *statuses_json(void)
{
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; i <= LL_ROW_SKIPPED; i++)
        cJSON_AddItemToArray(list, cJSON_CreateString(ll_row_status_names[i]));
    return list;
}

ll_status ll_archive_put_manifest(const ll_experiment *e, const ll_archive_about *about, FILE *file)
{
    char key[17];
    cJSON *o = cJSON_CreateObject(), *metrics = cJSON_CreateArray();
    cJSON_AddStringToObject(o, "format", LL_ARCHIVE_FORMAT);
    cJSON_AddNumberToObject(o, "format_version", LL_ARCHIVE_FORMAT_VERSION);
    cJSON_AddStringToObject(o, "version", about->version);
    if (about->container[0])
        cJSON_AddStringToObject(o, "container", about->container);
    else
        cJSON_AddNullToObject(o, "container");
    snprintf(key, sizeof key, "%016" PRIx64, ll_experiment_key(e));
    cJSON_AddStringToObject(o, "experiment", key);
    cJSON_AddStringToObject(o, "title", e->head.title);
    cJSON_AddNumberToObject(o, "runs", (double)e->runs);
    cJSON_AddNumberToObject(o, "points", (double)e->points);
    cJSON_AddNumberToObject(o, "repeats", (double)e->head.repeats);
    for (int i = 0; i < e->metric_count; i++)
        cJSON_AddItemToArray(metrics, cJSON_CreateString(e->metrics[i]));
    cJSON_AddItemToObject(o, "metrics", metrics);
    cJSON_AddItemToObject(o, "statuses", statuses_json());
    cJSON_AddItemToObject(o, "files", files_json(about->entries));
    cJSON_AddStringToObject(o, "verify", "laglab verify ARCHIVE; without laglab: sha256sum -c SHA256SUMS");
    char *text = cJSON_Print(o);
    cJSON_Delete(o);
    if (!text)
        return ll_error(LL_NO_MEMORY, "out of memory: manifest");
    fprintf(file, "%s\n", text);
    free(text);
    return ll_ok();
}

/* With the version that made the rows in place of the release. */
void ll_archive_put_citation(const char *version, FILE *file)
{
    static const char key[] = "version: ";
    for (const char *line = ll_citation; *line;) {
        int length = (int)strcspn(line, "\n");
        if (strncmp(line, key, sizeof key - 1) == 0)
            fprintf(file, "%s%s\n", key, version);
        else
            fprintf(file, "%.*s\n", length, line);
        line += length + (line[length] == '\n');
    }
}

void ll_archive_put_digests(const ll_archive_entry *entries, FILE *file)
{
    for (int i = 0; i < LL_ARCHIVE_DIGESTS; i++)
        fprintf(file, "%s  %s\n", entries[i].sha256, ll_archive_names[i]);
}

ll_status ll_archive_put_csv(const ll_experiment *e, const char *version, ll_row_source *source,
                             void *context, FILE *file)
{
    ll_result_table *table = NULL;
    ll_status status = ll_result_table_rows(e, version, source, context, &table);
    LL_THEN(status, ll_format_find("csv", 3)->write(ll_result_table_get(table), file));
    ll_result_table_free(table);
    return status;
}

ll_status ll_archive_put_report(const ll_experiment *e, const char *version, ll_row_source *source,
                                void *context, FILE *file)
{
    return ll_report_write_for(e, version, ll_archive_names[LL_ARCHIVE_CSV], source, context, file);
}

/* Writes an archive from a store. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "experiment/archive/internal.h"
#include "experiment/archive/rows.h"
#include "experiment/format/temporary.h"

typedef struct writing {
    ll_result_store *store;
    const char *id;
    const ll_archive_wish *wish;
    ll_experiment_record record;
    ll_experiment *experiment;
    FILE *files[LL_ARCHIVE_FILES]; /* temporary */
    ll_archive_entry entries[LL_ARCHIVE_FILES];
} writing;

ll_status ll_archive_container(const char *field, const char *container)
{
    static const char begin[] = "sha256:";
    const char *digits = container + sizeof begin - 1;
    if (strncmp(container, begin, sizeof begin - 1) == 0 && strlen(digits) == LL_SHA256_HEX &&
        strspn(digits, "0123456789abcdef") == LL_SHA256_HEX)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, field, "%s: must be sha256: and 64 hexadecimal digits; got %.100s",
                          field, container);
}

static ll_status read_experiment(writing *w)
{
    char *text = NULL;
    cJSON *json = NULL;
    LL_TRY(w->store->kind->record(w->store, w->id, &w->record));
    ll_status status = w->store->kind->specification(w->store, w->id, &text);
    LL_THEN(status, ll_json_parse(text, strlen(text), &json));
    LL_THEN(status, ll_experiment_parse(json, NULL, &w->experiment));
    cJSON_Delete(json);
    free(text);
    if (ll_failed(&status))
        return status;
    if (w->record.from != 0 || w->record.to != w->experiment->runs)
        return ll_error(LL_BAD_INPUT,
                        "%s: must have all runs, 0 to %" PRId64 "; is the shard %" PRId64 " to %" PRId64,
                        w->id, w->experiment->runs - 1, w->record.from, w->record.to - 1);
    if (w->record.state != LL_EXPERIMENT_DONE)
        return ll_error(LL_BAD_INPUT, "%s: must be done; is %s with %" PRId64 " of %" PRId64 " runs", w->id,
                        ll_experiment_state_names[w->record.state], w->record.done, w->experiment->runs);
    return ll_ok();
}

/* ---- the files ---- */

static ll_status put_rows(const ll_experiment *e, const char *version, ll_row_source *source, void *context,
                          FILE *file)
{
    ll_row row;
    ll_status status = ll_ok();
    (void)version;
    while (source(context, &row, &status))
        ll_archive_put_row(file, &row, e->metric_count);
    return status;
}

static ll_archive_put *const derived[LL_ARCHIVE_FILES] = {[LL_ARCHIVE_CSV] = ll_archive_put_csv,
                                                          [LL_ARCHIVE_ROWS] = put_rows,
                                                          [LL_ARCHIVE_REPORT] = ll_archive_put_report};

/* Rows of the store; asks from time to time whether to go on. */
typedef struct source {
    ll_stored_rows rows;
    const ll_interrupt *interrupt;
    int64_t given;
} source;

enum { ASK_EVERY = 64 };

static bool next_row(void *context, ll_row *row, ll_status *status)
{
    source *s = context;
    if (s->interrupt && s->given++ % ASK_EVERY == 0 && !s->interrupt->go_on(s->interrupt->context)) {
        *status = ll_error(LL_INTERRUPTED, "interrupted");
        return false;
    }
    return ll_stored_rows_next(&s->rows, row, status);
}

static ll_status put_derived(const writing *w, ll_archive_put *put, FILE *file)
{
    source s = {.interrupt = w->wish->interrupt};
    ll_status status = ll_stored_rows_open(&s.rows, w->store, w->id);
    LL_THEN(status, put(w->experiment, w->record.version, next_row, &s, file));
    ll_stored_rows_close(&s.rows);
    return status;
}

static ll_status put_specification(const writing *w, FILE *file)
{
    char *text = ll_experiment_text(w->experiment);
    if (!text)
        return ll_error(LL_NO_MEMORY, "out of memory: specification");
    fprintf(file, "%s\n", text);
    free(text);
    return ll_ok();
}

static ll_status put_file(const writing *w, ll_archive_file which, FILE *file)
{
    const ll_archive_about about = {w->record.version, w->wish->container ? w->wish->container : "",
                                    w->entries};
    if (derived[which])
        return put_derived(w, derived[which], file);
    if (which == LL_ARCHIVE_MANIFEST)
        return ll_archive_put_manifest(w->experiment, &about, file);
    if (which == LL_ARCHIVE_SPECIFICATION)
        return put_specification(w, file);
    if (which == LL_ARCHIVE_CITATION)
        ll_archive_put_citation(w->record.version, file);
    else
        ll_archive_put_digests(w->entries, file);
    return ll_ok();
}

static ll_status make_file(writing *w, ll_archive_file which)
{
    FILE *file = w->files[which] = ll_temporary_open(w->wish->folder);
    if (!file)
        return ll_error(LL_IO, "cannot create a temporary file");
    ll_status status = put_file(w, which, file);
    if (!ll_failed(&status) && (fflush(file) != 0 || ferror(file)))
        status = ll_error(LL_IO, "cannot write a temporary file: the disk is full");
    w->entries[which].size = ftello(file);
    LL_THEN(status, ll_sha256_file(file, 0, w->entries[which].size, w->entries[which].sha256));
    return status;
}

/* What lists the others comes after them. */
static ll_status make_files(writing *w)
{
    static const ll_archive_file order[] = {
        LL_ARCHIVE_SPECIFICATION, LL_ARCHIVE_CSV,      LL_ARCHIVE_ROWS,   LL_ARCHIVE_REPORT,
        LL_ARCHIVE_CITATION,      LL_ARCHIVE_MANIFEST, LL_ARCHIVE_DIGESTS};
    ll_status status = ll_ok();
    for (int i = 0; i < LL_ARCHIVE_FILES; i++)
        LL_THEN(status, make_file(w, order[i]));
    return status;
}

/* ---- the archive ---- */

ll_status ll_archive_write_to(ll_result_store *store, const char *id, const ll_archive_wish *wish, FILE *file)
{
    writing w = {.store = store, .id = id, .wish = wish};
    ll_status status = wish->container ? ll_archive_container("container", wish->container) : ll_ok();
    LL_THEN(status, read_experiment(&w));
    LL_THEN(status, make_files(&w));
    LL_THEN(status, ll_tar_write(file, ll_archive_names, w.files, LL_ARCHIVE_FILES));
    for (int i = 0; i < LL_ARCHIVE_FILES; i++)
        if (w.files[i])
            fclose(w.files[i]);
    ll_experiment_free(w.experiment);
    return status;
}

ll_status ll_archive_write(ll_result_store *store, const char *id, const char *container, const char *path)
{
    char temporary[4096];
    snprintf(temporary, sizeof temporary, "%s.part", path);
    FILE *file = fopen(temporary, "wb");
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s", temporary);
    const ll_archive_wish wish = {.container = container, .folder = P_tmpdir};
    ll_status status = ll_archive_write_to(store, id, &wish, file);
    bool good = fclose(file) == 0;
    if (!ll_failed(&status) && (!good || rename(temporary, path) != 0))
        status = ll_error(LL_IO, "cannot write %.200s", path);
    if (ll_failed(&status))
        unlink(temporary);
    return status;
}

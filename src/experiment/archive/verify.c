/* Checks an archive: its digests first, and only of a sound one anything else. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "experiment/archive/internal.h"
#include "experiment/archive/rows.h"
#include "experiment/spec/metric_path.h"

enum { TEXT_MAX = 64 << 20, CHOICE_STREAM = 1 };

typedef struct verifying {
    const ll_archive_check *check;
    ll_archive_result *result;
    const char *path;
    FILE *archive;
    ll_tar_member files[LL_ARCHIVE_FILES];
    ll_archive_entry entries[LL_ARCHIVE_FILES]; /* as they are */
    ll_experiment *experiment;
    bool is_same_version;
    ll_kept_block kept;
} verifying;

static void tell(verifying *v, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void tell(verifying *v, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    v->result->differences++;
    v->check->tell(v->check->context, text);
}

/* ---- files and digests ---- */

static ll_status find_files(verifying *v)
{
    ll_tar_member members[LL_TAR_MEMBERS_MAX];
    int count;
    LL_TRY(ll_tar_list(v->archive, members, &count));
    for (int i = 0; i < count || i < LL_ARCHIVE_FILES; i++) {
        if (i >= count)
            return ll_error(LL_BAD_INPUT, "archive: must have %s as file %d", ll_archive_names[i], i + 1);
        if (i >= LL_ARCHIVE_FILES || strcmp(members[i].name, ll_archive_names[i]) != 0)
            return ll_error(LL_BAD_INPUT, "archive: must have %s as file %d; has %s",
                            i < LL_ARCHIVE_FILES ? ll_archive_names[i] : "nothing", i + 1, members[i].name);
        v->files[i] = members[i];
        v->entries[i].size = members[i].size;
    }
    for (int i = 0; i < LL_ARCHIVE_FILES; i++)
        LL_TRY(ll_sha256_file(v->archive, v->files[i].offset, v->files[i].size, v->entries[i].sha256));
    return ll_ok();
}

/* The text of a file; caller frees. */
static ll_status read_text(verifying *v, ll_archive_file which, char **text)
{
    const ll_tar_member *file = &v->files[which];
    *text = NULL;
    if (file->size > TEXT_MAX)
        return ll_error(LL_BAD_INPUT, "%s: must have at most %d bytes; has %" PRId64, file->name, TEXT_MAX,
                        file->size);
    *text = calloc(1, (size_t)file->size + 1);
    if (!*text)
        return ll_error(LL_NO_MEMORY, "out of memory: %s", file->name);
    bool read = fseeko(v->archive, file->offset, SEEK_SET) == 0 &&
                fread(*text, 1, (size_t)file->size, v->archive) == (size_t)file->size;
    return read ? ll_ok() : ll_error(LL_IO, "cannot read %.200s", v->path);
}

static ll_status read_json(verifying *v, ll_archive_file which, cJSON **json)
{
    char *text;
    ll_status status = read_text(v, which, &text);
    LL_THEN(status, ll_json_parse(text, (size_t)v->files[which].size, json));
    free(text);
    if (status.code == LL_BAD_INPUT)
        return ll_error(LL_BAD_INPUT, "%s: %s", ll_archive_names[which], status.text);
    return status;
}

static ll_status damaged(const char *name, const char *by)
{
    return ll_error(LL_BAD_INPUT,
                    "%s: its digest differs from that in %s: the archive is damaged or was changed", name,
                    by);
}

/* What the list of digests would be, and what it is. */
static ll_status check_digests(verifying *v)
{
    char *made = NULL, *text;
    size_t size;
    ll_status status = read_text(v, LL_ARCHIVE_DIGESTS, &text);
    FILE *memory = ll_failed(&status) ? NULL : open_memstream(&made, &size);
    if (!memory) {
        free(text);
        return ll_failed(&status) ? status : ll_error(LL_NO_MEMORY, "out of memory: digests");
    }
    ll_archive_put_digests(v->entries, memory);
    fclose(memory);
    const char *at = text;
    for (int i = 0; i < LL_ARCHIVE_DIGESTS && !ll_failed(&status); i++) {
        char line[LL_SHA256_HEX + LL_TAR_NAME_MAX + 4];
        int length = snprintf(line, sizeof line, "%s  %s\n", v->entries[i].sha256, ll_archive_names[i]);
        if (strncmp(at, line, (size_t)length) != 0)
            status = damaged(ll_archive_names[i], ll_archive_names[LL_ARCHIVE_DIGESTS]);
        at += length;
    }
    if (!ll_failed(&status) &&
        ((size_t)v->files[LL_ARCHIVE_DIGESTS].size != size || memcmp(text, made, size) != 0))
        status = ll_error(LL_BAD_INPUT, "%s: must have a line per file, and nothing else",
                          ll_archive_names[LL_ARCHIVE_DIGESTS]);
    free(made);
    free(text);
    return status;
}

/* ---- the manifest ---- */

static const char *text_of(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsString(item) ? item->valuestring : "";
}

static double number_of(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsNumber(item) ? item->valuedouble : -1;
}

/* The manifest's list of files has the digests too, for readers of other programs. */
static ll_status check_manifest_files(const verifying *v, const cJSON *manifest)
{
    const cJSON *files = cJSON_GetObjectItemCaseSensitive(manifest, "files");
    for (int i = LL_ARCHIVE_SPECIFICATION; i <= LL_ARCHIVE_CITATION; i++) {
        const cJSON *file = cJSON_GetArrayItem(files, i - LL_ARCHIVE_SPECIFICATION);
        if (strcmp(text_of(file, "name"), ll_archive_names[i]) != 0)
            return ll_error(LL_BAD_INPUT, "manifest.json: must have %s in its files", ll_archive_names[i]);
        if (number_of(file, "bytes") != (double)v->entries[i].size ||
            strcmp(text_of(file, "sha256"), v->entries[i].sha256) != 0)
            return damaged(ll_archive_names[i], ll_archive_names[LL_ARCHIVE_MANIFEST]);
    }
    return ll_ok();
}

static ll_status read_manifest(verifying *v, const cJSON *manifest)
{
    ll_archive_result *r = v->result;
    const char *version = text_of(manifest, "version"), *container = text_of(manifest, "container");
    if (strcmp(text_of(manifest, "format"), LL_ARCHIVE_FORMAT) != 0)
        return ll_error(LL_BAD_INPUT, "manifest.json: format: must be %s", LL_ARCHIVE_FORMAT);
    if (number_of(manifest, "format_version") != LL_ARCHIVE_FORMAT_VERSION)
        return ll_error(LL_BAD_INPUT,
                        "manifest.json: format_version: must be %d, which this laglab reads; got %g",
                        LL_ARCHIVE_FORMAT_VERSION, number_of(manifest, "format_version"));
    size_t length = strlen(version);
    if (length == 0 || length > LL_VERSION_MAX ||
        strspn(version, "0123456789abcdefghijklmnopqrstuvwxyz.+-") != length)
        return ll_error(LL_BAD_INPUT,
                        "manifest.json: version: must be that of a laglab, as 0.2.0+3f2a9c1b4d5e");
    if (container[0])
        LL_TRY(ll_archive_container("manifest.json: container", container));
    snprintf(r->version, sizeof r->version, "%s", version);
    snprintf(r->container, sizeof r->container, "%s", container);
    v->is_same_version = strcmp(version, ll_version) == 0;
    return check_manifest_files(v, manifest);
}

static ll_status read_experiment(verifying *v, const cJSON *manifest)
{
    char key[17];
    cJSON *json = NULL;
    ll_status status = read_json(v, LL_ARCHIVE_SPECIFICATION, &json);
    if (!ll_failed(&status) && !cJSON_IsObject(cJSON_GetObjectItemCaseSensitive(json, "scenario")))
        status = ll_error(LL_BAD_INPUT, "experiment.json: scenario: must be a whole scenario");
    LL_THEN(status, ll_experiment_parse(json, NULL, &v->experiment));
    cJSON_Delete(json);
    if (ll_failed(&status))
        return status;
    snprintf(key, sizeof key, "%016" PRIx64, ll_experiment_key(v->experiment));
    if (strcmp(key, text_of(manifest, "experiment")) != 0)
        return ll_error(LL_BAD_INPUT, "manifest.json: experiment: must be the key of experiment.json, %s",
                        key);
    if (number_of(manifest, "runs") != (double)v->experiment->runs)
        return ll_error(LL_BAD_INPUT, "manifest.json: runs: must be those of experiment.json, %" PRId64,
                        v->experiment->runs);
    v->result->rows = v->experiment->runs;
    for (int i = 0; i < v->experiment->metric_count; i++)
        v->result->measured += ll_metric_is_cost(v->experiment->metrics[i]);
    return ll_ok();
}

/* ---- files that follow from the rows ---- */

/* A stream that compares what is written to it with a file of the archive. */
typedef struct comparison {
    FILE *archive;
    int64_t left, at;
    int64_t differs_at; /* -1: none so far */
} comparison;

static ssize_t compare(void *context, const char *bytes, size_t size)
{
    comparison *c = context;
    char there[4096];
    for (size_t done = 0; done < size && c->differs_at < 0;) {
        size_t wanted = size - done < sizeof there ? size - done : sizeof there;
        size_t got = (int64_t)wanted > c->left ? (size_t)c->left : wanted, same = 0;
        if (fread(there, 1, got, c->archive) != got)
            got = 0;
        while (same < got && there[same] == bytes[done + same])
            same++;
        if (same < wanted)
            c->differs_at = c->at + (int64_t)same;
        c->at += (int64_t)wanted;
        c->left -= (int64_t)got;
        done += wanted;
    }
    return (ssize_t)size;
}

/* Opens a stream for that file; `c` is what it finds. */
static ll_status open_comparison(const verifying *v, ll_archive_file which, comparison *c, FILE **stream)
{
    *c = (comparison){.archive = fopen(v->path, "rb"), .left = v->files[which].size, .differs_at = -1};
    *stream = NULL;
    if (c->archive && fseeko(c->archive, v->files[which].offset, SEEK_SET) == 0)
        *stream = fopencookie(c, "w", (cookie_io_functions_t){.write = compare});
    if (*stream)
        return ll_ok();
    if (c->archive)
        fclose(c->archive);
    return ll_error(LL_IO, "cannot read %.200s", v->path);
}

static void close_comparison(verifying *v, ll_archive_file which, comparison *c, FILE *stream)
{
    fclose(stream);
    fclose(c->archive);
    if (c->differs_at < 0 && c->left > 0)
        c->differs_at = c->at;
    if (c->differs_at >= 0)
        tell(v, "%s differs from what follows from rows.bin, from byte %" PRId64 " on",
             ll_archive_names[which], c->differs_at);
}

/* ---- rows ---- */

typedef struct reading {
    verifying *v;
    FILE *archive;
    int64_t left, run, wanted; /* wanted: rows still to be chosen */
    bool chooses;
} reading;

static ll_status open_rows(verifying *v, bool chooses, reading *r)
{
    int64_t rows = v->check->rows, runs = v->experiment->runs;
    *r = (reading){.v = v,
                   .archive = fopen(v->path, "rb"),
                   .left = v->files[LL_ARCHIVE_ROWS].size,
                   .wanted = rows == 0 || rows > runs ? runs : rows,
                   .chooses = chooses};
    if (r->archive && fseeko(r->archive, v->files[LL_ARCHIVE_ROWS].offset, SEEK_SET) == 0)
        return ll_ok();
    return ll_error(LL_IO, "cannot read %.200s", v->path);
}

static void close_rows(reading *r)
{
    if (r->archive)
        fclose(r->archive);
}

static bool same_metrics(verifying *v, const ll_row *there, const ll_row *here)
{
    bool same = true;
    for (int i = 0; i < v->experiment->metric_count; i++) {
        double a = there->metrics[i], b = here->metrics[i];
        if (ll_metric_is_cost(v->experiment->metrics[i]) || ll_archive_bits(a) == ll_archive_bits(b))
            continue;
        tell(v, "run %" PRId64 ": %s is %.17g in the archive, %.17g here", there->run,
             v->experiment->metrics[i], a, b);
        same = false;
    }
    return same;
}

static bool same_row(verifying *v, const ll_row *there, const ll_row *here)
{
    bool same = same_metrics(v, there, here);
    if (there->status != here->status) {
        tell(v, "run %" PRId64 ": its status is %s in the archive, %s here", there->run,
             ll_row_status_names[there->status], ll_row_status_names[here->status]);
        same = false;
    }
    if (there->hash != here->hash) {
        tell(v, "run %" PRId64 ": its hash is %016" PRIx64 " in the archive, %016" PRIx64 " here", there->run,
             there->hash, here->hash);
        same = false;
    }
    if (ll_archive_bits(there->t_s) != ll_archive_bits(here->t_s) || strcmp(there->error, here->error) != 0) {
        tell(v, "run %" PRId64 ": its end is %.17g s (%s) in the archive, %.17g s (%s) here", there->run,
             there->t_s, there->error, here->t_s, here->error);
        same = false;
    }
    return same;
}

static ll_status run_again(verifying *v, const ll_row *there)
{
    ll_row here;
    if (there->status == LL_ROW_SKIPPED) { /* by `until`: it was not run */
        v->result->skipped++;
        return ll_ok();
    }
    LL_TRY(ll_experiment_run(v->experiment, there->run, NULL, &v->kept, &here));
    v->result->compared++;
    v->result->equal += same_row(v, there, &here);
    return ll_ok();
}

/* Whether this row is of the sample: of those that are left each is as likely (Knuth's algorithm S). */
static bool choose(reading *r)
{
    double left = (double)(r->v->experiment->runs - r->run);
    bool chosen = ll_rng_unit(r->v->check->seed, CHOICE_STREAM, (uint64_t)r->run) * left < (double)r->wanted;
    r->wanted -= chosen;
    return chosen;
}

/* Rows of the archive, as the source of a table: an ll_row_source function. */
static bool next_row(void *context, ll_row *row, ll_status *status)
{
    reading *r = context;
    verifying *v = r->v;
    *status = ll_ok();
    if (r->run == v->experiment->runs) {
        if (r->left > 0)
            *status = ll_error(LL_BAD_INPUT, "rows.bin: must have %" PRId64 " rows; has more", r->run);
        return false;
    }
    *status = ll_archive_get_row(r->archive, v->experiment->metric_count, &r->left, row);
    if (!ll_failed(status) && row->run != r->run)
        *status =
            ll_error(LL_BAD_INPUT, "rows.bin: must have run %" PRId64 "; has %" PRId64, r->run, row->run);
    if (!ll_failed(status) && r->chooses && choose(r))
        *status = run_again(v, row);
    r->run++;
    return !ll_failed(status);
}

static ll_status check_derived(verifying *v, ll_archive_file which, bool chooses, ll_archive_put *put)
{
    reading rows;
    comparison c;
    FILE *stream;
    LL_TRY(open_comparison(v, which, &c, &stream));
    ll_status status = open_rows(v, chooses, &rows);
    LL_THEN(status, put(v->experiment, v->result->version, next_row, &rows, stream));
    close_rows(&rows);
    if (ll_failed(&status)) {
        fclose(stream);
        fclose(c.archive);
        return status;
    }
    close_comparison(v, which, &c, stream);
    return ll_ok();
}

static ll_status put_manifest(const verifying *v, FILE *file)
{
    const ll_archive_about about = {v->result->version, v->result->container, v->entries};
    return ll_archive_put_manifest(v->experiment, &about, file);
}

/* Files that the same version would have written differently. */
static ll_status check_texts(verifying *v)
{
    for (int i = 0; i < 2; i++) {
        ll_archive_file which = i ? LL_ARCHIVE_CITATION : LL_ARCHIVE_MANIFEST;
        comparison c;
        FILE *stream;
        LL_TRY(open_comparison(v, which, &c, &stream));
        ll_status status = ll_ok();
        if (i)
            ll_archive_put_citation(v->result->version, stream);
        else
            status = put_manifest(v, stream);
        close_comparison(v, which, &c, stream);
        LL_TRY(status);
    }
    return ll_ok();
}

/* ---- whole ---- */

static ll_status check_sound(verifying *v)
{
    if (!v->is_same_version && !v->check->any_version)
        tell(v, "version: the archive is of laglab %s, this is %s; their results may differ",
             v->result->version, ll_version);
    LL_TRY(check_derived(v, LL_ARCHIVE_CSV, true, ll_archive_put_csv));
    v->result->report_compared = v->is_same_version;
    if (!v->is_same_version)
        return ll_ok();
    LL_TRY(check_texts(v));
    return check_derived(v, LL_ARCHIVE_REPORT, false, ll_archive_put_report);
}

ll_status ll_archive_verify(const char *path, const ll_archive_check *check, ll_archive_result *result)
{
    cJSON *manifest = NULL;
    *result = (ll_archive_result){.rows = 0};
    verifying v = {.check = check, .result = result, .path = path, .archive = fopen(path, "rb")};
    if (!v.archive)
        return ll_error(LL_BAD_INPUT, "cannot read %.200s", path);
    ll_status status = find_files(&v);
    LL_THEN(status, check_digests(&v));
    LL_THEN(status, read_json(&v, LL_ARCHIVE_MANIFEST, &manifest));
    LL_THEN(status, read_manifest(&v, manifest));
    LL_THEN(status, read_experiment(&v, manifest));
    LL_THEN(status, check_sound(&v));
    cJSON_Delete(manifest);
    ll_experiment_free(v.experiment);
    ll_kept_block_free(&v.kept);
    fclose(v.archive);
    return status;
}

#include "daemon/api/answer.h"

#include <ctype.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "daemon/api/api.h"
#include "daemon/support/gzip.h"

/* ---- tags ---- */

/* Range requests get uncompressed bytes, since a part of a compressed file is useless. */
static bool wants_part(const ll_http_request *request, const ll_answer *answer)
{
    return answer->final && ll_http_header(request, "Range") != NULL;
}

static bool is_compressed(const ll_http_request *request, const ll_answer *answer)
{
    return ll_gzip_compresses(answer->type) && ll_http_takes_gzip(request) && !wants_part(request, answer);
}

static void write_tag(const ll_answer *answer, bool compressed, char tag[48])
{
    snprintf(tag, 48, "%s\"%016llx%s\"", answer->final ? "" : "W/", (unsigned long long)answer->tag,
             compressed ? "-gzip" : "");
}

bool ll_answer_known(const ll_http_request *request, ll_http_response *response, const ll_answer *answer)
{
    char tag[48], vary[80];
    bool compressed = is_compressed(request, answer);
    write_tag(answer, compressed, tag);
    snprintf(vary, sizeof vary, "%s%sAccept-Encoding", answer->vary ? answer->vary : "",
             answer->vary ? ", " : "");
    ll_http_set_header(response, "ETag", tag);
    ll_http_set_header(response, "Vary", vary);
    ll_http_set_header(response, "Cache-Control", "no-cache"); /* revalidated each time, often with a 304 */
    if (answer->final)
        ll_http_set_header(response, "Accept-Ranges", "bytes");
    if (ll_http_matches_tag(ll_http_header(request, "If-None-Match"), tag)) {
        response->status = 304;
        return true;
    }
    if (!request->head)
        return false;
    if (compressed)
        ll_http_set_header(response, "Content-Encoding", "gzip");
    ll_http_no_body(response, answer->type);
    return true;
}

/* ---- parts ---- */

/* Digits up to `end`; false when there are none, or too many. */
static bool read_digits(const char **at, uint64_t *value)
{
    const char *begin = *at;
    *value = 0;
    while (isdigit((unsigned char)**at) && *at - begin < 18)
        *value = 10 * *value + (uint64_t)(*(*at)++ - '0');
    return *at > begin;
}

typedef enum part { WHOLE, PART, NO_PART } part;

/* RFC 9110 14.2: one range of bytes; any other range is ignored, and the answer is the whole. */
static part read_range(const char *range, uint64_t size, uint64_t *from, uint64_t *length)
{
    uint64_t first = 0, last = size > 0 ? size - 1 : 0;
    if (strncasecmp(range, "bytes=", 6) != 0)
        return WHOLE;
    const char *at = range + 6;
    if (*at == '-') {
        at++;
        if (!read_digits(&at, &last) || *at != '\0')
            return WHOLE;
        first = last < size ? size - last : 0;
        if (last == 0 || size == 0)
            return NO_PART;
        last = size - 1;
    } else {
        if (!read_digits(&at, &first) || *at++ != '-')
            return WHOLE;
        if (*at != '\0' && (!read_digits(&at, &last) || *at != '\0' || last < first))
            return WHOLE;
        if (first >= size)
            return NO_PART;
        last = last < size ? last : size - 1;
    }
    *from = first;
    *length = last - first + 1;
    return PART;
}

static void choose_part(const ll_http_request *request, ll_http_response *response, const ll_answer *answer)
{
    char tag[48], text[96];
    uint64_t size = response->file_size;
    const char *range = ll_http_header(request, "Range"), *only = ll_http_header(request, "If-Range");
    write_tag(answer, false, tag);
    if (!wants_part(request, answer) || (only && strcmp(only, tag) != 0))
        return;
    part found = read_range(range, size, &response->file_from, &response->file_size);
    if (found == WHOLE)
        return;
    if (found == PART) {
        response->status = 206;
        snprintf(text, sizeof text, "bytes %llu-%llu/%llu", (unsigned long long)response->file_from,
                 (unsigned long long)(response->file_from + response->file_size - 1),
                 (unsigned long long)size);
    } else {
        ll_http_clear(response);
        ll_status error =
            ll_field_error(LL_BAD_INPUT, "Range", "Range: must be within the %llu bytes of the answer.",
                           (unsigned long long)size);
        ll_http_problem_as(response, request, 416, &error);
        snprintf(text, sizeof text, "bytes */%llu", (unsigned long long)size);
    }
    ll_http_set_header(response, "Content-Range", text);
}

/* ---- files ---- */

#define ROOM_BYTES (16 << 20) /* with less on its disk, an answer is made in memory */

/* A file without a name, which is gone when it is closed: in the folder, in memory where that cannot be
 * written. */
static FILE *open_temporary(const char *folder)
{
    struct statvfs disk;
    bool full = statvfs(folder, &disk) != 0 || (uint64_t)disk.f_bavail * disk.f_frsize < ROOM_BYTES;
    int fd = full ? -1 : open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd < 0)
        fd = memfd_create("laglab", MFD_CLOEXEC);
    FILE *file = fd >= 0 ? fdopen(fd, "w+b") : NULL;
    if (fd >= 0 && !file)
        close(fd);
    return file;
}

FILE *ll_answer_open(const ll_answer *answer, ll_status *status)
{
    FILE *file = open_temporary(answer->folder);
    *status = file ? ll_ok() : ll_error(LL_IO, "Cannot create a temporary file for the answer.");
    return file;
}

/* Whether the file is a memfd; only these can be sealed. */
static bool in_memory(FILE *file)
{
    return fcntl(fileno(file), F_GET_SEALS) >= 0;
}

/* Replaces `file` by its compressed form, and closes it. */
static ll_status compress(const ll_http_request *request, const ll_answer *answer, FILE **file)
{
    ll_status status;
    FILE *small = ll_answer_open(answer, &status);
    if (small)
        status = ll_gzip_file(*file, small, request->task);
    if (small) {
        fclose(*file);
        *file = small;
    }
    return status;
}

void ll_answer_send(const ll_http_request *request, ll_http_response *response, const ll_answer *answer,
                    const ll_status *made, FILE *file)
{
    ll_status status = *made;
    bool compressed = is_compressed(request, answer);
    if (!ll_failed(&status) && compressed)
        status = compress(request, answer, &file);
    if (!ll_failed(&status) && (fflush(file) != 0 || ferror(file)))
        status = ll_error(LL_IO, "No space on disk for the answer.");
    if (ll_failed(&status)) {
        if (file)
            fclose(file);
        ll_http_clear(response);
        ll_api_problem(response, request, &status);
        return;
    }
    response->file = file;
    response->file_size = (uint64_t)ftello(file);
    response->held = in_memory(file) ? (size_t)response->file_size : 0;
    snprintf(response->type, sizeof response->type, "%s", answer->type);
    if (compressed)
        ll_http_set_header(response, "Content-Encoding", "gzip");
    choose_part(request, response, answer);
}

/* ---- tables ---- */

static void media_type(const ll_format *format, char type[80])
{
    snprintf(type, 80, "%.*s", (int)strcspn(format->type, ";"), format->type);
}

const ll_format *ll_answer_format(const ll_http_request *request, ll_http_response *response)
{
    const char *name = ll_http_query(request, "format");
    const ll_format *best = name ? ll_format_find(name, strlen(name)) : NULL;
    double best_quality = 0, quality;
    char type[80];
    for (int i = 0; !name && ll_formats[i]; i++) {
        media_type(ll_formats[i], type);
        if (ll_http_accepts(request, type, &quality) && quality > best_quality) {
            best = ll_formats[i];
            best_quality = quality;
        }
    }
    if (best)
        return best;
    ll_status error =
        name ? ll_field_error(LL_BAD_INPUT, "format",
                              "format: must be one of csv, ndjson, json, sqlite; got `%.40s`.", name)
             : ll_error(LL_BAD_INPUT, "Accept: must allow text/csv, application/x-ndjson, application/json "
                                      "or application/vnd.sqlite3.");
    ll_http_problem_as(response, request, name ? 400 : 406, &error);
    return NULL;
}

enum { TRACE_ROWS = 1000000 }; /* of one answer, unless they are ticks in CSV */

ll_trace_request ll_answer_trace(const ll_http_request *request, const ll_interrupt *interrupt)
{
    const char *of = ll_http_query(request, "of");
    return (ll_trace_request){.of = of && strcmp(of, "ticks") != 0 ? of : NULL,
                              .name = "of",
                              .rows_max = TRACE_ROWS,
                              .interrupt = interrupt};
}

/* Functions of handlers: reading headers of the request, filling the response, also with an error. */
#include <cjson/cJSON.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "daemon/http/internal.h"
#include "daemon/net/problem_json.h"

const char *ll_http_query(const ll_http_request *request, const char *name)
{
    const http_exchange *exchange = request->impl;
    const char *value = NULL;
    size_t size;
    if (MHD_lookup_connection_value_n(exchange->connection, MHD_GET_ARGUMENT_KIND, name, strlen(name), &value,
                                      &size) == MHD_NO)
        return NULL;
    return value != NULL ? value : "";
}

/* The lines of one header. */
typedef struct header_lines {
    const char *name;
    const char *value; /* of the last line */
    int count;
    size_t size;  /* of all values, each with a separator */
    char *joined; /* where the next value goes; NULL: they are counted only */
} header_lines;

static enum MHD_Result add_line(void *closure, enum MHD_ValueKind kind, const char *name, const char *value)
{
    (void)kind;
    header_lines *lines = closure;
    if (strcasecmp(name, lines->name) != 0)
        return MHD_YES;
    lines->value = value != NULL ? value : "";
    size_t size = strlen(lines->value);
    lines->count++;
    lines->size += size + 2;
    while (size > 0 && (lines->value[size - 1] == ' ' || lines->value[size - 1] == '\t'))
        size--;
    if (lines->joined != NULL) {
        memcpy(lines->joined, lines->value, size);
        memcpy(lines->joined + size, ", ", 2);
        lines->joined += size + 2;
    }
    return MHD_YES;
}

static bool ends_with_space(const char *value)
{
    size_t size = strlen(value);
    return size > 0 && (value[size - 1] == ' ' || value[size - 1] == '\t');
}

/* RFC 9110 5.3, 5.5: lines of one name are one list; space behind a value is no part of it. */
const char *ll_http_header(const ll_http_request *request, const char *name)
{
    http_exchange *exchange = request->impl;
    header_lines lines = {.name = name};
    MHD_get_connection_values(exchange->connection, MHD_HEADER_KIND, add_line, &lines);
    bool plain = lines.count == 0 || (lines.count == 1 && !ends_with_space(lines.value));
    http_value *kept = plain ? NULL : malloc(sizeof *kept + lines.size);
    if (kept == NULL)
        return lines.value;
    lines.joined = kept->text;
    MHD_get_connection_values(exchange->connection, MHD_HEADER_KIND, add_line, &lines);
    lines.joined[-2] = '\0';
    kept->next = exchange->values;
    exchange->values = kept;
    return kept->text;
}

void ll_http_set_header(ll_http_response *response, const char *name, const char *value)
{
    int i = 0;
    while (i < response->headers && strcasecmp(response->header[i].name, name) != 0)
        i++;
    if (i == LL_HTTP_HEADERS) {
        response->failed = true;
        return;
    }
    snprintf(response->header[i].name, sizeof response->header[i].name, "%s", name);
    snprintf(response->header[i].value, sizeof response->header[i].value, "%s", value);
    /* Cuts at a line break, which would start another header. */
    response->header[i].value[strcspn(response->header[i].value, "\r\n")] = '\0';
    if (i == response->headers)
        response->headers++;
}

/* Reserves `size` more bytes and a NUL. */
static bool reserve(ll_http_response *response, size_t size)
{
    if (response->failed || size > SIZE_MAX / 4 - response->size) {
        response->failed = true;
        return false;
    }
    size_t needed = response->size + size + 1;
    if (needed <= response->capacity)
        return true;
    size_t capacity = response->capacity < 512 ? 1024 : 2 * response->capacity;
    capacity = capacity < needed ? needed : capacity;
    char *bytes = realloc(response->bytes, capacity);
    if (bytes == NULL) {
        response->failed = true;
        return false;
    }
    response->bytes = bytes;
    response->capacity = capacity;
    return true;
}

void ll_http_append(ll_http_response *response, const void *bytes, size_t size)
{
    if (size > 0 && reserve(response, size)) {
        memcpy(response->bytes + response->size, bytes, size);
        response->size += size;
    }
}

void ll_http_printf(ll_http_response *response, const char *format, ...)
{
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int size = vsnprintf(NULL, 0, format, arguments);
    if (size >= 0 && reserve(response, (size_t)size)) {
        vsnprintf(response->bytes + response->size, (size_t)size + 1, format, again);
        response->size += (size_t)size;
    }
    va_end(again);
    va_end(arguments);
}

void ll_http_clear(ll_http_response *response)
{
    free(response->bytes);
    if (response->file != NULL)
        fclose(response->file);
    if (response->reader_free != NULL)
        response->reader_free(response->reader_context);
    *response = (ll_http_response){.status = 200};
}

/* Takes ownership of `bytes` (malloc'ed). */
static void take_bytes(ll_http_response *response, int status, const char *type, char *bytes, size_t size)
{
    free(response->bytes);
    response->bytes = bytes;
    response->size = size;
    response->capacity = bytes != NULL ? size : 0;
    response->status = status;
    response->failed = response->failed || (bytes == NULL && size > 0);
    snprintf(response->type, sizeof response->type, "%s", type);
}

static int64_t read_nothing(void *context, uint64_t offset, char *buffer, size_t capacity)
{
    (void)context, (void)offset, (void)buffer, (void)capacity;
    return 0;
}

void ll_http_no_body(ll_http_response *response, const char *type)
{
    snprintf(response->type, sizeof response->type, "%s", type);
    response->reader = read_nothing;
}

void ll_http_json(ll_http_response *response, int status, cJSON *json)
{
    char *text = json != NULL ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    if (text == NULL) {
        response->failed = true;
        return;
    }
    take_bytes(response, status, "application/json", text, strlen(text));
}

void ll_http_text(ll_http_response *response, int status, const char *text)
{
    response->size = 0;
    response->status = status;
    snprintf(response->type, sizeof response->type, "application/json");
    ll_http_append(response, text, strlen(text));
}

bool ll_http_become_task(const ll_http_request *request, ll_http_response *response)
{
    response->to_work = request->task == NULL;
    return response->to_work;
}

/* ---- problems ---- */

void ll_http_problem_as(ll_http_response *response, const ll_http_request *request, int status,
                        const ll_status *error)
{
    cJSON *problem = ll_http_problem_json(status, error, request != NULL ? request->path : NULL);
    ll_http_json(response, status, problem);
    if (!response->failed)
        snprintf(response->type, sizeof response->type, "application/problem+json");
}

void ll_http_problem(ll_http_response *response, const ll_http_request *request, const ll_status *error)
{
    int status = ll_http_problem_status(error->code);
    if (status == 429 || status == 503)
        ll_http_problem_later(response, request, status, 5, error);
    else
        ll_http_problem_as(response, request, status, error);
}

void ll_http_problem_later(ll_http_response *response, const ll_http_request *request, int status,
                           int retry_after_s, const ll_status *error)
{
    char seconds[16];
    snprintf(seconds, sizeof seconds, "%d", retry_after_s);
    ll_http_problem_as(response, request, status, error);
    ll_http_set_header(response, "Retry-After", seconds);
}

/* ---- tags and encodings ---- */

bool ll_http_matches_tag(const char *header, const char *tag)
{
    tag += strncmp(tag, "W/", 2) == 0 ? 2 : 0;
    size_t size = strlen(tag);
    for (const char *at = header; at != NULL && *at != '\0'; at += strcspn(at, ",")) {
        at += strspn(at, ", \t");
        if (*at == '*')
            return true;
        at += strncmp(at, "W/", 2) == 0 ? 2 : 0;
        if (strncmp(at, tag, size) == 0)
            return true;
    }
    return false;
}

/* The value of `q` after an element of a list of `size` bytes; 1 when missing. */
static double quality_of(const char *element, size_t size)
{
    double value = 1;
    for (const char *at = element + strcspn(element, ";,"); at < element + size; at += strcspn(at, ";,")) {
        at += strspn(at, "; \t");
        if (at + 2 < element + size && (*at == 'q' || *at == 'Q') && at[1] == '=') {
            value = strtod(at + 2, NULL);
            value = value >= 0 && value <= 1 ? value : 0;
        }
    }
    return value;
}

bool ll_http_takes_gzip(const ll_http_request *request)
{
    const char *at = ll_http_header(request, "Accept-Encoding");
    double named = -1, star = 0;
    while (at != NULL && *at != '\0') {
        at += strspn(at, " \t,");
        size_t whole = strcspn(at, ","), name = strcspn(at, ",; \t");
        if (name == 4 && strncasecmp(at, "gzip", name) == 0)
            named = quality_of(at, whole);
        else if (name == 1 && *at == '*')
            star = quality_of(at, whole);
        at += whole;
    }
    return (named >= 0 ? named : star) > 0;
}

/* ---- Accept ---- */

/* How well a media range matches a type: 0 no match, 1 by `*`, 2 by the main type, 3 exactly. */
static int fit(const char *range, size_t size, const char *type)
{
    size_t main_size = strcspn(type, "/") + 1;
    if (size == 3 && memcmp(range, "*/*", 3) == 0)
        return 1;
    if (size == main_size + 1 && range[size - 1] == '*' && strncasecmp(range, type, main_size) == 0)
        return 2;
    return size == strlen(type) && strncasecmp(range, type, size) == 0 ? 3 : 0;
}

bool ll_http_accepts(const ll_http_request *request, const char *type, double *quality)
{
    const char *at = ll_http_header(request, "Accept");
    double best_quality = at == NULL || *at == '\0' ? 1 : 0;
    int best = 0;
    while (at != NULL && *at != '\0') {
        at += strspn(at, " \t,");
        size_t whole = strcspn(at, ","), range = strcspn(at, ",; \t");
        double value = quality_of(at, whole);
        int fits = fit(at, range, type);
        if (fits > best) {
            best = fits;
            best_quality = value;
        }
        at += whole;
    }
    if (quality != NULL)
        *quality = best_quality;
    return best_quality > 0;
}

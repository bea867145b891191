/* Turns an ll_http_response into the library's response. */
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "daemon/http/internal.h"
#include "daemon/support/gzip.h"

#define SMALL_ANSWER (64 << 10)
#define LEAST_COMPRESSED 1024
#define POOL_COMPRESS_MAX (1 << 20) /* bytes; compressing takes a few milliseconds */

/* No inline script, no foreign origin, and only in the frames of the pages that it names: the page needs none
 * of them. */
#define POLICY                                                                                               \
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "                        \
    "connect-src 'self'; font-src 'self'; manifest-src 'self'; frame-ancestors %s; "                         \
    "base-uri 'none'; form-action 'self'"

void ll_http_refuse(http_exchange *exchange, int status, ll_code code, const char *field, const char *format,
                    ...)
{
    ll_status error = ll_field_error(code, field, "%s", "");
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error.text, sizeof error.text, format, arguments);
    va_end(arguments);
    ll_http_problem_as(&exchange->response, &exchange->request, status, &error);
}

/* A reader and its context; the library frees it with the response. */
typedef struct body_reader {
    ll_http_reader *read;
    void *context;
    void (*free)(void *context);
} body_reader;

static ssize_t read_piece(void *closure, uint64_t offset, char *buffer, size_t capacity)
{
    body_reader *reader = closure;
    int64_t size = reader->read(reader->context, offset, buffer, capacity);
    if (size == 0)
        return MHD_CONTENT_READER_END_OF_STREAM;
    return size > 0 && (uint64_t)size <= capacity ? (ssize_t)size : MHD_CONTENT_READER_END_WITH_ERROR;
}

static void free_reader(void *closure)
{
    body_reader *reader = closure;
    if (reader->free != NULL)
        reader->free(reader->context);
    free(reader);
}

static struct MHD_Response *from_reader(ll_http_response *response)
{
    body_reader *reader = malloc(sizeof *reader);
    if (reader == NULL)
        return NULL;
    *reader = (body_reader){response->reader, response->reader_context, response->reader_free};
    struct MHD_Response *made =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 32 * 1024, read_piece, reader, free_reader);
    if (made == NULL) {
        free(reader);
        return NULL;
    }
    response->reader = NULL;
    response->reader_free = NULL;
    return made;
}

/* The library reads it at its own offsets, through its own descriptor. */
static struct MHD_Response *from_file(const ll_http_response *response)
{
    int fd = fcntl(fileno(response->file), F_DUPFD_CLOEXEC, 0);
    struct MHD_Response *made =
        fd < 0 ? NULL : MHD_create_response_from_fd_at_offset64(response->file_size, fd, response->file_from);
    if (made == NULL && fd >= 0)
        close(fd);
    return made;
}

/* A page of another build that asks for a file by its digest gets the present one, which no client keeps. */
static const char *cache_of(const http_exchange *exchange)
{
    return exchange->named == HTTP_OUR_DIGEST     ? "max-age=31536000, immutable"
           : exchange->named == HTTP_OTHER_DIGEST ? "no-store"
                                                  : "no-cache"; /* revalidated each time, mostly with a 304 */
}

static struct MHD_Response *from_document(http_exchange *exchange)
{
    ll_http_response *response = &exchange->response;
    const ll_http_request *request = &exchange->request;
    ll_document *document = response->document;
    const ll_document_gzip *gzip = NULL;
    char tag[LL_DOCUMENT_DIGEST + 16], other[256];
    if (ll_document_compresses(document)) {
        ll_http_set_header(response, "Vary", "Accept-Encoding");
        gzip = ll_http_takes_gzip(request) ? ll_document_compressed(document) : NULL;
    }
    snprintf(tag, sizeof tag, "\"%s%s\"", document->tag, gzip != NULL ? "-gzip" : "");
    ll_http_set_header(response, "ETag", tag);
    ll_http_set_header(response, "Cache-Control", cache_of(exchange));
    if (exchange->named == HTTP_ITS_ADDRESS && !ll_document_is_page(document)) {
        snprintf(other, sizeof other, "/%s%s", exchange->http->app.documents->digest, document->address);
        ll_http_set_header(response, "Content-Location", other);
    }
    if (ll_http_matches_tag(ll_http_header(request, "If-None-Match"), tag))
        response->status = 304; /* the library sends the length, which is that of a 200, and no body */
    else
        snprintf(response->type, sizeof response->type, "%s", document->type);
    if (gzip != NULL && response->status == 200)
        ll_http_set_header(response, "Content-Encoding", "gzip");
    if (gzip != NULL)
        return MHD_create_response_from_buffer(gzip->size, gzip->bytes, MHD_RESPMEM_PERSISTENT);
    return MHD_create_response_from_buffer(document->size, document->bytes, MHD_RESPMEM_PERSISTENT);
}

static ssize_t read_nothing(void *closure, uint64_t offset, char *buffer, size_t capacity)
{
    (void)closure, (void)offset, (void)buffer, (void)capacity;
    return MHD_CONTENT_READER_END_OF_STREAM;
}

/* Answer to HEAD when the size of the body is unknown, and 304, for which the library would say a size of 0.
 * Without the HTTP/1.0 option it would send the final chunk of a body, which the client would take for the
 * next answer. */
static struct MHD_Response *without_body(void)
{
    struct MHD_Response *made =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 64, read_nothing, NULL, NULL);
    if (made != NULL)
        MHD_set_response_options(made, MHD_RF_HTTP_1_0_COMPATIBLE_STRICT, MHD_RO_END);
    return made;
}

static struct MHD_Response *make(http_exchange *exchange)
{
    ll_http_response *response = &exchange->response;
    if (response->document != NULL)
        return from_document(exchange);
    if (response->status == 304 || (response->reader != NULL && exchange->head))
        return without_body();
    if (response->reader != NULL)
        return from_reader(response);
    if (response->file != NULL && response->file_size > 0)
        return from_file(response);
    if (response->size == 0)
        return MHD_create_response_from_buffer(0, NULL, MHD_RESPMEM_PERSISTENT);
    struct MHD_Response *made =
        MHD_create_response_from_buffer(response->size, response->bytes, MHD_RESPMEM_MUST_FREE);
    if (made != NULL) {
        response->bytes = NULL;
        response->size = response->capacity = 0;
    }
    return made;
}

/* The page of `?embed=1` has nothing to be tricked into: no key is typed there, nothing of others is changed.
 * All else is shown in no frame. */
static void add_policy(const http_exchange *exchange, struct MHD_Response *made)
{
    char origins[sizeof exchange->http->config.allow_embed], policy[sizeof POLICY + sizeof origins];
    const char *embed = ll_http_query(&exchange->request, "embed");
    snprintf(origins, sizeof origins, "%s", exchange->http->config.allow_embed);
    for (char *at = origins; (at = strpbrk(at, ",;\r\n")) != NULL;)
        *at = ' '; /* each would begin another policy, directive or header */
    bool framed = exchange->route == NULL && *origins != '\0' && embed != NULL && strcmp(embed, "1") == 0;
    snprintf(policy, sizeof policy, POLICY, framed ? origins : "'none'");
    MHD_add_response_header(made, "Content-Security-Policy", policy);
}

/* Modules, styles and words are parts of a page, whose policy holds: a policy of their own would say nothing,
 * and be an eighth of a first load. */
static bool is_part(const http_exchange *exchange)
{
    const char *type = exchange->response.type;
    return exchange->route == NULL &&
           (strncmp(type, "text/javascript", 15) == 0 || strncmp(type, "text/css", 8) == 0 ||
            strncmp(type, "application/json", 16) == 0);
}

static void add_headers(const http_exchange *exchange, struct MHD_Response *made)
{
    const ll_http_response *response = &exchange->response;
    bool cache_said = false, policy_said = false;
    for (int i = 0; i < response->headers; i++) {
        MHD_add_response_header(made, response->header[i].name, response->header[i].value);
        cache_said = cache_said || strcmp(response->header[i].name, "Cache-Control") == 0;
        policy_said = policy_said || strcmp(response->header[i].name, "Content-Security-Policy") == 0;
    }
    if (response->type[0] != '\0')
        MHD_add_response_header(made, "Content-Type", response->type);
    if (!cache_said)
        MHD_add_response_header(made, "Cache-Control", "no-store");
    MHD_add_response_header(made, "X-Request-Id", exchange->request.id);
    MHD_add_response_header(made, "X-Content-Type-Options", "nosniff");
    MHD_add_response_header(made, "Referrer-Policy", "no-referrer");
    if (!policy_said && !is_part(exchange))
        add_policy(exchange, made);
    MHD_add_response_header(made, "Cross-Origin-Resource-Policy",
                            exchange->cross_origin ? "cross-origin" : "same-origin");
    if (exchange->cross_origin) {
        MHD_add_response_header(made, "Access-Control-Allow-Origin",
                                ll_http_header(&exchange->request, "Origin"));
        MHD_add_response_header(made, "Access-Control-Expose-Headers",
                                "Location, Content-Location, Retry-After, X-Request-Id, ETag, Content-Range, "
                                "Accept-Ranges");
    }
    if (*exchange->http->config.allow_origin != '\0')
        MHD_add_response_header(made, "Vary", "Origin");
}

/* Compresses answers that are in memory and were made outside of the threads that read requests. Not those to
 * POST, which contain keys: a compressed size could leak them. */
void ll_http_compress(http_exchange *exchange)
{
    ll_http_response *response = &exchange->response;
    const ll_http_request *request = &exchange->request;
    char *bytes = NULL;
    size_t size = 0;
    if (response->status != 200 || response->size < LEAST_COMPRESSED || response->failed || exchange->head ||
        strcmp(request->method, "GET") != 0 || !ll_gzip_compresses(response->type))
        return;
    ll_http_set_header(response, "Vary", "Accept-Encoding");
    if ((request->task == NULL && response->size > POOL_COMPRESS_MAX) || !ll_http_takes_gzip(request))
        return;
    ll_status status =
        ll_gzip_bytes(response->bytes, response->size, LL_GZIP_FAST, request->task, &bytes, &size);
    if (ll_failed(&status))
        return; /* the uncompressed answer is sent, without compression */
    free(response->bytes);
    response->bytes = bytes;
    response->size = response->capacity = size;
    ll_http_set_header(response, "Content-Encoding", "gzip");
}

static int64_t answer_size(const ll_http_response *response)
{
    return (int64_t)(response->size + response->held);
}

/* Counts a large answer until it is sent; false when the limit is reached. Small ones are not counted. */
static bool count_answer(http_exchange *exchange)
{
    ll_http *http = exchange->http;
    int64_t size = answer_size(&exchange->response), most = http->config.max_answers_mib << 20;
    if (size <= SMALL_ANSWER)
        return true;
    if (atomic_fetch_add(&http->answer_bytes, size) + size <= most) {
        exchange->counted = size;
        return true;
    }
    atomic_fetch_sub(&http->answer_bytes, size);
    atomic_fetch_add(&http->refused_answers, 1);
    return false;
}

enum MHD_Result ll_http_send(http_exchange *exchange)
{
    exchange->phase = HTTP_QUEUED;
    if (exchange->response.failed) {
        ll_http_clear(&exchange->response);
        ll_status error = ll_error(LL_NO_MEMORY, "out of memory: answer");
        ll_http_problem_later(&exchange->response, &exchange->request, 503, 5, &error);
    }
    if (!count_answer(exchange)) {
        ll_status error = ll_error(LL_NO_MEMORY,
                                   "%.1f MiB of answers are being sent, and this one has %.1f MiB; the limit "
                                   "is reached (max_answers_mib)",
                                   (double)atomic_load(&exchange->http->answer_bytes) / 1048576.0,
                                   (double)answer_size(&exchange->response) / 1048576.0);
        ll_http_clear(&exchange->response);
        ll_http_problem_later(&exchange->response, &exchange->request, 503, 5, &error);
    }
    struct MHD_Response *made = make(exchange);
    if (made == NULL)
        return MHD_NO; /* closes the connection: not even the refusal could be made */
    add_headers(exchange, made);
    ll_http_deadline(exchange, exchange->http->config.response_timeout_s);
    enum MHD_Result result =
        MHD_queue_response(exchange->connection, (unsigned)exchange->response.status, made);
    MHD_destroy_response(made);
    return result;
}

#include "support/server_fixture.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "base/assert.h"
#include "base/rng.h"
#include "session/section.h"
#include "support/decode.h"

int64_t test_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

void test_sleep(double seconds)
{
    struct timespec t = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};
    nanosleep(&t, NULL);
}

/* ---- handlers ---- */

static void handle_hello(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context, (void)request;
    ll_http_text(response, 200, "{\"ok\":true}");
}

static void handle_echo(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    const char *query = ll_http_query(request, "q");
    snprintf(response->type, sizeof response->type, "text/plain");
    ll_http_printf(response, "%s|%s|%s|", request->parameter[0],
                   request->parameter[1] != NULL ? request->parameter[1] : "", query != NULL ? query : "");
    ll_http_append(response, request->body, request->body_size);
}

static void handle_slow(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context, (void)request;
    test_sleep(0.3);
    ll_http_text(response, 200, "slow");
}

static int64_t read_lines(void *context, uint64_t offset, char *buffer, size_t capacity)
{
    int *left = context;
    (void)offset;
    if (*left == 0) {
        return 0;
    }
    --*left;
    return snprintf(buffer, capacity, "line %d\n", *left);
}

static void handle_lines(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context, (void)request;
    int *left = malloc(sizeof *left);
    LL_ASSERT(left != NULL);
    *left = 1000;
    snprintf(response->type, sizeof response->type, "text/csv");
    response->reader = read_lines;
    response->reader_context = left;
    response->reader_free = free;
}

static void handle_limit(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    ll_status error = ll_field_error(LL_LIMIT, "sessions", "there are 10 sessions already (max_sessions)");
    ll_http_problem(response, request, &error);
}

static const ll_http_route routes[] = {
    {.method = "GET", .pattern = "/healthz", .handler = handle_hello},
    {.method = "GET", .pattern = "/limit", .handler = handle_limit},
    {.method = "GET", .pattern = "/slow", .handler = handle_slow, .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = "/lines", .handler = handle_lines},
    {.method = "GET", .pattern = "/echo/{a}/then/{b*}", .handler = handle_echo},
    {.method = "GET", .pattern = "/echo/{a}", .handler = handle_echo},
    {.method = "POST",
     .pattern = "/echo/{a}",
     .handler = handle_echo,
     .body_limit = 1000,
     .types = "application/json, text/plain"},
    {.method = "DELETE", .pattern = "/echo/{a}", .handler = handle_echo},
};

/* ---- streams ---- */

static void on_opened(void *context, void *session, ll_ws_viewer viewer, ll_frame_format format)
{
    test_server *f = context;
    static const char hello[] = "{\"type\":\"hello\"}";
    (void)session, (void)format;
    atomic_fetch_add(&f->opened, 1);
    if (atomic_load(&f->send_hello)) {
        const ll_ws_subscription all = {.every = {[LL_CHANNEL_SCENE] = 1}};
        ll_ws_hello(f->ws, viewer, hello, sizeof hello - 1);
        ll_ws_subscribe(f->ws, viewer, &all);
    }
}

static void on_message(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length)
{
    test_server *f = context;
    (void)session;
    char *answer = malloc(length + 16);
    LL_ASSERT(answer != NULL);
    int size = snprintf(answer, length + 16, "{\"echo\":%s}", text);
    ll_ws_send(f->ws, viewer, answer, (size_t)size);
    free(answer);
}

static void on_closed(void *context, void *session, ll_ws_viewer viewer)
{
    test_server *f = context;
    (void)session, (void)viewer;
    atomic_fetch_add(&f->closed, 1);
}

static void on_released(void *context, void *session)
{
    test_server *f = context;
    (void)session;
    atomic_fetch_add(&f->released, 1);
}

/* As a publisher that is as fast as can be, but finds nothing to publish: it reads the wants before the hook
 * returns. While the fixture publishes, its thread reads them. */
static void on_wanted(void *context, void *session)
{
    test_server *f = context;
    ll_record_request request = {0};
    if (session == NULL || atomic_load(&f->publishing)) {
        return;
    }
    ll_ws_wants(*(ll_ws_stream **)session, 1, 0, true, &request);
    atomic_fetch_add(request.channels != 0 ? &f->wanted : &f->wanted_nothing, 1);
}

typedef struct stamp {
    uint32_t seq;
} stamp;

typedef struct noise {
    uint16_t width, height;
} noise;

static const ll_record_field stamp_fields[] = {LL_INT(stamp, seq, NULL, "of its frame")};
static const ll_record_field noise_fields[] = {LL_INT(noise, width, NULL, "cells"),
                                               LL_INT(noise, height, NULL, "cells")};
static const ll_record stamp_record = {.id = 1,
                                       .name = "stamp",
                                       .channel = LL_CHANNEL_SCENE,
                                       .help = "A row a frame.",
                                       .form = LL_FORM_LOG,
                                       LL_ROWS_OF(stamp, stamp_fields)};
static const ll_record noise_record = {.id = 2,
                                       .name = "noise",
                                       .channel = LL_CHANNEL_SCENE,
                                       .help = "Bytes that cannot be shortened.",
                                       .form = LL_FORM_GRID,
                                       LL_ROWS_OF(noise, noise_fields)};

static ll_frame *frame_of(const test_server *f, uint32_t seq, uint32_t generation, uint16_t channels)
{
    ll_frame *frame = calloc(1, sizeof *frame);
    ll_rows *stamps = ll_rows_new(&stamp_record, 1), *noises = ll_rows_new(&noise_record, 1);
    uint8_t *bytes = malloc(f->frame_bytes);
    LL_ASSERT(frame != NULL && stamps != NULL && noises != NULL && bytes != NULL);
    for (size_t i = 0; i < f->frame_bytes; i++) {
        bytes[i] = (uint8_t)ll_rng_u64(seq, 0, i);
    }
    stamp now = {seq};
    noise shape = {(uint16_t)f->frame_bytes, 1};
    stamps->first = seq;
    ll_rows_add(stamps, &now, 1);
    ll_rows_add_plane(noises, &shape, bytes);
    free(bytes);
    *frame = (ll_frame){.seq = seq,
                        .generation = generation,
                        .channels = channels,
                        .flags = LL_FRAME_PLAYING,
                        .tick = seq,
                        .count = 2,
                        .record = {&stamp_record, &noise_record},
                        .section = {ll_section_new(stamps, seq), ll_section_new(noises, seq)}};
    ll_rows_free(stamps);
    ll_rows_free(noises);
    atomic_init(&frame->references, 1);
    return frame;
}

static void publish(test_server *f, ll_ws_stream *stream, uint32_t seq)
{
    uint32_t generation = atomic_load(&f->generation);
    ll_record_request request;
    ll_ws_wants(stream, seq, generation, false, &request);
    if (request.channels != 0) {
        ll_frame *frame = frame_of(f, seq, generation, request.channels);
        ll_ws_publish(stream, frame);
        ll_frame_release(frame);
    }
}

static void *publish_all(void *argument)
{
    test_server *f = argument;
    int64_t next = test_now();
    uint32_t seq = 0;
    while (!atomic_load(&f->end)) {
        next += 16666667;
        struct timespec t = {next / 1000000000, next % 1000000000};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        seq++;
        for (int s = 0; atomic_load(&f->publishing) && s < FRONT_SESSIONS; s++) {
            publish(f, f->stream[s], seq);
        }
        atomic_store(&f->published, seq);
        ll_ws_flush(f->ws);
    }
    return NULL;
}

/* ---- open and close ---- */

void test_server_prepare(test_server *f)
{
    *f = (test_server){.frame_bytes = 1000};
    ll_param_defaults(&ll_web_server_table, &f->config);
    snprintf(f->config.listen, sizeof f->config.listen, "127.0.0.1:0");
    atomic_store(&f->publishing, true);
    atomic_store(&f->send_hello, 1);
}

static bool has_started(void *context, const ll_http_request *request, ll_http_response *response)
{
    test_server *f = context;
    ll_status status = ll_error(LL_LIMIT, "starting");
    if (!atomic_load(&f->starting)) {
        return true;
    }
    ll_http_problem_later(response, request, 503, 1, &status);
    return false;
}

void test_server_open(test_server *f)
{
    ll_http_app app = {.routes = routes,
                       .route_count = sizeof routes / sizeof *routes,
                       .context = f,
                       .documents = &f->documents,
                       .started = has_started};
    ll_ws_hooks hooks = {.context = f,
                         .opened = on_opened,
                         .message = on_message,
                         .closed = on_closed,
                         .wanted = on_wanted,
                         .released = on_released};
    ll_status status = ll_web_server_open(&f->config, &app, &f->web_server);
    if (ll_failed(&status)) {
        fprintf(stderr, "%s\n", status.text);
        abort();
    }
    f->ws = ll_web_server_ws(f->web_server);
    ll_ws_set_hooks(f->ws, LL_STREAM_SESSION, &hooks);
    f->port = ll_web_server_port(f->web_server);
    for (int s = 0; s < FRONT_SESSIONS; s++) {
        char id[16];
        snprintf(id, sizeof id, "s%d", s);
        status = ll_ws_stream_open(f->ws, LL_STREAM_SESSION, id, &f->stream[s], &f->stream[s]);
        LL_ASSERT(!ll_failed(&status));
    }
    LL_ASSERT(pthread_create(&f->publisher, NULL, publish_all, f) == 0);
}

void test_server_close(test_server *f)
{
    ll_web_server_drain(f->web_server);
    atomic_store(&f->end, true);
    pthread_join(f->publisher, NULL);
    ll_web_server_close(f->web_server);
    ll_documents_free(&f->documents);
}

/* ---- a client ---- */

int net_connect(uint16_t port)
{
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), on = 1;
    if (fd >= 0 && connect(fd, (struct sockaddr *)&address, sizeof address) != 0) {
        close(fd);
        return -1;
    }
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return fd;
}

bool net_send_bytes(int fd, const void *bytes, size_t size)
{
    const char *at = bytes;
    while (size > 0) {
        ssize_t sent = send(fd, at, size, MSG_NOSIGNAL);
        if (sent <= 0) {
            return false;
        }
        at += sent;
        size -= (size_t)sent;
    }
    return true;
}

bool net_send(int fd, const char *text)
{
    return net_send_bytes(fd, text, strlen(text));
}

/* -1: timeout; 0: end; otherwise bytes read. */
static ssize_t read_some(int fd, void *bytes, size_t size, int64_t until)
{
    int64_t left = until - test_now();
    struct pollfd event = {.fd = fd, .events = POLLIN};
    if (poll(&event, 1, left > 0 ? (int)(left / 1000000) + 1 : 0) <= 0) {
        return -1;
    }
    ssize_t got = recv(fd, bytes, size, 0);
    return got < 0 ? 0 : got;
}

size_t net_read(int fd, char *text, size_t capacity, const char *needle, double seconds)
{
    int64_t until = test_now() + (int64_t)(seconds * 1e9);
    size_t size = 0;
    text[0] = '\0';
    while (size + 1 < capacity && (needle == NULL || memmem(text, size, needle, strlen(needle)) == NULL)) {
        ssize_t got = read_some(fd, text + size, capacity - 1 - size, until);
        if (got <= 0) {
            break;
        }
        size += (size_t)got;
        text[size] = '\0';
    }
    return size;
}

bool net_closed(int fd, double seconds)
{
    int64_t until = test_now() + (int64_t)(seconds * 1e9);
    char bytes[4096];
    ssize_t got;
    do {
        got = read_some(fd, bytes, sizeof bytes, until);
    } while (got > 0);
    return got == 0;
}

bool net_header(const char *answer, const char *name, char *value, size_t capacity)
{
    size_t length = strlen(name);
    for (const char *line = strstr(answer, "\r\n"); line != NULL; line = strstr(line + 2, "\r\n")) {
        if (strncasecmp(line + 2, name, length) == 0 && line[2 + length] == ':') {
            const char *begin = line + 3 + length;
            begin += strspn(begin, " ");
            snprintf(value, capacity, "%.*s", (int)strcspn(begin, "\r\n"), begin);
            return true;
        }
    }
    return false;
}

/* Reads byte by byte to the end of the head: what follows is for the next reader. */
static size_t read_head(int fd, char *answer, size_t capacity, int64_t until)
{
    size_t size = 0;
    while (size + 1 < capacity && (size < 4 || memcmp(answer + size - 4, "\r\n\r\n", 4) != 0)) {
        if (read_some(fd, answer + size, 1, until) <= 0) {
            break;
        }
        size++;
    }
    answer[size] = '\0';
    return size;
}

static int status_of(const char *answer)
{
    return strncmp(answer, "HTTP/1.1 ", 9) == 0 ? atoi(answer + 9) : 0;
}

int net_request(int fd, const char *request, char *answer, size_t capacity)
{
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    char value[32];
    net_send(fd, request);
    size_t size = read_head(fd, answer, capacity, until);
    size_t body = net_header(answer, "Content-Length", value, sizeof value) ? strtoul(value, NULL, 10) : 0;
    bool has_body = strncmp(request, "HEAD", 4) != 0 && status_of(answer) != 304;
    size_t end = size + (has_body ? body : 0);
    while (size < end && size + 1 < capacity) {
        ssize_t got = read_some(fd, answer + size, (end < capacity - 1 ? end : capacity - 1) - size, until);
        if (got <= 0) {
            break;
        }
        size += (size_t)got;
        answer[size] = '\0';
    }
    return status_of(answer);
}

int net_ask(uint16_t port, const char *request, char *answer, size_t capacity)
{
    int fd = net_connect(port);
    int status = net_request(fd, request, answer, capacity);
    close(fd);
    return status;
}

/* ---- a viewer ---- */

int viewer_upgrade(int fd, const char *session, const char *protocol, const char *extra)
{
    char text[4096];
    snprintf(text, sizeof text,
             "GET /api/v1/sessions/%s/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: "
             "websocket\r\nConnection: Upgrade\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: %s\r\n%s\r\n",
             session, protocol, extra);
    net_send(fd, text);
    read_head(fd, text, sizeof text, test_now() + LIMIT_S * INT64_C(1000000000));
    /* The key and the answer of RFC 6455 1.3. */
    if (status_of(text) == 101 && strstr(text, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=") == NULL) {
        return 0;
    }
    return status_of(text);
}

int viewer_open(uint16_t port, const char *session, const char *protocol)
{
    int fd = net_connect(port);
    if (fd >= 0 && viewer_upgrade(fd, session, protocol, "") != 101) {
        close(fd);
        return -1;
    }
    return fd;
}

bool viewer_send(int fd, int opcode, const void *bytes, size_t size)
{
    static const unsigned char mask[4] = {0x11, 0x22, 0x33, 0x44};
    unsigned char *frame = malloc(size + 14);
    size_t at = 0;
    LL_ASSERT(frame != NULL);
    frame[at++] = (unsigned char)opcode;
    if (size < 126) {
        frame[at++] = (unsigned char)(0x80 | size);
    } else if (size < 65536) {
        frame[at++] = 0x80 | 126;
        frame[at++] = (unsigned char)(size >> 8);
        frame[at++] = (unsigned char)size;
    } else {
        frame[at++] = 0x80 | 127;
        for (int shift = 56; shift >= 0; shift -= 8) {
            frame[at++] = (unsigned char)((uint64_t)size >> shift);
        }
    }
    memcpy(frame + at, mask, 4);
    at += 4;
    for (size_t i = 0; i < size; i++) {
        frame[at++] = ((const unsigned char *)bytes)[i] ^ mask[i % 4];
    }
    bool sent = net_send_bytes(fd, frame, at);
    free(frame);
    return sent;
}

bool viewer_say(int fd, const char *text)
{
    return viewer_send(fd, 0x81, text, strlen(text));
}

bool viewer_ack(int fd, uint32_t seq)
{
    char text[32];
    snprintf(text, sizeof text, "{\"ack\":%u}", seq);
    return viewer_say(fd, text);
}

static bool read_all(int fd, void *bytes, size_t size, int64_t until)
{
    for (size_t at = 0; at < size;) {
        ssize_t got = read_some(fd, (char *)bytes + at, size - at, until);
        if (got <= 0) {
            return false;
        }
        at += (size_t)got;
    }
    return true;
}

bool viewer_piece(int fd, viewer_frame *frame, double seconds)
{
    int64_t until = test_now() + (int64_t)(seconds * 1e9);
    unsigned char head[10];
    if (!read_all(fd, head, 2, until)) {
        return false;
    }
    until = test_now() + LIMIT_S * INT64_C(1000000000); /* a frame that has begun is read to its end */
    frame->opcode = head[0] & 15;
    frame->size = head[1] & 127;
    size_t more = frame->size == 126 ? 2 : frame->size == 127 ? 8 : 0;
    if (head[1] & 128 || !read_all(fd, head + 2, more, until)) {
        return false;
    }
    for (size_t i = 0; i < more; i++) {
        frame->size = (i == 0 ? 0 : frame->size << 8) | head[2 + i];
    }
    if (frame->size >= sizeof frame->bytes || !read_all(fd, frame->bytes, frame->size, until)) {
        return false;
    }
    frame->bytes[frame->size] = '\0';
    return true;
}

bool viewer_read(int fd, viewer_frame *frame, double seconds)
{
    do {
        if (!viewer_piece(fd, frame, seconds)) {
            return false;
        }
        if (frame->opcode == 9) {
            viewer_send(fd, 0x8a, frame->bytes, frame->size);
        }
    } while (frame->opcode == 9);
    return true;
}

static uint64_t varint(const unsigned char **at)
{
    uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
        value |= (uint64_t)(**at & 127) << shift;
        if (*(*at)++ < 128) {
            return value;
        }
    }
}

uint32_t viewer_seq(const viewer_frame *frame)
{
    const unsigned char *at = frame->bytes + 2;
    return (uint32_t)varint(&at);
}

bool viewer_is_whole(const viewer_frame *frame)
{
    return frame->bytes[1] & LL_FRAME_JUMP;
}

int viewer_close_code(int fd, double seconds)
{
    int64_t until = test_now() + (int64_t)(seconds * 1e9);
    viewer_frame frame;
    while (test_now() < until) {
        if (!viewer_read(fd, &frame, (double)(until - test_now()) * 1e-9)) {
            return test_now() < until ? -1 : 0;
        }
        if (frame.opcode == 8) {
            return frame.size >= 2 ? frame.bytes[0] << 8 | frame.bytes[1] : 1005;
        }
    }
    return 0;
}

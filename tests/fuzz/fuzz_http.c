/* Whole requests from a socket: through connection limiter, head parser and HTTP library to a handler, one
 * after the other on a kept connection, until the client closes. A second, restricted reader of RFC 9112
 * follows plain requests: handlers must be called with exactly these, and not for a request that two readers
 * could take for two (a body with two lengths, an unknown coding), nor for later ones. Output must be whole
 * answers. */
#include "check.h"

#include <ctype.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <strings.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "daemon/http/http.h"
#include "daemon/listener/web_server.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/proxies.h"
#include "daemon/net/upgrade.h"
#include "daemon/stream/ws.h"

#define LONG 4096
#define BODY 256 /* body limit of a route */
#define CALLS 256
#define PATH 128
#define LATE_NS INT64_C(15000000000) /* half of the body timeout */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* ---- the daemon ---- */

typedef struct handled {
    char method[8], path[PATH];
    size_t body_size;
    char body[BODY];
} handled;

static struct {
    ll_connection_limiter *connection_limiter;
    ll_ws *ws;
    ll_ws_stream *stream;
    ll_http *http;
    ll_allow allow;
    ll_proxies proxies;
    pthread_mutex_t lock;
    handled call[CALLS];
    int calls;
} side = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void handler(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    pthread_mutex_lock(&side.lock);
    FUZZ_CHECK(side.calls < CALLS && request->body_size <= BODY && request->body[request->body_size] == '\0');
    handled *c = &side.call[side.calls++];
    snprintf(c->method, sizeof c->method, "%s", request->head ? "HEAD" : request->method);
    snprintf(c->path, sizeof c->path, "%s", request->path);
    c->body_size = request->body_size;
    memcpy(c->body, request->body, request->body_size);
    pthread_mutex_unlock(&side.lock);
    ll_http_text(response, 200, request->parameter[0]);
}

static void on_opened(void *context, void *session, ll_ws_viewer viewer, ll_frame_format format)
{
    (void)context, (void)session, (void)format;
    ll_ws_hello(side.ws, viewer, "{}", 2);
}

static void on_message(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length)
{
    (void)context, (void)session, (void)viewer, (void)text, (void)length;
}

static void on_closed(void *context, void *session, ll_ws_viewer viewer)
{
    (void)context, (void)session, (void)viewer;
}

static void start(void)
{
    static const ll_http_route routes[] = {
        {.method = "GET", .pattern = "/x/{name}", .handler = handler},
        {.method = "POST", .pattern = "/x/{name}", .handler = handler, .body_limit = BODY},
        {.method = "DELETE", .pattern = "/x/{name}", .handler = handler, .query = "q,points"},
    };
    const ll_ws_hooks hooks = {.opened = on_opened, .message = on_message, .closed = on_closed};
    const ll_http_app app = {.routes = routes, .route_count = 3};
    ll_web_server_config config;
    ll_param_defaults(&ll_web_server_table, &config);
    config.stream_threads = config.http_threads = config.control_threads = 1;
    config.www[0] = '\0';
    config.max_head_bytes = LONG;
    side.connection_limiter = ll_connection_limiter_new(1000, 1000);
    FUZZ_CHECK(side.connection_limiter != NULL);
    ll_status status = ll_proxies_parse("", &side.proxies);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_ws_start(&config, side.connection_limiter, &side.ws);
    FUZZ_CHECK(!fuzz_failed(&status));
    ll_ws_set_hooks(side.ws, LL_STREAM_SESSION, &hooks);
    status = ll_ws_stream_open(side.ws, LL_STREAM_SESSION, "s", &side, &side.stream);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_http_start(&config, &app, &side.allow, &side.proxies, side.connection_limiter, side.ws,
                           &side.http);
    FUZZ_CHECK(!fuzz_failed(&status));
}

/* ---- the second reader ---- */

typedef struct plain {
    char method[8];
    const char *target;
    size_t target_size;
    bool ambiguous; /* plain, except that the length of its body is ambiguous */
    bool whole;     /* head and body are complete */
    bool called;    /* a handler must be called for it */
    size_t body_size;
    char body[LONG];
} plain;

typedef struct text {
    const char *at, *end;
} text;

static bool take_line(text *rest, text *line)
{
    const char *feed = memchr(rest->at, '\n', (size_t)(rest->end - rest->at));
    if (feed == NULL || feed == rest->at || feed[-1] != '\r')
        return false;
    *line = (text){rest->at, feed - 1};
    rest->at = feed + 1;
    return true;
}

static bool only(const char *at, const char *end, const char *beside)
{
    for (; at < end; at++)
        if (!isalnum((unsigned char)*at) && (*at == '\0' || strchr(beside, *at) == NULL))
            return false;
    return true;
}

static bool first_line(text line, plain *p)
{
    static const char *const methods[] = {"GET", "HEAD", "POST", "DELETE", "PUT", "PATCH"};
    const char *space = memchr(line.at, ' ', (size_t)(line.end - line.at));
    const char *version = line.end - strlen(" HTTP/1.1");
    if (space == NULL || version <= space || memcmp(version, " HTTP/1.1", 9) != 0)
        return false;
    p->target = space + 1;
    p->target_size = (size_t)(version - p->target);
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
        if ((size_t)(space - line.at) == strlen(methods[i]) &&
            memcmp(line.at, methods[i], strlen(methods[i])) == 0)
            snprintf(p->method, sizeof p->method, "%s", methods[i]);
    return p->method[0] != '\0' && p->target_size > 1 && p->target_size < PATH && p->target[0] == '/' &&
           only(p->target, version, "/-_.");
}

/* A number of at most six digits in the base; -1: invalid. */
static long number(const char *at, const char *end, int base)
{
    char digits[8] = "";
    if (end - at < 1 || end - at > 6)
        return -1;
    memcpy(digits, at, (size_t)(end - at));
    for (const char *d = digits; d < digits + (end - at); d++) /* a NUL is no digit */
        if (base == 10 ? !isdigit((unsigned char)*d) : !isxdigit((unsigned char)*d))
            return -1;
    return strtol(digits, NULL, base);
}

static bool is_name(text line, const char *colon, const char *name)
{
    return (size_t)(colon - line.at) == strlen(name) && strncasecmp(line.at, name, strlen(name)) == 0;
}

typedef struct fields {
    int hosts, lengths, codings, others;
    long length;
    bool local, chunked;
} fields;

static bool one_field(text line, fields *f)
{
    const char *colon = memchr(line.at, ':', (size_t)(line.end - line.at));
    if (colon == NULL || colon == line.at || line.end - colon < 3 || colon[1] != ' ' ||
        !only(line.at, colon, "-") || !only(colon + 2, line.end, "-_./=*"))
        return false;
    text value = {colon + 2, line.end};
    if (is_name(line, colon, "Host")) {
        f->hosts++;
        f->local = value.end - value.at == 9 && memcmp(value.at, "localhost", 9) == 0;
    } else if (is_name(line, colon, "Content-Length")) {
        f->lengths++;
        f->length = number(value.at, value.end, 10);
        return f->length >= 0;
    } else if (is_name(line, colon, "Transfer-Encoding")) {
        f->codings++;
        f->chunked = value.end - value.at == 7 && strncasecmp(value.at, "chunked", 7) == 0;
    } else {
        /* The answer to requests with unknown headers may be any. */
        f->others += !is_name(line, colon, "Accept") && !is_name(line, colon, "X-Other");
    }
    return true;
}

static bool take_bytes(text *rest, long size, plain *p)
{
    if (rest->end - rest->at < size)
        return false;
    memcpy(p->body + p->body_size, rest->at, (size_t)size);
    p->body_size += (size_t)size;
    rest->at += size;
    return true;
}

static bool take_chunks(text *rest, plain *p)
{
    for (;;) {
        text line;
        if (!take_line(rest, &line))
            return false;
        long size = number(line.at, line.end, 16);
        if (size < 0 || (size > 0 && !take_bytes(rest, size, p)))
            return false;
        if (!take_line(rest, &line) || line.at != line.end)
            return false;
        if (size == 0)
            return true;
    }
}

/* False where this reader stops. */
static bool take_request(text *rest, plain *p)
{
    text line;
    fields f = {0};
    memset(p, 0, offsetof(plain, body));
    if (!take_line(rest, &line) || !first_line(line, p))
        return false;
    for (;;) {
        if (!take_line(rest, &line))
            return false;
        if (line.at == line.end)
            break;
        if (!one_field(line, &f))
            return false;
    }
    p->ambiguous = f.lengths > 1 || f.codings > 1 || (f.codings > 0 && (f.lengths > 0 || !f.chunked));
    if (p->ambiguous)
        return true;
    p->whole = f.codings > 0 ? take_chunks(rest, p) : take_bytes(rest, f.length, p);
    bool reads = strcmp(p->method, "POST") != 0;
    bool known = strcmp(p->method, "PUT") != 0 && strcmp(p->method, "PATCH") != 0;
    bool bodied = f.length > 0 || f.codings > 0;
    const char *name = p->target + 3, *end = p->target + p->target_size;
    p->called = p->whole && f.hosts == 1 && f.local && f.others == 0 && known && !(reads && bodied) &&
                p->body_size <= BODY && end > name && memcmp(p->target, "/x/", 3) == 0 &&
                memchr(name, '/', (size_t)(end - name)) == NULL;
    return p->whole;
}

static bool is_call_of(const handled *c, const plain *p)
{
    return strcmp(c->method, p->method) == 0 && strlen(c->path) == p->target_size &&
           memcmp(c->path, p->target, p->target_size) == 0 && c->body_size == p->body_size &&
           memcmp(c->body, p->body, p->body_size) == 0;
}

/* ---- output ---- */

static bool is_bodyless(int status, bool head)
{
    return head || status == 204 || status == 304 || status < 200;
}

/* Status of one answer; 0: none. */
static int take_answer(text *rest, bool head)
{
    text line;
    long length = -1;
    bool chunked = false;
    if (rest->at == rest->end)
        return 0;
    FUZZ_CHECK(take_line(rest, &line) && line.end - line.at >= 13 && memcmp(line.at, "HTTP/1.", 7) == 0);
    int status = (int)number(line.at + 9, line.at + 12, 10);
    FUZZ_CHECK(status >= 100 && status < 600 && line.at[8] == ' ');
    for (;;) {
        FUZZ_CHECK(take_line(rest, &line));
        if (line.at == line.end)
            break;
        const char *colon = memchr(line.at, ':', (size_t)(line.end - line.at));
        FUZZ_CHECK(colon != NULL && only(line.at, colon, "-"));
        for (const char *c = line.at; c < line.end; c++)
            FUZZ_CHECK((unsigned char)*c >= ' ' && *c != 0x7f);
        if (is_name(line, colon, "Content-Length"))
            length = number(colon + 2, line.end, 10);
        chunked = chunked || is_name(line, colon, "Transfer-Encoding");
    }
    if (is_bodyless(status, head))
        return status;
    FUZZ_CHECK(chunked != (length >= 0));
    plain body = {0};
    if (chunked)
        FUZZ_CHECK(take_chunks(rest, &body));
    FUZZ_CHECK(chunked || rest->end - rest->at >= length);
    rest->at += chunked ? 0 : length;
    return status;
}

/* ---- one connection ---- */

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Until the peer closes. The acceptor's thread would watch connections meanwhile. */
static size_t read_all(int fd, char *answer, size_t room, bool *cut)
{
    size_t got = 0;
    int64_t late = now_ns() + LATE_NS;
    for (;;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        int ready = poll(&p, 1, 5);
        if (ready < 0) { /* libFuzzer's timer interrupts waits */
            FUZZ_CHECK(errno == EINTR);
            continue;
        }
        if (ready == 0) {
            FUZZ_CHECK(now_ns() < late);
            *cut = true; /* possibly, on a slow machine */
            ll_http_watch(side.http, now_ns());
            continue;
        }
        ssize_t n = read(fd, answer + got, room - got);
        if (n < 0 && errno == EINTR)
            continue;
        *cut = *cut || n < 0; /* closed with unread bytes: output may be lost */
        if (n <= 0)
            return got;
        got += (size_t)n;
        FUZZ_CHECK(got < room);
    }
}

/* A connection that was cut is at its end here before it is at the server, which may still be calling the
 * handlers of requests that it had read. */
static void wait_for_end(void)
{
    int64_t late = now_ns() + LATE_NS;
    while (ll_connection_limiter_count(side.connection_limiter) > 0) {
        FUZZ_CHECK(now_ns() < late);
        sched_yield();
    }
}

/* Compares calls and answers with the plain requests. `whole`: no answer was lost. */
static void compare(const uint8_t *data, size_t size, const char *answer, size_t answered, bool whole)
{
    static plain p;
    bool must = whole; /* nothing has closed the connection so far */
    text rest = {(const char *)data, (const char *)data + size}, sent = {answer, answer + answered};
    int seen = 0;
    while (take_request(&rest, &p) && !p.ambiguous) {
        bool call = seen < side.calls && is_call_of(&side.call[seen], &p);
        FUZZ_CHECK(call || !p.called || !must);
        seen += call;
        int status = whole ? take_answer(&sent, strcmp(p.method, "HEAD") == 0) : 200;
        FUZZ_CHECK(status != 0 || !must);
        must = must && p.called;
        if (status == 0 || status == 101)
            return;
    }
    if (p.ambiguous)
        FUZZ_CHECK(seen == side.calls);
    for (int i = seen; i < side.calls; i++)
        FUZZ_CHECK(strlen(side.call[i].path) > 0 && side.call[i].path[0] == '/');
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char answer[1 << 20];
    struct sockaddr_in from = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    int ends[2];
    ll_head head;
    ll_upgrade upgrade;
    int refusal;
    if (side.http == NULL)
        start();
    if (size > LONG || ll_head_parse((const char *)data, size, &head) != LL_HEAD_WHOLE)
        return 0; /* the acceptor answers it: see fuzz_head.c */
    ll_status status = ll_upgrade_check(&head, &side.allow, &upgrade, &refusal);
    if (!fuzz_failed(&status) && ll_ws_knows(side.ws, &upgrade))
        return 0; /* a stream's: see fuzz_frames.c */
    FUZZ_CHECK(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) == 0);
    side.calls = 0;
    FUZZ_CHECK(write(ends[0], data, size) == (ssize_t)size);
    shutdown(ends[0], SHUT_WR);
    ll_connection_limiter_pass pass = ll_proxies_pass(&side.proxies, (const struct sockaddr *)&from);
    FUZZ_CHECK(ll_connection_limiter_enter(side.connection_limiter, &pass) == LL_CONNECTION_LIMITER_OPEN);
    FUZZ_CHECK(ll_http_adopt(side.http, ends[1], (const struct sockaddr *)&from, sizeof from));
    bool cut = false;
    size_t answered = read_all(ends[0], answer, sizeof answer, &cut);
    close(ends[0]);
    wait_for_end();
    pthread_mutex_lock(&side.lock);
    compare(data, size, answer, answered, !cut);
    pthread_mutex_unlock(&side.lock);
    return 0;
}

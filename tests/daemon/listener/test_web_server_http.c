/* HTTP: routes, refusals, files, bodies, kept connections. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <cjson/cJSON.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/server_fixture.h"

#define HOST "Host: localhost\r\n"
#define GET(path) "GET " path " HTTP/1.1\r\n" HOST "\r\n"

#define LINE "export const one = 1;\n"
#define MODULE LINE LINE LINE LINE LINE LINE
#define SECOND 17 /* characters before a path in its second address */

static test_server f;
static char www[64];

static void write_file(const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", www, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static int set_up(void **state)
{
    (void)state;
    char path[128];
    snprintf(www, sizeof www, "/tmp/laglab-www-XXXXXX");
    assert_non_null(mkdtemp(www));
    snprintf(path, sizeof path, "%s/js", www);
    mkdir(path, 0755);
    write_file("index.html", "<!doctype html><title>page</title><script src=\"js/page.js\"></script>");
    write_file("js/page.js", MODULE);
    write_file(".secret", "hidden");
    test_server_prepare(&f);
    ll_status status = ll_documents_read(&f.documents, www);
    LL_THEN(status, ll_documents_finish(&f.documents));
    assert_false(ll_failed(&status));
    snprintf(f.config.allow_origin, sizeof f.config.allow_origin, "https://lab.example, https://two.example");
    snprintf(f.config.allow_host, sizeof f.config.allow_host, "lab.example");
    f.config.head_timeout_s = 1;
    f.config.body_timeout_s = 1;
    f.config.idle_timeout_s = 2;
    test_server_open(&f);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    static const char *const names[] = {"index.html", "js/page.js", ".secret", "js", ""};
    char path[128];
    test_server_close(&f);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, "%s/%s", www, names[i]);
        assert_int_equal(remove(path), 0);
    }
    return 0;
}

/* Every refusal is an RFC 9457 document with the same status. */
static void expect_problem(int status, const char *request, const char *field)
{
    char answer[8192], type[64];
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), status);
    assert_true(net_header(answer, "Content-Type", type, sizeof type));
    assert_string_equal(type, "application/problem+json");
    cJSON *problem = cJSON_Parse(strstr(answer, "\r\n\r\n") + 4);
    assert_int_equal(cJSON_GetObjectItem(problem, "status")->valueint, status);
    assert_true(strlen(cJSON_GetObjectItem(problem, "detail")->valuestring) > 10);
    assert_non_null(cJSON_GetObjectItem(problem, "title"));
    if (field != NULL) {
        const cJSON *error = cJSON_GetArrayItem(cJSON_GetObjectItem(problem, "errors"), 0);
        assert_string_equal(cJSON_GetObjectItem(error, "field")->valuestring, field);
    }
    cJSON_Delete(problem);
}

static void expect_body(const char *request, int status, const char *body)
{
    char answer[8192];
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), status);
    assert_string_equal(strstr(answer, "\r\n\r\n") + 4, body);
}

static void test_routes(void **state)
{
    (void)state;
    expect_body(GET("/healthz"), 200, "{\"ok\":true}");
    expect_body(GET("/echo/x?q=a%20b"), 200, "x||a b|");
    expect_body(GET("/echo/a%20b"), 200, "a b|||");
    expect_body(GET("/echo/x/then/1/2/3?q"), 200, "x|1/2/3||");
    expect_body("POST /echo/x HTTP/1.1\r\n" HOST
                "Content-Type: text/plain; charset=utf-8\r\nContent-Length: 4\r\n\r\nbody",
                200, "x|||body");
    expect_body(
        "POST /echo/x HTTP/1.1\r\n" HOST
        "Content-Type: text/plain\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n2\r\nde\r\n0\r\n\r\n",
        200, "x|||abcde");
    expect_body("DELETE /echo/x HTTP/1.1\r\n" HOST "\r\n", 200, "x|||");
    expect_body(GET("/slow"), 200, "slow");
}

static void test_refusals(void **state)
{
    (void)state;
    char answer[8192], value[64];
    expect_problem(404, GET("/nothing"), NULL);
    expect_problem(404, GET("/echo/"), NULL);
    expect_problem(404, GET("/echo/a/b"), NULL);
    expect_problem(404, GET("/echo/a/then/"), NULL);
    expect_problem(405, "PUT /echo/a HTTP/1.1\r\n" HOST "\r\n", NULL);
    net_ask(f.port, "PUT /echo/a HTTP/1.1\r\n" HOST "\r\n", answer, sizeof answer);
    assert_true(net_header(answer, "Allow", value, sizeof value));
    assert_string_equal(value, "GET, HEAD, POST, DELETE");
    expect_problem(405, "POST / HTTP/1.1\r\n" HOST "\r\n", NULL);
    expect_problem(413,
                   "POST /echo/a HTTP/1.1\r\n" HOST
                   "Content-Type: text/plain\r\nContent-Length: 1001\r\nExpect: "
                   "100-continue\r\n\r\n",
                   NULL);
    expect_problem(413, "DELETE /echo/a HTTP/1.1\r\n" HOST "Content-Length: 1\r\n\r\nx", NULL);
    expect_problem(415,
                   "POST /echo/a HTTP/1.1\r\n" HOST "Content-Type: text/html\r\nContent-Length: 1\r\n\r\nx",
                   "Content-Type");
    expect_problem(415, "POST /echo/a HTTP/1.1\r\n" HOST "Content-Length: 1\r\n\r\nx", "Content-Type");
    expect_problem(400, "GET /healthz HTTP/1.1\r\n\r\n", "Host");
    expect_problem(429, GET("/limit"), "sessions");
    net_ask(f.port, GET("/limit"), answer, sizeof answer);
    assert_true(net_header(answer, "Retry-After", value, sizeof value));
}

static void test_body_limits(void **state)
{
    (void)state;
    char answer[4096], *request = calloc(1, 12000);
    assert_non_null(request);
    int head = snprintf(request, 12000,
                        "POST /echo/a HTTP/1.1\r\n" HOST
                        "Content-Type: text/plain\r\nContent-Length: 10000\r\n\r\n");
    memset(request + head, 'x', 10000);
    int fd = net_connect(f.port);
    assert_int_equal(net_request(fd, request, answer, sizeof answer), 413);
    /* The refused body was read: the connection can still be used. */
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    close(fd);
    head = snprintf(request, 12000,
                    "POST /echo/a HTTP/1.1\r\n" HOST
                    "Content-Type: text/plain\r\nTransfer-Encoding: chunked\r\n\r\n2000\r\n");
    memset(request + head, 'x', 0x2000);
    snprintf(request + head + 0x2000, 100, "\r\n0\r\n\r\n");
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), 413);
    free(request);
}

static void test_who(void **state)
{
    (void)state;
    char answer[4096], value[64];
    expect_problem(421, "GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n", "Host");
    expect_body("GET /healthz HTTP/1.1\r\nHost: lab.example:80\r\n\r\n", 200, "{\"ok\":true}");
    expect_body("GET /healthz HTTP/1.1\r\nHost: [::1]:8080\r\n\r\n", 200, "{\"ok\":true}");
    expect_problem(403, "DELETE /echo/a HTTP/1.1\r\n" HOST "Origin: http://evil.example\r\n\r\n", "Origin");
    expect_problem(403, "DELETE /echo/a HTTP/1.1\r\n" HOST "Origin: null\r\n\r\n", "Origin");
    expect_problem(403, "DELETE /echo/a HTTP/1.1\r\n" HOST "Sec-Fetch-Site: cross-site\r\n\r\n", "Origin");
    expect_body("DELETE /echo/a HTTP/1.1\r\n" HOST "Origin: http://localhost\r\n\r\n", 200, "a|||");
    const char *allowed = "DELETE /echo/a HTTP/1.1\r\n" HOST "Origin: https://two.example\r\n\r\n";
    assert_int_equal(net_ask(f.port, allowed, answer, sizeof answer), 200);
    assert_true(net_header(answer, "Access-Control-Allow-Origin", value, sizeof value));
    assert_string_equal(value, "https://two.example");
    const char *preflight = "OPTIONS /echo/a HTTP/1.1\r\n" HOST "Origin: https://lab.example\r\n\r\n";
    assert_int_equal(net_ask(f.port, preflight, answer, sizeof answer), 204);
    assert_true(net_header(answer, "Access-Control-Allow-Methods", value, sizeof value));
    assert_non_null(strstr(value, "DELETE"));
}

static void test_headers(void **state)
{
    (void)state;
    char answer[4096], value[512], other[64];
    assert_int_equal(net_ask(f.port, "HEAD /healthz HTTP/1.1\r\n" HOST "X-Request-Id: abc-1\r\n\r\n", answer,
                             sizeof answer),
                     200);
    assert_true(net_header(answer, "X-Request-Id", value, sizeof value));
    assert_string_equal(value, "abc-1");
    assert_true(net_header(answer, "Content-Length", value, sizeof value));
    assert_string_equal(value, "11");
    assert_string_equal(strstr(answer, "\r\n\r\n"), "\r\n\r\n");
    net_ask(f.port, "GET /healthz HTTP/1.1\r\n" HOST "X-Request-Id: a b<script>\r\n\r\n", answer,
            sizeof answer);
    assert_true(net_header(answer, "X-Request-Id", other, sizeof other));
    assert_int_equal(strlen(other), 16);
    assert_true(net_header(answer, "Content-Security-Policy", value, sizeof value));
    assert_null(strstr(value, "unsafe"));
    assert_true(net_header(answer, "X-Content-Type-Options", value, sizeof value));
    assert_true(net_header(answer, "Referrer-Policy", value, sizeof value));
}

static void test_files(void **state)
{
    (void)state;
    char answer[4096], tag[64], request[256], type[64];
    snprintf(request, sizeof request,
             "<!doctype html><title>page</title><script src=\"%s/js/page.js\"></script>", f.documents.digest);
    expect_body(GET("/"), 200, request);
    expect_body(GET("/index.html"), 200, request);
    assert_int_equal(net_ask(f.port, GET("/js/page.js"), answer, sizeof answer), 200);
    assert_true(net_header(answer, "Content-Type", type, sizeof type));
    assert_string_equal(type, "text/javascript; charset=utf-8");
    assert_true(net_header(answer, "ETag", tag, sizeof tag));
    snprintf(request, sizeof request,
             "GET /js/page.js HTTP/1.1\r\n" HOST "If-None-Match: \"x\", W/%s\r\n\r\n", tag);
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), 304);
    static const char *const nothing[] = {"/js",
                                          "/.secret",
                                          "/js/../.secret",
                                          "/..%2f..%2fetc%2fpasswd",
                                          "/../../../etc/passwd",
                                          "/js//page.js",
                                          "/%00",
                                          "/js/%2e%2e/index.html",
                                          "/index.html/",
                                          "/js\\..\\.secret"};
    for (size_t i = 0; i < sizeof nothing / sizeof *nothing; i++) {
        snprintf(request, sizeof request, "GET %s HTTP/1.1\r\n" HOST "\r\n", nothing[i]);
        int status = net_ask(f.port, request, answer, sizeof answer);
        if (strcmp(nothing[i], "/%00") != 0) { /* which the library takes for / */
            assert_int_equal(status, 404);
        }
        assert_null(strstr(answer, "hidden"));
    }
}

/* Compressed for who takes it, with a tag of its own, by each method and at both addresses. */
static void test_compressed_files(void **state)
{
    (void)state;
    static const char *const others[] = {"", "Accept-Encoding: br\r\n", "Accept-Encoding: gzip;q=0\r\n"};
    char answer[4096], plain[64], small[64], value[64], request[256];
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        snprintf(request, sizeof request, "GET /js/page.js HTTP/1.1\r\n" HOST "%s\r\n", others[i]);
        assert_int_equal(net_ask(f.port, request, answer, sizeof answer), 200);
        assert_true(net_header(answer, "ETag", plain, sizeof plain));
        assert_true(net_header(answer, "Vary", value, sizeof value));
        assert_string_equal(strstr(answer, "\r\n\r\n") + 4, MODULE);
    }
    assert_int_equal(net_ask(f.port, "HEAD /js/page.js HTTP/1.1\r\n" HOST "Accept-Encoding: br, gzip\r\n\r\n",
                             answer, sizeof answer),
                     200);
    assert_true(net_header(answer, "Content-Encoding", value, sizeof value));
    assert_string_equal(value, "gzip");
    assert_true(net_header(answer, "Content-Type", value, sizeof value));
    assert_string_equal(value, "text/javascript; charset=utf-8");
    assert_true(net_header(answer, "Content-Length", value, sizeof value));
    assert_in_range(atoi(value), 20, sizeof MODULE - 2);
    assert_true(net_header(answer, "ETag", small, sizeof small));
    assert_string_not_equal(small, plain);
    assert_string_equal(strstr(answer, "\r\n\r\n") + 4, "");

    /* The connection goes on, and the length is that of the whole. */
    int fd = net_connect(f.port);
    for (int i = 0; i < 2; i++) {
        char length[64];
        snprintf(request, sizeof request,
                 "GET /js/page.js HTTP/1.1\r\n" HOST "Accept-Encoding: gzip\r\nIf-None-Match: %s\r\n\r\n",
                 small);
        net_send(fd, request);
        net_read(fd, answer, sizeof answer, "\r\n\r\n", LIMIT_S);
        assert_int_equal(strncmp(answer, "HTTP/1.1 304", 12), 0);
        assert_false(net_header(answer, "Content-Encoding", length, sizeof length));
        assert_true(net_header(answer, "Content-Length", length, sizeof length));
        assert_string_equal(length, value);
    }
    close(fd);
}

static void expect_cache(const char *digest, const char *path, int status, const char *cache)
{
    char answer[4096], value[64], request[256];
    snprintf(request, sizeof request, "GET %s%s HTTP/1.1\r\n" HOST "\r\n", digest, path);
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), status);
    assert_true(net_header(answer, "Cache-Control", value, sizeof value));
    assert_string_equal(value, cache);
}

/* Kept forever below the digest of what there is, never below another one. What is no document is not there:
 * nothing is changed at an address that says nothing changes. */
static void test_second_addresses(void **state)
{
    (void)state;
    char ours[SECOND + 1], answer[4096], request[256], value[64], expected[64];
    snprintf(ours, sizeof ours, "/%s", f.documents.digest);
    expect_cache(ours, "/js/page.js", 200, "max-age=31536000, immutable");
    expect_cache("/0123456789abcdef", "/js/page.js", 200, "no-store");
    expect_cache("", "/js/page.js", 200, "no-cache");
    net_ask(f.port, GET("/js/page.js"), answer, sizeof answer);
    assert_true(net_header(answer, "Content-Location", value, sizeof value));
    snprintf(expected, sizeof expected, "%s/js/page.js", ours);
    assert_string_equal(value, expected);
    static const char *const absent[] = {"/", "/index.html", "/healthz", "/.secret", "/js", "/K7QF"};
    for (size_t i = 0; i < sizeof absent / sizeof *absent; i++) {
        expect_cache(ours, absent[i], 404, "no-store");
    }
    expect_cache("/0123456789abcdeg", "/js/page.js", 404, "no-store");
    expect_cache("/0123456789abcdef0", "/js/page.js", 404, "no-store");
    snprintf(request, sizeof request, "DELETE %s/echo/one HTTP/1.1\r\n" HOST "\r\n", ours);
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), 405);
    snprintf(request, sizeof request,
             "GET %s/api/v1/sessions/s0/stream HTTP/1.1\r\n" HOST
             "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n",
             ours);
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), 404);
}

static void test_kept_connections(void **state)
{
    (void)state;
    char answer[4096], *all = malloc(1 << 16);
    assert_non_null(all);
    int fd = net_connect(f.port);
    for (int i = 0; i < 20; i++) {
        assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    }
    /* Three at once, the middle one slow: the answers come in order. */
    net_send(fd, GET("/echo/one") GET("/slow") GET("/echo/three"));
    net_read(fd, all, 1 << 16, "three|||", LIMIT_S);
    assert_non_null(strstr(all, "one|||"));
    assert_non_null(strstr(strstr(all, "one|||"), "\r\n\r\nslow"));
    assert_non_null(strstr(strstr(all, "slow"), "three|||"));
    close(fd);
    fd = net_connect(f.port);
    net_send(fd, "GET /lines HTTP/1.1\r\n" HOST "Connection: close\r\n\r\n");
    size_t size = net_read(fd, all, 1 << 16, NULL, LIMIT_S);
    assert_non_null(strstr(all, "chunked"));
    assert_non_null(strstr(all, "line 999\n"));
    assert_non_null(strstr(all, "line 0\n"));
    assert_string_equal(all + size - 5, "0\r\n\r\n");
    close(fd);
    free(all);
}

/* A client that disconnects during a streamed answer or a slow handler leaks nothing (checked by the leak
 * sanitizer). */
static void test_hang_up(void **state)
{
    (void)state;
    for (int i = 0; i < 10; i++) {
        int fd = net_connect(f.port);
        net_send(fd, i % 2 ? GET("/lines") : GET("/slow"));
        struct linger reset = {1, 0};
        setsockopt(fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        close(fd);
    }
    test_sleep(0.5);
    expect_body(GET("/healthz"), 200, "{\"ok\":true}");
}

/* Slow requests on a connection that libmicrohttpd owns: a head, a body, an idle one. */
static void test_watchdog(void **state)
{
    (void)state;
    char answer[4096];
    uint64_t before = ll_web_server_get_stats(f.web_server).cut;
    int fd = net_connect(f.port), body = net_connect(f.port), idle = net_connect(f.port);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(net_request(idle, GET("/healthz"), answer, sizeof answer), 200);
    net_send(fd, "GET /healthz HTTP/1.1\r\n");
    net_send(body,
             "POST /echo/a HTTP/1.1\r\n" HOST "Content-Type: text/plain\r\nContent-Length: 500\r\n\r\nx");
    for (int i = 0; i < 8; i++) { /* would reset an inactivity timer */
        test_sleep(0.25);
        net_send(fd, "X");
        net_send(body, "x");
    }
    assert_true(net_closed(fd, 0.5));
    assert_true(net_closed(body, 0.5));
    assert_true(net_closed(idle, 2));
    assert_true(ll_web_server_get_stats(f.web_server).cut >= before + 2);
    close(fd);
    close(body);
    close(idle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_routes),           cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_body_limits),      cmocka_unit_test(test_who),
        cmocka_unit_test(test_headers),          cmocka_unit_test(test_files),
        cmocka_unit_test(test_compressed_files), cmocka_unit_test(test_second_addresses),
        cmocka_unit_test(test_kept_connections), cmocka_unit_test(test_hang_up),
        cmocka_unit_test(test_watchdog),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

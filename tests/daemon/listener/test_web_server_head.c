/* The acceptor with slow, malformed, huge and too many connections. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support/server_fixture.h"

#define GET(path) "GET " path " HTTP/1.1\r\nHost: localhost\r\n\r\n"

static test_server f;
static char answer[40000];

static int set_up(void **state)
{
    (void)state;
    test_server_prepare(&f);
    f.config.head_timeout_s = 3;
    f.config.max_connections = 700;
    f.config.max_connections_per_ip = 600;
    test_server_open(&f);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    test_server_close(&f);
    return 0;
}

/* Another client gets an answer. */
static void expect_alive(void)
{
    assert_int_equal(net_ask(f.port, GET("/healthz"), answer, sizeof answer), 200);
}

static void test_byte_by_byte(void **state)
{
    (void)state;
    int fd = net_connect(f.port);
    for (const char *at = GET("/healthz"); *at != '\0'; at++) {
        assert_true(net_send_bytes(fd, at, 1));
        test_sleep(0.0005);
    }
    net_read(fd, answer, sizeof answer, "true}", LIMIT_S);
    assert_memory_equal(answer, "HTTP/1.1 200", 12);
    close(fd);
}

static void expect_refusal(const void *bytes, size_t size, int status)
{
    char expected[32];
    int fd = net_connect(f.port);
    net_send_bytes(fd, bytes, size);
    net_read(fd, answer, sizeof answer, NULL, LIMIT_S);
    snprintf(expected, sizeof expected, "HTTP/1.1 %d ", status);
    assert_memory_equal(answer, expected, strlen(expected));
    assert_non_null(strstr(answer, "application/problem+json"));
    snprintf(expected, sizeof expected, "\"status\":%d", status);
    assert_non_null(strstr(answer, expected));
    close(fd);
}

static void test_junk(void **state)
{
    (void)state;
    static const char tls[] = "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03";
    static const char *const junk[] = {"hello\r\n\r\n",
                                       "get / HTTP/1.1\r\n\r\n",
                                       "GET /\r\n\r\n",
                                       "GET  / HTTP/1.1\r\n\r\n",
                                       "GET / HTTP/1.1\r\nno colon\r\n\r\n",
                                       "GET / HTTP/1.1\r\nHost: a\r\n folded: b\r\n\r\n",
                                       "\x01\x02\x03"};
    expect_refusal(tls, sizeof tls - 1, 400);
    for (size_t i = 0; i < sizeof junk / sizeof *junk; i++) {
        expect_refusal(junk[i], strlen(junk[i]), 400);
    }
    static const char http2[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
    expect_refusal(http2, sizeof http2 - 1, 505);
    static const char version[] = "GET / HTTP/2.0\r\n\r\n";
    expect_refusal(version, sizeof version - 1, 505);
    char *huge = malloc(30000);
    assert_non_null(huge);
    int size = snprintf(huge, 30000, "GET / HTTP/1.1\r\nCookie: ");
    memset(huge + size, 'x', (size_t)(30000 - size));
    expect_refusal(huge, 30000, 431);
    free(huge);
    expect_refusal("GET / HTTP/1.1\r\nHost: ", 22, 408);
}

/* A head of nearly the maximum size is accepted by HTTP and streams. */
static void test_big_head(void **state)
{
    (void)state;
    char *request = malloc(17000), *cookie = malloc(15000);
    assert_true(request != NULL && cookie != NULL);
    memset(cookie, 'c', 14999);
    cookie[14999] = '\0';
    snprintf(request, 17000, "GET /healthz HTTP/1.1\r\nHost: localhost\r\nCookie: %s\r\n\r\n", cookie);
    assert_int_equal(net_ask(f.port, request, answer, sizeof answer), 200);
    snprintf(request, 17000, "Cookie: %s\r\n", cookie);
    free(cookie);
    int fd = net_connect(f.port);
    snprintf(answer, sizeof answer,
             "GET /api/v1/sessions/s0/stream HTTP/1.1\r\nHost: localhost\r\n%sUpgrade: WebSocket\r\n"
             "Connection: keep-alive, Upgrade\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: other, laglab.v2.json, laglab.v2.bin\r\n\r\n",
             request);
    net_send(fd, answer);
    net_read(fd, answer, sizeof answer, "\"hello\"}", LIMIT_S);
    assert_memory_equal(answer, "HTTP/1.1 101", 12);
    assert_non_null(strstr(answer, "laglab.v2.json"));
    close(fd);
    free(request);
}

/* Clients that send a byte now and then are refused while they do so; others are served meanwhile. */
static void test_lorises(void **state)
{
    (void)state;
    enum { COUNT = 300 };
    int fd[COUNT], refused = 0, left = COUNT;
    bool beside = false; /* another has its answer, and the last of them is not yet refused */
    for (int i = 0; i < COUNT; i++) {
        fd[i] = net_connect(f.port);
        assert_true(fd[i] >= 0);
        net_send(fd[i], "GET / HT");
    }
    for (int64_t until = test_now() + LIMIT_S * INT64_C(1000000000); left > 0 && test_now() < until;) {
        for (int i = 0; i < COUNT; i++) {
            struct pollfd event = {.fd = fd[i], .events = POLLIN};
            if (fd[i] < 0)
                continue;
            if (poll(&event, 1, 0) == 0) {
                net_send(fd[i], "x");
                continue;
            }
            size_t size = net_read(fd[i], answer, sizeof answer, NULL, LIMIT_S);
            refused += size > 12 && memcmp(answer, "HTTP/1.1 408", 12) == 0;
            close(fd[i]);
            fd[i] = -1;
            left--;
        }
        expect_alive();
        struct pollfd last = {.fd = fd[COUNT - 1], .events = POLLIN};
        beside = beside || (last.fd >= 0 && poll(&last, 1, 0) == 0);
        test_sleep(0.01);
    }
    assert_int_equal(refused, COUNT);
    assert_true(beside);
}

static void test_rude(void **state)
{
    (void)state;
    for (int i = 0; i < 100; i++) {
        int fd = net_connect(f.port);
        if (i % 4 == 1) {
            net_send(fd, "GET /");
        } else if (i % 4 == 2) {
            net_send(fd, GET("/healthz"));
        } else if (i % 4 == 3) {
            net_send(fd,
                     "GET /api/v1/sessions/s0/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                     "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: "
                     "laglab.v2.bin\r\n\r\n");
        }
        struct linger reset = {1, 0};
        if (i % 2) {
            setsockopt(fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        }
        close(fd);
    }
    int fd = net_connect(f.port); /* half-closed: the answer still comes */
    net_send(fd, GET("/healthz"));
    shutdown(fd, SHUT_WR);
    net_read(fd, answer, sizeof answer, NULL, LIMIT_S);
    assert_memory_equal(answer, "HTTP/1.1 200", 12);
    close(fd);
    fd = net_connect(f.port);
    shutdown(fd, SHUT_WR);
    assert_true(net_closed(fd, LIMIT_S));
    close(fd);
    expect_alive();
}

/* All clients have left, and the connection limiter has counted that. */
static void expect_empty(void)
{
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    while (ll_web_server_get_stats(f.web_server).connections > 0 && test_now() < until) {
        test_sleep(0.02);
    }
    assert_int_equal(ll_web_server_get_stats(f.web_server).connections, 0);
}

/* 600 connections of one address are accepted, others get the reason; after they close, new ones are
 * accepted. */
static void test_limits(void **state)
{
    (void)state;
    enum { COUNT = 1000, ACCEPTED = 600 };
    int *fd = malloc(COUNT * sizeof *fd), refused = 0;
    assert_non_null(fd);
    expect_empty();
    for (int i = 0; i < COUNT; i++) {
        fd[i] = net_connect(f.port);
        assert_true(fd[i] >= 0);
    }
    for (int i = COUNT - 1; i >= 0; i--) { /* the first are accepted: nothing comes */
        struct pollfd event = {.fd = fd[i], .events = POLLIN};
        if (poll(&event, 1, i >= ACCEPTED ? LIMIT_S * 1000 : 0) == 1) {
            net_read(fd[i], answer, sizeof answer, NULL, LIMIT_S);
            if (memcmp(answer, "HTTP/1.1 429", 12) == 0) {
                assert_non_null(strstr(answer, "Retry-After"));
                assert_non_null(strstr(answer, "max_connections_per_ip"));
                refused++;
            }
        }
    }
    for (int i = 0; i < COUNT; i++) {
        close(fd[i]);
    }
    free(fd);
    assert_int_equal(refused, COUNT - ACCEPTED);
    assert_int_equal(ll_web_server_get_stats(f.web_server).refused_per_ip, COUNT - ACCEPTED);
    expect_empty();
    expect_alive();
}

/* Without a free descriptor the acceptor waits, and continues when there is one. */
static void test_no_descriptors(void **state)
{
    (void)state;
    struct rlimit limit, small;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &limit), 0);
    int fd = net_connect(f.port), other = net_connect(f.port);
    test_sleep(0.1);
    int lowest = dup(fd);
    close(lowest);
    small = limit;
    small.rlim_cur = (rlim_t)lowest + 1;
    int late = socket(AF_INET, SOCK_STREAM, 0); /* takes the last one */
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &small), 0);
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(f.port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    assert_int_equal(connect(late, (struct sockaddr *)&address, sizeof address), 0);
    net_send(late, GET("/healthz"));
    test_sleep(0.3);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &limit), 0);
    net_read(late, answer, sizeof answer, "true}", LIMIT_S);
    assert_memory_equal(answer, "HTTP/1.1 200", 12);
    close(late);
    close(other);
    close(fd);
}

static void test_listen(void **state)
{
    (void)state;
    static test_server second;
    test_server_prepare(&second);
    snprintf(second.config.listen, sizeof second.config.listen, "127.0.0.1:%u", f.port);
    ll_http_app app = {0};
    ll_status status = ll_web_server_open(&second.config, &app, &second.web_server);
    assert_int_equal(status.code, LL_IO);
    static const char *const wrong[] = {"127.0.0.1", "127.0.0.1:",   "127.0.0.1:99999",
                                        "::1:80",    "127.0.0.1:8x", "nowhere.invalid:1"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        snprintf(second.config.listen, sizeof second.config.listen, "%s", wrong[i]);
        status = ll_web_server_open(&second.config, &app, &second.web_server);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, "listen");
    }
    snprintf(second.config.listen, sizeof second.config.listen, "[::1]:0");
    status = ll_web_server_open(&second.config, &app, &second.web_server);
    if (!ll_failed(&status)) { /* there may be no IPv6 here */
        assert_memory_equal(ll_web_server_address(second.web_server), "[::1]:", 6);
        ll_web_server_close(second.web_server);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_byte_by_byte),   cmocka_unit_test(test_junk),   cmocka_unit_test(test_big_head),
        cmocka_unit_test(test_lorises),        cmocka_unit_test(test_rude),   cmocka_unit_test(test_limits),
        cmocka_unit_test(test_no_descriptors), cmocka_unit_test(test_listen),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

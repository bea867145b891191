/* The head parser, the allow-lists and the connection limiter: no sockets. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/net/connection_limiter.h"
#include "daemon/net/upgrade.h"

#define T(text) ((ll_text){text, sizeof(text) - 1})

static void test_every_prefix_is_partial(void **state)
{
    (void)state;
    static const char head[] =
        "GET /api/v1/sessions/abc/stream?x=1 HTTP/1.1\r\nHost: lab\r\nORIGIN:http://lab\r\n"
        "Connection: keep-alive ,\r\nConnection: Upgrade\r\nUpgrade: h2c , WebSocket\r\n\r\nrest";
    ll_head parsed;
    size_t whole = sizeof head - 1 - 4;
    for (size_t size = 0; size < whole; size++) {
        /* An allocation of the exact size, so that the sanitizer detects an over-read. */
        char *copy = malloc(size + 1);
        assert_non_null(copy);
        memcpy(copy, head, size);
        char *exact = realloc(copy, size > 0 ? size : 1);
        assert_int_equal(ll_head_parse(exact, size, &parsed), LL_HEAD_PARTIAL);
        free(exact);
    }
    assert_int_equal(ll_head_parse(head, sizeof head - 1, &parsed), LL_HEAD_WHOLE);
    assert_int_equal(parsed.size, whole);
    assert_memory_equal(parsed.host.at, "lab", parsed.host.size);
    assert_memory_equal(parsed.origin.at, "http://lab", parsed.origin.size);
    assert_true(parsed.upgrade && parsed.websocket);
    assert_null(parsed.twice);
}

static void test_heads(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        ll_head_state state;
    } cases[] = {{"", LL_HEAD_PARTIAL},
                 {"\r\n\r\nGET", LL_HEAD_PARTIAL},
                 {"\r\nGET / HTTP/1.0\r\n\r\n", LL_HEAD_WHOLE},
                 {"GET / HTTP/1.1\nHost: a\n\n", LL_HEAD_WHOLE},
                 {"PRI * HTTP", LL_HEAD_PARTIAL},
                 {"PRI * HTTP/2.0\r\n", LL_HEAD_VERSION},
                 {"GET / HTTP/2.0\r\n", LL_HEAD_VERSION},
                 {"GET / HTTP/0.9\r\n", LL_HEAD_VERSION},
                 {"GET / HTTP/1.7\r\n\r\n", LL_HEAD_WHOLE},
                 {"GET / HTTP/1.10\r\n\r\n", LL_HEAD_INVALID},
                 {"GET / http/1.1\r\n\r\n", LL_HEAD_INVALID},
                 {"get", LL_HEAD_INVALID},
                 {"\x16\x03\x01", LL_HEAD_INVALID},
                 {"GET /\x01 HTTP/1.1\r\n", LL_HEAD_INVALID},
                 {"ABCDEFGHIJKLMNOPQRSTUVWXYZ", LL_HEAD_INVALID},
                 {"GET / HTTP/1.1\r\n: x\r\n", LL_HEAD_INVALID},
                 {"GET / HTTP/1.1\r\nA b: x\r\n", LL_HEAD_INVALID},
                 {"GET / HTTP/1.1\r\nA: x\ry\r\n", LL_HEAD_INVALID}};
    ll_head head;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(ll_head_parse(cases[i].text, strlen(cases[i].text), &head), cases[i].state);
    }
    static const char twice[] = "GET / HTTP/1.1\r\nHost: a\r\nhost: b\r\n\r\n";
    assert_int_equal(ll_head_parse(twice, sizeof twice - 1, &head), LL_HEAD_WHOLE);
    assert_string_equal(head.twice, "Host");
    static const char length[] = "GET / HTTP/1.1\r\nContent-Length: x\r\n\r\n";
    assert_int_equal(ll_head_parse(length, sizeof length - 1, &head), LL_HEAD_INVALID);
    assert_string_equal(head.fault->field, "Content-Length");
}

#define BIN "laglab.v2.bin"
#define JSON "laglab.v2.json"
#define HOST "Host: localhost\r\n"
#define UPGRADE "Upgrade: websocket\r\nConnection: Upgrade\r\n"
#define VERSION "Sec-WebSocket-Version: 13\r\n"
#define KEY "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
#define PROTOCOL(names) "Sec-WebSocket-Protocol: " names "\r\n"

/* Lists may come in several lines (RFC 9110 5.3, RFC 6455 11.3.4); everything else once, and without a
 * body. */
static void test_upgrades(void **state)
{
    (void)state;
    static const struct {
        const char *kind, *headers;
        int status;
        ll_frame_format format;
        const char *field;
    } cases[] = {
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL(BIN), 101, LL_FRAME_BINARY, ""},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL("x, " JSON ", " BIN), 101, LL_FRAME_JSON, ""},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL("x") PROTOCOL(BIN) PROTOCOL(JSON), 101,
         LL_FRAME_BINARY, ""},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL(JSON) PROTOCOL(BIN), 101, LL_FRAME_JSON, ""},
        {"classes", HOST UPGRADE VERSION KEY PROTOCOL(BIN) PROTOCOL(JSON), 101, LL_FRAME_JSON, ""},
        {"classes", HOST UPGRADE VERSION KEY PROTOCOL(BIN), 400, 0, "Sec-WebSocket-Protocol"},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL("Laglab.v2.bin"), 400, 0, "Sec-WebSocket-Protocol"},
        {"sessions", HOST UPGRADE VERSION KEY, 400, 0, "Sec-WebSocket-Protocol"},
        {"sessions",
         HOST "Connection: keep-alive\r\nUpgrade: websocket, h2c\r\nConnection: x, Upgrade\r\n" VERSION KEY
             PROTOCOL(BIN),
         101, LL_FRAME_BINARY, ""},
        {"sessions",
         HOST "Upgrade: h2c\r\nUpgrade: websocket\r\nConnection: Upgrade, HTTP2-Settings\r\n" VERSION KEY
             PROTOCOL(BIN),
         101, LL_FRAME_BINARY, ""},
        {"sessions", HOST "Upgrade: h2c\r\nConnection: Upgrade\r\n" VERSION KEY PROTOCOL(BIN), 426, 0,
         "Upgrade"},
        {"sessions", HOST "Upgrade: websocket\r\nConnection: close\r\n" VERSION KEY PROTOCOL(BIN), 426, 0,
         "Upgrade"},
        {"sessions", HOST UPGRADE VERSION KEY KEY PROTOCOL(BIN), 400, 0, "Sec-WebSocket-Key"},
        {"sessions", HOST UPGRADE VERSION VERSION KEY PROTOCOL(BIN), 400, 0, "Sec-WebSocket-Version"},
        {"sessions", HOST HOST UPGRADE VERSION KEY PROTOCOL(BIN), 400, 0, "Host"},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL(BIN) "Content-Length: 7\r\n", 400, 0,
         "Content-Length"},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL(BIN) "Transfer-Encoding: chunked\r\n", 400, 0,
         "Transfer-Encoding"},
        {"sessions", HOST UPGRADE VERSION KEY PROTOCOL(BIN) "Content-Length: 00\r\n", 101, LL_FRAME_BINARY,
         ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[600];
        ll_head head;
        ll_upgrade upgrade;
        int status;
        int size = snprintf(text, sizeof text, "GET /api/v1/%s/a/stream HTTP/1.1\r\n%s\r\n", cases[i].kind,
                            cases[i].headers);
        assert_int_equal(ll_head_parse(text, (size_t)size, &head), LL_HEAD_WHOLE);
        ll_status error = ll_upgrade_check(&head, &(ll_allow){0}, &upgrade, &status);
        assert_int_equal(status, cases[i].status);
        assert_string_equal(error.field, cases[i].field);
        if (status == 101) {
            assert_int_equal(upgrade.format, cases[i].format);
            assert_string_equal(upgrade.key, "dGhlIHNhbXBsZSBub25jZQ==");
        }
    }
}

/* What a header of this name and value is refused with; 0: not at all. */
static int fault_of(const char *name, const char *value)
{
    const ll_head_fault *fault =
        ll_header_fault((ll_text){name, strlen(name)}, (ll_text){value, strlen(value)});
    return fault != NULL ? fault->status : 0;
}

static void test_faults(void **state)
{
    (void)state;
    static const struct {
        const char *name, *value;
        int status;
    } cases[] = {{"X-Plain", "a\tb \xc3\xa4", 0},
                 {"!#$%&'*+-.^_`|~09azAZ", "", 0},
                 {"", "a", 400},
                 {"A b", "a", 400},
                 {"A\t", "a", 400},
                 {"A(", "a", 400},
                 {"\xc3\xa4", "a", 400},
                 {"A", "a\rb", 400},
                 {"A", "\v", 400},
                 {"A", "\x7f", 400},
                 {"content-length", "0", 0},
                 {"Content-Length", "0000000000000000099", 0},
                 {"Content-Length", "18446744073709551615", 413},
                 {"Content-Length", "", 400},
                 {"Content-Length", "+1", 400},
                 {"Content-Length", "-1", 400},
                 {"Content-Length", "0x1b", 400},
                 {"Content-Length", "27, 27", 400},
                 {"Content-Length", "27 ", 400},
                 {"Content-Lengths", "27 ", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(fault_of(cases[i].name, cases[i].value), cases[i].status);
    }
    assert_int_equal(ll_header_fault((ll_text){"A\0b", 3}, T("a"))->status, 400);
    assert_int_equal(ll_header_fault(T("A"), (ll_text){"a\0b", 3})->status, 400);
    assert_null(ll_target_fault("/a%20b?c=%d"));
    assert_null(ll_target_fault("http://lab.example:80/a%20b?d=://%20"));
    assert_null(ll_target_fault("/a?b=http://%20"));
    assert_null(ll_target_fault("*"));
    assert_non_null(ll_target_fault("http://lab%2eexample/"));
    assert_non_null(ll_target_fault("http://lab.example%2fa"));
    assert_non_null(ll_target_fault("/a b"));
    assert_non_null(ll_target_fault("/a\tb"));
    assert_non_null(ll_target_fault("/%00"));
}

static void test_hosts(void **state)
{
    (void)state;
    ll_allow allow = {.hosts = "lab.example, two.example:8080", .origins = ""};
    assert_true(ll_allow_host(&allow, T("localhost")));
    assert_true(ll_allow_host(&allow, T("LOCALHOST:8080")));
    assert_true(ll_allow_host(&allow, T("localhost.")));
    assert_true(ll_allow_host(&allow, T("lab.example.:443")));
    assert_false(ll_allow_host(&allow, T("localhost..")));
    assert_false(ll_allow_host(&allow, T(".")));
    assert_true(ll_allow_host(&allow, T("192.168.0.1:80")));
    assert_true(ll_allow_host(&allow, T("[fe80::1]:80")));
    assert_true(ll_allow_host(&allow, T("lab.example")));
    assert_true(ll_allow_host(&allow, T("Lab.Example:99")));
    assert_true(ll_allow_host(&allow, T("two.example:8080")));
    assert_false(ll_allow_host(&allow, T("two.example:8081")));
    assert_false(ll_allow_host(&allow, T("evil.example")));
    assert_false(ll_allow_host(&allow, T("localhost.evil.example")));
    assert_false(ll_allow_host(&allow, T("127.0.0.1.evil.example")));
    assert_false(ll_allow_host(&allow, T("")));
    assert_false(ll_allow_host(&allow, (ll_text){0}));
    assert_false(ll_allow_host(&allow, T("[")));
    assert_false(ll_allow_host(&allow, T("::1")));
    assert_false(ll_allow_host(&allow, T("[::1]x:80")));
    assert_true(ll_allow_host(&allow, T("lab.example:")));
    assert_false(ll_allow_host(&allow, T("lab.example:80@evil.example")));
    assert_false(ll_allow_host(&allow, T("lab.example:80/evil.example:80")));
}

static void test_origins(void **state)
{
    (void)state;
    ll_allow allow = {.hosts = "", .origins = "https://lab.example,http://two.example:81"};
    assert_true(ll_allow_origin(&allow, (ll_text){0}, T("a")));
    assert_true(ll_allow_origin(&allow, T("http://a:80"), T("a:80")));
    assert_true(ll_allow_origin(&allow, T("http://a"), T("a:80")));
    assert_true(ll_allow_origin(&allow, T("https://a"), T("a:443")));
    assert_true(ll_allow_origin(&allow, T("https://A:8080"), T("a:8080")));
    assert_true(ll_allow_origin(&allow, T("https://lab.example"), T("a")));
    assert_true(ll_allow_origin(&allow, T("http://two.example:81"), T("a")));
    assert_false(ll_allow_origin(&allow, T("http://two.example"), T("a")));
    assert_false(ll_allow_origin(&allow, T("http://a:81"), T("a")));
    assert_false(ll_allow_origin(&allow, T("http://a"), T("a:443")));
    assert_false(ll_allow_origin(&allow, T("null"), T("null")));
    assert_false(ll_allow_origin(&allow, T("file://"), T("")));
    assert_false(ll_allow_origin(&allow, T(""), T("a")));
    assert_false(ll_allow_origin(&allow, T("http://a"), (ll_text){0}));
}

static void test_stream_paths(void **state)
{
    (void)state;
    ll_stream_kind kind;
    char id[65], target[200];
    assert_true(ll_stream_path(T("/api/v1/experiments/e1/stream"), &kind, id));
    assert_int_equal(kind, LL_STREAM_EXPERIMENT);
    assert_string_equal(id, "e1");
    assert_true(ll_stream_path(T("/api/v1/classes/c1/stream"), &kind, id));
    assert_int_equal(kind, LL_STREAM_CLASS);
    assert_string_equal(id, "c1");
    assert_false(ll_stream_path(T("/api/v1/classes/stream"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/experiments//stream"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/scenarios/e1/stream"), &kind, id));
    assert_true(ll_stream_path(T("/api/v1/sessions/aZ0_-/stream"), &kind, id));
    assert_int_equal(kind, LL_STREAM_SESSION);
    assert_string_equal(id, "aZ0_-");
    assert_true(ll_stream_path(T("/api/v1/sessions/a/stream?x"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/sessions/a/stream/"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/sessions/a/streams"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/sessions//stream"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/sessions/a/b/stream"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/sessions/a"), &kind, id));
    assert_false(ll_stream_path(T("/api/v1/sessions/%61/stream"), &kind, id));
    for (int length = 64; length <= 65; length++) {
        int size = snprintf(target, sizeof target, "/api/v1/sessions/%0*d/stream", length, 0);
        assert_int_equal(ll_stream_path((ll_text){target, (size_t)size}, &kind, id), length == 64);
    }
}

static ll_connection_limiter_pass pass_of(const char *address)
{
    struct sockaddr_in four = {.sin_family = AF_INET};
    struct sockaddr_in6 six = {.sin6_family = AF_INET6};
    if (inet_pton(AF_INET, address, &four.sin_addr) == 1) {
        return ll_connection_limiter_pass_of((struct sockaddr *)&four);
    }
    assert_int_equal(inet_pton(AF_INET6, address, &six.sin6_addr), 1);
    return ll_connection_limiter_pass_of((struct sockaddr *)&six);
}

static void test_connection_limiter(void **state)
{
    (void)state;
    ll_connection_limiter *connection_limiter = ll_connection_limiter_new(5, 2);
    ll_connection_limiter_pass a = pass_of("10.0.0.1"), b = pass_of("::ffff:10.0.0.1"),
                               c = pass_of("2001:db8::1"), d = pass_of("2001:db8::2"),
                               e = pass_of("2001:db8:0:1::1");
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &a), LL_CONNECTION_LIMITER_OPEN);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &b), LL_CONNECTION_LIMITER_OPEN);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &a), LL_CONNECTION_LIMITER_FULL_FOR_IP);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &c), LL_CONNECTION_LIMITER_OPEN);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &d), LL_CONNECTION_LIMITER_OPEN);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &c),
                     LL_CONNECTION_LIMITER_FULL_FOR_IP); /* the same /64 */
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &e), LL_CONNECTION_LIMITER_OPEN);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &e), LL_CONNECTION_LIMITER_FULL);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &(ll_connection_limiter_pass){0}),
                     LL_CONNECTION_LIMITER_OPEN); /* not counted */
    ll_connection_limiter_leave(connection_limiter, &b);
    assert_int_equal(ll_connection_limiter_enter(connection_limiter, &a), LL_CONNECTION_LIMITER_OPEN);
    assert_int_equal(ll_connection_limiter_count(connection_limiter), 5);
    ll_connection_limiter_free(connection_limiter);
}

/* Many addresses that connect and disconnect in different orders: the table finds each. */
static void test_connection_limiter_many(void **state)
{
    (void)state;
    enum { COUNT = 1000 };
    ll_connection_limiter *connection_limiter = ll_connection_limiter_new(COUNT, 1);
    struct sockaddr_in address = {.sin_family = AF_INET};
    for (uint32_t round = 0; round < 3; round++) {
        for (uint32_t i = 0; i < COUNT; i++) {
            address.sin_addr.s_addr = htonl(0x0a000000 + i * 7 + round);
            ll_connection_limiter_pass pass = ll_connection_limiter_pass_of((struct sockaddr *)&address);
            assert_int_equal(ll_connection_limiter_enter(connection_limiter, &pass),
                             LL_CONNECTION_LIMITER_OPEN);
        }
        for (uint32_t i = 0; i < COUNT; i++) {
            address.sin_addr.s_addr = htonl(0x0a000000 + i * 613 % COUNT * 7 + round);
            ll_connection_limiter_pass pass = ll_connection_limiter_pass_of((struct sockaddr *)&address);
            ll_connection_limiter_leave(connection_limiter, &pass);
        }
        assert_int_equal(ll_connection_limiter_count(connection_limiter), 0);
    }
    ll_connection_limiter_free(connection_limiter);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_prefix_is_partial),
        cmocka_unit_test(test_heads),
        cmocka_unit_test(test_upgrades),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_hosts),
        cmocka_unit_test(test_origins),
        cmocka_unit_test(test_stream_paths),
        cmocka_unit_test(test_connection_limiter),
        cmocka_unit_test(test_connection_limiter_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Streams: handshake, frames and their pacing, messages, closing, upgrades on kept connections. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support/server_fixture.h"

#define BIN "laglab.v2.bin"
#define JSON "laglab.v2.json"
#define GET(path) "GET " path " HTTP/1.1\r\nHost: localhost\r\n\r\n"

/* Longer than a busy machine keeps a viewer from acknowledging what it has read. */
#define ACK_TIMEOUT_S 2
#define QUIET_S 0.3 /* after which nothing more is on its way */

static test_server f;
static viewer_frame frame;
static char answer[40000];

static int set_up(void **state)
{
    (void)state;
    test_server_prepare(&f);
    f.config.max_viewers = 20;
    f.config.ack_timeout_s = ACK_TIMEOUT_S;
    f.config.hello_timeout_s = 1;
    f.config.max_messages_per_s = 100;
    f.config.stream_threads = 2;
    snprintf(f.config.allow_origin, sizeof f.config.allow_origin, "https://lab.example");
    test_server_open(&f);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    test_server_close(&f);
    return 0;
}

static int open_with_hello(const char *session, const char *protocol)
{
    int fd = viewer_open(f.port, session, protocol);
    assert_true(fd >= 0);
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_int_equal(frame.opcode, 1);
    assert_string_equal((char *)frame.bytes, "{\"type\":\"hello\"}");
    return fd;
}

/* The next frame; messages before it are counted. */
static int read_frame(int fd)
{
    int messages = -1;
    do {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        messages++;
    } while (frame.opcode == 1);
    return messages;
}

static int upgrade_status(const char *session, const char *protocol, const char *extra)
{
    int fd = net_connect(f.port), status = viewer_upgrade(fd, session, protocol, extra);
    close(fd);
    return status;
}

static void test_handshake(void **state)
{
    (void)state;
    assert_int_equal(upgrade_status("s0", BIN, ""), 101);
    assert_int_equal(upgrade_status("s0", "nonsense, " JSON, ""), 101);
    assert_int_equal(upgrade_status("s0", BIN, "Origin: http://127.0.0.1\r\n"), 101);
    assert_int_equal(upgrade_status("s0", BIN, "Origin: https://lab.example\r\n"), 101);
    assert_int_equal(upgrade_status("s0", BIN, "Origin: http://evil.example\r\n"), 403);
    assert_int_equal(upgrade_status("s0", BIN, "Origin: http://127.0.0.1:81\r\n"), 403);
    assert_int_equal(upgrade_status("s0", BIN, "Origin: null\r\n"), 403);
    assert_int_equal(upgrade_status("s0", "laglab.v9", ""), 400);
    assert_int_equal(upgrade_status("s0", BIN, "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"), 400);
    assert_int_equal(upgrade_status("nobody", BIN, ""), 404);
    assert_int_equal(net_ask(f.port, GET("/api/v1/sessions/s0/stream"), answer, sizeof answer), 426);
    const char *old = "GET /api/v1/sessions/s0/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                      "Connection: Upgrade\r\nSec-WebSocket-Version: 8\r\nSec-WebSocket-Key: "
                      "dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " BIN "\r\n\r\n";
    assert_int_equal(net_ask(f.port, old, answer, sizeof answer), 426);
    const char *post = "POST /api/v1/sessions/s0/stream HTTP/1.1\r\nHost: localhost\r\n\r\n";
    assert_int_equal(net_ask(f.port, post, answer, sizeof answer), 405);
}

/* The same answers on a connection that libmicrohttpd owns already. */
static void test_small_print(void **state)
{
    (void)state;
    static const struct {
        const char *extra;
        int status;
        const char *field;
    } cases[] = {
        {"Upgrade: h2c\r\nConnection: keep-alive\r\nSec-WebSocket-Protocol: other\r\n", 101, NULL},
        {"Content-Length: 0\r\n", 101, NULL},
        {"Content-Length: 5\r\n", 400, "\"Content-Length\""},
        {"Transfer-Encoding: chunked\r\n", 400, "\"Transfer-Encoding\""},
        {"Sec-WebSocket-Version: 13\r\n", 400, "\"Sec-WebSocket-Version\""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int kept = 0; kept < 2; kept++) {
            char request[600];
            snprintf(request, sizeof request,
                     "GET /api/v1/sessions/s0/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                     "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
                     "dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " BIN "\r\n%s\r\n%s",
                     cases[i].extra,
                     cases[i].status == 101                  ? ""
                     : strncmp(cases[i].extra, "Tr", 2) == 0 ? "5\r\n\x89\x80xxx\r\n0\r\n\r\n"
                                                             : "\x89\x80xxx");
            int fd = net_connect(f.port);
            if (kept) {
                assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
            }
            assert_int_equal(net_request(fd, request, answer, sizeof answer), cases[i].status);
            if (cases[i].field != NULL) {
                assert_non_null(strstr(answer, "application/problem+json"));
                assert_non_null(strstr(answer, cases[i].field));
            }
            close(fd);
        }
    }
}

static void test_frames(void **state)
{
    (void)state;
    int fd = open_with_hello("s0", BIN);
    uint32_t last = 0;
    int in_a_row = 0; /* a busy machine may be late for one, which is then left out */
    for (int i = 0; in_a_row < 30 && i < 600; i++) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        assert_int_equal(frame.opcode, 2);
        assert_in_range(frame.size, 1000, 1050);
        assert_int_equal(viewer_is_whole(&frame), i == 0);
        assert_true(i == 0 || viewer_seq(&frame) > last);
        in_a_row = viewer_seq(&frame) == last + 1 ? in_a_row + 1 : 1;
        last = viewer_seq(&frame);
        viewer_ack(fd, last);
    }
    assert_int_equal(in_a_row, 30);
    /* A jump of time: all viewers get whole sections once. */
    atomic_fetch_add(&f.generation, 1);
    int whole = 0;
    for (int i = 0; i < 10; i++) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        whole += viewer_is_whole(&frame);
        viewer_ack(fd, viewer_seq(&frame));
    }
    assert_int_equal(whole, 1);
    close(fd);
    fd = open_with_hello("s1", JSON);
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_int_equal(frame.opcode, 1);
    assert_non_null(strstr((char *)frame.bytes, "\"flags\":[\"playing\",\"jump\"]"));
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_non_null(strstr((char *)frame.bytes, "\"flags\":[\"playing\"],\"stamp\":[{\"id\":"));
    close(fd);
}

/* A viewer that stops acknowledging has at most four frames in flight; the next one is the newest, as a delta
 * against the last one sent. */
static void test_credit(void **state)
{
    (void)state;
    int fd = open_with_hello("s2", BIN);
    for (int i = 0; i < 10; i++) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        viewer_ack(fd, viewer_seq(&frame));
    }
    test_sleep(0.4);
    int in_flight = 0;
    uint32_t last = 0;
    while (viewer_read(fd, &frame, QUIET_S)) {
        in_flight++;
        last = viewer_seq(&frame);
    }
    assert_in_range(in_flight, 1, LL_FRAME_WINDOW);
    unsigned newest = atomic_load(&f.published);
    assert_true(newest > last + 10);
    viewer_ack(fd, last);
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_true(viewer_seq(&frame) >= newest);
    assert_false(viewer_is_whole(&frame));
    viewer_ack(fd, 0xffffffff); /* never sent: ignored */
    /* Then no acknowledgement for longer than the timeout. */
    assert_int_equal(viewer_close_code(fd, LIMIT_S), 1013);
    close(fd);
    /* A viewer that never acknowledged has no such timeout. */
    fd = open_with_hello("s2", BIN);
    for (int i = 0; i < 60; i++) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
    }
    close(fd);
}

/* Each acknowledgement starts the time of ack_timeout_s again, however long ago the others in flight
 * were sent: a slow line takes long for the whole first frames. */
static void test_late_acknowledgements(void **state)
{
    (void)state;
    int fd = open_with_hello("s2", BIN), count = 0;
    uint32_t seq[LL_FRAME_WINDOW];
    for (int i = 0; i < 10; i++) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        viewer_ack(fd, viewer_seq(&frame));
    }
    test_sleep(0.3);
    while (count < LL_FRAME_WINDOW && viewer_read(fd, &frame, QUIET_S)) {
        seq[count++] = viewer_seq(&frame);
    }
    assert_true(count >= 2);
    for (int i = 0; i < count; i++) {
        test_sleep(0.45 * ACK_TIMEOUT_S); /* together longer than the timeout */
        viewer_ack(fd, seq[i]);
    }
    int newest = 0;
    while (viewer_read(fd, &frame, QUIET_S)) { /* one for each acknowledgement */
        assert_int_not_equal(frame.opcode, 8);
        newest++;
    }
    assert_true(newest >= 1);
    close(fd);
}

/* Who has more frames in flight than the server remembers (the first ones, before it acknowledged) is alive
 * as long as it acknowledges one after the other, old as they are. */
static void test_old_acknowledgements(void **state)
{
    (void)state;
    enum { READ = 40, ACKNOWLEDGED = 6 };
    int fd = open_with_hello("s2", BIN);
    uint32_t seq[READ];
    for (int i = 0; i < READ; i++) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        seq[i] = viewer_seq(&frame);
    }
    for (int i = 0; i < ACKNOWLEDGED; i++) {
        viewer_ack(fd, seq[i]);
        test_sleep(0.25 * ACK_TIMEOUT_S); /* together longer than the timeout */
        while (viewer_read(fd, &frame, 0.01)) {
            assert_int_not_equal(frame.opcode, 8);
        }
    }
    while (viewer_read(fd, &frame, LIMIT_S)) { /* the last one again is no progress */
        viewer_ack(fd, seq[ACKNOWLEDGED - 1]);
        if (frame.opcode == 8) {
            close(fd);
            return;
        }
    }
    fail_msg("a viewer that acknowledges nothing new is not closed");
}

/* Before its first acknowledgement a viewer has three frames, however long it takes, until it answers the
 * ping behind the first one: then it is one that never acknowledges, and its socket paces it. */
static void test_first_ping(void **state)
{
    (void)state;
    int fd = open_with_hello("s2", BIN), frames = 0, pings = 0;
    unsigned char payload[125];
    size_t size = 0;
    test_sleep(1); /* reads nothing, as on a slow line */
    while (viewer_piece(fd, &frame, 0.3)) {
        if (frame.opcode == 9) {
            pings++;
            size = frame.size;
            memcpy(payload, frame.bytes, size);
        }
        frames += frame.opcode == 2;
    }
    assert_int_equal(frames, 3);
    assert_int_equal(pings, 1);
    viewer_send(fd, 0x8a, payload, size);
    for (int i = 0; i < 30; i++) {
        read_frame(fd);
        assert_int_equal(frame.opcode, 2);
    }
    close(fd);
}

/* Reads a fifth of the data, and acknowledges what it has read: of the others most are left out. A queue of
 * all, or of each second one as for a slow viewer, would give them one after the other, older and older. */
static void read_slowly(int fd)
{
    enum { READ = 40 };
    uint32_t first = 0, last = 0;
    for (int i = 0; i < READ; i++) {
        read_frame(fd);
        last = viewer_seq(&frame);
        first = i == 0 ? last : first;
        test_sleep(0.083);
        viewer_ack(fd, last);
    }
    assert_true(last - first >= 3 * (READ - 1));
    close(fd);
}

static void test_slow_reader(void **state)
{
    (void)state;
    read_slowly(open_with_hello("s2", BIN));
}

static void test_messages(void **state)
{
    (void)state;
    int fd = open_with_hello("s3", BIN);
    viewer_say(fd, "{\"ping\":1}");
    do {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
    } while (frame.opcode != 1);
    assert_string_equal((char *)frame.bytes, "{\"echo\":{\"ping\":1}}");
    /* In three fragments, with a ping between them. */
    viewer_send(fd, 0x01, "[1,", 3);
    viewer_send(fd, 0x00, "2,", 2);
    viewer_send(fd, 0x89, "p", 1);
    viewer_send(fd, 0x80, "3]", 2);
    bool pong = false, echo = false;
    while (!pong || !echo) {
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        pong = pong || frame.opcode == 10;
        echo = echo || strcmp((char *)frame.bytes, "{\"echo\":[1,2,3]}") == 0;
    }
    viewer_send(fd, 0x88, "\x03\xe8", 2);
    assert_int_equal(viewer_close_code(fd, LIMIT_S), 1000);
    close(fd);
}

static void expect_close(int opcode, const void *bytes, size_t size, int code)
{
    int fd = open_with_hello("s3", BIN);
    viewer_send(fd, opcode, bytes, size);
    assert_int_equal(viewer_close_code(fd, LIMIT_S), code);
    close(fd);
}

static void test_bad_messages(void **state)
{
    (void)state;
    char *big = malloc(70000);
    assert_non_null(big);
    memset(big, ' ', 70000);
    expect_close(0x81, big, 70000, 1009);
    free(big);
    expect_close(0x81, "\xc3\x28", 2, 1007);
    expect_close(0x82, "binary", 6, 1003);
    int fd = open_with_hello("s3", BIN);
    for (int i = 0; i < 400; i++) {
        viewer_say(fd, "{}");
    }
    bool told = false;
    while (viewer_read(fd, &frame, 2) && frame.opcode != 8) {
        told = told || strstr((char *)frame.bytes, "max_messages_per_s") != NULL;
    }
    assert_int_equal(frame.opcode, 8);
    assert_int_equal(frame.bytes[0] << 8 | frame.bytes[1], 1008);
    assert_true(told);
    close(fd);
}

static void test_crowd(void **state)
{
    (void)state;
    int fd[20];
    for (int i = 0; i < 20; i++) {
        fd[i] = open_with_hello("s3", i % 2 ? BIN : JSON);
    }
    int more = viewer_open(f.port, "s3", BIN);
    assert_true(more >= 0);
    assert_int_equal(viewer_close_code(more, LIMIT_S), 4429);
    close(more);
    for (int i = 0; i < 20; i++) {
        assert_true(viewer_read(fd[i], &frame, LIMIT_S));
    }
    assert_int_equal(ll_ws_viewers(f.stream[3]), 20);
    for (int i = 0; i < 20; i++) {
        close(fd[i]);
    }
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    while (ll_ws_viewers(f.stream[3]) > 0 && test_now() < until) {
        test_sleep(0.01);
    }
    assert_int_equal(ll_ws_viewers(f.stream[3]), 0);
    ll_record_request request;
    ll_ws_wants(f.stream[3], 1, 0, true, &request);
    assert_int_equal(request.channels, 0);
    atomic_store(&f.send_hello, 0);
    int ignored = viewer_open(f.port, "s3", BIN);
    assert_int_equal(viewer_close_code(ignored, LIMIT_S), 1013);
    close(ignored);
    atomic_store(&f.send_hello, 1);
}

/* Reads nothing of 3.6 MB/s, which its socket paces, until that is full: another viewer, of the same thread,
 * goes on to get frames while the deaf one is still there and gets none. */
static void test_deaf(void **state)
{
    (void)state;
    enum { IN_A_ROW = 30 };
    static test_server g;
    test_server_prepare(&g);
    g.config.stream_threads = 1;
    g.frame_bytes = 60000;
    test_server_open(&g);
    int deaf = viewer_open(g.port, "s0", BIN), fd = viewer_open(g.port, "s0", BIN);
    assert_true(deaf >= 0 && fd >= 0);
    for (int i = 0; i < 3; i++) { /* its hello, a frame, the ping behind it with another */
        assert_true(viewer_read(deaf, &frame, LIMIT_S));
    }
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    uint64_t sent = 2 * IN_A_ROW;
    for (int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
         sent > IN_A_ROW + LL_FRAME_WINDOW && test_now() < until;) {
        uint64_t before = ll_web_server_get_stats(g.web_server).ws.frames;
        for (int i = 0; i < IN_A_ROW; i++) {
            read_frame(fd);
            viewer_ack(fd, viewer_seq(&frame));
        }
        sent = ll_web_server_get_stats(g.web_server).ws.frames - before;
    }
    assert_in_range(sent, 1, IN_A_ROW + LL_FRAME_WINDOW);
    assert_int_equal(ll_ws_viewers(g.stream[0]), 2);
    for (int i = 0; i < 2 * LL_FRAME_WINDOW; i++) { /* no credit ran out: it gets more where it reads */
        assert_true(viewer_read(deaf, &frame, LIMIT_S));
        assert_int_equal(frame.opcode, 2);
    }
    close(fd);
    close(deaf);
    test_server_close(&g);
}

static void test_delete(void **state)
{
    (void)state;
    ll_ws_stream *stream, *again;
    ll_status status = ll_ws_stream_open(f.ws, LL_STREAM_SESSION, "deleted", NULL, &stream);
    assert_false(ll_failed(&status));
    status = ll_ws_stream_open(f.ws, LL_STREAM_SESSION, "deleted", NULL, &again);
    assert_int_equal(status.code, LL_CONFLICT);
    status = ll_ws_stream_open(f.ws, LL_STREAM_SESSION, "no/id", NULL, &again);
    assert_int_equal(status.code, LL_BAD_INPUT);
    int fd = open_with_hello("deleted", BIN);
    unsigned released = atomic_load(&f.released);
    ll_ws_stream_close(stream, LL_WS_NO_SESSION, "the session was \"deleted\"");
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    assert_string_equal((char *)frame.bytes,
                        "{\"type\":\"bye\",\"reason\":\"the session was \\\"deleted\\\"\"}");
    assert_int_equal(viewer_close_code(fd, LIMIT_S), 4404);
    close(fd);
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    while (atomic_load(&f.released) == released && test_now() < until) {
        test_sleep(0.01);
    }
    assert_int_equal(atomic_load(&f.released), released + 1);
    assert_int_equal(upgrade_status("deleted", BIN, ""), 404);
}

/* ---- upgrades on connections that libmicrohttpd owns already ---- */

static void wait_for_no_connections(void)
{
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    while (ll_web_server_get_stats(f.web_server).connections > 0 && test_now() < until) {
        test_sleep(0.01);
    }
    assert_int_equal(ll_web_server_get_stats(f.web_server).connections, 0);
}

static void test_kept(void **state)
{
    (void)state;
    uint64_t before = ll_web_server_get_stats(f.web_server).bridged;
    wait_for_no_connections();
    for (int i = 0; i < 200; i++) {
        int fd = net_connect(f.port);
        for (int k = 0; k < 3; k++) {
            assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
        }
        assert_int_equal(viewer_upgrade(fd, i % 2 ? "s0" : "s1", i % 3 ? BIN : JSON, ""), 101);
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        assert_string_equal((char *)frame.bytes, "{\"type\":\"hello\"}");
        assert_true(viewer_read(fd, &frame, LIMIT_S));
        viewer_say(fd, "{\"n\":1}");
        do {
            assert_true(viewer_read(fd, &frame, LIMIT_S));
        } while (strncmp((char *)frame.bytes, "{\"echo\"", 7) != 0);
        assert_true(ll_web_server_get_stats(f.web_server).connections >= 1);
        viewer_send(fd, 0x88, "\x03\xe8", 2);
        assert_int_equal(viewer_close_code(fd, LIMIT_S), 1000);
        close(fd);
    }
    assert_int_equal(ll_web_server_get_stats(f.web_server).bridged - before, 200);
    wait_for_no_connections();
}

/* A 404 would say that a stored session is gone. */
static void test_unknown_while_starting(void **state)
{
    (void)state;
    atomic_store(&f.starting, true);
    assert_int_equal(upgrade_status("nobody", BIN, ""), 503);
    assert_int_equal(upgrade_status("s0", BIN, ""), 101);
    int fd = net_connect(f.port);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(viewer_upgrade(fd, "nobody", BIN, ""), 503);
    close(fd);
    atomic_store(&f.starting, false);
    assert_int_equal(upgrade_status("nobody", BIN, ""), 404);
}

static void test_kept_refusals(void **state)
{
    (void)state;
    int fd = net_connect(f.port);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(viewer_upgrade(fd, "s0", BIN, "Origin: http://evil.example\r\n"), 403);
    close(fd);
    fd = net_connect(f.port);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(viewer_upgrade(fd, "nobody", BIN, ""), 404);
    close(fd);
    fd = net_connect(f.port);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(viewer_upgrade(fd, "s0", BIN, "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"), 400);
    close(fd);
    for (int i = 0; i < 20; i++) { /* closed at once */
        fd = net_connect(f.port);
        assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
        assert_int_equal(viewer_upgrade(fd, "s0", BIN, ""), 101);
        struct linger reset = {1, 0};
        setsockopt(fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        close(fd);
    }
}

/* The upgrade and the first message in one segment: no byte is lost on the way. On a kept connection
 * libmicrohttpd has read what comes before the 101 (docs/limits.md), and the stream begins after it. */
static void test_all_at_once(void **state)
{
    (void)state;
    static const char head[] =
        "GET /api/v1/sessions/s0/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
        "dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " BIN "\r\n\r\n";
    for (int kept = 0; kept < 2; kept++) {
        char text[1024];
        int fd = net_connect(f.port);
        int size = snprintf(text, sizeof text, "%s%s", kept ? GET("/healthz") : "", head);
        memcpy(text + size, "\x81\x82\0\0\0\0{}", 8);
        net_send_bytes(fd, text, (size_t)size + 8);
        int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
        size_t got = 0;
        while (kept && memmem(answer, got, "{\"type\":\"hello\"}", 16) == NULL && test_now() < until) {
            got += net_read(fd, answer + got, sizeof answer - got, "{\"type\":\"hello\"}", 0.2);
        }
        viewer_say(fd, "[2]");
        while (memmem(answer, got, "{\"echo\":[2]}", 12) == NULL && test_now() < until) {
            got += net_read(fd, answer + got, sizeof answer - got, "{\"echo\":[2]}", 0.2);
        }
        assert_non_null(memmem(answer, got, "{\"echo\":[2]}", 12));
        assert_int_equal(memmem(answer, got, "{\"echo\":{}}", 11) != NULL, !kept);
        close(fd);
    }
}

static void test_slow_reader_bridged(void **state)
{
    (void)state;
    int fd = net_connect(f.port);
    assert_int_equal(net_request(fd, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(viewer_upgrade(fd, "s2", BIN, ""), 101);
    assert_true(viewer_read(fd, &frame, LIMIT_S));
    read_slowly(fd);
}

/* A slow viewer gets a message, and half the frames. */
static void test_slower_rate(void **state)
{
    (void)state;
    int fd = open_with_hello("s1", BIN), messages = 0, skipped = 0;
    uint32_t last = 0;
    int64_t until = test_now() + LIMIT_S * INT64_C(1000000000);
    while (messages == 0 && test_now() < until) {
        messages = read_frame(fd);
        test_sleep(0.1);
        viewer_ack(fd, viewer_seq(&frame));
    }
    assert_int_equal(messages, 1);
    for (int i = 0; i < 30; i++) {
        read_frame(fd);
        last = viewer_seq(&frame);
        skipped += i >= 10 && last % 2 != 0; /* earlier ones: queued frames */
        viewer_ack(fd, last);
    }
    assert_int_equal(skipped, 0);
    close(fd);
}

/* All viewers, on connections of their own and on kept ones, get a message when the daemon stops. */
static void test_drain(void **state)
{
    (void)state;
    static test_server g;
    int fd[40];
    test_server_prepare(&g);
    test_server_open(&g);
    for (int i = 0; i < 40; i++) {
        fd[i] = net_connect(g.port);
        if (i % 2) {
            assert_int_equal(net_request(fd[i], GET("/healthz"), answer, sizeof answer), 200);
        }
        assert_int_equal(viewer_upgrade(fd[i], "s0", BIN, ""), 101);
        assert_true(viewer_read(fd[i], &frame, LIMIT_S));
    }
    int kept = net_connect(g.port);
    assert_int_equal(net_request(kept, GET("/healthz"), answer, sizeof answer), 200);
    /* Clients send their close frame only after the drain, which must not wait longer than its time. */
    int64_t begin = test_now();
    ll_web_server_drain(g.web_server);
    assert_true((double)(test_now() - begin) < 3.5e9);
    assert_int_equal(net_request(kept, GET("/healthz"), answer, sizeof answer), 200);
    assert_int_equal(net_connect(g.port), -1);
    for (int i = 0; i < 40; i++) {
        assert_int_equal(viewer_close_code(fd[i], LIMIT_S), 1001);
        close(fd[i]);
    }
    close(kept);
    test_server_close(&g);
    assert_int_equal(atomic_load(&g.opened), atomic_load(&g.closed));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_handshake),
        cmocka_unit_test(test_small_print),
        cmocka_unit_test(test_frames),
        cmocka_unit_test(test_credit),
        cmocka_unit_test(test_late_acknowledgements),
        cmocka_unit_test(test_old_acknowledgements),
        cmocka_unit_test(test_first_ping),
        cmocka_unit_test(test_slow_reader),
        cmocka_unit_test(test_messages),
        cmocka_unit_test(test_bad_messages),
        cmocka_unit_test(test_crowd),
        cmocka_unit_test(test_deaf),
        cmocka_unit_test(test_delete),
        cmocka_unit_test(test_kept),
        cmocka_unit_test(test_unknown_while_starting),
        cmocka_unit_test(test_kept_refusals),
        cmocka_unit_test(test_all_at_once),
        cmocka_unit_test(test_slow_reader_bridged),
        cmocka_unit_test(test_slower_rate),
        cmocka_unit_test(test_drain),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

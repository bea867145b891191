/* A web server with a test application, and a client of raw bytes, for the tests of the daemon's port.
 *
 * The application has sessions s0, s1, ... that publish frames of about 1000 bytes (or `frame_bytes`) at 60
 * Hz while `publishing`. A viewer gets {"type":"hello"} and is subscribed to all channels; its messages are
 * sent back as {"echo":...}. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "daemon/http/documents.h"
#include "daemon/listener/web_server.h"

#define FRONT_SESSIONS 4
/* What a test waits for comes much earlier: the limit only ends a hang. */
#define LIMIT_S 60

typedef struct test_server {
    ll_web_server_config config;
    ll_documents documents; /* none; may be filled before it is opened */
    ll_web_server *web_server;
    ll_ws *ws;
    ll_ws_stream *stream[FRONT_SESSIONS];
    uint16_t port;
    size_t frame_bytes;
    atomic_bool publishing, end;
    atomic_bool starting; /* its application has not all streams yet */
    atomic_uint generation, opened, closed, released;
    atomic_uint published;              /* number of the newest frame that all streams have */
    atomic_uint wanted, wanted_nothing; /* calls of hook `wanted` while not publishing, and those in which
                                           ll_ws_wants had no channel */
    atomic_int send_hello;              /* 0: viewers get no hello */
    pthread_t publisher;
} test_server;

/* Defaults, a free port, the tests' own page; `config` may be changed between the two. */
void test_server_prepare(test_server *f);
void test_server_open(test_server *f);
void test_server_close(test_server *f);

int64_t test_now(void); /* monotonic, ns */
void test_sleep(double seconds);

/* ---- a client ---- */

int net_connect(uint16_t port);
bool net_send(int fd, const char *text);
bool net_send_bytes(int fd, const void *bytes, size_t size);
/* Reads until `needle` was seen (NULL: until the end), `seconds` have passed or `capacity` - 1 bytes were
 * read. Returns the size; the text is terminated. */
size_t net_read(int fd, char *text, size_t capacity, const char *needle, double seconds);
bool net_closed(int fd, double seconds); /* the peer closed within that time */

/* Sends a request and reads the whole answer (head and Content-Length). Returns the status; 0: no answer. */
int net_request(int fd, const char *request, char *answer, size_t capacity);
/* The same on a new connection. */
int net_ask(uint16_t port, const char *request, char *answer, size_t capacity);
bool net_header(const char *answer, const char *name, char *value, size_t capacity);

/* ---- a viewer ---- */

typedef struct viewer_frame {
    int opcode;
    size_t size;
    unsigned char bytes[70000];
} viewer_frame;

/* Handshake on `fd`; `extra` are additional header lines. Returns the status. Reads no byte after the
 * head. */
int viewer_upgrade(int fd, const char *session, const char *protocol, const char *extra);
int viewer_open(uint16_t port, const char *session,
                const char *protocol); /* connects and upgrades; -1 when refused */
bool viewer_send(int fd, int opcode, const void *bytes, size_t size);
bool viewer_say(int fd, const char *text);
bool viewer_ack(int fd, uint32_t seq);
bool viewer_piece(int fd, viewer_frame *frame, double seconds); /* one frame, also a ping */
bool viewer_read(int fd, viewer_frame *frame, double seconds);  /* one frame; answers pings */
uint32_t viewer_seq(const viewer_frame *frame);
bool viewer_is_whole(const viewer_frame *frame); /* all sections whole */
int viewer_close_code(int fd,
                      double seconds); /* reads up to a close frame; its code, 0: none, -1: connection cut */

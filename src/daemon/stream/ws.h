/* WebSocket streams: frames of sessions to viewers, messages both ways; and the progress of experiments,
 * which are messages only.
 *
 * Each session's stream runs on one thread (by a hash of its id), with all its viewers. A published frame is
 * shared by all viewers of the stream; there is no queue of frames per viewer. Each viewer gets the channels
 * that it subscribed to, at its rates, as deltas to what it was sent last: WebSocket is reliable and ordered,
 * so that a base always arrives before its delta. A viewer that has acknowledged once has at most
 * LL_FRAME_WINDOW frames in flight and then gets the newest; one that never did is limited by its socket. A
 * viewer that misses too many frames gets them at a lower rate (pace.h). libwebsockets shakes hands and reads
 * and writes frames; acks, the times of pings, message size and message rate are handled here.
 *
 * Opening of a viewer: hook `opened` -> hosting calls ll_ws_hello, at once or later, from any thread -> hello
 * is sent -> its subscription (after a second without one, the channels that are drawn) counts in
 * ll_ws_wants, and hook `wanted` is called. To refuse, hosting calls ll_ws_close instead.
 *
 * Threads: hooks run on the stream's thread and must not block for long, since all viewers of that thread
 * wait. Any thread may call any function, hooks too; but publishing calls of one stream (wants, publish,
 * close) must come from one thread at a time. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/net/upgrade.h"
#include "session/frame.h"

typedef struct ll_ws ll_ws;
typedef struct ll_ws_stream ll_ws_stream;
typedef uint64_t ll_ws_viewer; /* never reused; calls with a viewer that has left have no effect. 0: none */

/* Application close codes, by HTTP status. */
#define LL_WS_NORMAL 1000
#define LL_WS_GOING_AWAY 1001
#define LL_WS_UNSUPPORTED 1003
#define LL_WS_POLICY 1008
#define LL_WS_TOO_BIG 1009
#define LL_WS_TRY_LATER 1013
#define LL_WS_FORBIDDEN 4403
#define LL_WS_NO_SESSION 4404
#define LL_WS_TOO_MANY 4429

typedef struct ll_ws_hooks {
    void *context;
    void (*opened)(void *context, void *session, ll_ws_viewer viewer, ll_frame_format format);
    /* A text message other than an ack; valid UTF-8, NUL-terminated after `length`. */
    void (*message)(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length);
    void (*closed)(void *context, void *session, ll_ws_viewer viewer);
    /* A viewer waits for data that no publication had (the first after it subscribed): publish even when
     * nothing changed. Called once until ll_ws_wants is called, then again (within 250 ms) while the viewer
     * still waits. May be NULL when hosting polls ll_ws_wants. */
    void (*wanted)(void *context, void *session);
    /* The answer to ll_ws_ping: the time that it took on the network and in the viewer's browser. May be
     * NULL. */
    void (*pong)(void *context, void *session, ll_ws_viewer viewer, int64_t round_trip_ns);
    /* The stream is closed and its last viewer has left: no further hook gets `session`. Exactly once after
     * ll_ws_stream_close. May be NULL. */
    void (*released)(void *context, void *session);
} ll_ws_hooks;

typedef struct ll_ws_stats {
    uint64_t viewers;       /* at present */
    uint64_t streams;       /* at present */
    uint64_t opened;        /* viewers since the start */
    uint64_t frames, bytes; /* sent */
    uint64_t skipped;       /* frames that were due while the viewer was not ready */
    uint64_t messages;      /* received, acks included */
    uint64_t closed_slow;   /* 1013 */
    uint64_t closed_policy; /* 1002, 1003, 1007, 1008, 1009 */
    uint64_t dropped;       /* publications dropped because a stream thread was late */
} ll_ws_stats;

/* ---- streams ---- */

/* Sets the hooks of streams of a kind, before the first of them is opened. */
void ll_ws_set_hooks(ll_ws *ws, ll_stream_kind kind, const ll_ws_hooks *hooks);

/* Opens a stream under its path (upgrade.h). ID: 1 to 64 characters of [A-Za-z0-9_-]. LL_CONFLICT when it is
 * open already. The hooks get `session`. */
ll_status ll_ws_stream_open(ll_ws *ws, ll_stream_kind kind, const char *id, void *session,
                            ll_ws_stream **stream);

/* Sends viewers the frames published before, {"type":"bye","reason":...} and the close code; new viewers get
 * a 404. The stream must not be used afterwards. Hook `released` is called when the last viewer has left (if
 * there is none, maybe before this returns). */
void ll_ws_stream_close(ll_ws_stream *stream, int code, const char *reason);

int ll_ws_viewers(const ll_ws_stream *stream); /* that got their hello; cheap */

/* ---- frames ---- */

/* What the next frame, with this `seq` and `generation`, has to contain. `whole`: no frame follows soon, so
 * that no viewer may wait for a later one. Sets channels, `anew`, from_event and viewers; channels 0: no
 * viewers. Cheap (a few atomic loads): call it before each frame. */
void ll_ws_wants(ll_ws_stream *stream, uint32_t seq, uint32_t generation, bool whole,
                 ll_record_request *request);

/* Queues the frame and takes its own reference; ll_ws_flush sends. At most 4 wait unsent, then the oldest is
 * dropped. `seq` must rise. */
void ll_ws_publish(ll_ws_stream *stream, ll_frame *frame);

/* Wakes the stream threads that have something to send: call once after a batch of publications. */
void ll_ws_flush(ll_ws *ws);

/* ---- messages ---- */

/* The first message of a viewer (text JSON); copied. Frames follow. */
void ll_ws_hello(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length);

/* A viewer's subscription: every n-th frame of each channel, n a divisor of LL_FRAME_HZ; 0: none. */
typedef struct ll_ws_subscription {
    uint8_t every[LL_CHANNELS];
} ll_ws_subscription;

/* Replaces its subscription; without channels it gets no frames. */
void ll_ws_subscribe(ll_ws *ws, ll_ws_viewer viewer, const ll_ws_subscription *subscription);

/* A reliable, ordered text message; copied. A viewer with more than 64 queued messages or 256 kB is closed
 * with 1013. */
void ll_ws_send(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length);

/* Measures the round trip by a WebSocket ping, unless one is on its way; see hook `pong`. */
void ll_ws_ping(ll_ws *ws, ll_ws_viewer viewer);

/* Sends {"type":"bye","reason":REASON}, then closes. */
void ll_ws_close(ll_ws *ws, ll_ws_viewer viewer, int code, const char *reason);

/* ---- for the web server only ---- */

struct ll_web_server_config;
struct ll_connection_limiter;
struct ll_connection_limiter_pass;

ll_status ll_ws_start(const struct ll_web_server_config *config,
                      struct ll_connection_limiter *connection_limiter, ll_ws **ws);
bool ll_ws_knows(ll_ws *ws, const ll_upgrade *upgrade); /* whether the stream is open */

/* Takes over a socket whose upgrade was checked, and whose head has been read; the answer is sent here. The
 * streams own `fd` and `pass` from here on. */
void ll_ws_adopt(ll_ws *ws, const ll_upgrade *upgrade, int fd, const struct ll_connection_limiter_pass *pass);

ll_ws_stats ll_ws_get_stats(ll_ws *ws);
void ll_ws_drain(ll_ws *ws, double seconds); /* 1001 to all, joins the threads */
void ll_ws_free(ll_ws *ws);                  /* after drain; frees the streams too */

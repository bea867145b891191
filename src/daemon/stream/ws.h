/* WebSocket streams: frames of sessions to viewers, messages both ways; and the progress of experiments,
 * which is messages only.
 *
 * Each session's stream lives on one thread (by a hash of its id), with all its viewers.
 * Publishing hands over a frame that all viewers of the stream share; there is no queue of frames per viewer.
 * Each gets what it subscribed to, at its rate, against what it was sent last: WebSocket is reliable and in
 * order, so that what was sent is there before what follows. A viewer that has acknowledged once has at most
 * LL_FRAME_WINDOW frames in flight and then gets the newest; one that never did is paced by its socket. One
 * that misses too many gets half the rate for a while. The framing (framing.h), acks, pings, the message size
 * and the message rate are dealt with here.
 *
 * How a viewer begins: hook `opened` -> hosting calls ll_ws_hello, at once or later from any thread -> hello
 * is sent -> what it subscribes to (else, after a second, to what is drawn) counts in ll_ws_wants and hook
 * `wanted` is called. Hosting refuses by ll_ws_close instead.
 *
 * Threads: hooks run on the stream's thread and must not block for long: all viewers of that thread wait.
 * Every function may be called by any thread, hooks included, but calls about one stream's publishing (wants,
 * publish, close) by one thread at a time. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/net/upgrade.h"
#include "session/frame.h"

typedef struct ll_ws ll_ws;
typedef struct ll_ws_stream ll_ws_stream;
typedef uint64_t
    ll_ws_viewer; /* never reused; a function called with a viewer that has gone does nothing. 0 is none */

/* Close codes of the application, after HTTP's. */
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
    /* A text message that is not an ack; valid UTF-8, NUL-terminated beyond `length`. */
    void (*message)(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length);
    void (*closed)(void *context, void *session, ll_ws_viewer viewer);
    /* Some viewer waits for what no publication held yet (the first after it subscribed): publish even when
     * nothing changed. Called at most once between two
     * publications. May be NULL when hosting polls ll_ws_wants. */
    void (*wanted)(void *context, void *session);
    /* The stream is closed and its last viewer gone: no further hook gets `session`. Exactly once after
     * ll_ws_stream_close. May be NULL. */
    void (*released)(void *context, void *session);
} ll_ws_hooks;

typedef struct ll_ws_stats {
    uint64_t viewers;       /* now */
    uint64_t streams;       /* now */
    uint64_t opened;        /* viewers since the start */
    uint64_t frames, bytes; /* sent */
    uint64_t skipped;       /* frames that a viewer was due and not ready for */
    uint64_t messages;      /* received, acks included */
    uint64_t closed_slow;   /* 1013 */
    uint64_t closed_policy; /* 1002, 1003, 1007, 1008, 1009 */
    uint64_t dropped;       /* publications that a stream thread was too late for */
} ll_ws_stats;

/* ---- streams ---- */

/* The hooks of streams of a kind; before the first of them is opened. Those of sessions are the door's. */
void ll_ws_set_hooks(ll_ws *ws, ll_stream_kind kind, const ll_ws_hooks *hooks);

/* Makes a stream known by its path (upgrade.h). ID: 1 to 64 characters of [A-Za-z0-9_-]. LL_CONFLICT when it
 * is known already. `session` is handed to the hooks. */
ll_status ll_ws_stream_open(ll_ws *ws, ll_stream_kind kind, const char *id, void *session,
                            ll_ws_stream **stream);

/* Viewers get what was published before, a {"type":"bye","reason":...} and the close code; new ones a 404.
 * The stream must not be used after it; hook `released` tells when the last viewer has gone (at once when
 * there is none: maybe before this returns). */
void ll_ws_stream_close(ll_ws_stream *stream, int code, const char *reason);

int ll_ws_viewers(const ll_ws_stream *stream); /* that got their hello; cheap */

/* ---- frames ---- */

/* What the next frame should hold, `seq` and `generation` being that frame's; `whole`: it is the last for
 * now, so that no viewer waits for a later one. Sets channels, `anew`, from_event and viewers; channels 0:
 * there are no viewers. Cheap (a few atomic loads): call it before each frame. */
void ll_ws_wants(const ll_ws_stream *stream, uint32_t seq, uint32_t generation, bool whole,
                 ll_record_request *request);

/* Queues the frame, of which it takes a reference of its own; ll_ws_flush sends. At most 4 wait unsent, then
 * the oldest is dropped. Each has a greater seq than the one before. */
void ll_ws_publish(ll_ws_stream *stream, ll_frame *frame);

/* Wakes the stream threads that have something to send: once after a batch of publications. */
void ll_ws_flush(ll_ws *ws);

/* ---- messages ---- */

/* The first message of a viewer (text JSON); copied. Frames follow. */
void ll_ws_hello(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length);

/* What a viewer gets: of each channel every n-th frame, n a divisor of LL_FRAME_HZ; 0: not at all. */
typedef struct ll_ws_subscription {
    uint8_t every[LL_CHANNELS];
} ll_ws_subscription;

/* Takes the place of what it had; none of any channel: it gets no frames. */
void ll_ws_subscribe(ll_ws *ws, ll_ws_viewer viewer, const ll_ws_subscription *subscription);

/* A reliable text message, in order; copied. A viewer whose messages pile up beyond 64 or 256 kB is closed
 * with 1013. */
void ll_ws_send(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length);

/* Says {"type":"bye","reason":REASON}, then closes. */
void ll_ws_close(ll_ws *ws, ll_ws_viewer viewer, int code, const char *reason);

/* ---- for the door only ---- */

struct ll_web_server_config;
struct ll_connection_limiter;
struct ll_connection_limiter_pass;

ll_status ll_ws_start(const struct ll_web_server_config *config, const ll_ws_hooks *hooks,
                      struct ll_connection_limiter *connection_limiter, ll_ws **ws);
bool ll_ws_knows(ll_ws *ws, const ll_upgrade *upgrade);

/* A socket whose upgrade request was valid and has been read. */
typedef struct ll_ws_socket {
    int fd;
    bool answered;                /* its 101 is sent; else it is written here */
    void (*release)(void *owner); /* instead of close(fd): it is somebody else's */
    void *owner;
} ll_ws_socket;

/* Hands it over, with the `begun` bytes that were read behind its request (copied). Socket and `pass` belong
 * to the streams from here on. */
void ll_ws_adopt(ll_ws *ws, const ll_upgrade *upgrade, const ll_ws_socket *socket, const void *begun,
                 size_t begun_size, const struct ll_connection_limiter_pass *pass);

ll_ws_stats ll_ws_get_stats(ll_ws *ws);
void ll_ws_drain(ll_ws *ws, double seconds); /* 1001 to all, joins the threads */
void ll_ws_free(ll_ws *ws);                  /* after drain; streams too */

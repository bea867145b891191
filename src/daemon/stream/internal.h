/* Shared by the files of this room, lower ones first: command_queue.c, registry.c (any thread), socket.c
 * (what is sent to a viewer), messages.c (messages to a viewer), frames.c (frames for a viewer), viewer.c
 * (life of a viewer), events.c (what libwebsockets calls), thread.c (the loop) and ws.c (any thread). Not for
 * other rooms. */
#pragma once

#include <ev.h>
#include <libwebsockets.h>
#include <pthread.h>
#include <stdatomic.h>

#include "daemon/net/config.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/upgrade.h"
#include "daemon/stream/pace.h"
#include "daemon/stream/ws.h"
#include "threads/clock.h"

#define WS_PENDING 4       /* publications that wait for a stream's thread */
#define WS_OUTSTANDING 8   /* frames whose sending time is remembered */
#define WS_MAX_MESSAGES 64 /* queued for one viewer */
#define WS_MAX_MESSAGE_BYTES (256 * 1024)
#define WS_BUCKETS 4096 /* of the registry */

/* A command to a stream's thread, or a text message to a viewer: everything that other threads hand over
 * except publications. */
typedef enum ws_command_kind {
    WS_COMMAND_ADOPT,
    WS_COMMAND_HELLO,
    WS_COMMAND_SUBSCRIBE,
    WS_COMMAND_SEND,
    WS_COMMAND_PING,
    WS_COMMAND_CLOSE,
    WS_COMMAND_CLOSE_STREAM
} ws_command_kind;

typedef struct ws_command {
    struct ws_command *next;
    ws_command_kind kind;
    ll_ws_viewer viewer;
    ll_ws_stream *stream;
    int code; /* for closing */
    int fd;   /* for adopting, as the next two members */
    ll_connection_limiter_pass pass;
    ll_upgrade upgrade;
    ll_ws_subscription subscription;
    size_t size;
    unsigned char room[LWS_PRE]; /* for the head of the frame */
    unsigned char text[];
} ws_command;

struct cJSON;

typedef struct ws_viewer ws_viewer;
typedef struct ws_thread ws_thread;

struct ll_ws_stream {
    ll_ws *ws;
    ws_thread *thread;
    void *session;
    ll_stream_kind kind;
    char id[65];
    ll_ws_stream *next_in_bucket; /* guarded by the registry's lock */
    atomic_int viewers;           /* that got their hello */
    atomic_int binary_viewers;    /* those of them whose frames are binary */
    /* What viewers want of the next frame, for the publishing thread. */
    atomic_ullong every[LL_CHANNELS]; /* bit n: a viewer gets every n-th frame */
    atomic_uint missing;              /* channels that a viewer has not got at all */
    atomic_bool anew;
    _Atomic int64_t from_event;
    atomic_uint generation; /* of the last publication */
    atomic_bool published;
    atomic_bool asked;             /* hook `wanted` was called since the last ll_ws_wants */
    ll_frame *pending[WS_PENDING]; /* guarded by the thread's lock, as the next two members */
    int pending_count;
    ll_ws_stream *next_dirty;
    ll_frame *latest;            /* used by the thread only, as all following members */
    ll_frame *taken[WS_PENDING]; /* from `pending`, to be distributed */
    int taken_count;
    ll_ws_stream *next_taken;
    size_t kept_bytes; /* size of the sections that viewers have, except those of the latest frame */
    ws_viewer *first;
    int viewer_count;   /* viewers, with or without hello */
    bool wants_changed; /* since what viewers want was published last */
    bool closing;
};

/* Which frames a viewer gets, and when. */
typedef struct ws_viewer_frames {
    bool ready, fresh, subscribed;
    ll_ws_subscription subscription;
    uint16_t wants, has, overdue; /* channels: subscribed; received since; due when it was not ready */
    ll_frame_state state;         /* sections sent last */
    uint32_t last_sent, generation;
    int64_t last_tick;
    uint8_t last_flags;
    int64_t overdue_ns; /* since when the events are overdue */
    int64_t hello_ns, first_sent_ns;
} ws_viewer_frames;

/* Flow control of frames, by acknowledgements. */
typedef struct ws_viewer_flow {
    struct {
        uint32_t seq;
        int64_t sent_ns;
    } outstanding[WS_OUTSTANDING]; /* oldest first */
    int outstanding_count, window;
    bool answered;      /* the ping behind the first frame, or another */
    int64_t acked_ns;   /* time of the newest acknowledgement; 0: none */
    uint32_t acked_seq; /* the frame that it was for */
    int64_t delay_ns;   /* delay of acknowledgements without queueing: a slowly rising minimum */
    ll_ws_pace pace;    /* a slow viewer gets every n-th of its frames */
} ws_viewer_flow;

/* Text messages, both ways. */
typedef struct ws_viewer_messages {
    ws_command *first, *last; /* queued to be sent */
    int count;
    size_t bytes;
    char *received; /* a fragmented message */
    size_t received_size, received_capacity;
    double tokens; /* of the rate limit */
    int64_t tokens_ns;
} ws_viewer_messages;

/* The end of the connection. */
typedef struct ws_viewer_closing {
    int code; /* not 0: closing, since `since_ns` */
    int64_t since_ns;
    char reason[120];
    bool hangs_up; /* for what it sends: our half is closed behind the close frame */
} ws_viewer_closing;

struct ws_viewer {
    ws_thread *thread;
    struct lws *wsi;
    ll_connection_limiter_pass pass;
    ll_upgrade upgrade;
    ll_ws_stream *stream;
    ws_viewer *next, *previous; /* in the stream's list */
    ll_ws_viewer handle;
    int64_t opened_ns;
    ws_viewer_frames frames;
    ws_viewer_flow flow;
    ws_viewer_messages messages;
    ws_viewer_closing closing;
    int64_t received_ns, pinged_ns;
    int64_t measured_ns; /* when the ping that measures the round trip was sent; 0: none */
    bool dead;           /* cut; freed in the next turn */
};

/* The frame that was written last, for viewers that get the same bytes; during a distribution only. */
typedef struct ws_repeated {
    const ll_frame *frame; /* NULL: none */
    ll_frame_state state;  /* what the viewer had: compared, not owned */
    uint16_t channels;
    bool jump;
    ll_frame_format format;
} ws_repeated;

typedef struct ws_counts {
    atomic_ullong viewers, opened, frames, bytes, skipped, messages, closed_slow, closed_policy, dropped;
} ws_counts;

struct ws_thread {
    ll_ws *ws;
    int index;
    pthread_t handle;
    bool started;
    int event_fd;
    struct ev_loop *loop;
    struct lws_context *context; /* serves this thread's viewers on the loop */
    ev_io woken;
    ev_timer sweep;
    atomic_bool wake_pending, drain;

    pthread_mutex_t lock; /* guards commands, dirty streams and their pending publications */
    ws_command *first_command, *last_command;
    ll_ws_stream *dirty;
    bool stopped;

    /* the thread only */
    ws_viewer **slot; /* by the low 16 bits of a handle */
    int slots;
    uint64_t serial;
    int sockets;
    ws_viewer *adopting; /* its connection is being made */
    ws_repeated repeated;
    int64_t now_ns;    /* read once per turn, and for each message */
    ll_buffer message; /* the frame that was written last, behind LWS_PRE bytes for its head */
    ws_counts counts;
};

struct ll_ws {
    ll_web_server_config config;
    ll_ws_hooks hooks[LL_STREAM_KINDS];
    ll_connection_limiter *connection_limiter;
    pthread_mutex_t registry_lock;
    ll_ws_stream *bucket[WS_BUCKETS];
    atomic_int stream_count;
    bool drained;
    int threads;
    ws_thread thread[];
};

void ll_ws_count(atomic_ullong *counter, uint64_t n);
void ll_ws_wake(ws_thread *thread);
ws_command *ll_ws_command_new(ws_command_kind kind, const char *text, size_t size); /* NULL without memory */
bool ll_ws_submit(ws_thread *thread,
                  ws_command *command); /* false: it has stopped; the command stays the caller's */

/* registry.c */
ws_thread *ll_ws_thread_of(ll_ws *ws, const char *id);
ll_ws_stream *ll_ws_find_stream(ll_ws *ws, ll_stream_kind kind, const char *id);
void ll_ws_stream_free(ll_ws_stream *stream);
void ll_ws_stream_destroy(ll_ws_stream *stream); /* without references; calls `released` */

/* socket.c: all on the viewer's thread. */
/* LWS_PRE bytes before `payload` are writable. What the socket does not take is copied. */
void ll_ws_socket_write(ws_viewer *viewer, unsigned char *payload, size_t size, enum lws_write_protocol kind);
bool ll_ws_socket_full(const ws_viewer *viewer); /* do not write: bytes wait, or a close frame */
void ll_ws_socket_ping(ws_viewer *viewer);
void ll_ws_socket_measure(ws_viewer *viewer); /* the round trip, by a ping; hook `pong` */
void ll_ws_socket_cut(ws_viewer *viewer);     /* without a close frame */

/* messages.c: all on the viewer's thread. */
void ll_ws_viewer_send(ws_viewer *viewer, ws_command *message);        /* takes ownership */
void ll_ws_viewer_send_json(ws_viewer *viewer, struct cJSON *message); /* takes ownership */
void ll_ws_viewer_close(ws_viewer *viewer, int code, const char *reason);
void ll_ws_messages_flush(ws_viewer *viewer); /* as many as the socket accepts */
void ll_ws_messages_drop(ws_viewer *viewer);

/* frames.c: all on the viewer's thread. Selects the frames of each viewer. */
void ll_ws_stream_distribute(ll_ws_stream *stream, ll_frame **frames, int count); /* takes ownership */
void ll_ws_viewer_subscribe(ws_viewer *viewer, const ll_ws_subscription *subscription);
void ll_ws_viewer_send_newest(ws_viewer *viewer); /* the newest frame, if the viewer does not have it */
void ll_ws_viewer_acknowledge(ws_viewer *viewer, uint32_t seq);
void ll_ws_viewer_sweep_frames(ws_viewer *viewer);
void ll_ws_viewer_release_sections(
    ws_viewer *viewer); /* releases its sections and wants; it is still in its stream */

/* viewer.c: all on the viewer's thread. */
ws_viewer *ll_ws_viewer_of(ws_thread *thread, ll_ws_viewer handle);
ws_viewer *ll_ws_viewer_new(ws_thread *thread, const ws_command *adopt); /* NULL without memory */
void ll_ws_viewer_free(ws_viewer *viewer);
void ll_ws_viewer_open(ws_viewer *viewer);
void ll_ws_viewer_hello(ws_viewer *viewer, ws_command *hello);                /* takes ownership */
void ll_ws_viewer_receive(ws_viewer *viewer, const char *bytes, size_t size); /* a piece of a message */
void ll_ws_viewer_pong(ws_viewer *viewer);
void ll_ws_viewer_writable(ws_viewer *viewer);
void ll_ws_viewer_ends(ws_viewer *viewer, int code); /* nothing is sent any more: the library closes */
void ll_ws_viewer_sweep(ws_viewer *viewer);
void ll_ws_stream_release_if_done(ll_ws_stream *stream);

/* events.c: all on the viewer's thread. */
struct lws_context *ll_ws_context_new(ws_thread *thread); /* NULL: no plug-in for libev */
void ll_ws_adopt_viewer(ws_thread *thread, const ws_command *command);

/* thread.c */
bool ll_ws_thread_prepare(ws_thread *thread);
void *ll_ws_thread_main(void *thread);

/* What the files of this room share, from the ground up: post.c, registry.c (any thread), socket.c (bytes of
 * a viewer, in and out), messages.c (to it), frames.c (for it), viewer.c (the whole of it), thread.c (the
 * loop) and ws.c (any thread). Not for others. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/net/config.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/framing.h"
#include "daemon/net/upgrade.h"
#include "daemon/stream/ws.h"

#define WS_PENDING 4       /* publications that wait for a stream's thread */
#define WS_OUTSTANDING 8   /* frames whose sending time is remembered */
#define WS_MAX_MESSAGES 64 /* queued for one viewer */
#define WS_MAX_MESSAGE_BYTES (256 * 1024)
#define WS_BUCKETS 4096      /* of the registry */
#define WS_INPUT (16 * 1024) /* read at once */

/* A text on its way to a viewer, or news for a thread: everything that crosses threads beside publications.
 */
typedef enum ws_mail_kind {
    WS_MAIL_ADOPT,
    WS_MAIL_HELLO,
    WS_MAIL_SUBSCRIBE,
    WS_MAIL_SEND,
    WS_MAIL_CLOSE,
    WS_MAIL_CLOSE_STREAM
} ws_mail_kind;

typedef struct ws_mail {
    struct ws_mail *next;
    ws_mail_kind kind;
    ll_ws_viewer viewer;
    ll_ws_stream *stream;
    int code;            /* of a close */
    ll_ws_socket socket; /* of an adoption; what was begun is the text */
    ll_connection_limiter_pass pass;
    ll_upgrade upgrade;
    ll_ws_subscription subscription;
    size_t size;
    unsigned char room[LL_FRAMING_ROOM]; /* for the head of the frame */
    unsigned char text[];
} ws_mail;

struct cJSON;

typedef struct ws_viewer ws_viewer;
typedef struct ws_thread ws_thread;

struct ll_ws_stream {
    ll_ws *ws;
    ws_thread *thread;
    void *session;
    ll_stream_kind kind;
    char id[65];
    ll_ws_stream *next_in_bucket; /* registry lock */
    atomic_int viewers;           /* that got their hello */
    /* What they want of the next frame, for the thread that publishes. */
    atomic_ullong every[LL_CHANNELS]; /* bit n: some viewer gets every n-th frame */
    atomic_uint missing;              /* channels that some viewer has not got at all */
    atomic_bool anew;
    _Atomic int64_t from_event;
    atomic_uint generation; /* of the last publication */
    atomic_bool published;
    ll_frame *pending[WS_PENDING]; /* thread's lock, as the next two */
    int pending_count;
    ll_ws_stream *next_dirty;
    ll_frame *latest;  /* thread only, as the rest */
    size_t kept_bytes; /* of the sections that viewers have, but for those of the latest frame */
    ws_viewer *first;
    int arrived; /* viewers, greeted or not */
    bool want_said, closing;
};

/* Where what comes of a viewer's bytes goes; viewer.c's. */
typedef struct ws_receiver {
    void (*piece)(ws_viewer *viewer, const ll_framing *piece);
    void (*ping)(ws_viewer *viewer);
    void (*pong)(ws_viewer *viewer);
    void (*left)(ws_viewer *viewer, int code); /* it says goodbye; LL_FRAMING_NO_CODE: without a code */
    void (*fault)(ws_viewer *viewer, int code, const char *reason); /* it cannot be understood */
    void (*writable)(ws_viewer *viewer);
} ws_receiver;

struct ws_viewer {
    ws_thread *thread;
    const ws_receiver *receiver;
    ll_ws_socket socket;
    uint32_t events; /* that epoll looks for */
    ws_viewer *next_dead;
    ll_connection_limiter_pass pass;
    ll_upgrade upgrade;
    ll_ws_stream *stream;
    ws_viewer *next, *previous; /* of the stream */
    ll_ws_viewer handle;
    int64_t opened_ns;
    /* frames */
    bool ready, fresh, subscribed, acked_once;
    ll_ws_subscription subscription;
    uint16_t wants, has, owed; /* channels: of the subscription; got since; due when it was not ready */
    ll_frame_state state;      /* what it was sent last */
    uint32_t last_sent, generation;
    int64_t last_tick;
    uint8_t last_flags;
    int64_t greeted_ns, first_sent_ns;
    struct {
        uint32_t seq;
        int64_t sent_ns;
    } outstanding[WS_OUTSTANDING]; /* oldest first */
    int outstanding_count, window;
    int64_t delay_ns; /* of acknowledgements when nothing queues: a minimum that forgets slowly */
    /* of one that is too slow for its rates */
    int slowdown; /* it gets every so-manieth of its frames */
    int due_count, missed_count;
    int64_t counted_ns, missed_ns; /* when that count began; when it missed one last */
    /* messages */
    ws_mail *first_message, *last_message;
    int message_count;
    size_t message_bytes;
    char *received; /* a message in pieces */
    size_t received_size, received_capacity;
    double tokens; /* of the rate limit */
    int64_t tokens_ns;
    bool rate_said;
    int close_code; /* set: says goodbye, since `close_ns` */
    int64_t close_ns;
    char close_reason[120];
    /* the socket */
    ll_framing framing;
    unsigned char *rest; /* of what was written: the socket was full */
    size_t rest_at, rest_end, rest_capacity;
    unsigned char pong[LL_FRAMING_CONTROL]; /* the answer to its last ping */
    int pong_size;
    bool pong_wanted;
    bool deaf; /* after a fault or its close frame: what it sends is read and thrown away */
    bool said; /* our close frame is written */
    bool shut; /* and our half of the connection closed */
    int64_t heard_ns, pinged_ns;
    bool dead; /* it is freed at the end of the turn */
};

typedef struct ws_counts {
    atomic_ullong viewers, opened, frames, bytes, skipped, messages, closed_slow, closed_policy, dropped;
} ws_counts;

struct ws_thread {
    ll_ws *ws;
    int index;
    pthread_t handle;
    bool started;
    int epoll, event_fd;
    atomic_bool wake_pending, drain;

    pthread_mutex_t lock; /* mail, dirty streams and their pending publications */
    ws_mail *first_mail, *last_mail;
    ll_ws_stream *dirty;
    bool stopped;

    /* the thread only */
    ws_viewer **slot; /* by the low 16 bits of a handle */
    int slots;
    uint64_t serial;
    int sockets;
    ws_viewer *first_dead;
    unsigned char *input; /* WS_INPUT */
    int64_t now_ns;       /* read once a turn */
    ll_buffer message;    /* in the making */
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

/* post.c */
int64_t ll_ws_now(void);
void ll_ws_count(atomic_ullong *counter, uint64_t n);
void ll_ws_wake(ws_thread *thread);
void ll_ws_release(const ll_ws_socket *socket);                            /* closes it, or gives it back */
ws_mail *ll_ws_mail_new(ws_mail_kind kind, const char *text, size_t size); /* NULL without memory */
bool ll_ws_post(ws_thread *thread,
                ws_mail *mail); /* false when it has stopped: the mail is still the caller's */

/* registry.c */
ws_thread *ll_ws_thread_of(ll_ws *ws, const char *id);
ll_ws_stream *ll_ws_find_stream(ll_ws *ws, ll_stream_kind kind, const char *id);
void ll_ws_stream_free(ll_ws_stream *stream);
void ll_ws_stream_destroy(ll_ws_stream *stream); /* nobody holds it; calls `released` */

/* socket.c: all on the viewer's thread. A socket that fails makes its viewer dead. */
bool ll_ws_socket_open(ws_viewer *viewer); /* watched from here on; writes the 101 where it is wanted */
void ll_ws_socket_event(ws_viewer *viewer, uint32_t events);
void ll_ws_socket_take(ws_viewer *viewer, unsigned char *bytes, size_t size); /* that came */
/* LL_FRAMING_ROOM bytes before `payload` are free. What the socket does not take is kept. */
void ll_ws_socket_write(ws_viewer *viewer, unsigned char *payload, size_t size, ll_opcode opcode);
bool ll_ws_socket_full(const ws_viewer *viewer); /* something is kept: do not write */
void ll_ws_socket_want(ws_viewer *viewer);       /* its receiver's `writable`, soon */
void ll_ws_socket_say_close(ws_viewer *viewer, int code, const char *reason); /* at the end, once */
void ll_ws_socket_fail(ws_viewer *viewer);
void ll_ws_socket_free(ws_viewer *viewer); /* the socket and what is kept for it */

/* messages.c: all on the viewer's thread. */
void ll_ws_viewer_send(ws_viewer *viewer, ws_mail *message);     /* takes it */
void ll_ws_viewer_say(ws_viewer *viewer, struct cJSON *message); /* takes it */
void ll_ws_viewer_close(ws_viewer *viewer, int code, const char *reason);
void ll_ws_messages_flush(ws_viewer *viewer); /* as many as the socket takes */
void ll_ws_messages_drop(ws_viewer *viewer);

/* frames.c: all on the viewer's thread. Which frames a viewer gets, and when. */
void ll_ws_stream_distribute(ll_ws_stream *stream, ll_frame **frames, int count); /* takes them */
void ll_ws_viewer_subscribe(ws_viewer *viewer, const ll_ws_subscription *subscription);
void ll_ws_viewer_try(ws_viewer *viewer); /* the newest frame, if it has not got it */
void ll_ws_viewer_acknowledge(ws_viewer *viewer, uint32_t seq);
void ll_ws_viewer_sweep_frames(ws_viewer *viewer);
void ll_ws_viewer_forget(ws_viewer *viewer); /* what it has and wants; it is in its stream still */

/* viewer.c: all on the viewer's thread. */
extern const ws_receiver ll_ws_viewer_receiver;
void ll_ws_viewer_open(ws_viewer *viewer);
void ll_ws_viewer_gone(ws_viewer *viewer);
void ll_ws_viewer_hello(ws_viewer *viewer, ws_mail *hello); /* takes it */
void ll_ws_viewer_sweep(ws_viewer *viewer);
void ll_ws_stream_release_if_done(ll_ws_stream *stream);

/* thread.c */
bool ll_ws_thread_prepare(ws_thread *thread);
void *ll_ws_thread_main(void *thread);

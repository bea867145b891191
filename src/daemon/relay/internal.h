/* Shared by the files of this room: source.c (the stream of a session), tunnel.c (messages of one viewer),
 * streams.c (all of them: hooks of viewers, and the thread), forward.c (REST) and relay.c (the process). Not
 * for other rooms. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/http/http.h"
#include "daemon/relay/relay.h"
#include "daemon/relay/upstream.h"
#include "daemon/stream/frame_reader.h"
#include "daemon/stream/ws.h"

typedef struct relay_streams relay_streams;
typedef struct relay_source relay_source;

/* A message that waits. */
typedef struct relay_text {
    struct relay_text *next;
    size_t size;
    char text[];
} relay_text;

/* A connection to the owner for one viewer's own messages. */
typedef struct relay_tunnel {
    relay_source *source;
    ll_ws_viewer viewer;
    struct relay_tunnel *next; /* guarded by streams->lock, as the following */
    relay_text *first, **end;  /* of the viewer, to be sent */
    size_t bytes;
    bool gone; /* the viewer has left */

    /* the thread only */
    ll_upstream *upstream;
    bool open, failed;
    char *key; /* sent again after the connection was lost; NULL: none */
} relay_tunnel;

/* A viewer of a session. */
typedef struct relay_viewer {
    struct relay_viewer *next;
    ll_ws_viewer viewer;
    ll_frame_format format;
    bool greeted; /* its hello was sent */
} relay_viewer;

/* A stream that is passed on. */
struct relay_source {
    relay_streams *streams;
    ll_stream_kind kind;
    char id[65];
    ll_ws_stream *stream;
    relay_source *next; /* of the thread's list, or of the new ones */

    /* guarded by streams->lock */
    int viewers;
    int64_t idle_ns;        /* since when there are none */
    relay_viewer *watching; /* of a session, in any order */
    int waiting;            /* how many of them were not greeted */
    relay_tunnel *tunnels;
    bool wanted; /* a viewer waits for a frame */
    bool ended;  /* closed: who comes now comes again */

    /* the thread only; of a session's stream */
    ll_upstream *upstream, *greeting; /* greeting: a second connection, for a new hello */
    bool open, up;                    /* the connection stands; and the hello has come */
    bool owner_away;                  /* the owner, a relay, says so of its own */
    bool away;                        /* viewers know that no frames come */
    int64_t away_ns;                  /* since when that is so; 0: it is not */
    char *hello[2];                   /* by format; NULL: none yet */
    char session_kind[16];
    double tick_hz;
    bool stale; /* parameters have changed since the hello */
    bool version_known;
    int64_t version; /* of the parameters */
    /* The subscription that was sent last, and the last one that surely counts; see `fresh_channels`. */
    ll_ws_subscription asked, granted;
    int asks, granting; /* unanswered ones; frames until what was asked counts */
    unsigned divisor;   /* of the owner's rates for us */
    int64_t lower_ns;   /* since when less would do; 0: never */
    int attempt;
    int64_t retry_ns, up_ns, pinged_ns, missing_ns, greeted_ns, repeated_ns;
    ll_frame_reader reader;
    double debt; /* bytes that the owner's messages have cost beyond what is due by now; see `charge` */
    int64_t charged_ns;
    uint16_t fresh; /* channels whose rows are of the last frame's tick */
    ll_frame_state last;
    uint32_t last_generation;
    uint32_t seq, offset, generation; /* of the frames that are published: offset to the owner's */
    bool published;
    int end_code; /* not 0: to be closed, for this reason */
    char end_reason[120];
};

typedef struct relay_counts {
    atomic_ullong frames, bytes; /* from the owner */
    atomic_ullong lost, faults;  /* connections that ended, messages that could not be read */
    atomic_int sources, connected, tunnels;
} relay_counts;

struct relay_streams {
    const ll_relay_config *config;
    ll_owner *owner;
    ll_upstreams *upstreams;
    ll_ws *ws;
    pthread_t thread;
    bool started;
    atomic_bool stopping;
    atomic_ullong epoch; /* rises whenever an answer that was kept may have become wrong */

    pthread_mutex_t lock;
    relay_source *fresh; /* opened since the thread looked */
    int sources;         /* all, fresh ones included */
    int tunnels;
    bool dirty; /* something for the thread */

    /* the thread only */
    relay_source *first;
    bool published;
    int64_t swept_ns;
    ll_row_set space;

    /* The owner's clock less ours, by the pongs: for the age of frames. */
    _Atomic int64_t clock_ns;
    int64_t clock_error_ns, clock_known_ns; /* the thread only */
    relay_counts counts;
};

/* streams.c */
ll_status ll_relay_streams_new(const ll_relay_config *config, ll_owner *owner, relay_streams **streams);
ll_ws_hooks ll_relay_hooks(relay_streams *streams);
ll_status ll_relay_streams_start(relay_streams *streams, ll_ws *ws);
void ll_relay_streams_stop(relay_streams *streams); /* after the streams' threads have ended */
void ll_relay_streams_free(relay_streams *streams); /* after `ws` was freed */

/* source.c: on the thread. */
void ll_relay_source_step(relay_source *source, int64_t now_ns);
void ll_relay_source_free(relay_source *source);
/* Closes its connections; its memory stays until the stream is released. */
void ll_relay_source_disconnect(relay_source *source);

/* tunnel.c */
/* Passes a message on to the owner. Any thread. LL_LIMIT, LL_NO_MEMORY. */
ll_status ll_relay_tunnel_send(relay_source *source, ll_ws_viewer viewer, const char *text, size_t size);
/* The same without a message: the streams of classes and experiments are a tunnel from the start. */
ll_status ll_relay_tunnel_open(relay_source *source, ll_ws_viewer viewer);
void ll_relay_tunnels_step(relay_source *source); /* the thread: sends, and frees those whose viewers left */
void ll_relay_tunnels_free(relay_source *source); /* the thread: all of them */

/* forward.c */
typedef struct ll_forward ll_forward;
ll_forward *ll_forward_new(const ll_relay_config *config, ll_owner *owner, relay_streams *streams);
void ll_forward_free(ll_forward *forward);
void ll_forward_request(ll_forward *forward, const ll_http_request *request, ll_http_response *response);
typedef struct ll_forward_stats {
    uint64_t requests, kept, failed; /* kept: answered without the owner */
} ll_forward_stats;
ll_forward_stats ll_forward_get_stats(ll_forward *forward);

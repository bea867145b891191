/* Streams of the owner: WebSocket connections of a client, all read by one thread.
 *
 * libcurl resolves names, connects and encrypts. The WebSocket of the version that Debian 12 has is not
 * compiled in, so that frames are read by daemon/net/framing.h, as those of viewers are. Connecting may take
 * seconds: each attempt has a thread for that time. An owner that is silent for some seconds, and does not
 * answer pings either, counts as gone. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

int64_t ll_relay_now(void); /* monotonic, ns */

typedef struct ll_owner {
    char url[512];  /* without / at the end */
    char host[280]; /* of the Host header, with the port */
    char path[512]; /* before that of a request */
    const char *ca_file;
    atomic_bool stopping; /* attempts to connect end soon */
} ll_owner;

/* From http://HOST[:PORT][/PATH]. LL_BAD_INPUT. */
ll_status ll_owner_parse(const char *url, const char *ca_file, ll_owner *owner);

void *ll_owner_request(ll_owner *owner); /* a CURL with its settings for this owner; NULL without memory */

enum { LL_UPSTREAM_CUT = 1006 }; /* the connection ended without a close frame, or could not be made */

/* Called on the thread that calls ll_upstreams_serve. */
typedef struct ll_upstream_hooks {
    void (*opened)(void *context);
    void (*text)(void *context, const char *text, size_t size); /* NUL-terminated */
    void (*binary)(void *context, const void *bytes, size_t size);
    /* The last call. `code`: of the close frame, LL_UPSTREAM_CUT, or the HTTP status of a refusal. */
    void (*closed)(void *context, int code, const char *reason);
} ll_upstream_hooks;

typedef struct ll_upstream ll_upstream;
typedef struct ll_upstreams ll_upstreams;

ll_status ll_upstreams_new(ll_owner *owner, ll_upstreams **upstreams);
/* Waits for attempts to connect (set owner->stopping before), and closes all. */
void ll_upstreams_free(ll_upstreams *upstreams);

/* Handles what has happened, waiting at most `wait_ms` for it or for ll_upstreams_wake. */
void ll_upstreams_serve(ll_upstreams *upstreams, int wait_ms);
void ll_upstreams_wake(ll_upstreams *upstreams); /* any thread */

/* The thread that serves; also within a hook. NULL without memory or thread. */
ll_upstream *ll_upstream_open(ll_upstreams *upstreams, const char *path, const char *protocol,
                              const ll_upstream_hooks *hooks, void *context);
void ll_upstream_send(ll_upstream *upstream, const char *text, size_t size);
void ll_upstream_close(ll_upstream *upstream); /* no hook is called; NULL: no effect */

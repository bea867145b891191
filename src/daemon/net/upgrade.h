/* Parsing of request heads for routing, and checks of host and origin: pure functions, no sockets.
 *
 * The head parser only decides between HTTP and streams. The side that gets the connection parses the head
 * again; a head that this parser rejects goes to the HTTP side, which answers it. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "session/frame.h"

typedef struct ll_text { /* not NUL-terminated; `at` is NULL when absent */
    const char *at;
    size_t size;
} ll_text;

typedef enum ll_head_state {
    LL_HEAD_PARTIAL, /* incomplete */
    LL_HEAD_WHOLE,
    LL_HEAD_INVALID, /* not HTTP/1; `fault` may say why */
    LL_HEAD_VERSION, /* another version of HTTP */
} ll_head_state;

/* Why a head is refused. */
typedef struct ll_head_fault {
    int status;
    const char *field, *text; /* a header's name or empty; a sentence */
} ll_head_fault;

/* Formats of frames, by the names that Sec-WebSocket-Protocol has for them. */
enum { LL_STREAM_PROTOCOLS = 2 };

/* What an upgrade is decided by. The lists Upgrade, Connection and Sec-WebSocket-Protocol may come in several
 * lines. */
typedef struct ll_head {
    ll_text method, target, host, version, key, origin, length;
    bool http11;
    bool websocket;                       /* Upgrade has it */
    bool upgrade;                         /* Connection has it */
    bool encoded;                         /* there is a Transfer-Encoding */
    int protocols;                        /* in Sec-WebSocket-Protocol */
    int protocol_at[LL_STREAM_PROTOCOLS]; /* place of each format of frames among them, from 1; 0: none */
    const char *twice;                    /* a header that came again and may not; NULL: none */
    const ll_head_fault *fault;           /* NULL: none, or not a head at all */
    size_t size;                          /* of the head with its empty line */
} ll_head;

ll_head_state ll_head_parse(const char *bytes, size_t size, ll_head *head);

/* One header; space around `value` is no part of it. */
void ll_head_add(ll_head *head, ll_text name, ll_text value);

/* What is wrong with a header, in which two parsers could differ; `value` without space before it. NULL: no
 * fault. */
const ll_head_fault *ll_header_fault(ll_text name, ll_text value);

/* Why a request's target must not reach a handler: it is none, or the library would truncate it (`%00`) or
 * reject it (too many arguments). NULL: no fault. */
const char *ll_target_fault(const char *target);
enum { LL_ARGUMENTS_MAX = 64 };

/* Allowed hosts and origins. Lists are comma separated; empty or NULL: only the default ones. */
typedef struct ll_allow {
    const char *hosts, *origins;
} ll_allow;

/* Protects against DNS rebinding: allows localhost, address literals and the listed names. `host` is the Host
 * header's value. */
bool ll_allow_host(const ll_allow *allow, ll_text host);
/* Allows own pages (Origin's host and port equal Host's) and the listed origins; also no Origin, since only
 * browsers send one. */
bool ll_allow_origin(const ll_allow *allow, ll_text origin, ll_text host);

/* Kind of a stream: frames of a session, the progress of an experiment, or the state of a class. */
typedef enum ll_stream_kind {
    LL_STREAM_SESSION,
    LL_STREAM_EXPERIMENT,
    LL_STREAM_CLASS,
    LL_STREAM_KINDS
} ll_stream_kind;

extern const char *const ll_stream_names[LL_STREAM_KINDS]; /* for messages: session */

/* Kind and id of a stream's path, `/api/v1/sessions/ID/stream`, or `experiments` or `classes` in place of
 * `sessions` (a query may follow); false for any other path. */
bool ll_stream_path(ll_text target, ll_stream_kind *kind, char id[65]);

typedef struct ll_upgrade {
    ll_stream_kind kind;
    char id[65];
    ll_frame_format format; /* LL_FRAME_JSON unless it is of a session */
    char key[25];           /* Sec-WebSocket-Key */
} ll_upgrade;

/* Checks whether `head`, whose target is a stream's path, is a valid upgrade. If not, `http_status` is the
 * status to refuse it with (400, 403, 405, 421, 426). Does not check that the session exists. */
ll_status ll_upgrade_check(const ll_head *head, const ll_allow *allow, ll_upgrade *upgrade, int *http_status);

extern const char *const ll_stream_protocols[LL_STREAM_PROTOCOLS]; /* by ll_frame_format */

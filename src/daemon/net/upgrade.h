/* Reading of request heads for routing, and who may come in: pure functions, no sockets.
 *
 * The head parser serves the acceptor's decision only (HTTP or stream); whoever gets the connection reads the
 * head again, and what this parser finds odd goes to the HTTP side, which answers it. */
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
    LL_HEAD_PARTIAL, /* may become a head */
    LL_HEAD_WHOLE,
    LL_HEAD_JUNK,  /* not HTTP/1 */
    LL_HEAD_HTTP2, /* the preface of HTTP/2 */
} ll_head_state;

typedef struct ll_head {
    ll_text method, target, host, upgrade, connection, version, key, protocols, origin, fetch_site;
    bool http11;
    bool twice;  /* a header that decides was there more than once */
    size_t size; /* of the head with its empty line */
} ll_head;

ll_head_state ll_head_parse(const char *bytes, size_t size, ll_head *head);

/* Why no handler may see a request's target, as it came: what the library would cut (`%00`) or choke on (too
 * many arguments). NULL: nothing. */
const char *ll_target_fault(const char *target);
enum { LL_ARGUMENTS_MAX = 64 };

bool ll_has_token(ll_text list, const char *token); /* comma separated, case ignored */

/* Who may talk to the daemon. Lists are comma separated; empty or NULL: none beside the standard ones. */
typedef struct ll_allow {
    const char *hosts, *origins;
} ll_allow;

/* Against DNS rebinding: localhost, address literals and the names allowed. `host` is a Host header's value.
 */
bool ll_allow_host(const ll_allow *allow, ll_text host);
/* Own pages (Origin's host and port equal Host's) and the origins allowed. No Origin is no browser: allowed.
 */
bool ll_allow_origin(const ll_allow *allow, ll_text origin, ll_text host);

/* What a stream is about: frames of a session, or the progress of an experiment. */
typedef enum ll_stream_kind { LL_STREAM_SESSION, LL_STREAM_EXPERIMENT, LL_STREAM_KINDS } ll_stream_kind;

/* Kind and id of a stream's path, `/api/v1/sessions/ID/stream` or `/api/v1/experiments/ID/stream` (a query
 * may follow); false when it is another path. */
bool ll_stream_path(ll_text target, ll_stream_kind *kind, char id[65]);

typedef struct ll_upgrade {
    ll_stream_kind kind;
    char id[65];
    ll_frame_format format; /* of an experiment's stream always LL_FRAME_JSON */
    char key[25];           /* Sec-WebSocket-Key */
} ll_upgrade;

/* Whether `head`, whose target is a stream's path, is an upgrade that the stream side may take. The HTTP
 * status to refuse it with is in `http_status` (400, 403, 405, 421, 426). That the session exists is not
 * looked at. */
ll_status ll_upgrade_check(const ll_head *head, const ll_allow *allow, ll_upgrade *upgrade, int *http_status);

extern const char *const ll_stream_protocols[2]; /* by ll_frame_format */

/* Messages of viewers: those to a session, and the answers on a stream of any kind. */
#pragma once

#include "base/status.h"
#include "daemon/stream/ws.h"

struct cJSON;

enum { LL_REPLY_ID = 40 }; /* space for the `id` of a message as JSON; empty: none */

/* A message's `id`: a whole number or a short text, which the reply repeats. */
ll_status ll_request_id(const struct cJSON *message, char reply_id[LL_REPLY_ID]);

ll_status ll_request_rates(const struct cJSON *subscribe, ll_ws_subscription *subscription);
ll_status ll_request_ping(const struct cJSON *ping);

/* Answers, which the caller deletes or sends; `type` is "reply" or another. */
struct cJSON *ll_request_answer(const char *type, const char *reply_id);
struct cJSON *ll_request_granted(const ll_ws_subscription *subscription, const char *reply_id);
struct cJSON *ll_request_pong(const struct cJSON *ping, int64_t wall_ns, const char *reply_id);

void ll_request_send(ll_ws *ws, ll_ws_viewer viewer, struct cJSON *json); /* takes ownership */
void ll_request_refuse(ll_ws *ws, ll_ws_viewer viewer, const char *reply_id, int http_status,
                       const ll_status *error);

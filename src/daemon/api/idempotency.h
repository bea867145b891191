/* Idempotency-Key of POST /sessions: a repeated request of the same client gets the answer of the first one,
 * and creates nothing. A client is its address with the key of access that it presents.
 *
 * The newest answers are kept in memory, a bounded number: they contain keys, which are never written to
 * disk. They are kept under a salted hash of client and Idempotency-Key. Any thread. */
#pragma once

#include "daemon/api/api.h"

ll_api_idempotency *ll_api_idempotency_new(void); /* NULL: no memory, or no random numbers */
void ll_api_idempotency_free(ll_api_idempotency *table);

typedef enum ll_api_repeat {
    LL_REPEAT_FIRST, /* continue, then call ll_api_idempotency_end */
    LL_REPEAT_SAME,  /* the same request again */
    LL_REPEAT_BUSY,  /* the first request is still in progress */
    LL_REPEAT_OTHER, /* the same key with another body */
} ll_api_repeat;

/* `access`: the key of access of the request; NULL: it has none. `number` gets what ll_api_idempotency_end
 * needs, `answer` the first answer (malloc'ed, caller frees), if there is one. When what it made is gone,
 * call ll_api_idempotency_end without an answer, then begin again. */
ll_api_repeat ll_api_idempotency_begin(ll_api_idempotency *table, const ll_http_request *request,
                                       const char *access, const char *key, uint64_t *number, char **answer);
/* `answer` NULL: the request failed, or what it made is gone; the key may be used again. */
void ll_api_idempotency_end(ll_api_idempotency *table, uint64_t number, const char *answer);

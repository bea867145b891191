/* Idempotency-Key of POST /sessions: a repeated request gets the answer of the first one, and creates
 * nothing.
 *
 * The newest answers are kept in memory, a bounded number: they contain keys, which are never written to
 * disk. Any thread. */
#pragma once

#include "daemon/api/api.h"

ll_api_idempotency *ll_api_idempotency_new(void);
void ll_api_idempotency_free(ll_api_idempotency *table);

typedef enum ll_api_repeat {
    LL_REPEAT_FIRST, /* continue, then call ll_api_idempotency_end */
    LL_REPEAT_SAME,  /* `answer` (malloc'ed, caller frees) is the first answer */
    LL_REPEAT_BUSY,  /* the first request is still in progress */
    LL_REPEAT_OTHER, /* the same key with another body */
} ll_api_repeat;

ll_api_repeat ll_api_idempotency_begin(ll_api_idempotency *table, const char *peer, const char *key,
                                       const char *body, size_t size, uint64_t *name, char **answer);
/* `answer` NULL: the request failed, and the key may be used again. */
void ll_api_idempotency_end(ll_api_idempotency *table, uint64_t name, const char *answer);

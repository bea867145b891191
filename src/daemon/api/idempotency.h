/* Idempotency-Key of POST /sessions: a repeated request gets the first one's answer and makes nothing.
 *
 * The last answers are kept in memory (they hold keys, which never reach the disk), a bounded number of them.
 * Any thread. */
#pragma once

#include "daemon/api/api.h"

ll_api_idempotency *ll_api_idempotency_new(void);
void ll_api_idempotency_free(ll_api_idempotency *table);

typedef enum ll_api_repeat {
    LL_REPEAT_FIRST, /* go on, then call ll_api_idempotency_end */
    LL_REPEAT_SAME,  /* `answer` (malloc'ed, caller frees) is what was answered */
    LL_REPEAT_BUSY,  /* the first is still being worked on */
    LL_REPEAT_OTHER, /* the same key with another body */
} ll_api_repeat;

ll_api_repeat ll_api_idempotency_begin(ll_api_idempotency *table, const char *peer, const char *key,
                                       const char *body, size_t size, uint64_t *name, char **answer);
/* `answer` NULL: it failed, the key is free again. */
void ll_api_idempotency_end(ll_api_idempotency *table, uint64_t name, const char *answer);

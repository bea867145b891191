#include "daemon/api/idempotency.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/support/digest.h"

enum { KEPT = 1024 };

typedef struct stored_answer {
    unsigned char name[LL_DIGEST_SIZE]; /* hash of peer and key */
    unsigned char body[LL_DIGEST_SIZE];
    uint64_t number; /* 0: free */
    char *answer;    /* NULL while the first request is in progress */
} stored_answer;

struct ll_api_idempotency {
    pthread_mutex_t lock;
    uint64_t number;
    stored_answer entry[KEPT];
};

ll_api_idempotency *ll_api_idempotency_new(void)
{
    ll_api_idempotency *table = calloc(1, sizeof *table);
    if (table)
        pthread_mutex_init(&table->lock, NULL);
    return table;
}

void ll_api_idempotency_free(ll_api_idempotency *table)
{
    if (!table)
        return;
    for (int i = 0; i < KEPT; i++)
        free(table->entry[i].answer);
    pthread_mutex_destroy(&table->lock);
    free(table);
}

ll_api_repeat ll_api_idempotency_begin(ll_api_idempotency *table, const char *peer, const char *key,
                                       const char *body, size_t size, uint64_t *name, char **answer)
{
    stored_answer wanted = {0};
    *name = 0;
    if (!ll_digest(peer, strlen(peer) + 1, key, strlen(key), wanted.name) ||
        !ll_digest(body, size, "", 0, wanted.body))
        return LL_REPEAT_FIRST; /* out of memory: the request is answered, but not remembered */
    ll_api_repeat result = LL_REPEAT_FIRST;
    pthread_mutex_lock(&table->lock);
    for (int i = 0; i < KEPT; i++) {
        stored_answer *entry = &table->entry[i];
        if (entry->number == 0 || memcmp(entry->name, wanted.name, sizeof wanted.name) != 0)
            continue;
        result = memcmp(entry->body, wanted.body, sizeof wanted.body) != 0 ? LL_REPEAT_OTHER
                 : entry->answer                                           ? LL_REPEAT_SAME
                                                                           : LL_REPEAT_BUSY;
        if (result == LL_REPEAT_SAME)
            *answer = strdup(entry->answer);
        break;
    }
    if (result == LL_REPEAT_FIRST) {
        wanted.number = *name = ++table->number;
        stored_answer *entry = &table->entry[wanted.number % KEPT]; /* the oldest */
        free(entry->answer);
        *entry = wanted;
    }
    pthread_mutex_unlock(&table->lock);
    return result;
}

void ll_api_idempotency_end(ll_api_idempotency *table, uint64_t name, const char *answer)
{
    pthread_mutex_lock(&table->lock);
    stored_answer *entry = &table->entry[name % KEPT];
    if (entry->number == name) {
        entry->answer = answer ? strdup(answer) : NULL;
        if (!entry->answer)
            entry->number = 0;
    }
    pthread_mutex_unlock(&table->lock);
}

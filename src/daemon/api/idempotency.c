#include "daemon/api/idempotency.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "daemon/support/digest.h"

enum { KEPT = 1024 };

typedef struct stored_answer {
    unsigned char name[LL_DIGEST_SIZE]; /* hash of client and key */
    unsigned char body[LL_DIGEST_SIZE];
    uint64_t number; /* 0: free */
    char *answer;    /* NULL while the first request is in progress */
} stored_answer;

struct ll_api_idempotency {
    pthread_mutex_t lock;
    unsigned char salt[16];
    uint64_t number;
    stored_answer entry[KEPT];
};

ll_api_idempotency *ll_api_idempotency_new(void)
{
    ll_api_idempotency *table = calloc(1, sizeof *table);
    if (!table || getrandom(table->salt, sizeof table->salt, 0) != (ssize_t)sizeof table->salt) {
        free(table);
        return NULL;
    }
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

/* `access` with its end, so that an empty key differs from none. */
static bool make_name(const ll_api_idempotency *table, const char *peer, const char *access, const char *key,
                      unsigned char name[LL_DIGEST_SIZE])
{
    return ll_digest(table->salt, sizeof table->salt, access, access ? strlen(access) + 1 : 0, name) &&
           ll_digest(name, LL_DIGEST_SIZE, peer, strlen(peer), name) &&
           ll_digest(name, LL_DIGEST_SIZE, key, strlen(key), name);
}

ll_api_repeat ll_api_idempotency_begin(ll_api_idempotency *table, const ll_http_request *request,
                                       const char *access, const char *key, uint64_t *number, char **answer)
{
    stored_answer wanted = {0};
    *number = 0;
    if (!make_name(table, request->peer, access, key, wanted.name) ||
        !ll_digest(request->body, request->body_size, "", 0, wanted.body))
        return LL_REPEAT_FIRST; /* out of memory: the request is answered, but not remembered */
    ll_api_repeat result = LL_REPEAT_FIRST;
    pthread_mutex_lock(&table->lock);
    for (int i = 0; i < KEPT; i++) {
        stored_answer *entry = &table->entry[i];
        if (entry->number == 0 || !ll_digest_equal(entry->name, wanted.name))
            continue;
        result = !ll_digest_equal(entry->body, wanted.body) ? LL_REPEAT_OTHER
                 : entry->answer                            ? LL_REPEAT_SAME
                                                            : LL_REPEAT_BUSY;
        *number = entry->number;
        *answer = entry->answer ? strdup(entry->answer) : NULL;
        break;
    }
    if (result == LL_REPEAT_FIRST) {
        wanted.number = *number = ++table->number;
        stored_answer *entry = &table->entry[wanted.number % KEPT]; /* the oldest */
        free(entry->answer);
        *entry = wanted;
    }
    pthread_mutex_unlock(&table->lock);
    return result;
}

void ll_api_idempotency_end(ll_api_idempotency *table, uint64_t number, const char *answer)
{
    pthread_mutex_lock(&table->lock);
    stored_answer *entry = &table->entry[number % KEPT];
    if (entry->number == number) {
        free(entry->answer);
        entry->answer = answer ? strdup(answer) : NULL;
        if (!entry->answer)
            entry->number = 0;
    }
    pthread_mutex_unlock(&table->lock);
}

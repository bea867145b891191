#include "daemon/api/idempotency.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/support/seal.h"

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

/* ---- of a shared store ---- */

static void write_hex(const unsigned char digest[LL_DIGEST_SIZE], char text[LL_ANSWER_HEX])
{
    for (size_t i = 0; i < LL_DIGEST_SIZE; i++)
        snprintf(text + 2 * i, 3, "%02x", digest[i]);
}

/* Names what is stored and the key that seals it, neither of which leads to the other. */
static bool name_claim(const ll_http_request *request, const char *key, ll_api_claim *claim)
{
    static const char name_of[] = "name", seal_of[] = "seal";
    unsigned char both[LL_DIGEST_SIZE], name[LL_DIGEST_SIZE], body[LL_DIGEST_SIZE];
    bool done = ll_digest(request->peer, strlen(request->peer) + 1, key, strlen(key), both) &&
                ll_digest(name_of, sizeof name_of, both, sizeof both, name) &&
                ll_digest(seal_of, sizeof seal_of, both, sizeof both, claim->seal) &&
                ll_digest(request->body, request->body_size, "", 0, body);
    if (!done)
        return false;
    write_hex(name, claim->key.name);
    write_hex(body, claim->key.body);
    return true;
}

static char *seal_answer(void *context, const ll_created_session *created)
{
    const ll_api_claim *claim = context;
    cJSON *json = ll_api_describe_created(created);
    char *text = cJSON_PrintUnformatted(json), *sealed = text ? ll_seal(claim->seal, text) : NULL;
    cJSON_Delete(json);
    free(text);
    return sealed;
}

ll_status ll_api_idempotency_claim(ll_host *host, const ll_http_request *request, const char *key,
                                   ll_api_claim *claim, ll_api_repeat *repeat, char **text)
{
    static const ll_api_repeat repeats[] = {[LL_ANSWER_FIRST] = LL_REPEAT_FIRST,
                                            [LL_ANSWER_SAME] = LL_REPEAT_SAME,
                                            [LL_ANSWER_OTHER] = LL_REPEAT_OTHER,
                                            [LL_ANSWER_BUSY] = LL_REPEAT_BUSY};
    ll_answer_claim found;
    *claim = (ll_api_claim){.answer = {.text = seal_answer, .context = claim, .key = &claim->key}};
    if (!name_claim(request, key, claim))
        return ll_error(LL_NO_MEMORY, "out of memory: Idempotency-Key");
    LL_TRY(ll_host_claim_answer(host, &claim->key, &found));
    *repeat = repeats[found.state];
    *text = found.text ? ll_unseal(claim->seal, found.text) : NULL;
    free(found.text);
    return *repeat == LL_REPEAT_SAME && !*text ? ll_error(LL_IO, "The stored answer cannot be read.")
                                               : ll_ok();
}

void ll_api_idempotency_give_back(ll_store *store, ll_api_claim *claim)
{
    ll_store_wait(store, ll_store_release_answer(store, &claim->key));
}

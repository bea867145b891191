/* All sessions of a host by id and by code. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/hash.h"
#include "daemon/hosting/hosted.h"
#include "daemon/support/log.h"

static unsigned bucket_of(const char *text)
{
    return (unsigned)(ll_hash(0, text, strlen(text)) % LL_HOST_BUCKETS);
}

static ll_hosted *find_code(ll_host *host, const char *code)
{
    ll_hosted *hosted = host->by_code[bucket_of(code)];
    while (hosted && strcmp(hosted->code, code) != 0)
        hosted = hosted->next_by_code;
    return hosted;
}

ll_hosted *ll_host_find(ll_host *host, const char *id)
{
    if (!ll_is_id(id))
        return NULL;
    pthread_mutex_lock(&host->lock);
    ll_hosted *hosted = host->by_id[bucket_of(id)];
    while (hosted && strcmp(hosted->id, id) != 0)
        hosted = hosted->next_by_id;
    if (hosted)
        ll_hosted_retain(hosted);
    pthread_mutex_unlock(&host->lock);
    return hosted;
}

ll_hosted *ll_host_find_code(ll_host *host, const char *code)
{
    if (!ll_is_code(code))
        return NULL;
    pthread_mutex_lock(&host->lock);
    ll_hosted *hosted = find_code(host, code);
    if (hosted)
        ll_hosted_retain(hosted);
    pthread_mutex_unlock(&host->lock);
    return hosted;
}

static bool choose_code(ll_host *host, ll_hosted *hosted)
{
    for (int attempt = 0; attempt < 1000; attempt++) {
        if (!ll_new_code(hosted->code))
            return false;
        if (!find_code(host, hosted->code))
            return true;
    }
    return false;
}

bool ll_host_register(ll_host *host, ll_hosted *hosted)
{
    pthread_mutex_lock(&host->lock);
    bool room = host->sessions < host->config.max_sessions && (hosted->code[0] || choose_code(host, hosted));
    if (room) {
        ll_hosted_retain(hosted);
        ll_hosted **by_id = &host->by_id[bucket_of(hosted->id)],
                  **by_code = &host->by_code[bucket_of(hosted->code)];
        hosted->next_by_id = *by_id;
        *by_id = hosted;
        hosted->next_by_code = *by_code;
        *by_code = hosted;
        unsigned place = host->next_place++;
        hosted->worker = (int)(place % (unsigned)host->worker_count);
        hosted->slot = (int)(place / (unsigned)host->worker_count % LL_SLOTS);
        host->sessions++;
        hosted->serial = ++host->serials;
    }
    pthread_mutex_unlock(&host->lock);
    return room;
}

void ll_host_unregister(ll_host *host, ll_hosted *hosted)
{
    bool found = false;
    pthread_mutex_lock(&host->lock);
    ll_hosted **link = &host->by_id[bucket_of(hosted->id)];
    while (*link && *link != hosted)
        link = &(*link)->next_by_id;
    if (*link) {
        *link = hosted->next_by_id;
        link = &host->by_code[bucket_of(hosted->code)];
        while (*link && *link != hosted)
            link = &(*link)->next_by_code;
        if (*link)
            *link = hosted->next_by_code;
        host->sessions--;
        found = true;
    }
    pthread_mutex_unlock(&host->lock);
    if (found)
        ll_hosted_release(hosted);
}

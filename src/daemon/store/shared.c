/* Functions of a store that several daemons share; without one they do nothing. */
#include "daemon/store/shared.h"

#include <math.h>

#include "daemon/store/internal.h"

const char *const ll_claim_whys[LL_CLAIM_WHYS] = {"free", "own", "dead", "given"};

ll_status ll_store_open_shared(const ll_shared_config *config, ll_store **store)
{
    *store = NULL;
#ifdef LAGLAB_POSTGRES
    return ll_pg_open(config, store);
#else
    (void)config;
    return ll_field_error(LL_BAD_INPUT, "store", "store: this build of laglab has no PostgreSQL.");
#endif
}

ll_status ll_store_import(const char *directory, const char *url, ll_imported *imported)
{
    *imported = (ll_imported){0};
#ifdef LAGLAB_POSTGRES
    return ll_pg_import(directory, url, imported);
#else
    (void)directory, (void)url;
    return ll_field_error(LL_BAD_INPUT, "store", "store: this build of laglab has no PostgreSQL.");
#endif
}

bool ll_store_is_shared(const ll_store *store)
{
    return store && store->kind->shared;
}

int64_t ll_store_daemon(ll_store *store)
{
    if (!ll_store_is_shared(store))
        return 0;
    pthread_mutex_lock(&store->lock);
    int64_t daemon = store->daemon;
    pthread_mutex_unlock(&store->lock);
    return daemon;
}

double ll_store_lease_left_s(ll_store *store)
{
    return ll_store_is_shared(store) ? store->kind->shared->lease_left_s(store) : (double)INFINITY;
}

ll_status ll_store_check_lease(ll_store *store)
{
    if (!ll_store_is_shared(store) || ll_store_lease_left_s(store) > 0)
        return ll_ok();
    return ll_error(LL_UNAVAILABLE, "The store does not answer; this daemon waits until it does.");
}

ll_status ll_store_claim(ll_store *store, const char *id, ll_claim *claim)
{
    return store->kind->shared->claim(store, id, claim);
}

ll_status ll_store_release_id(ll_store *store, const char *id)
{
    return store->kind->shared->release_id(store, id);
}

ll_status ll_store_mark_dead(ll_store *store, int64_t daemon, bool gone, bool *marked)
{
    bool unused;
    return store->kind->shared->mark_dead(store, daemon, gone, marked ? marked : &unused);
}

ll_status ll_store_ask(ll_store *store, int64_t owner, const char *id)
{
    return store->kind->shared->ask(store, owner, id);
}

void ll_store_on_asked(ll_store *store, void (*asked)(void *context, const char *id), void *context)
{
    if (ll_store_is_shared(store))
        store->kind->shared->on_asked(store, asked, context);
}

ll_status ll_store_reserve_code(ll_store *store, int64_t number, const char *code, ll_session_quota *quota,
                                bool *taken)
{
    return store->kind->shared->reserve_code(store, number, code, quota, taken);
}

ll_status ll_store_count_keys(ll_store *store, ll_log_size *sizes, int64_t count,
                              void (*each)(void *context, const ll_key_use *use), void *context)
{
    return store->kind->shared->count_keys(store, sizes, count, each, context);
}

ll_status ll_store_find_code(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1])
{
    return store->kind->shared->find_code(store, code, id);
}

ll_status ll_store_read_state(ll_store *store, int64_t number, ll_stored_state *state)
{
    return store->kind->shared->read_state(store, number, state);
}

ll_status ll_store_open_class(ll_store *store, const ll_new_class *wanted, ll_opened_class *opened)
{
    return store->kind->shared->open_class(store, wanted, opened);
}

ll_status ll_store_claim_class(ll_store *store, const char *id, ll_claim *claim)
{
    return store->kind->shared->claim_class(store, id, claim);
}

ll_status ll_store_find_class(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1])
{
    return store->kind->shared->find_class(store, code, id);
}

ll_status ll_store_claim_answer(ll_store *store, ll_answer_key *key, ll_answer_claim *claim)
{
    return store->kind->shared->claim_answer(store, key, claim);
}

ll_status ll_store_expire(ll_store *store, double ttl_s, int64_t *deleted)
{
    *deleted = 0;
    return ll_store_is_shared(store) ? store->kind->shared->expire(store, ttl_s, deleted) : ll_ok();
}

ll_status ll_store_replace(ll_store *store)
{
    return ll_store_is_shared(store) ? store->kind->shared->replace(store) : ll_ok();
}

ll_status ll_store_drain(ll_store *store)
{
    return ll_store_is_shared(store) ? store->kind->shared->drain(store) : ll_ok();
}

/* Creation of sessions, new ones and forks, with their keys. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/hosting/quota.h"
#include "daemon/hosting/session_entry.h"
#include "session/scenario.h"
#include "session/workload.h"

enum { CLAIMS = 3 };            /* of an answer whose owner turns out to be dead */
enum { LIGHT_BYTES = 2 << 20 }; /* a state of this size is made within about a millisecond */

static int count_players(ll_session *session)
{
    cJSON *params = ll_session_params(session);
    int players = cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(params, "players"));
    cJSON_Delete(params);
    return players < LL_PLAYERS_MAX ? players : LL_PLAYERS_MAX;
}

static bool make_keys(ll_session_entry *session_entry, ll_created_session *created)
{
    ll_key_hash keys[1 + LL_PLAYERS_MAX];
    created->players = count_players(session_entry->session);
    if (!ll_new_key(created->owner_key) || !ll_key_hash_make(created->owner_key, &keys[0]))
        return false;
    for (int i = 0; i < created->players; i++) {
        if (!ll_new_key(created->player_keys[i]) || !ll_key_hash_make(created->player_keys[i], &keys[1 + i]))
            return false;
    }
    return ll_session_entry_set_keys(session_entry, keys, 1 + created->players);
}

static ll_status create_fork(ll_session_entry *origin, ll_task *task, ll_session_entry *session_entry)
{
    ll_session *session;
    LL_TRY(ll_session_entry_enter(origin, task, &session, NULL));
    ll_status status =
        ll_session_fork(session, ll_session_entry_on_line, session_entry, &session_entry->session);
    ll_session_entry_leave(origin);
    return status;
}

static ll_status control(ll_session_entry *session_entry, const char *op, const char *name, double value)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "op", op);
    if (name)
        cJSON_AddNumberToObject(json, name, value);
    ll_status status = ll_session_control(session_entry->session, session_entry->wall, json);
    cJSON_Delete(json);
    return status;
}

static ll_status make_session(ll_session_entry *session_entry, const ll_create_request *request,
                              ll_scenario *scenario, ll_created_session *created)
{
    ll_status status = request->origin ? create_fork(request->origin, request->task, session_entry)
                                       : ll_session_open(scenario, ll_session_entry_on_line, session_entry,
                                                         &session_entry->session);
    if (ll_failed(&status))
        return status;
    if (request->workload)
        status = ll_session_load(session_entry->session, request->workload);
    if (ll_failed(&status))
        return status;
    session_entry->wall = ll_host_now();
    if (!make_keys(session_entry, created))
        return ll_error(LL_NO_MEMORY, "Random numbers for keys not available.");
    if (request->speed > 0 && request->speed != ll_session_get_info(session_entry->session).speed)
        status = control(session_entry, "speed", "speed", request->speed);
    if (!ll_failed(&status) && !request->paused)
        status = control(session_entry, "play", NULL, 0);
    return status;
}

static ll_status check_limits(ll_host *host, const ll_create_request *request)
{
    LL_TRY(ll_host_check_store(host));
    return ll_quota_check_session(host, request->peer, request->class_key,
                                  request->origin ? atomic_load(&request->origin->shared.log_bytes) : 0);
}

/* Parses the scenario of a new session. Without a task, a large one is refused, since making its state takes
 * long. */
static ll_status read_scenario(const ll_host *host, const ll_create_request *request, ll_scenario *scenario)
{
    if (request->origin)
        return ll_ok();
    LL_TRY(ll_scenario_parse(request->scenario, scenario));
    if (request->seed >= 0)
        ((ll_scenario_head *)scenario->config)->seed = request->seed;
    ll_status status = ll_quota_check_state(&host->config, scenario);
    if (ll_failed(&status)) {
        ll_scenario_free(scenario);
        return status;
    }
    if (request->task || scenario->kind->size(scenario->config) <= LIGHT_BYTES)
        return ll_ok();
    ll_scenario_free(scenario);
    return ll_error(LL_INTERRUPTED, "the session is large");
}

static ll_status register_created(ll_host *host, ll_session_entry *session_entry, ll_created_session *created)
{
    if (!ll_host_register(host, session_entry)) {
        created->full = true;
        atomic_fetch_add(&host->refused.sessions, 1);
        return ll_error(LL_LIMIT, "Session limit of %lld reached.", (long long)host->config.max_sessions);
    }
    ll_session_entry_retain(session_entry); /* for the stream */
    ll_status status = ll_ws_stream_open(host->ws, LL_STREAM_SESSION, session_entry->identity.id,
                                         session_entry, &session_entry->stream);
    if (ll_failed(&status)) {
        ll_session_entry_release(session_entry);
        ll_host_unregister(host, session_entry);
    }
    return status;
}

static ll_status full_group(const ll_create_request *request)
{
    return ll_error(LL_LIMIT, "sessions: must be at most %lld of one class (--max-class-sessions)",
                    (long long)request->group_most);
}

/* What it is called in the store. In a shared one its code is reserved before anything is stored, since other
 * daemons choose codes at the same time. */
static ll_status reserve_code(ll_host *host, ll_session_entry *session_entry,
                              const ll_create_request *request, bool *taken)
{
    ll_class_key *key = request->class_key;
    ll_session_quota quota = {.most = request->group_most,
                              .class_key = key ? key->name : "",
                              .most_of_key = key ? key->most[LL_KEY_SESSIONS] : -1};
    if (request->group)
        memcpy(quota.stem, request->group, LL_STEM_LENGTH);
    ll_status status =
        ll_store_reserve_code(host->store, session_entry->stored.place.number, session_entry->identity.code,
                              request->group || key ? &quota : NULL, taken);
    if (ll_failed(&status))
        return status;
    return quota.full ? full_group(request) : quota.key_full ? ll_quota_key_full(key) : status;
}

/* In a store of this daemon alone. */
static ll_status count_here(ll_host *host, ll_session_entry *session_entry, const ll_create_request *request)
{
    if (request->group && ll_host_count_stem(host, request->group) >= request->group_most)
        return full_group(request);
    if (!request->class_key)
        return ll_ok();
    if (!ll_class_key_take(request->class_key, LL_KEY_SESSIONS))
        return ll_quota_key_full(request->class_key);
    atomic_store(&session_entry->shared.class_key, request->class_key);
    return ll_ok();
}

static ll_status reserve_names(ll_host *host, ll_session_entry *session_entry,
                               const ll_create_request *request)
{
    LL_TRY(ll_store_new_place(host->store, &session_entry->stored.place));
    atomic_store(&session_entry->shared.claimed, true);
    if (!ll_store_is_shared(host->store))
        return count_here(host, session_entry, request);
    ll_session_entry_set_class_key(session_entry, request->class_key);
    for (int attempt = 0; attempt < 100; attempt++) {
        char *code = session_entry->identity.code;
        bool taken = true;
        if (!ll_new_code(host->config.shard, code))
            return ll_error(LL_NO_MEMORY, "Random numbers for a code not available.");
        LL_TRY(reserve_code(host, session_entry, request, &taken));
        if (!taken)
            return ll_ok();
    }
    return ll_error(LL_UNAVAILABLE, "No code is free.");
}

/* What is stored together with the session. Its name has to be of the incarnation that stores the session:
 * another daemon may have the name by now. */
static ll_status add_answer(const ll_create_answer *answer, ll_session_entry *session_entry,
                            ll_created_session *created)
{
    if (!answer)
        return ll_ok();
    if (answer->key->daemon != session_entry->stored.place.daemon)
        return ll_error(LL_UNAVAILABLE, "This daemon takes no sessions now; try again.");
    created->session_entry = session_entry;
    char *text = answer->text(answer->context, created);
    created->session_entry = NULL;
    if (!text)
        return ll_error(LL_NO_MEMORY, "out of memory: answer");
    ll_store_batch_answer(&session_entry->stored.collected, answer->key, text);
    free(text);
    return ll_ok();
}

/* No client has the key of a session that was not stored: it is deleted when the store works again. One that
 * is stored with an answer may be given to the client that repeats its request: it stays, unless it never
 * will be stored. */
static void give_up(ll_host *host, const ll_create_request *request, ll_session_entry *session_entry,
                    uint64_t ticket)
{
    if (!request->answer || ll_store_get_outcome(host->store, ticket) == LL_STORE_LOST)
        ll_host_discard(host, session_entry, &ticket);
    ll_session_entry_release(session_entry);
}

/* The engine checks the scenario first: an invalid one never gets into the registry or the store. */
ll_status ll_host_create_session(ll_host *host, const ll_create_request *request, ll_created_session *created)
{
    memset(created, 0, sizeof *created);
    ll_scenario scenario = {0};
    ll_status status = read_scenario(host, request, &scenario);
    LL_THEN(status, check_limits(host, request));
    ll_session_entry *session_entry = ll_failed(&status) ? NULL : ll_session_entry_new(host);
    if (ll_failed(&status)) {
        ll_scenario_free(&scenario);
        return status;
    }
    if (!session_entry || !ll_new_id(host->config.shard, session_entry->identity.id)) {
        ll_scenario_free(&scenario);
        ll_session_entry_release(session_entry);
        return ll_error(LL_NO_MEMORY, "out of memory: session");
    }
    if (request->group)
        memcpy(session_entry->identity.id, request->group, LL_STEM_LENGTH);
    session_entry->shared.client_bytes =
        request->class_key ? NULL : ll_quota_client_bytes(host, request->peer);
    status = reserve_names(host, session_entry, request);
    if (ll_failed(&status)) {
        ll_scenario_free(&scenario);
        ll_session_entry_release(session_entry);
        return status;
    }
    pthread_mutex_lock(&session_entry->lock);
    session_entry->stored.collecting = true;
    status = make_session(session_entry, request, &scenario, created);
    LL_THEN(status, ll_session_entry_fits(session_entry));
    if (session_entry->session) {
        ll_session_info info = ll_session_get_info(session_entry->session);
        created->status = info.status;
        created->tick = info.tick;
    }
    LL_THEN(status, add_answer(request->answer, session_entry, created));
    LL_THEN(status, register_created(host, session_entry, created));
    if (!ll_failed(&status))
        ll_session_entry_save(session_entry);
    session_entry->deleted = ll_failed(&status);
    if (session_entry->session)
        ll_session_entry_update_stats(session_entry);
    uint64_t ticket = session_entry->stored.ticket;
    pthread_mutex_unlock(&session_entry->lock);
    if (ll_failed(&status)) {
        if ((request->group || request->class_key) && ll_store_is_shared(host->store))
            ll_store_delete(host->store, session_entry->stored.place); /* its code counts */
        ll_session_entry_release(session_entry);
        return status;
    }
    atomic_fetch_add(&host->counts.created, 1);
    status = ll_store_wait(host->store, ticket);
    if (ll_failed(&status)) {
        give_up(host, request, session_entry, ticket);
        return ll_error(status.code, "Session not stored: %.200s", status.text);
    }
    ll_session_entry_notify(session_entry);
    created->session_entry = session_entry;
    return ll_ok();
}

/* ---- requests that may be repeated ---- */

ll_status ll_host_claim_answer(ll_host *host, ll_answer_key *key, ll_answer_claim *claim)
{
    bool gone = true;
    for (int attempt = 0; attempt < CLAIMS && gone; attempt++) {
        LL_TRY(ll_store_check_lease(host->store));
        LL_TRY(ll_store_claim_answer(host->store, key, claim));
        if (claim->state != LL_ANSWER_BUSY || claim->owner == key->daemon)
            return ll_ok();
        LL_TRY(ll_neighbour_judge(host->store, claim->owner, claim->url, claim->over, &gone));
    }
    return ll_ok();
}

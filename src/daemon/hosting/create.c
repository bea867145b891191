/* Creation of sessions, new ones and forks, with their keys. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/hosting/quota.h"
#include "daemon/hosting/session_entry.h"
#include "session/scenario.h"
#include "session/workload.h"

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
    for (int i = 0; i < created->players; i++)
        if (!ll_new_key(created->player_keys[i]) || !ll_key_hash_make(created->player_keys[i], &keys[1 + i]))
            return false;
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
    session_entry->wall = ll_now_ns();
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
    LL_TRY(ll_store_check(host->store));
    return ll_quota_check_session(host, request->peer, request->class_key,
                                  request->origin ? atomic_load(&request->origin->shared.log_bytes) : 0);
}

static ll_status read_scenario(const ll_host *host, const ll_create_request *request, ll_scenario *scenario)
{
    if (request->origin)
        return ll_ok();
    LL_TRY(ll_scenario_parse(request->scenario, scenario));
    if (request->seed >= 0)
        ((ll_scenario_head *)scenario->config)->seed = request->seed;
    ll_status status = ll_quota_check_state(&host->config, scenario);
    if (ll_failed(&status))
        ll_scenario_free(scenario);
    return status;
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

static ll_status take_number(ll_host *host, ll_session_entry *session_entry, const ll_create_request *request)
{
    if (request->group && ll_host_count_stem(host, request->group) >= request->group_most)
        return ll_error(LL_LIMIT, "sessions: must be at most %lld of one class (--max-class-sessions)",
                        (long long)request->group_most);
    if (request->class_key && !ll_class_key_take(request->class_key, LL_KEY_SESSIONS))
        return ll_quota_key_full(request->class_key);
    atomic_store(&session_entry->shared.class_key, request->class_key);
    session_entry->stored.number = ll_store_new_number(host->store);
    return ll_ok();
}

/* The engine checks the scenario first: an invalid one never gets into the registry or the store. */
ll_status ll_host_create_session(ll_host *host, const ll_create_request *request, ll_created_session *created)
{
    memset(created, 0, sizeof *created);
    ll_scenario scenario = {0};
    ll_status status = check_limits(host, request);
    LL_THEN(status, read_scenario(host, request, &scenario));
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
    status = take_number(host, session_entry, request);
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
    LL_THEN(status, register_created(host, session_entry, created));
    if (!ll_failed(&status))
        ll_session_entry_save(session_entry);
    session_entry->deleted = ll_failed(&status);
    if (session_entry->session)
        ll_session_entry_update_stats(session_entry);
    uint64_t ticket = session_entry->stored.ticket;
    pthread_mutex_unlock(&session_entry->lock);
    if (ll_failed(&status)) {
        ll_session_entry_release(session_entry);
        return status;
    }
    atomic_fetch_add(&host->counts.created, 1);
    status = ll_store_wait(host->store, ticket);
    if (ll_failed(&status)) { /* no client has its key: it is deleted when the store works again */
        ll_host_discard(host, session_entry);
        ll_session_entry_release(session_entry);
        return ll_error(status.code, "Session not stored: %.200s", status.text);
    }
    ll_session_entry_notify(session_entry);
    created->session_entry = session_entry;
    return ll_ok();
}

/* Making of sessions: new ones and forks, with their keys. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/hosting/quota.h"
#include "daemon/hosting/session_entry.h"
#include "session/scenario.h"
#include "session/workload.h"

enum { LIGHT_BYTES = 2 << 20 }; /* of a state that is made within a millisecond or so */

static int count_players(ll_session *session)
{
    cJSON *params = ll_session_params(session);
    int players = cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(params, "players"));
    cJSON_Delete(params);
    return players < LL_PLAYERS_MAX ? players : LL_PLAYERS_MAX;
}

static bool make_keys(ll_session_entry *session_entry, ll_host_made *made)
{
    made->players = count_players(session_entry->session);
    if (!ll_new_key(made->owner_key) || !ll_key_hash_make(made->owner_key, &session_entry->keys[0]))
        return false;
    for (int i = 0; i < made->players; i++) {
        if (!ll_new_key(made->player_keys[i]) ||
            !ll_key_hash_make(made->player_keys[i], &session_entry->keys[1 + i]))
            return false;
    }
    session_entry->key_count = 1 + made->players;
    return true;
}

static ll_status fork_of(ll_session_entry *origin, ll_task *task, ll_session_entry *session_entry)
{
    ll_session *session;
    ll_status status = ll_session_entry_enter(origin, task, &session, NULL);
    if (ll_failed(&status))
        return status;
    status = ll_session_fork(session, ll_session_entry_on_line, session_entry, &session_entry->session);
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

static ll_status make_session(ll_session_entry *session_entry, const ll_create_request *order,
                              ll_scenario *scenario, ll_host_made *made)
{
    ll_status status = order->origin ? fork_of(order->origin, order->task, session_entry)
                                     : ll_session_open(scenario, ll_session_entry_on_line, session_entry,
                                                       &session_entry->session);
    if (ll_failed(&status))
        return status;
    if (order->workload)
        status = ll_session_load(session_entry->session, order->workload);
    if (ll_failed(&status))
        return status;
    session_entry->wall = ll_host_now();
    if (!make_keys(session_entry, made))
        return ll_error(LL_NO_MEMORY, "The system gives no random numbers for keys.");
    if (order->speed > 0 && order->speed != ll_session_get_info(session_entry->session).speed)
        status = control(session_entry, "speed", "speed", order->speed);
    if (!ll_failed(&status) && !order->paused)
        status = control(session_entry, "play", NULL, 0);
    return status;
}

bool ll_host_allows_creation(ll_host *host, const char *peer)
{
    if (ll_rate_limits_take(host->creations, peer, ll_host_now()))
        return true;
    atomic_fetch_add(&host->refused_creations, 1);
    return false;
}

static ll_status allowed(ll_host *host, const ll_create_request *order)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    return ll_quota_make(host, order->peer, order->origin ? atomic_load(&order->origin->log_bytes) : 0);
}

/* Reads the scenario of a new session. To make a large one is work. */
static ll_status read_scenario(const ll_host *host, const ll_create_request *order, ll_scenario *scenario)
{
    if (order->origin)
        return ll_ok();
    ll_status status = ll_scenario_parse(order->scenario, scenario);
    if (ll_failed(&status))
        return status;
    if (order->seed >= 0)
        ((ll_scenario_head *)scenario->config)->seed = order->seed;
    status = ll_quota_state(&host->config, scenario);
    if (ll_failed(&status)) {
        ll_scenario_free(scenario);
        return status;
    }
    if (order->task || scenario->kind->size(scenario->config) <= LIGHT_BYTES)
        return ll_ok();
    ll_scenario_free(scenario);
    return ll_error(LL_INTERRUPTED, "the session is large");
}

static ll_status enrol(ll_host *host, ll_session_entry *session_entry, ll_host_made *made)
{
    if (!ll_host_register(host, session_entry)) {
        made->full = true;
        atomic_fetch_add(&host->refused_sessions, 1);
        return ll_error(LL_LIMIT, "There are %lld sessions already, which is the limit.",
                        (long long)host->config.max_sessions);
    }
    ll_session_entry_retain(session_entry); /* the stream's */
    ll_status status = ll_ws_stream_open(host->ws, LL_STREAM_SESSION, session_entry->id, session_entry,
                                         &session_entry->stream);
    if (ll_failed(&status)) {
        ll_session_entry_release(session_entry);
        ll_host_unregister(host, session_entry);
    }
    return status;
}

/* The engine's part comes first: a scenario that is wrong leaves no trace in the registry or the store. */
ll_status ll_host_make(ll_host *host, const ll_create_request *order, ll_host_made *made)
{
    memset(made, 0, sizeof *made);
    ll_scenario scenario = {0};
    ll_status status = read_scenario(host, order, &scenario);
    if (!ll_failed(&status))
        status = allowed(host, order);
    ll_session_entry *session_entry = ll_failed(&status) ? NULL : ll_session_entry_new(host);
    if (ll_failed(&status)) {
        ll_scenario_free(&scenario);
        return status;
    }
    if (!session_entry || !ll_new_id(session_entry->id)) {
        ll_scenario_free(&scenario);
        ll_session_entry_release(session_entry);
        return ll_error(LL_NO_MEMORY, "There is no memory for another session.");
    }
    session_entry->stored.number = ll_store_new_number(host->store);
    session_entry->share = ll_quota_share(host, order->peer);
    pthread_mutex_lock(&session_entry->lock);
    status = make_session(session_entry, order, &scenario, made);
    if (!ll_failed(&status))
        status = ll_session_entry_fits(session_entry);
    if (!ll_failed(&status))
        status = enrol(host, session_entry, made);
    if (ll_failed(&status) && session_entry->lines > 0)
        ll_store_delete(host->store, session_entry->stored.number);
    if (!ll_failed(&status))
        ll_session_entry_save(session_entry);
    session_entry->deleted = ll_failed(&status);
    if (session_entry->session) {
        ll_session_info info = ll_session_get_info(session_entry->session);
        made->status = info.status;
        made->tick = info.tick;
        ll_session_entry_note(session_entry);
    }
    uint64_t ticket = session_entry->ticket;
    pthread_mutex_unlock(&session_entry->lock);
    if (ll_failed(&status)) {
        ll_session_entry_release(session_entry);
        return status;
    }
    atomic_fetch_add(&host->created, 1);
    status = ll_store_wait(host->store, ticket);
    if (ll_failed(&status)) { /* nobody knows its key: it goes again when the store works */
        ll_host_discard(host, session_entry, &ticket);
        ll_session_entry_release(session_entry);
        return ll_error(LL_IO, "The session could not be stored: %.200s", status.text);
    }
    ll_session_entry_notify(session_entry);
    made->session_entry = session_entry;
    return ll_ok();
}

/* Permission to create, and what only the operator may do. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/jobs/experiments.h"
#include "daemon/support/access.h"

enum { LIST_MOST = 1000 }; /* sessions in one answer */

static ll_access *access_of(const ll_api *api)
{
    return ll_host_get_config(api->host)->access;
}

static int creation_of(const ll_api *api)
{
    return access_of(api) ? atomic_load(&access_of(api)->creation) : LL_CREATION_OPEN;
}

/* ---- checks for all handlers ---- */

/* A wrong key counts towards the rate limit of wrong codes, so that neither can be guessed. */
static void refuse_key(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       const char *sentence)
{
    ll_status error = ll_error(LL_FORBIDDEN, "%s", sentence);
    if (!ll_host_allows_lookup(api->host, request->peer))
        error = ll_error(LL_LIMIT, "Too many wrong keys and codes from this address.");
    ll_api_problem(response, request, &error);
}

bool ll_api_is_operator(const ll_api *api, const char *key)
{
    return ll_access_is_operator(access_of(api), key, strlen(key));
}

ll_class_key *ll_api_class_key(const ll_api *api, const ll_http_request *request)
{
    const char *key = ll_api_find_key(request);
    return key ? ll_access_class_key(access_of(api), key, strlen(key)) : NULL;
}

bool ll_api_may_create(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    int creation = creation_of(api);
    if (creation == LL_CREATION_OPEN)
        return true;
    bool class = creation == LL_CREATION_CLASS;
    const char *key = ll_api_key(request, response, class ? "a class key" : "the operator's key");
    if (!key)
        return false;
    if (ll_access_may_create(access_of(api), key, strlen(key)))
        return true;
    refuse_key(api, request, response, class ? "Wrong class key." : "Only the operator may create here.");
    return false;
}

static bool is_operator(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    if (!ll_api_started(api, request, response))
        return false;
    const char *key = ll_api_key(request, response, "the operator's key");
    if (!key)
        return false;
    if (ll_api_is_operator(api, key))
        return true;
    const ll_access *access = access_of(api);
    refuse_key(api, request, response,
               access && access->has_operator ? "Wrong operator key."
                                              : "This daemon has no operator; see --operator-key-file.");
    return false;
}

bool ll_api_admits_inside(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    if (!ll_http_header(request, "X-Forwarded-For") && !ll_http_header(request, "Forwarded"))
        return true;
    if (ll_api_find_key(request))
        return is_operator(api, request, response);
    ll_status error = ll_error(LL_NOT_FOUND, "Not found: through a proxy only with the operator's key.");
    ll_api_problem(response, request, &error);
    return false;
}

/* ---- lists ---- */

static ll_status whole(const ll_http_request *request, const char *name, int64_t low, int64_t high,
                       int64_t *value)
{
    const char *text = ll_http_query(request, name);
    char *end;
    if (!text)
        return ll_ok();
    int64_t number = strtoll(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end || number < low || number > high)
        return ll_field_error(LL_BAD_INPUT, name,
                              "%s: must be a whole number from %lld to %lld; got `%.40s`.", name,
                              (long long)low, (long long)high, text);
    *value = number;
    return ll_ok();
}

static void add_name(cJSON *json, const char *class_key)
{
    cJSON_AddItemToObject(json, "class_key",
                          class_key[0] ? cJSON_CreateString(class_key) : cJSON_CreateNull());
}

static cJSON *describe_entry(const ll_host_entry *entry)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", entry->id);
    cJSON_AddStringToObject(json, "code", entry->code);
    cJSON_AddStringToObject(json, "status",
                            entry->status < 0 ? "unloaded" : ll_session_status_names[entry->status]);
    cJSON_AddBoolToObject(json, "parked", entry->parked);
    cJSON_AddNumberToObject(json, "viewers", entry->viewers);
    cJSON_AddNumberToObject(json, "created_s", (double)(entry->created_ms / 1000));
    cJSON_AddNumberToObject(json, "idle_s", entry->idle_s);
    cJSON_AddNumberToObject(json, "log_bytes", (double)entry->log_bytes);
    add_name(json, entry->class_key ? entry->class_key->name : "");
    return json;
}

void ll_get_sessions(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    int64_t after = 0, most = LIST_MOST;
    ll_host_entry *entries = NULL;
    int count = 0;
    if (!is_operator(api, request, response))
        return;
    ll_status status = whole(request, "after", 0, INT64_C(9007199254740991), &after);
    LL_THEN(status, whole(request, "limit", 1, LIST_MOST, &most));
    LL_THEN(status, ll_host_list(api->host, after, (int)most, &entries, &count));
    if (ll_failed(&status)) {
        ll_api_problem(response, request, &status);
        return;
    }
    cJSON *json = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(json, "sessions");
    for (int i = 0; i < count; i++)
        cJSON_AddItemToArray(list, describe_entry(&entries[i]));
    if (count == most)
        cJSON_AddNumberToObject(json, "next", (double)entries[count - 1].serial);
    else
        cJSON_AddNullToObject(json, "next");
    free(entries);
    ll_http_json(response, 200, json);
}

static void add_record(void *context, const ll_experiment_record *record)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddItemToArray(context, json);
    cJSON_AddStringToObject(json, "id", record->id);
    cJSON_AddStringToObject(json, "state", ll_experiment_state_names[record->state]);
    cJSON_AddNumberToObject(json, "runs", (double)(record->to - record->from));
    cJSON_AddNumberToObject(json, "done", (double)record->done);
    cJSON_AddNumberToObject(json, "created_s", (double)record->created_s);
    cJSON_AddStringToObject(json, "version", record->version);
    add_name(json, record->class_key);
}

void ll_get_experiments(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!is_operator(api, request, response))
        return;
    cJSON *json = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(json, "experiments");
    ll_result_store *store = ll_experiments_store(api->experiments);
    ll_status status = ll_result_store_list(store, add_record, list);
    ll_api_result(response, request, &status, json);
}

/* ---- class keys ---- */

/* As in the file; logs in bytes, as they are elsewhere. */
static const char *quota_name(int quota)
{
    return quota == LL_KEY_LOGS ? "log_bytes" : ll_key_quota_names[quota];
}

static cJSON *describe_key(const ll_class_key *key)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "name", key->name);
    cJSON *used = cJSON_AddObjectToObject(json, "used"), *most = cJSON_AddObjectToObject(json, "most");
    for (int i = 0; i < LL_KEY_USES; i++)
        cJSON_AddNumberToObject(used, quota_name(i), (double)atomic_load(&key->used[i]));
    for (int i = 0; i < LL_KEY_QUOTAS; i++)
        cJSON_AddItemToObject(most, quota_name(i),
                              key->most[i] < 0 ? cJSON_CreateNull()
                                               : cJSON_CreateNumber((double)key->most[i]));
    cJSON_AddNumberToObject(json, "refused", (double)atomic_load(&key->refused));
    return json;
}

void ll_get_class_keys(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!is_operator(api, request, response))
        return;
    ll_experiments_delete_expired(api->experiments);
    const ll_class_keys *keys = &access_of(api)->class_keys;
    cJSON *json = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(json, "class_keys");
    for (int i = 0; i < keys->count; i++)
        if (keys->keys[i].name[0])
            cJSON_AddItemToArray(list, describe_key(&keys->keys[i]));
    ll_http_json(response, 200, json);
}

/* ---- creation ---- */

static void answer_creation(const ll_api *api, ll_http_response *response)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "creation", ll_creation_names[creation_of(api)]);
    ll_http_json(response, 200, json);
}

void ll_get_creation(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)request;
    answer_creation(context, response);
}

void ll_put_creation(void *context, const ll_http_request *request, ll_http_response *response)
{
    static const char *const names[] = {"creation", NULL};
    ll_api *api = context;
    if (!is_operator(api, request, response))
        return;
    cJSON *body = ll_api_body(request, response);
    if (!body)
        return;
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(body, "creation");
    ll_status status = ll_api_only(body, names);
    LL_THEN(status, ll_access_set_creation(access_of(api), cJSON_IsString(value) ? value->valuestring : ""));
    if (ll_api_good(response, request, &status))
        answer_creation(api, response);
    cJSON_Delete(body);
}

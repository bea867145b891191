/* Sessions: creating, describing, forking, deleting. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/api/idempotency.h"
#include "experiment/spec/experiment.h"
#include "library/library.h"
#include "session/scenario.h"
#include "session/workload.h"

/* ---- request body of POST /sessions ---- */

/* Sets parameters of a scenario by path, before the session is created: also those that are not live. */
static ll_status set_paths(cJSON **scenario, const cJSON *set)
{
    if (!cJSON_IsObject(set))
        return ll_field_error(
            LL_BAD_INPUT, "set",
            "set: must be an object of paths and values, such as {\"players.1.lag_ms\":250}.");
    ll_scenario parsed = {0};
    LL_TRY(ll_scenario_parse(*scenario, &parsed));
    ll_status status = ll_experiment_apply(parsed.kind, set, parsed.config);
    if (!ll_failed(&status)) {
        cJSON_Delete(*scenario);
        *scenario = ll_param_write(parsed.kind->table, parsed.config);
        if (!*scenario)
            status = ll_error(LL_NO_MEMORY, "out of memory: scenario");
    }
    ll_scenario_free(&parsed);
    return status;
}

static ll_status read_scenario(const ll_api *api, const cJSON *body, cJSON **scenario)
{
    const cJSON *given = cJSON_GetObjectItemCaseSensitive(body, "scenario");
    const cJSON *set = cJSON_GetObjectItemCaseSensitive(body, "set");
    ll_status status;
    if (cJSON_IsString(given)) {
        status = ll_scenario_load(api->scenarios, given->valuestring, scenario);
        if (status.code == LL_NOT_FOUND || status.code == LL_BAD_INPUT)
            status = ll_field_error(LL_BAD_INPUT, "scenario",
                                    "Scenario `%.60s` not found; GET /api/v1/scenarios lists all.",
                                    given->valuestring);
    } else if (cJSON_IsObject(given)) {
        *scenario = cJSON_Duplicate(given, true);
        status = *scenario ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: scenario");
    } else {
        status = ll_field_error(LL_BAD_INPUT, "scenario",
                                "scenario: must be an id (text) or a scenario (object).");
    }
    if (!ll_failed(&status) && set)
        status = set_paths(scenario, set);
    return status;
}

static ll_status read_options(const cJSON *body, ll_create_request *create)
{
    const cJSON *seed = cJSON_GetObjectItemCaseSensitive(body, "seed");
    const cJSON *paused = cJSON_GetObjectItemCaseSensitive(body, "paused");
    const cJSON *speed = cJSON_GetObjectItemCaseSensitive(body, "speed");
    if (seed) {
        double value = cJSON_IsNumber(seed) ? seed->valuedouble : -1;
        if (!(value >= 0 && value <= 9007199254740991.0 && value == floor(value)))
            return ll_field_error(LL_BAD_INPUT, "seed",
                                  "seed: must be a whole number from 0 to 9007199254740991.");
        create->seed = (int64_t)value;
    }
    if (paused && !cJSON_IsBool(paused))
        return ll_field_error(LL_BAD_INPUT, "paused", "paused: must be true or false.");
    if (paused)
        create->paused = cJSON_IsTrue(paused);
    if (speed) {
        if (!cJSON_IsNumber(speed) || !(speed->valuedouble >= 0.1 && speed->valuedouble <= 10))
            return ll_field_error(LL_BAD_INPUT, "speed", "speed: must be a number from 0.1 to 10.");
        create->speed = speed->valuedouble;
    }
    return ll_ok();
}

/* ---- answer 201 ---- */

static void answer_created(ll_http_response *response, const char *text, const char *id)
{
    ll_http_text(response, 201, text);
    char location[128];
    snprintf(location, sizeof location, "/api/v1/sessions/%s", id);
    ll_http_set_header(response, "Location", location);
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* The session that an earlier answer reports; NULL: it is gone. The caller releases it. */
static ll_session_entry *find_created(const ll_api *api, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    const char *id = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "id"));
    ll_session_entry *session_entry = id ? ll_host_find(api->host, id) : NULL;
    cJSON_Delete(json);
    return session_entry;
}

bool ll_api_make_session(ll_api *api, const ll_http_request *request, ll_http_response *response,
                         const ll_create_request *create, ll_created_session *created)
{
    if (atomic_load(&api->phase) == LL_API_DRAINING) {
        ll_status stopping = ll_error(LL_LIMIT, "The daemon is stopping.");
        ll_http_problem_later(response, request, 503, 10, &stopping);
        return false;
    }
    if (!ll_api_started(api, request, response))
        return false;
    ll_status status = ll_host_create_session(api->host, create, created);
    if (!ll_failed(&status))
        return true;
    if (created->full) /* the limit of the daemon; that of the client is a rate limit */
        ll_http_problem_later(response, request, 503, 60, &status);
    else
        ll_api_problem(response, request, &status);
    return false;
}

static cJSON *describe_created(const ll_created_session *created)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", ll_session_entry_id(created->session_entry));
    cJSON_AddStringToObject(json, "code", ll_session_entry_code(created->session_entry));
    cJSON_AddStringToObject(json, "owner_key", created->owner_key);
    cJSON *keys = cJSON_AddArrayToObject(json, "player_keys");
    for (int i = 0; i < created->players; i++)
        cJSON_AddItemToArray(keys, cJSON_CreateString(created->player_keys[i]));
    cJSON_AddStringToObject(json, "status", ll_session_status_names[created->status]);
    cJSON_AddNumberToObject(json, "tick", (double)created->tick);
    ll_api_links(json, ll_session_entry_id(created->session_entry));
    return json;
}

/* The answer as text, for a repeated request; NULL: an error was answered. */
static char *answer_session(ll_http_response *response, const ll_created_session *created)
{
    cJSON *json = describe_created(created);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    if (text)
        answer_created(response, text, ll_session_entry_id(created->session_entry));
    ll_session_entry_release(created->session_entry);
    return text;
}

bool ll_api_create_session(ll_api *api, const ll_http_request *request, ll_http_response *response,
                           const cJSON *body, const ll_create_request *base, ll_created_session *created)
{
    static const char *const names[] = {"scenario", "set", "seed", "workload", "paused", "speed", NULL};
    cJSON *scenario = NULL;
    ll_workload *workload = NULL;
    ll_create_request create = *base;
    create.peer = request->peer;
    create.task = request->task;
    ll_status status = ll_api_only(body, names);
    LL_THEN(status, read_options(body, &create));
    LL_THEN(status, read_scenario(api, body, &scenario));
    if (!ll_failed(&status) && cJSON_HasObjectItem(body, "workload"))
        status = ll_workload_parse(cJSON_GetObjectItemCaseSensitive(body, "workload"), &workload);
    create.scenario = scenario;
    create.workload = workload;
    bool made = ll_api_good(response, request, &status) &&
                ll_api_make_session(api, request, response, &create, created);
    ll_workload_free(workload);
    cJSON_Delete(scenario);
    return made;
}

static char *create_new(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    ll_created_session created;
    ll_create_request base = {.seed = -1, .class_key = ll_api_class_key(api, request)};
    bool allowed = ll_api_rate(api, request, response, base.class_key, NULL);
    cJSON *body = allowed ? ll_api_body(request, response) : NULL;
    bool made = body && ll_api_create_session(api, request, response, body, &base, &created);
    cJSON_Delete(body);
    return made ? answer_session(response, &created) : NULL;
}

static void refuse_repeat(ll_api_repeat repeat, const ll_http_request *request, ll_http_response *response)
{
    ll_status busy = ll_field_error(LL_CONFLICT, "Idempotency-Key",
                                    "First request with this Idempotency-Key still in progress."),
              other = ll_field_error(LL_CONFLICT, "Idempotency-Key",
                                     "Idempotency-Key was used with another body.");
    if (repeat == LL_REPEAT_BUSY)
        ll_http_problem(response, request, &busy);
    else
        ll_http_problem_as(response, request, 422, &other);
}

/* False: what the request had made is gone and forgotten; to be called again. */
static bool answer_once(ll_api *api, const ll_http_request *request, ll_http_response *response,
                        const char *key)
{
    uint64_t number;
    char *text = NULL;
    ll_api_repeat repeat =
        ll_api_idempotency_begin(api->idempotency, request, ll_api_find_key(request), key, &number, &text);
    ll_session_entry *before = text ? find_created(api, text) : NULL;
    bool gone = text && !before;
    if (gone) {
        ll_api_idempotency_end(api->idempotency, number, NULL);
    } else if (repeat == LL_REPEAT_FIRST) {
        text = create_new(api, request, response);
        ll_api_idempotency_end(api->idempotency, number, text);
    } else if (repeat != LL_REPEAT_SAME) {
        refuse_repeat(repeat, request, response);
    } else if (text) {
        answer_created(response, text, ll_session_entry_id(before));
    } else {
        response->failed = true; /* no memory for the text */
    }
    ll_session_entry_release(before);
    free(text);
    return !gone;
}

void ll_post_sessions(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_may_create(api, request, response))
        return;
    const char *key = ll_http_header(request, "Idempotency-Key");
    if (!key || !*key) {
        free(create_new(api, request, response));
        return;
    }
    while (!answer_once(api, request, response, key)) {
    }
}

void ll_post_fork(void *context, const ll_http_request *request, ll_http_response *response)
{
    static const char *const names[] = {"paused", "speed", NULL};
    ll_api *api = context;
    ll_session_entry *origin = ll_api_session(api, request, response);
    if (!origin)
        return;
    if (!ll_api_may_create(api, request, response) ||
        !ll_api_rate(api, request, response, ll_api_class_key(api, request), origin)) {
        ll_session_entry_release(origin);
        return;
    }
    cJSON *body = ll_api_optional_body(request, response);
    if (body) {
        ll_create_request create = {.origin = origin,
                                    .seed = -1,
                                    .paused = true,
                                    .peer = request->peer,
                                    .class_key = ll_api_class_key(api, request),
                                    .task = request->task};
        ll_created_session created;
        ll_status status = ll_api_only(body, names);
        LL_THEN(status, read_options(body, &create));
        if (ll_api_good(response, request, &status) &&
            ll_api_make_session(api, request, response, &create, &created))
            free(answer_session(response, &created));
        cJSON_Delete(body);
    }
    ll_session_entry_release(origin);
}

/* ---- one session ---- */

static cJSON *describe_error(const ll_session *session)
{
    const ll_status *error = ll_session_error(session);
    if (!error || !ll_failed(error))
        return cJSON_CreateNull();
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "field", error->field);
    cJSON_AddStringToObject(json, "detail", error->text);
    return json;
}

static cJSON *describe(ll_session *session, const ll_session_entry *session_entry, bool parked)
{
    ll_session_info info = ll_session_get_info(session);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", ll_session_entry_id(session_entry));
    cJSON_AddStringToObject(json, "code", ll_session_entry_code(session_entry));
    cJSON_AddStringToObject(json, "title", info.title ? info.title : "");
    cJSON_AddStringToObject(json, "kind", info.kind);
    cJSON_AddStringToObject(json, "status", ll_session_status_names[info.status]);
    cJSON_AddBoolToObject(json, "parked", parked);
    cJSON_AddNumberToObject(json, "tick", (double)info.tick);
    cJSON_AddNumberToObject(json, "time_s", (double)info.time / 1e9);
    cJSON_AddNumberToObject(json, "head_tick", (double)info.head_tick);
    cJSON_AddNumberToObject(json, "log_end_s", (double)info.head / 1e9);
    cJSON_AddNumberToObject(json, "duration_s", (double)info.duration / 1e9);
    cJSON_AddNumberToObject(json, "tick_hz", (double)info.tick_freq / 1e3);
    cJSON_AddNumberToObject(json, "speed", info.speed);
    cJSON_AddItemToObject(json, "seed", ll_param_number((double)info.seed));
    cJSON_AddNumberToObject(json, "params_version", info.params_version);
    cJSON_AddNumberToObject(json, "generation", info.generation);
    cJSON_AddNumberToObject(json, "viewers", ll_session_entry_viewers(session_entry));
    cJSON_AddNumberToObject(json, "timeline_skipped", info.timeline_skipped);
    cJSON_AddItemToObject(json, "params", ll_session_params(session));
    cJSON_AddItemToObject(json, "cost", ll_session_cost(session));
    cJSON_AddItemToObject(json, "error", describe_error(session));
    cJSON_AddItemToObject(json, "notices", ll_session_notices(session));
    ll_api_links(json, ll_session_entry_id(session_entry));
    return json;
}

void ll_get_session(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_session_entry *session_entry = ll_api_session(context, request, response);
    if (!session_entry)
        return;
    ll_session *session;
    bool parked;
    ll_status status = ll_session_entry_enter(session_entry, request->task, &session, &parked);
    if (ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else {
        cJSON *json = describe(session, session_entry, parked);
        ll_session_entry_leave(session_entry);
        ll_http_json(response, 200, json);
    }
    ll_session_entry_release(session_entry);
}

void ll_delete_session(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_session_entry *session_entry = ll_api_session(api, request, response);
    if (!session_entry)
        return;
    if (ll_api_permits(request, response, session_entry, -1)) {
        ll_status status = ll_host_delete(api->host, session_entry, request->task);
        if (ll_api_good(response, request, &status))
            response->status = 204;
    }
    ll_session_entry_release(session_entry);
}

void ll_get_code(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response))
        return;
    bool allowed = ll_host_allows_lookup(api->host, request->peer);
    ll_session_entry *session_entry = allowed ? ll_host_find_code(api->host, request->parameter[0]) : NULL;
    if (!session_entry) {
        ll_status status = allowed ? ll_error(LL_NOT_FOUND, "Code not found.")
                                   : ll_error(LL_LIMIT, "Too many codes looked up from this address.");
        ll_api_problem(response, request, &status);
        return;
    }
    const char *id = ll_session_entry_id(session_entry);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", id);
    ll_api_links(json, id);
    ll_http_json(response, 200, json);
    ll_session_entry_release(session_entry);
}

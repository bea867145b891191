#include "daemon/api/api.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <cjson/cJSON.h>

#include "daemon/support/tasks.h"
#include "session/scenario.h"

bool ll_api_started(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (atomic_load(&api->phase) != LL_API_STARTING)
        return true;
    ll_status error = ll_error(LL_LIMIT, "The daemon is starting.");
    ll_http_problem_later(response, request, 503, 1, &error);
    return false;
}

ll_session_entry *ll_api_session(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    if (!ll_api_started(api, request, response))
        return NULL;
    ll_session_entry *session_entry = ll_host_find(api->host, request->parameter[0]);
    ll_status none = ll_error(LL_NOT_FOUND, "Session not found.");
    if (!session_entry)
        ll_api_problem(response, request, &none);
    return session_entry;
}

const char *ll_api_find_key(const ll_http_request *request)
{
    const char *header = ll_http_header(request, "Authorization");
    if (!header || strncasecmp(header, "Bearer", 6) != 0 || (header[6] != ' ' && header[6] != '\0'))
        return NULL;
    return header + 6 + strspn(header + 6, " ");
}

const char *ll_api_key(const ll_http_request *request, ll_http_response *response, const char *whose)
{
    const char *key = ll_api_find_key(request);
    if (key)
        return key;
    ll_status error = ll_error(LL_FORBIDDEN, "Authorization: must be `Bearer KEY` with %s.", whose);
    ll_http_problem_as(response, request, 401, &error);
    ll_http_set_header(response, "WWW-Authenticate", "Bearer realm=\"laglab\"");
    return NULL;
}

bool ll_api_permits(const ll_http_request *request, ll_http_response *response,
                    const ll_session_entry *session_entry, int player)
{
    const char *key = ll_api_key(
        request, response, player < 0 ? "the session's owner_key" : "the owner_key or the player's key");
    if (!key)
        return false;
    int role = ll_session_entry_role(session_entry, key, strlen(key));
    if (role == LL_ROLE_OWNER || (player >= 0 && role == player))
        return true;
    ll_status error =
        ll_error(LL_FORBIDDEN, role == LL_ROLE_NONE ? "Key of another session." : "Key of another player.");
    ll_http_problem(response, request, &error);
    return false;
}

bool ll_api_rate(ll_api *api, const ll_http_request *request, ll_http_response *response,
                 ll_class_key *class_key, const ll_session_entry *origin)
{
    ll_status status = ll_host_check_rate(api->host, request->peer, class_key, NULL, origin);
    return ll_api_good(response, request, &status);
}

bool ll_api_class_rate(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       const ll_class_entry *entry, const ll_session_entry *origin)
{
    ll_host_class one = ll_class_entry_of_host(entry);
    ll_status status =
        ll_host_check_rate(api->host, request->peer, ll_class_entry_class_key(entry), &one, origin);
    return ll_api_good(response, request, &status);
}

ll_status ll_api_query_flag(const ll_http_request *request, const char *name, bool *flag)
{
    const char *text = ll_http_query(request, name);
    *flag = text && strcmp(text, "true") == 0;
    return !text || *flag || strcmp(text, "false") == 0
               ? ll_ok()
               : ll_field_error(LL_BAD_INPUT, name, "%s: must be true or false; got `%.40s`.", name, text);
}

cJSON *ll_api_body(const ll_http_request *request, ll_http_response *response)
{
    cJSON *json = NULL;
    ll_status status = ll_json_parse(request->body, request->body_size, &json);
    if (!ll_failed(&status) && !cJSON_IsObject(json)) {
        cJSON_Delete(json);
        json = NULL;
        status = ll_error(LL_BAD_INPUT, "body: must be a JSON object");
    }
    if (ll_failed(&status)) {
        ll_http_problem(response, request, &status);
        return NULL;
    }
    return json;
}

cJSON *ll_api_optional_body(const ll_http_request *request, ll_http_response *response)
{
    return request->body_size > 0 ? ll_api_body(request, response) : cJSON_CreateObject();
}

bool ll_api_good(ll_http_response *response, const ll_http_request *request, const ll_status *status)
{
    if (ll_failed(status))
        ll_api_problem(response, request, status);
    return !ll_failed(status);
}

void ll_api_problem(ll_http_response *response, const ll_http_request *request, const ll_status *error)
{
    if (error->code == LL_INTERRUPTED && ll_http_become_task(request, response))
        return;
    ll_status answered = error->code == LL_INTERRUPTED ? ll_task_error(request->task, error->text) : *error;
    error = &answered;
    if (error->code == LL_LIMIT)
        ll_http_problem_later(response, request, 429, 1, error);
    else if (error->code == LL_IO)
        ll_http_problem_as(response, request, 507, error);
    else if (error->code == LL_UNAVAILABLE)
        ll_http_problem_later(response, request, 503, 1, error);
    else
        ll_http_problem(response, request, error);
}

void ll_api_result(ll_http_response *response, const ll_http_request *request, const ll_status *status,
                   cJSON *json)
{
    if (ll_api_good(response, request, status))
        ll_http_json(response, 200, json);
    else
        cJSON_Delete(json);
}

ll_status ll_api_only(const cJSON *object, const char *const *names)
{
    char known[200] = "";
    const cJSON *member;
    cJSON_ArrayForEach(member, object)
    {
        const char *const *name = names;
        while (*name && strcmp(*name, member->string) != 0)
            name++;
        if (*name)
            continue;
        for (name = names; *name; name++)
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", name == names ? "" : ", ",
                     *name);
        return ll_field_error(LL_BAD_INPUT, member->string, "%.60s: unknown; must be one of %s.",
                              member->string, known);
    }
    return ll_ok();
}

void ll_api_links(cJSON *json, const char *id)
{
    static const char *const parts[] = {"stream",  "params", "control", "input", "state",
                                        "metrics", "trace",  "packets", "log",   "fork"};
    char path[160];
    cJSON *links = cJSON_AddObjectToObject(json, "links");
    snprintf(path, sizeof path, "/api/v1/sessions/%s", id);
    cJSON_AddStringToObject(links, "self", path);
    snprintf(path, sizeof path, "/#s=%s", id);
    cJSON_AddStringToObject(links, "page", path);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        snprintf(path, sizeof path, "/api/v1/sessions/%s/%s", id, parts[i]);
        cJSON_AddStringToObject(links, parts[i], path);
    }
}

void ll_api_begun(ll_http_response *response, const char *path, const char *id, const char *key)
{
    char self[160];
    snprintf(self, sizeof self, "%s%s", path, id);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", id);
    if (*key)
        cJSON_AddStringToObject(json, "owner_key", key);
    cJSON_AddStringToObject(cJSON_AddObjectToObject(json, "links"), "self", self);
    ll_http_json(response, *key ? 202 : 200, json);
    if (!*key)
        return;
    ll_http_set_header(response, "Location", self);
    ll_http_set_header(response, "Retry-After", "1");
}

#include "daemon/api/api.h"

#include <stdio.h>

#include <cjson/cJSON.h>

static void answer_begun(const char *path, const char *id, const char *key, ll_http_response *response)
{
    char self[160];
    snprintf(self, sizeof self, "%s%s", path, id);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", id);
    cJSON_AddStringToObject(json, "owner_key", key);
    cJSON *links = cJSON_AddObjectToObject(json, "links");
    cJSON_AddStringToObject(links, "self", self);
    ll_http_json(response, 202, json);
    ll_http_set_header(response, "Location", self);
    ll_http_set_header(response, "Retry-After", "1");
}

void ll_api_job_start(ll_api *api, const ll_http_request *request, ll_http_response *response,
                      ll_job_spec *spec, const char *path)
{
    char id[LL_ID_LENGTH + 1], key[LL_KEY_LENGTH + 1];
    spec->client = request->peer;
    ll_status status = ll_jobs_add(api->jobs, spec, id, key);
    if (ll_api_good(response, request, &status))
        answer_begun(path, id, key, response);
}

void ll_api_job_get(ll_api *api, const ll_http_request *request, ll_http_response *response, ll_job_kind kind)
{
    if (!ll_api_started(api, request, response))
        return;
    cJSON *json = cJSON_CreateObject();
    ll_status status = ll_jobs_describe(api->jobs, kind, request->parameter[0], json);
    ll_api_result(response, request, &status, json);
}

void ll_api_job_delete(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       ll_job_kind kind, const char *whose)
{
    if (!ll_api_started(api, request, response))
        return;
    const char *key = ll_api_key(request, response, whose);
    if (!key)
        return;
    ll_status status =
        ll_jobs_remove(api->jobs, kind, request->parameter[0], ll_api_is_operator(api, key) ? NULL : key);
    if (ll_api_good(response, request, &status))
        response->status = 204;
}

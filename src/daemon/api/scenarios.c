/* The scenario library, the schema, and the documents of this API. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/http/http_problem.h"
#include "experiment/spec/experiment.h"
#include "library/library.h"
#include "session/records.h"
#include "session/scenario.h"

/* Reads `brief`, whether texts are left out; absent: no. False: it is neither true nor false, and refused. */
static bool read_brief(const ll_http_request *request, ll_http_response *response, bool *brief)
{
    ll_status status = ll_api_query_flag(request, "brief", brief);
    if (ll_failed(&status))
        ll_http_problem(response, request, &status);
    return !ll_failed(&status);
}

void ll_get_scenarios(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    cJSON *list = NULL;
    bool brief;
    if (!read_brief(request, response, &brief))
        return;
    ll_status status = ll_scenario_list(api->scenarios, &list);
    if (ll_failed(&status)) {
        ll_http_problem_as(response, request, 503, &status);
        return;
    }
    cJSON *json = cJSON_CreateObject(), *item;
    if (brief)
        cJSON_ArrayForEach(item, list) cJSON_DeleteItemFromObjectCaseSensitive(item, "text");
    cJSON_AddItemToObject(json, "scenarios", list);
    ll_http_json(response, 200, json);
}

void ll_get_scenario(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    cJSON *json = NULL;
    ll_status status = ll_scenario_load(api->scenarios, request->parameter[0], &json);
    if (ll_failed(&status)) {
        if (status.code == LL_BAD_INPUT) /* an id with other characters cannot exist */
            status.code = LL_NOT_FOUND;
        ll_http_problem(response, request, &status);
        return;
    }
    ll_http_json(response, 200, json);
}

/* Leaves out the descriptions below `node`: more than half of a schema. A value may have that name too. */
static void drop_descriptions(cJSON *node)
{
    cJSON *at = node->child;
    while (at) {
        cJSON *next = at->next;
        if (cJSON_IsString(at) && at->string && strcmp(at->string, "description") == 0)
            cJSON_Delete(cJSON_DetachItemViaPointer(node, at));
        else
            drop_descriptions(at);
        at = next;
    }
}

static void send_schema(ll_http_response *response, cJSON *json)
{
    ll_http_json(response, 200, json);
    snprintf(response->type, sizeof response->type, "application/schema+json");
}

void ll_get_schema(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    bool brief;
    if (!read_brief(request, response, &brief))
        return;
    cJSON *json = NULL;
    ll_status status = ll_scenario_schema(ll_http_query(request, "kind"), &json);
    if (ll_failed(&status)) {
        ll_http_problem(response, request, &status);
        return;
    }
    if (brief)
        drop_descriptions(json);
    send_schema(response, json);
}

void ll_get_experiment_schema(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    send_schema(response, ll_experiment_schema());
}

void ll_get_stream_schema(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    ll_http_json(response, 200, ll_stream_schema());
}

void ll_get_metric_tables(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    ll_http_json(response, 200, ll_metrics_of_kinds());
}

void ll_get_experiment_library(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    cJSON *list = NULL;
    ll_status status = ll_scenario_list_experiments(api->scenarios, &list);
    if (ll_failed(&status)) {
        ll_http_problem_as(response, request, 503, &status);
        return;
    }
    cJSON *json = cJSON_CreateObject();
    cJSON_AddItemToObject(json, "experiments", list);
    ll_http_json(response, 200, json);
}

static void send_document(const ll_api *api, const char *name, const ll_http_request *request,
                          ll_http_response *response)
{
    char path[600], piece[8192];
    snprintf(path, sizeof path, "%s/%s", api->documents, name);
    FILE *file = fopen(path, "rbe");
    if (!file) {
        ll_status error = ll_error(LL_NOT_FOUND, "%s is not installed: %s.", name, strerror(errno));
        ll_http_problem(response, request, &error);
        return;
    }
    size_t got;
    while ((got = fread(piece, 1, sizeof piece, file)) > 0)
        ll_http_append(response, piece, got);
    fclose(file);
    snprintf(response->type, sizeof response->type, "application/yaml");
}

void ll_get_openapi(void *context, const ll_http_request *request, ll_http_response *response)
{
    send_document(context, "openapi.yaml", request, response);
}

void ll_get_asyncapi(void *context, const ll_http_request *request, ll_http_response *response)
{
    send_document(context, "asyncapi.yaml", request, response);
}

void ll_get_schemas(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    send_schema(response, ll_schemas());
}

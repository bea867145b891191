/* The scenario library, the schema, and the documents of this API: constant documents, which are made at the
 * start. A single scenario is read from its file. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/support/log.h"
#include "experiment/spec/experiment.h"
#include "library/library.h"
#include "session/records.h"
#include "session/scenario.h"

#define V1 "/api/v1"
#define JSON "application/json"
#define SCHEMA "application/schema+json"

/* ---- at the start ---- */

static ll_status add(ll_documents *documents, const char *address, const char *type, const cJSON *json)
{
    char *text = json ? cJSON_PrintUnformatted(json) : NULL;
    return ll_documents_add(documents, address, type, text, text ? strlen(text) : 0);
}

/* The same of JSON that it takes. */
static ll_status add_made(ll_documents *documents, const char *address, const char *type, cJSON *json)
{
    ll_status status = add(documents, address, type, json);
    cJSON_Delete(json);
    return status;
}

/* Leaves out the members of that name below `node`, if they are texts: a value may have that name too. */
static void drop(cJSON *node, const char *name)
{
    cJSON *at = node ? node->child : NULL;
    while (at) {
        cJSON *next = at->next;
        if (cJSON_IsString(at) && at->string && strcmp(at->string, name) == 0)
            cJSON_Delete(cJSON_DetachItemViaPointer(node, at));
        else
            drop(at, name);
        at = next;
    }
}

/* The address of a variant: queries are in the order of the alphabet. */
static const char *variant(const char *path, bool brief, const char *kind, char address[160])
{
    snprintf(address, 160, "%s%s%s%s%s", path, brief ? "?brief=true" : "",
             !kind   ? ""
             : brief ? "&"
                     : "?",
             kind ? "kind=" : "", kind ? kind : "");
    return address;
}

/* Whole, and without the members `dropped`: for a schema more than half. Takes `json`. */
static ll_status add_both(ll_documents *documents, const char *path, const char *kind, const char *type,
                          const char *dropped, cJSON *json)
{
    char address[160];
    ll_status status = add(documents, variant(path, false, kind, address), type, json);
    drop(json, dropped);
    LL_THEN(status, add(documents, variant(path, true, kind, address), type, json));
    cJSON_Delete(json);
    return status;
}

static ll_status add_schema(ll_documents *documents, const char *kind)
{
    cJSON *json = NULL;
    LL_TRY(ll_scenario_schema(kind, &json));
    return add_both(documents, V1 "/schema", kind, SCHEMA, "description", json);
}

static ll_status add_lists(ll_documents *documents, const char *folder)
{
    cJSON *scenarios = NULL, *experiments = NULL, *json = cJSON_CreateObject();
    ll_status status = ll_scenario_list(folder, &scenarios);
    LL_THEN(status, ll_scenario_list_experiments(folder, &experiments));
    cJSON_AddItemToObject(json, "scenarios", scenarios);
    if (ll_failed(&status)) {
        cJSON_Delete(json);
        return ll_error(LL_NOT_FOUND, "%s", status.text);
    }
    status = add_both(documents, V1 "/scenarios", NULL, JSON, "text", json);
    json = cJSON_CreateObject();
    cJSON_AddItemToObject(json, "experiments", experiments);
    LL_THEN(status, add(documents, V1 "/experiments/library", JSON, json));
    cJSON_Delete(json);
    return status;
}

/* A folder that is not installed is missing to those alone who ask for what is in it. */
static ll_status unless_missing(ll_status status)
{
    if (status.code != LL_NOT_FOUND)
        return status;
    ll_log_write("warn", "not installed", "%s", status.text);
    return ll_ok();
}

static ll_status add_file(ll_documents *documents, const char *folder, const char *name)
{
    char address[64], path[600];
    snprintf(address, sizeof address, V1 "/%s", name);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return unless_missing(ll_documents_add_file(documents, address, path));
}

ll_status ll_api_describe(ll_api *api, const char *www)
{
    ll_documents *documents = &api->documents;
    const char *folder = ll_host_get_config(api->host)->api;
    LL_TRY(add_schema(documents, NULL));
    for (int i = 0; ll_sim_kinds[i]; i++)
        LL_TRY(add_schema(documents, ll_sim_kinds[i]->name));
    LL_TRY(add_made(documents, V1 "/schemas.json", SCHEMA, ll_schemas()));
    LL_TRY(add_made(documents, V1 "/experiments/schema", SCHEMA, ll_experiment_schema()));
    LL_TRY(add_made(documents, V1 "/stream/schema.json", JSON, ll_stream_schema()));
    LL_TRY(add_made(documents, V1 "/metrics", JSON, ll_metrics_of_kinds()));
    LL_TRY(unless_missing(add_lists(documents, api->scenarios)));
    LL_TRY(add_file(documents, folder, "openapi.yaml"));
    LL_TRY(add_file(documents, folder, "asyncapi.yaml"));
    LL_TRY(unless_missing(ll_documents_read(documents, www)));
    return ll_documents_finish(documents);
}

/* ---- answers ---- */

static void answer(const ll_api *api, const char *address, const ll_http_request *request,
                   ll_http_response *response)
{
    response->document = ll_documents_find(&api->documents, address);
    if (response->document)
        return;
    ll_status error = ll_error(LL_NOT_FOUND, "%s is not installed.", address);
    ll_http_problem(response, request, &error);
}

void ll_get_document(void *context, const ll_http_request *request, ll_http_response *response)
{
    answer(context, request->path, request, response);
}

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
    char address[160];
    bool brief;
    if (read_brief(request, response, &brief))
        answer(context, variant(V1 "/scenarios", brief, NULL, address), request, response);
}

void ll_get_schema(void *context, const ll_http_request *request, ll_http_response *response)
{
    const ll_api *api = context;
    char address[160];
    bool brief;
    const char *kind = ll_http_query(request, "kind");
    if (!read_brief(request, response, &brief))
        return;
    response->document = ll_documents_find(&api->documents, variant(V1 "/schema", brief, kind, address));
    if (response->document)
        return;
    cJSON *none = NULL;
    ll_status status = ll_scenario_schema(kind, &none); /* which says the kinds that there are */
    ll_http_problem(response, request, &status);
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

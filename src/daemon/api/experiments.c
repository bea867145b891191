/* Experiments: creating, watching, pausing. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/hosting/quota.h"
#include "daemon/jobs/experiments.h"
#include "daemon/support/tasks.h"
#include "threads/clock.h"

#define PATH "/api/v1/experiments/"

/* ---- creating ---- */

static void describe_size(cJSON *json, const ll_experiment *e)
{
    cJSON_AddNumberToObject(json, "points", (double)e->points);
    cJSON_AddNumberToObject(json, "repeats", (double)e->head.repeats);
    cJSON_AddNumberToObject(json, "runs", (double)e->runs);
    cJSON_AddItemToObject(json, "notices", ll_experiment_notices(e));
}

static void add_links(cJSON *json, const char *id)
{
    static const char *const parts[] = {"results", "report", "control", "stream"};
    char path[160];
    cJSON *links = cJSON_AddObjectToObject(json, "links");
    snprintf(path, sizeof path, PATH "%s", id);
    cJSON_AddStringToObject(links, "self", path);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        snprintf(path, sizeof path, PATH "%s/%s", id, parts[i]);
        cJSON_AddStringToObject(links, parts[i], path);
    }
}

ll_status ll_api_run_size(const ll_api *api, const ll_experiment *e, int64_t run)
{
    ll_scenario scenario = {0};
    ll_status status = ll_experiment_open(e, run, &scenario);
    LL_THEN(status, ll_quota_check_state(ll_host_get_config(api->host), &scenario));
    ll_scenario_free(&scenario);
    return status;
}

/* Runs the first run, to measure the cost of a run. */
static ll_status answer_dry_run(const ll_api *api, const ll_experiment *e, const ll_interrupt *interrupt,
                                ll_http_response *response)
{
    ll_row row;
    LL_TRY(ll_api_run_size(api, e, 0));
    int64_t from = ll_thread_cpu_ns();
    ll_status status = ll_experiment_run(e, 0, interrupt, NULL, &row);
    double run_s = (double)(ll_thread_cpu_ns() - from) * 1e-9;
    if (ll_failed(&status))
        return status;
    cJSON *json = cJSON_CreateObject();
    describe_size(json, e);
    cJSON_AddNumberToObject(json, "run_s", run_s);
    cJSON_AddNumberToObject(json, "estimated_cpu_s", run_s * (double)e->runs);
    ll_http_json(response, 200, json);
    return status;
}

static ll_status answer_created(ll_api *api, const ll_experiment *e, const ll_http_request *request,
                                ll_http_response *response)
{
    char id[LL_ID_LENGTH + 1], key[LL_KEY_LENGTH + 1], location[80];
    LL_TRY(ll_experiments_add(api->experiments, e, request->peer, ll_api_class_key(api, request), id, key));
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", id);
    cJSON_AddStringToObject(json, "owner_key", key);
    describe_size(json, e);
    add_links(json, id);
    ll_http_json(response, 202, json);
    snprintf(location, sizeof location, PATH "%s", id);
    ll_http_set_header(response, "Location", location);
    return ll_ok();
}

void ll_post_experiments(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment *e = NULL;
    if (!ll_api_started(api, request, response) || !ll_api_may_create(api, request, response) ||
        !ll_api_rate(api, request, response, ll_api_class_key(api, request), NULL))
        return;
    cJSON *body = ll_api_body(request, response);
    if (!body)
        return;
    bool dry_only = false;
    ll_interrupt interrupt = ll_task_interrupt(request->task);
    ll_status status = ll_api_query_flag(request, "dry_run", &dry_only);
    LL_THEN(status, ll_experiment_parse(body, api->scenarios, &interrupt, &e));
    LL_THEN(status, dry_only ? answer_dry_run(api, e, &interrupt, response)
                             : answer_created(api, e, request, response));
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    ll_experiment_free(e);
    cJSON_Delete(body);
}

/* ---- one experiment ---- */

bool ll_api_experiment(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       ll_experiment_record *record, ll_experiment **experiment)
{
    if (!ll_api_started(api, request, response))
        return false;
    ll_interrupt interrupt = ll_task_interrupt(request->task);
    ll_status status = ll_experiments_find(api->experiments, request->parameter[0], record);
    if (experiment)
        LL_THEN(status, ll_experiments_read(api->experiments, record->id, &interrupt, experiment));
    return ll_api_good(response, request, &status);
}

static bool permitted(const ll_api *api, const ll_http_request *request, ll_http_response *response,
                      const ll_experiment_record *record)
{
    const char *key = ll_api_key(request, response, "the experiment's owner_key");
    if (!key)
        return false;
    if (ll_experiments_permits(record, key) || ll_api_is_operator(api, key))
        return true;
    ll_status error = ll_error(LL_FORBIDDEN, "Key of another experiment.");
    ll_http_problem(response, request, &error);
    return false;
}

static void add_version(const ll_experiment_record *r, cJSON *json)
{
    ll_status status = ll_result_store_check_version(r);
    cJSON_AddStringToObject(json, "version", r->version);
    if (ll_failed(&status))
        cJSON_AddStringToObject(json, "held_back", status.text);
    else
        cJSON_AddNullToObject(json, "held_back");
}

static void answer_record(ll_api *api, const ll_experiment_record *r, const ll_experiment *e,
                          ll_http_response *response)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", r->id);
    cJSON_AddStringToObject(json, "title", e->head.title);
    cJSON_AddNumberToObject(json, "points", (double)e->points);
    cJSON_AddNumberToObject(json, "repeats", (double)e->head.repeats);
    ll_experiments_describe(api->experiments, r, json);
    cJSON_AddNumberToObject(json, "created_s", (double)r->created_s);
    add_version(r, json);
    cJSON_AddItemToObject(json, "notices", ll_experiment_notices(e));
    cJSON_AddItemToObject(json, "experiment", cJSON_Duplicate(e->json, true));
    add_links(json, r->id);
    ll_http_json(response, 200, json);
}

void ll_get_experiment(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_experiment_record record;
    ll_experiment *e = NULL;
    if (ll_api_experiment(context, request, response, &record, &e))
        answer_record(context, &record, e, response);
    ll_experiment_free(e);
}

void ll_delete_experiment(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment_record record;
    if (!ll_api_experiment(api, request, response, &record, NULL) ||
        !permitted(api, request, response, &record))
        return;
    ll_status status = ll_experiments_remove(api->experiments, record.id);
    if (ll_api_good(response, request, &status))
        response->status = 204;
}

static ll_status read_op(const cJSON *body, ll_experiment_state *state)
{
    static const char *const names[] = {"op", NULL};
    static const struct {
        const char *name;
        ll_experiment_state state;
    } ops[] = {{"pause", LL_EXPERIMENT_PAUSED},
               {"resume", LL_EXPERIMENT_RUNNING},
               {"cancel", LL_EXPERIMENT_CANCELLED}};
    const cJSON *op = cJSON_GetObjectItemCaseSensitive(body, "op");
    LL_TRY(ll_api_only(body, names));
    for (size_t i = 0; i < sizeof ops / sizeof ops[0]; i++)
        if (cJSON_IsString(op) && strcmp(op->valuestring, ops[i].name) == 0) {
            *state = ops[i].state;
            return ll_ok();
        }
    return ll_field_error(LL_BAD_INPUT, "op", "op: must be one of pause, resume, cancel.");
}

void ll_post_experiment_control(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment_record record;
    ll_experiment *e = NULL;
    ll_experiment_state state = LL_EXPERIMENT_RUNNING;
    ll_interrupt interrupt = ll_task_interrupt(request->task);
    if (!ll_api_experiment(api, request, response, &record, NULL))
        return;
    cJSON *body = permitted(api, request, response, &record) ? ll_api_body(request, response) : NULL;
    if (body) {
        ll_status status = read_op(body, &state);
        LL_THEN(status, ll_experiments_set(api->experiments, &record, state));
        LL_THEN(status, ll_experiments_find(api->experiments, record.id, &record));
        LL_THEN(status, ll_experiments_read(api->experiments, record.id, &interrupt, &e));
        if (ll_api_good(response, request, &status))
            answer_record(api, &record, e, response);
    }
    cJSON_Delete(body);
    ll_experiment_free(e);
}

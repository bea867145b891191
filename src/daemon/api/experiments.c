/* Experiments: creating, watching, pausing, reading. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cjson/cJSON.h>

#include "base/hash.h"
#include "base/version.h"
#include "daemon/api/answer.h"
#include "daemon/api/api.h"
#include "daemon/hosting/quota.h"
#include "daemon/http/http_problem.h"
#include "daemon/jobs/experiments.h"
#include "daemon/support/tasks.h"
#include "experiment/format/compare.h"
#include "experiment/format/table.h"
#include "experiment/report/report.h"

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

static double thread_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Whether a run is small enough to be made for a request. */
static ll_status check_size(const ll_api *api, const ll_experiment *e, int64_t run)
{
    ll_scenario scenario = {0};
    ll_status status = ll_experiment_open(e, run, &scenario);
    LL_THEN(status, ll_quota_check_state(ll_host_get_config(api->host), &scenario));
    ll_scenario_free(&scenario);
    return status;
}

/* Runs the first run, to measure the cost of a run. */
static ll_status answer_dry_run(const ll_api *api, const ll_experiment *e, ll_task *task,
                                ll_http_response *response)
{
    ll_row row;
    ll_interrupt interrupt = ll_task_interrupt(task);
    LL_TRY(check_size(api, e, 0));
    double from = thread_seconds();
    ll_status status = ll_experiment_run(e, 0, &interrupt, NULL, &row);
    double run_s = thread_seconds() - from;
    if (ll_failed(&status))
        return status;
    cJSON *json = cJSON_CreateObject();
    describe_size(json, e);
    cJSON_AddNumberToObject(json, "run_s", run_s);
    cJSON_AddNumberToObject(json, "estimated_cpu_s", run_s * (double)e->runs);
    ll_http_json(response, 200, json);
    cJSON_Delete(json);
    return status;
}

static ll_status answer_created(ll_api *api, const ll_experiment *e, const char *client,
                                ll_http_response *response)
{
    char id[LL_ID_LENGTH + 1], key[LL_KEY_LENGTH + 1], location[80];
    LL_TRY(ll_experiments_add(api->experiments, e, client, id, key));
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", id);
    cJSON_AddStringToObject(json, "owner_key", key);
    describe_size(json, e);
    add_links(json, id);
    ll_http_json(response, 202, json);
    cJSON_Delete(json);
    snprintf(location, sizeof location, PATH "%s", id);
    ll_http_set_header(response, "Location", location);
    return ll_ok();
}

void ll_post_experiments(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment *e = NULL;
    if (!ll_api_started(api, request, response) || !ll_api_may_create(api, request, response))
        return;
    cJSON *body = ll_api_body(request, response);
    if (!body)
        return;
    const char *dry = ll_http_query(request, "dry_run");
    ll_status status = ll_experiment_parse(body, api->scenarios, &e);
    if (!ll_failed(&status) && dry && strcmp(dry, "true") != 0 && strcmp(dry, "false") != 0)
        status = ll_field_error(LL_BAD_INPUT, "dry_run", "dry_run: must be true or false; got `%.40s`.", dry);
    bool dry_only = dry && strcmp(dry, "true") == 0;
    if (!ll_failed(&status) && dry_only && !request->task) /* before it counts towards the limits */
        status = ll_error(LL_INTERRUPTED, "a dry run needs a task");
    if (!ll_failed(&status) && !ll_host_allows_creation(api->host, request->peer))
        status = ll_error(LL_LIMIT, "Too many sessions and experiments created from this address.");
    LL_THEN(status, dry_only ? answer_dry_run(api, e, request->task, response)
                             : answer_created(api, e, request->peer, response));
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    ll_experiment_free(e);
    cJSON_Delete(body);
}

/* ---- one experiment ---- */

/* False: not found, and answered. `experiment` may be NULL. */
static bool find(ll_api *api, const ll_http_request *request, ll_http_response *response,
                 ll_experiment_record *record, ll_experiment **experiment)
{
    if (!ll_api_started(api, request, response))
        return false;
    ll_status status = ll_experiments_find(api->experiments, request->parameter[0], record, experiment);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    return !ll_failed(&status);
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

static void add_version(ll_api *api, const ll_experiment_record *r, cJSON *json)
{
    ll_status status = ll_result_store_check_version(ll_experiments_store(api->experiments), r);
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
    add_version(api, r, json);
    cJSON_AddItemToObject(json, "notices", ll_experiment_notices(e));
    cJSON_AddItemToObject(json, "experiment", cJSON_Duplicate(e->json, true));
    add_links(json, r->id);
    ll_http_json(response, 200, json);
    cJSON_Delete(json);
}

void ll_get_experiment(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_experiment_record record;
    ll_experiment *e = NULL;
    if (find(context, request, response, &record, &e))
        answer_record(context, &record, e, response);
    ll_experiment_free(e);
}

void ll_delete_experiment(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment_record record;
    if (!find(api, request, response, &record, NULL) || !permitted(api, request, response, &record))
        return;
    ll_status status = ll_experiments_remove(api->experiments, record.id);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    else
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
    if (!find(api, request, response, &record, &e))
        return;
    cJSON *body = permitted(api, request, response, &record) ? ll_api_body(request, response) : NULL;
    if (body) {
        ll_status status = read_op(body, &state);
        LL_THEN(status, ll_experiments_set(api->experiments, &record, state));
        LL_THEN(status, ll_experiments_find(api->experiments, record.id, &record, NULL));
        if (ll_failed(&status))
            ll_api_problem(response, request, &status);
        else
            answer_record(api, &record, e, response);
    }
    cJSON_Delete(body);
    ll_experiment_free(e);
}

/* ---- answers as files ---- */

/* The tag is a hash of the present state of experiment `r` and of the request's options. */
static ll_answer answer_of(const ll_api *api, const ll_experiment_record *r, const char *type,
                           uint64_t results_query)
{
    uint64_t tag = ll_hash(results_query, r->id, strlen(r->id));
    tag = ll_hash(tag, r->version, strlen(r->version));
    tag = ll_hash(tag, ll_version, strlen(ll_version)); /* another version may format it differently */
    tag = ll_hash(tag, type, strlen(type));
    tag = ll_hash_u64(tag, (uint64_t)r->done);
    return (ll_answer){.type = type,
                       .folder = ll_host_get_config(api->host)->data,
                       .tag = ll_hash_u64(tag, (uint64_t)r->state),
                       .final = r->state == LL_EXPERIMENT_DONE || r->state == LL_EXPERIMENT_FAILED};
}

/* ---- one run ---- */

static ll_status read_run(const ll_http_request *request, const ll_experiment *e, int64_t *run)
{
    char *end;
    *run = strtoll(request->parameter[1], &end, 10);
    return *end || *run < 0 || *run >= e->runs
               ? ll_error(LL_NOT_FOUND, "run: must be 0 to %lld", (long long)e->runs - 1)
               : ll_ok();
}

/* The scenario of one run, as POST /sessions takes it, to view it live. */
void ll_get_experiment_run(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_experiment_record record;
    ll_experiment *e = NULL;
    ll_scenario scenario = {0};
    int64_t run;
    if (!find(context, request, response, &record, &e))
        return;
    ll_status status = read_run(request, e, &run);
    LL_THEN(status, ll_experiment_open(e, run, &scenario));
    if (ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else {
        cJSON *json = ll_param_write(scenario.kind->table, scenario.config);
        ll_http_json(response, 200, json);
        cJSON_Delete(json);
    }
    ll_scenario_free(&scenario);
    ll_experiment_free(e);
}

static void put(void *file, const char *text, size_t length)
{
    fwrite(text, 1, length, file);
}

/* The run is repeated, since no trace is stored. */
void ll_get_experiment_trace(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_experiment_record record;
    ll_experiment *e = NULL;
    int64_t run;
    if (!find(context, request, response, &record, &e))
        return;
    ll_answer answer = answer_of(context, &record, "text/csv; charset=utf-8", 0);
    ll_status status = read_run(request, e, &run);
    if (ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else {
        answer.tag = ll_hash_u64(
            ll_hash(ll_hash(3, record.id, strlen(record.id)), ll_version, strlen(ll_version)), (uint64_t)run);
        answer.final = true; /* a run depends only on the experiment and its number */
        ll_interrupt interrupt = ll_task_interrupt(request->task);
        if (!ll_answer_known(request, response, &answer)) {
            status = check_size(context, e, run);
            FILE *file = ll_failed(&status) ? NULL : ll_answer_open(&answer, &status);
            if (file)
                status = ll_experiment_trace(e, run, &interrupt, put, file);
            ll_answer_send(request, response, &answer, &status, file);
        }
    }
    ll_experiment_free(e);
}

/* ---- results ---- */

static void media_type(const ll_format *format, char type[80])
{
    snprintf(type, 80, "%.*s", (int)strcspn(format->type, ";"), format->type);
}

/* Chosen by the query's `format`, else by Accept. NULL: refused. */
static const ll_format *choose_format(const ll_http_request *request, ll_http_response *response)
{
    const char *name = ll_http_query(request, "format");
    const ll_format *best = name ? ll_format_find(name, strlen(name)) : NULL;
    double best_quality = 0, quality;
    char type[80];
    for (int i = 0; !name && ll_formats[i]; i++) {
        media_type(ll_formats[i], type);
        if (ll_http_accepts(request, type, &quality) && quality > best_quality) {
            best = ll_formats[i];
            best_quality = quality;
        }
    }
    if (best)
        return best;
    ll_status error =
        name ? ll_field_error(LL_BAD_INPUT, "format",
                              "format: must be one of csv, ndjson, json, parquet, sqlite; got `%.40s`.", name)
             : ll_error(LL_BAD_INPUT, "Accept: must allow text/csv, application/x-ndjson, application/json, "
                                      "application/vnd.apache.parquet or application/vnd.sqlite3.");
    ll_http_problem_as(response, request, name ? 400 : 406, &error);
    return NULL;
}

/* Rows of the store; checks from time to time whether the task may continue. */
typedef struct yielding_rows {
    ll_stored_rows rows;
    ll_task *task;
    int64_t given;
} yielding_rows;

enum { ASK_EVERY = 64 };

static bool next_row(void *context, ll_row *row, ll_status *status)
{
    yielding_rows *a = context;
    if (a->given++ % ASK_EVERY == 0 && !ll_task_yield(a->task)) {
        *status = ll_error(LL_INTERRUPTED, "interrupted after %lld rows", (long long)a->given - 1);
        return false;
    }
    return ll_stored_rows_next(&a->rows, row, status);
}

/* true or false; absent: false. */
static ll_status query_flag(const ll_http_request *request, const char *name, bool *flag)
{
    const char *text = ll_http_query(request, name);
    *flag = text && strcmp(text, "true") == 0;
    return !text || *flag || strcmp(text, "false") == 0
               ? ll_ok()
               : ll_field_error(LL_BAD_INPUT, name, "%s: must be true or false; got `%.40s`.", name, text);
}

/* What the query selects: runs, points, or points compared with one of them. */
typedef struct results_query {
    bool points, sensitivity;
    int64_t compare; /* a point; -1: none */
} results_query;

static ll_status read_results_query(const ll_http_request *request, const ll_experiment *e, results_query *w)
{
    const char *compare = ll_http_query(request, "compare");
    w->compare = -1;
    ll_status status = query_flag(request, "points", &w->points);
    LL_THEN(status, query_flag(request, "sensitivity", &w->sensitivity));
    if (!ll_failed(&status) && compare && w->points && !w->sensitivity)
        status = ll_compare_point(e, "compare", compare, &w->compare);
    return status;
}

static ll_status make_table(ll_api *api, const ll_experiment_record *record, const ll_experiment *e,
                            const results_query *w, yielding_rows *rows, ll_result_table **table)
{
    ll_row *baseline = NULL;
    int64_t count = 0;
    if (w->sensitivity)
        return ll_result_table_sensitivity(e, next_row, rows, table);
    if (!w->points)
        return ll_result_table_rows(e, record->version, next_row, rows, table);
    ll_status status = ll_ok();
    if (w->compare >= 0)
        status = ll_compare_rows(e, ll_experiments_store(api->experiments), record->id, w->compare, &baseline,
                                 &count);
    LL_THEN(status, ll_result_table_compared(e, baseline, count, next_row, rows, table));
    free(baseline);
    return status;
}

static ll_status write_table(ll_api *api, ll_task *task, const ll_experiment_record *record,
                             const ll_experiment *e, const results_query *w, const ll_format *format,
                             FILE *file)
{
    yielding_rows a = {.task = task};
    ll_result_table *table = NULL;
    ll_status status = ll_stored_rows_open(&a.rows, ll_experiments_store(api->experiments), record->id);
    LL_THEN(status, make_table(api, record, e, w, &a, &table));
    LL_THEN(status, format->write(ll_result_table_get(table), file));
    ll_result_table_free(table);
    ll_stored_rows_close(&a.rows);
    return status;
}

void ll_get_experiment_results(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment_record record;
    ll_experiment *e = NULL;
    results_query w;
    if (!find(api, request, response, &record, &e))
        return;
    const ll_format *format = choose_format(request, response);
    ll_status status = format ? read_results_query(request, e, &w) : ll_ok();
    if (ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else if (format) {
        uint64_t asked = ll_hash_u64(w.points + 2u * w.sensitivity, (uint64_t)w.compare);
        ll_answer answer = answer_of(api, &record, format->type, asked);
        answer.vary = "Accept";
        if (!ll_answer_known(request, response, &answer)) {
            FILE *file = ll_answer_open(&answer, &status);
            if (file)
                status = write_table(api, request->task, &record, e, &w, format, file);
            ll_answer_send(request, response, &answer, &status, file);
        }
    }
    ll_experiment_free(e);
}

void ll_get_experiment_report(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_experiment_record record;
    ll_experiment *e = NULL;
    yielding_rows a = {.task = request->task};
    if (!find(api, request, response, &record, &e))
        return;
    ll_answer answer = answer_of(api, &record, "text/html; charset=utf-8", 5);
    if (!ll_answer_known(request, response, &answer)) {
        ll_status status = ll_stored_rows_open(&a.rows, ll_experiments_store(api->experiments), record.id);
        FILE *file = ll_failed(&status) ? NULL : ll_answer_open(&answer, &status);
        if (file)
            status = ll_report_write(e, record.version, next_row, &a, file);
        ll_answer_send(request, response, &answer, &status, file);
        ll_stored_rows_close(&a.rows);
    }
    /* Its script runs in an origin of its own: it reaches neither keys nor the API. */
    ll_http_set_header(response, "Content-Security-Policy",
                       "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                       "frame-ancestors 'none'; "
                       "sandbox allow-scripts allow-popups allow-popups-to-escape-sandbox");
    ll_experiment_free(e);
}

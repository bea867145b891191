/* What is read of an experiment as a file: one run, results, report. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "base/hash.h"
#include "base/version.h"
#include "daemon/api/answer.h"
#include "daemon/api/api.h"
#include "daemon/jobs/experiments.h"
#include "daemon/support/tasks.h"
#include "experiment/format/compare.h"
#include "experiment/report/report.h"

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
                       .final = r->state == LL_EXPERIMENT_DONE};
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
    if (!ll_api_experiment(context, request, response, &record, &e))
        return;
    ll_status status = read_run(request, e, &run);
    LL_THEN(status, ll_experiment_open(e, run, &scenario));
    if (ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else {
        cJSON *json = ll_param_write(scenario.kind->table, scenario.config);
        ll_http_json(response, 200, json);
    }
    ll_scenario_free(&scenario);
    ll_experiment_free(e);
}

/* A table of one run, of the records or columns that the query names. */
typedef struct run_trace {
    ll_trace_request wanted;
    const ll_format *format;
    FILE *file;
} run_trace;

static void put(void *file, const char *text, size_t length)
{
    fwrite(text, 1, length, file);
}

static ll_status write_run(void *context, ll_session *copy, int64_t to)
{
    run_trace *t = context;
    ll_trace_table *table = NULL;
    t->wanted.to = to;
    if (!t->wanted.of && t->format == ll_formats[0])
        return ll_session_write_trace(copy, 0, to, t->wanted.interrupt, put, t->file);
    ll_status status = ll_trace_table_new(copy, &t->wanted, &table);
    LL_THEN(status, t->format->write(ll_trace_table_get(table), t->file));
    ll_trace_table_free(table);
    return status;
}

/* Of the query's `of` and of the format. */
static uint64_t trace_tag(const ll_experiment_record *record, int64_t run, const run_trace *t)
{
    uint64_t tag = ll_hash(ll_hash(3, record->id, strlen(record->id)), ll_version, strlen(ll_version));
    const char *of = t->wanted.of ? t->wanted.of : "";
    return ll_hash(ll_hash_u64(ll_hash(tag, of, strlen(of)), (uint64_t)run), t->format->name,
                   strlen(t->format->name));
}

/* The run is repeated, since no trace is stored. */
void ll_get_experiment_trace(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_experiment_record record;
    ll_experiment *e = NULL;
    int64_t run;
    if (!ll_api_experiment(context, request, response, &record, &e))
        return;
    ll_interrupt interrupt = ll_task_interrupt(request->task);
    run_trace t = {.wanted = ll_answer_trace(request, &interrupt),
                   .format = ll_answer_format(request, response)};
    ll_status status = read_run(request, e, &run);
    if (t.format && ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else if (t.format) {
        ll_answer answer = answer_of(context, &record, t.format->type, 0);
        answer.tag = trace_tag(&record, run, &t);
        answer.final = true; /* a run depends only on the experiment and its number */
        answer.vary = "Accept";
        if (!ll_answer_known(request, response, &answer)) {
            status = ll_api_run_size(context, e, run);
            t.file = ll_failed(&status) ? NULL : ll_answer_open(&answer, &status);
            if (t.file)
                status = ll_experiment_read_run(e, run, &interrupt, write_run, &t);
            ll_answer_send(request, response, &answer, &status, t.file);
        }
    }
    ll_experiment_free(e);
}

/* ---- results ---- */

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

/* What the query selects: runs, points, or points compared with one of them. */
typedef struct results_query {
    bool points, sensitivity;
    int64_t compare; /* a point; -1: none */
} results_query;

static ll_status read_results_query(const ll_http_request *request, const ll_experiment *e, results_query *w)
{
    const char *compare = ll_http_query(request, "compare");
    w->compare = -1;
    ll_status status = ll_api_query_flag(request, "points", &w->points);
    LL_THEN(status, ll_api_query_flag(request, "sensitivity", &w->sensitivity));
    if (!ll_failed(&status) && compare && w->points && !w->sensitivity)
        status = ll_compare_point(e, "compare", compare, &w->compare);
    return status;
}

static ll_status make_table(const ll_experiment_record *record, const ll_experiment *e,
                            const results_query *w, yielding_rows *rows, ll_result_table **table)
{
    ll_row *baseline = NULL;
    int64_t count = 0;
    if (w->sensitivity)
        return ll_result_table_sensitivity(e, next_row, rows, table);
    if (!w->points)
        return ll_result_table_rows(e, record->version, next_row, rows, table);
    ll_status status = ll_ok();
    if (w->compare >= 0) {
        ll_stored_rows_seek(&rows->rows, w->compare * e->head.repeats);
        status = ll_compare_rows(e, w->compare, next_row, rows, &baseline, &count);
        ll_stored_rows_seek(&rows->rows, 0);
    }
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
    LL_THEN(status, make_table(record, e, w, &a, &table));
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
    if (!ll_api_experiment(api, request, response, &record, &e))
        return;
    const ll_format *format = ll_answer_format(request, response);
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
    if (!ll_api_experiment(api, request, response, &record, &e))
        return;
    ll_answer answer = answer_of(api, &record, "text/html; charset=utf-8", 5);
    if (!ll_answer_known(request, response, &answer)) {
        ll_status status = ll_stored_rows_open(&a.rows, ll_experiments_store(api->experiments), record.id);
        FILE *file = ll_failed(&status) ? NULL : ll_answer_open(&answer, &status);
        if (file)
            status = ll_report_write(e, record.version, NULL, next_row, &a, file);
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

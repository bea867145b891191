/* The table of routes. The web server answers 404, 405, 413 and 415 from it; api/openapi.yaml describes each
 * row. */
#include <stdlib.h>
#include <string.h>

#include "daemon/api/api.h"
#include "daemon/api/idempotency.h"
#include "daemon/jobs/jobs.h"
#include "daemon/support/log.h"
#include "threads/clock.h"

#define JSON_TYPE "application/json"
#define PATCH_TYPES "application/merge-patch+json, application/json"
#define V1 "/api/v1"

enum { BODY = 1 }; /* placeholder for --max-body-bytes */

/* What may compute for more than a millisecond, with any body, is a task from its first byte. The others are
 * short with a body of at most HTTP_SHORT_BODY bytes; those that would be long in a rare case, as a seek, ask
 * for a task by ll_http_become_task. tests/lib/heavy.mjs has the heaviest request of each row. */
static const ll_http_route table[] = {
    {.method = "GET",
     .pattern = V1 "/scenarios",
     .handler = ll_get_scenarios,
     .query = "brief",
     .document = true},
    {.method = "GET", .pattern = V1 "/scenarios/{id*}", .handler = ll_get_scenario, .run_on = LL_HTTP_TASK},
    {.method = "GET",
     .pattern = V1 "/schema",
     .handler = ll_get_schema,
     .query = "kind,brief",
     .document = true},
    {.method = "GET", .pattern = V1 "/openapi.yaml", .handler = ll_get_document, .document = true},
    {.method = "GET", .pattern = V1 "/schemas.json", .handler = ll_get_document, .document = true},
    {.method = "GET", .pattern = V1 "/asyncapi.yaml", .handler = ll_get_document, .document = true},
    {.method = "GET", .pattern = V1 "/stream/schema.json", .handler = ll_get_document, .document = true},
    {.method = "GET", .pattern = V1 "/metrics", .handler = ll_get_document, .document = true},
    {.method = "POST",
     .pattern = V1 "/sessions",
     .handler = ll_post_sessions,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {.method = "GET",
     .pattern = V1 "/sessions",
     .handler = ll_get_sessions,
     .run_on = LL_HTTP_TASK,
     .query = "after,limit"},
    {.method = "GET", .pattern = V1 "/creation", .handler = ll_get_creation},
    {.method = "GET", .pattern = V1 "/class-keys", .handler = ll_get_class_keys, .run_on = LL_HTTP_TASK},
    {.method = "PUT",
     .pattern = V1 "/creation",
     .handler = ll_put_creation,
     .body_limit = BODY,
     .types = JSON_TYPE},
    {.method = "GET", .pattern = V1 "/sessions/{id}", .handler = ll_get_session, .run_on = LL_HTTP_TASK},
    {.method = "DELETE",
     .pattern = V1 "/sessions/{id}",
     .handler = ll_delete_session,
     .run_on = LL_HTTP_POOL},
    {.method = "PATCH",
     .pattern = V1 "/sessions/{id}/params",
     .handler = ll_patch_params,
     .body_limit = BODY,
     .types = PATCH_TYPES,
     .run_on = LL_HTTP_POOL},
    {.method = "POST",
     .pattern = V1 "/sessions/{id}/control",
     .handler = ll_post_control,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {.method = "POST",
     .pattern = V1 "/sessions/{id}/input",
     .handler = ll_post_input,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {.method = "POST",
     .pattern = V1 "/sessions/{id}/fork",
     .handler = ll_post_fork,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {.method = "GET",
     .pattern = V1 "/sessions/{id}/state",
     .handler = ll_get_state,
     .run_on = LL_HTTP_TASK,
     .query = "tick"},
    {.method = "GET",
     .pattern = V1 "/sessions/{id}/metrics",
     .handler = ll_get_metrics,
     .run_on = LL_HTTP_TASK},
    {.method = "GET",
     .pattern = V1 "/sessions/{id}/trace",
     .handler = ll_get_trace,
     .run_on = LL_HTTP_TASK,
     .query = "from_s,to_s,of,format"},
    {.method = "GET",
     .pattern = V1 "/sessions/{id}/packets",
     .handler = ll_get_packets,
     .run_on = LL_HTTP_TASK,
     .query = "from_s,to_s,at"},
    {.method = "GET", .pattern = V1 "/sessions/{id}/log", .handler = ll_get_log, .run_on = LL_HTTP_TASK},
    {.method = "POST",
     .pattern = V1 "/experiments",
     .handler = ll_post_experiments,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK,
     .query = "dry_run"},
    {.method = "GET", .pattern = V1 "/experiments", .handler = ll_get_experiments, .run_on = LL_HTTP_TASK},
    {.method = "GET", .pattern = V1 "/experiments/schema", .handler = ll_get_document, .document = true},
    {.method = "GET", .pattern = V1 "/experiments/library", .handler = ll_get_document, .document = true},
    {.method = "GET",
     .pattern = V1 "/experiments/{id}",
     .handler = ll_get_experiment,
     .run_on = LL_HTTP_TASK},
    {.method = "DELETE",
     .pattern = V1 "/experiments/{id}",
     .handler = ll_delete_experiment,
     .run_on = LL_HTTP_TASK},
    {.method = "POST",
     .pattern = V1 "/experiments/{id}/control",
     .handler = ll_post_experiment_control,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {.method = "GET",
     .pattern = V1 "/experiments/{id}/results",
     .handler = ll_get_experiment_results,
     .run_on = LL_HTTP_TASK,
     .query = "format,points,compare,sensitivity"},
    {.method = "GET",
     .pattern = V1 "/experiments/{id}/runs/{run}",
     .handler = ll_get_experiment_run,
     .run_on = LL_HTTP_TASK},
    {.method = "GET",
     .pattern = V1 "/experiments/{id}/runs/{run}/trace",
     .handler = ll_get_experiment_trace,
     .run_on = LL_HTTP_TASK,
     .query = "of,format"},
    {.method = "GET",
     .pattern = V1 "/experiments/{id}/report",
     .handler = ll_get_experiment_report,
     .run_on = LL_HTTP_TASK},
    {.method = "POST",
     .pattern = V1 "/advise",
     .handler = ll_post_advise,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {.method = "GET", .pattern = V1 "/advise/{id}", .handler = ll_get_advice, .run_on = LL_HTTP_TASK},
    {.method = "DELETE", .pattern = V1 "/advise/{id}", .handler = ll_delete_advice, .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = V1 "/tradeoffs", .handler = ll_get_tradeoffs},
    {.method = "POST",
     .pattern = V1 "/tradeoffs",
     .handler = ll_post_tradeoffs,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {.method = "GET", .pattern = V1 "/tradeoffs/{id}", .handler = ll_get_tradeoff, .run_on = LL_HTTP_TASK},
    {.method = "DELETE",
     .pattern = V1 "/tradeoffs/{id}",
     .handler = ll_delete_tradeoff,
     .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = V1 "/codes/{code}", .handler = ll_get_code, .run_on = LL_HTTP_POOL},
    {.method = "POST",
     .pattern = V1 "/classes",
     .handler = ll_post_classes,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = V1 "/classes/{id}", .handler = ll_get_class, .run_on = LL_HTTP_POOL},
    {.method = "PATCH",
     .pattern = V1 "/classes/{id}",
     .handler = ll_patch_class,
     .body_limit = BODY,
     .types = PATCH_TYPES,
     .run_on = LL_HTTP_POOL},
    {.method = "DELETE", .pattern = V1 "/classes/{id}", .handler = ll_delete_class, .run_on = LL_HTTP_POOL},
    {.method = "PUT",
     .pattern = V1 "/classes/{id}/board",
     .handler = ll_put_board,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {.method = "DELETE",
     .pattern = V1 "/classes/{id}/seats/{player}",
     .handler = ll_delete_seat,
     .run_on = LL_HTTP_POOL},
    {.method = "GET",
     .pattern = V1 "/classes/{id}/members",
     .handler = ll_get_members,
     .run_on = LL_HTTP_POOL},
    {.method = "DELETE",
     .pattern = V1 "/classes/{id}/members/{number}",
     .handler = ll_delete_members,
     .run_on = LL_HTTP_POOL,
     .query = "and"},
    {.method = "POST",
     .pattern = V1 "/classes/{id}/members",
     .handler = ll_post_members,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = V1 "/classes/{id}/member", .handler = ll_get_member, .run_on = LL_HTTP_POOL},
    {.method = "PATCH",
     .pattern = V1 "/classes/{id}/member",
     .handler = ll_patch_member,
     .body_limit = BODY,
     .types = PATCH_TYPES,
     .run_on = LL_HTTP_POOL},
    {.method = "DELETE",
     .pattern = V1 "/classes/{id}/member",
     .handler = ll_delete_member,
     .run_on = LL_HTTP_POOL},
    {.method = "PUT",
     .pattern = V1 "/classes/{id}/vote",
     .handler = ll_put_vote,
     .body_limit = BODY,
     .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = "/healthz", .handler = ll_get_healthz},
    {.method = "GET", .pattern = "/readyz", .handler = ll_get_readyz},
    {.method = "GET", .pattern = "/metrics", .handler = ll_get_prometheus},
};

ll_status ll_api_init(ll_api *api, ll_host *host, ll_store *store, ll_experiments *experiments,
                      ll_tasks *tasks)
{
    memset(api, 0, sizeof *api);
    const ll_host_config *config = ll_host_get_config(host);
    api->host = host;
    api->store = store;
    api->experiments = experiments;
    api->tasks = tasks;
    api->jobs = ll_jobs_new(tasks, config);
    api->scenarios = config->scenarios;
    api->started = ll_now_ns();
    api->route_count = (int)(sizeof table / sizeof table[0]);
    api->routes = malloc(sizeof table);
    api->idempotency = ll_api_idempotency_new();
    if (!api->routes || !api->idempotency || !api->jobs) {
        ll_api_end(api);
        return ll_error(LL_NO_MEMORY, "out of memory: routes");
    }
    memcpy(api->routes, table, sizeof table);
    for (int i = 0; i < api->route_count; i++) {
        if (api->routes[i].body_limit == BODY)
            api->routes[i].body_limit = (size_t)config->max_body_bytes;
        if (!api->routes[i].query)
            api->routes[i].query = "";
    }
    return ll_ok();
}

void ll_api_end(ll_api *api)
{
    ll_documents_free(&api->documents);
    free(api->routes);
    api->routes = NULL;
    ll_jobs_free(api->jobs);
    api->jobs = NULL;
    ll_api_idempotency_free(api->idempotency);
    api->idempotency = NULL;
}

static void count_answer(ll_api *api, int status, double seconds)
{
    int class = status >= 100 && status < 600 ? status / 100 : 0;
    atomic_fetch_add_explicit(&api->answered.count[class], 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&api->answered.duration_us[class], (uint64_t)(seconds * 1e6),
                              memory_order_relaxed);
}

void ll_api_done(void *context, const ll_http_request *request, const ll_http_route *route, int status,
                 double seconds)
{
    ll_api *api = context;
    count_answer(api, status, seconds);
    /* Not what the request is to blame for (501, 505), nor a full or stopping daemon (503), which /metrics
     * counts, nor a store that fails (507), which is logged once. */
    if (status != 500)
        return;
    /* The pattern and not the path, since paths contain session ids. */
    ll_log_write("error", "request failed", "%s %s answered %d after %.1f ms, request %s",
                 request ? request->method : "?", route ? route->pattern : "(file)", status, seconds * 1e3,
                 request ? request->id : "?");
}

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

#define ROUTE(method_, pattern_, handler_) .method = (method_), .pattern = (pattern_), .handler = (handler_)

enum { BODY = 1 }; /* placeholder for --max-body-bytes */

/* What may compute for more than a millisecond, with any body, is a task from its first byte. The others are
 * short with a body of at most HTTP_SHORT_BODY bytes; those that would be long in a rare case, as a seek, ask
 * for a task by ll_http_become_task. tests/lib/heavy.mjs has the heaviest request of each row. */
static const ll_http_route table[] = {
    {ROUTE("GET", V1 "/scenarios", ll_get_scenarios), .query = "brief", .document = true},
    {ROUTE("GET", V1 "/scenarios/{id*}", ll_get_scenario), .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/schema", ll_get_schema), .query = "kind,brief", .document = true},
    {ROUTE("GET", V1 "/openapi.yaml", ll_get_document), .document = true},
    {ROUTE("GET", V1 "/schemas.json", ll_get_document), .document = true},
    {ROUTE("GET", V1 "/asyncapi.yaml", ll_get_document), .document = true},
    {ROUTE("GET", V1 "/stream/schema.json", ll_get_document), .document = true},
    {ROUTE("GET", V1 "/metrics", ll_get_document), .document = true},
    {ROUTE("POST", V1 "/sessions", ll_post_sessions), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/sessions", ll_get_sessions), .run_on = LL_HTTP_TASK, .query = "after,limit"},
    {ROUTE("GET", V1 "/creation", ll_get_creation)},
    {ROUTE("GET", V1 "/class-keys", ll_get_class_keys), .run_on = LL_HTTP_TASK},
    {ROUTE("PUT", V1 "/creation", ll_put_creation), .body_limit = BODY, .types = JSON_TYPE},
    {ROUTE("GET", V1 "/sessions/{id}", ll_get_session), .run_on = LL_HTTP_TASK},
    {ROUTE("DELETE", V1 "/sessions/{id}", ll_delete_session), .run_on = LL_HTTP_POOL},
    {ROUTE("PATCH", V1 "/sessions/{id}/params", ll_patch_params), .body_limit = BODY, .types = PATCH_TYPES,
     .run_on = LL_HTTP_POOL},
    {ROUTE("POST", V1 "/sessions/{id}/control", ll_post_control), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {ROUTE("POST", V1 "/sessions/{id}/input", ll_post_input), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {ROUTE("POST", V1 "/sessions/{id}/fork", ll_post_fork), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/sessions/{id}/state", ll_get_state), .run_on = LL_HTTP_TASK, .query = "tick"},
    {ROUTE("GET", V1 "/sessions/{id}/hello", ll_get_hello), .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/sessions/{id}/frame", ll_get_frame), .run_on = LL_HTTP_TASK,
     .query = "channels,from_event"},
    {ROUTE("GET", V1 "/sessions/{id}/metrics", ll_get_metrics), .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/sessions/{id}/trace", ll_get_trace), .run_on = LL_HTTP_TASK,
     .query = "from_s,to_s,of,format"},
    {ROUTE("GET", V1 "/sessions/{id}/packets", ll_get_packets), .run_on = LL_HTTP_TASK,
     .query = "from_s,to_s,at"},
    {ROUTE("GET", V1 "/sessions/{id}/log", ll_get_log), .run_on = LL_HTTP_TASK},
    {ROUTE("POST", V1 "/experiments", ll_post_experiments), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK, .query = "dry_run"},
    {ROUTE("GET", V1 "/experiments", ll_get_experiments), .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/experiments/schema", ll_get_document), .document = true},
    {ROUTE("GET", V1 "/experiments/library", ll_get_document), .document = true},
    {ROUTE("GET", V1 "/experiments/{id}", ll_get_experiment), .run_on = LL_HTTP_TASK},
    {ROUTE("DELETE", V1 "/experiments/{id}", ll_delete_experiment), .run_on = LL_HTTP_TASK},
    {ROUTE("POST", V1 "/experiments/{id}/control", ll_post_experiment_control), .body_limit = BODY,
     .types = JSON_TYPE, .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/experiments/{id}/results", ll_get_experiment_results), .run_on = LL_HTTP_TASK,
     .query = "format,points,compare,sensitivity"},
    {ROUTE("GET", V1 "/experiments/{id}/runs/{run}", ll_get_experiment_run), .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/experiments/{id}/runs/{run}/trace", ll_get_experiment_trace), .run_on = LL_HTTP_TASK,
     .query = "of,format"},
    {ROUTE("GET", V1 "/experiments/{id}/report", ll_get_experiment_report), .run_on = LL_HTTP_TASK},
    {ROUTE("POST", V1 "/advise", ll_post_advise), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/advise/{id}", ll_get_advice), .run_on = LL_HTTP_TASK},
    {ROUTE("DELETE", V1 "/advise/{id}", ll_delete_advice), .run_on = LL_HTTP_POOL},
    {ROUTE("GET", V1 "/tradeoffs", ll_get_tradeoffs), .run_on = LL_HTTP_POOL},
    {ROUTE("POST", V1 "/tradeoffs", ll_post_tradeoffs), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {ROUTE("GET", V1 "/tradeoffs/{id}", ll_get_tradeoff), .run_on = LL_HTTP_TASK},
    {ROUTE("DELETE", V1 "/tradeoffs/{id}", ll_delete_tradeoff), .run_on = LL_HTTP_POOL},
    {ROUTE("GET", V1 "/codes/{code}", ll_get_code), .run_on = LL_HTTP_POOL},
    {ROUTE("POST", V1 "/classes", ll_post_classes), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {ROUTE("GET", V1 "/classes/{id}", ll_get_class), .run_on = LL_HTTP_POOL},
    {ROUTE("PATCH", V1 "/classes/{id}", ll_patch_class), .body_limit = BODY, .types = PATCH_TYPES,
     .run_on = LL_HTTP_POOL},
    {ROUTE("DELETE", V1 "/classes/{id}", ll_delete_class), .run_on = LL_HTTP_POOL},
    {ROUTE("PUT", V1 "/classes/{id}/board", ll_put_board), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_TASK},
    {ROUTE("DELETE", V1 "/classes/{id}/seats/{player}", ll_delete_seat), .run_on = LL_HTTP_POOL},
    {ROUTE("GET", V1 "/classes/{id}/members", ll_get_members), .run_on = LL_HTTP_POOL},
    {ROUTE("DELETE", V1 "/classes/{id}/members/{number}", ll_delete_members), .run_on = LL_HTTP_POOL,
     .query = "and"},
    {ROUTE("POST", V1 "/classes/{id}/members", ll_post_members), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {ROUTE("GET", V1 "/classes/{id}/member", ll_get_member), .run_on = LL_HTTP_POOL},
    {ROUTE("PATCH", V1 "/classes/{id}/member", ll_patch_member), .body_limit = BODY, .types = PATCH_TYPES,
     .run_on = LL_HTTP_POOL},
    {ROUTE("DELETE", V1 "/classes/{id}/member", ll_delete_member), .run_on = LL_HTTP_POOL},
    {ROUTE("PUT", V1 "/classes/{id}/vote", ll_put_vote), .body_limit = BODY, .types = JSON_TYPE,
     .run_on = LL_HTTP_POOL},
    {ROUTE("GET", "/healthz", ll_get_healthz)},
    {ROUTE("GET", "/readyz", ll_get_readyz)},
    {ROUTE("GET", "/metrics", ll_get_prometheus)},
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
    LL_TRY(ll_measurements_open(tasks, config, store, &api->measurements));
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
    ll_measurements_close(api->measurements);
    api->measurements = NULL;
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

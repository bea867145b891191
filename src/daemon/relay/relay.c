#include "daemon/relay/relay.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <curl/curl.h>

#include "daemon/http/http_problem.h"
#include "daemon/listener/prometheus.h"
#include "daemon/listener/web_server.h"
#include "daemon/relay/internal.h"
#include "daemon/support/log.h"
#include "daemon/support/process.h"
#include "daemon/support/tasks.h"
#include "library/program.h"

enum { BODY_MOST = 16 << 20 /* the owner has its own limit */, TURNS = 64 /* requests that wait for it */ };

typedef struct relay {
    ll_relay_config config;
    ll_web_server_config web_server_config;
    ll_owner owner;
    relay_streams *streams;
    ll_forward *forward;
    ll_tasks *tasks;
    _Atomic(ll_web_server *) web_server;
    atomic_bool ready;
    int64_t started_ns;
    ll_answered answered;
    sigset_t signals;
} relay;

/* ---- its own answers ---- */

static void get_healthz(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context, (void)request;
    ll_http_text(response, 200, "application/json", "{\"status\":\"ok\"}");
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* Also without the owner: its viewers have the last frame, and another relay would not have more. */
static void get_readyz(void *context, const ll_http_request *request, ll_http_response *response)
{
    relay *r = context;
    if (atomic_load(&r->ready)) {
        ll_http_text(response, 200, "application/json", "{\"status\":\"ready\"}");
    } else {
        ll_status error = ll_error(LL_LIMIT, "The relay starts or stops.");
        ll_http_problem_later(response, request, 503, 5, &error);
    }
    ll_http_set_header(response, "Cache-Control", "no-store");
}

static void write_relay(ll_http_response *response, relay *r)
{
    relay_counts *counts = &r->streams->counts;
    ll_forward_stats forward = ll_forward_get_stats(r->forward);
    ll_prometheus_gauge(response, "relay_streams", atomic_load(&counts->sources),
                        "Streams that are passed on.");
    ll_prometheus_gauge(response, "relay_streams_connected", atomic_load(&counts->connected),
                        "Streams of sessions that are being read from the owner.");
    ll_prometheus_gauge(response, "relay_tunnels", atomic_load(&counts->tunnels),
                        "Viewers with a connection of their own to the owner.");
    ll_prometheus_counter(response, "relay_frames_total", atomic_load(&counts->frames),
                          "Frames read from the owner.");
    ll_prometheus_counter(response, "relay_frame_bytes_total", atomic_load(&counts->bytes),
                          "Bytes of frames read from the owner.");
    ll_prometheus_counter(response, "relay_lost_total", atomic_load(&counts->lost),
                          "Connections of streams to the owner that ended or could not be made.");
    ll_prometheus_counter(response, "relay_faults_total", atomic_load(&counts->faults),
                          "Messages of the owner that could not be read.");
    ll_prometheus_counter(response, "relay_requests_total", forward.requests, "Requests for the owner.");
    ll_prometheus_counter(response, "relay_requests_kept_total", forward.kept,
                          "Those of them that were answered without asking it again.");
    ll_prometheus_counter(response, "relay_requests_failed_total", forward.failed,
                          "Those of them that it did not answer.");
}

static void get_metrics(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)request;
    relay *r = context;
    ll_web_server *web_server = atomic_load(&r->web_server);
    ll_web_server_stats stats = {0};
    if (web_server != NULL)
        stats = ll_web_server_get_stats(web_server);
    ll_tasks_stats tasks = ll_tasks_get_stats(r->tasks);
    ll_prometheus_begin(response);
    ll_prometheus_process(response, (double)(ll_relay_now() - r->started_ns) * 1e-9);
    write_relay(response, r);
    ll_prometheus_web_server(response, &stats);
    ll_prometheus_answered(response, &r->answered);
    ll_prometheus_tasks(response, &tasks, &stats);
    ll_prometheus_family(response, "refused_total", "counter", "Refusals, by limit.");
    ll_prometheus_refused(response, &stats);
}

static void forward(void *context, const ll_http_request *request, ll_http_response *response)
{
    relay *r = context;
    ll_forward_request(r->forward, request, response);
}

#define API "/api/{rest*}"

static const ll_http_route routes[] = {
    {.method = "GET", .pattern = "/healthz", .handler = get_healthz, .query = ""},
    {.method = "GET", .pattern = "/readyz", .handler = get_readyz, .query = ""},
    {.method = "GET", .pattern = "/metrics", .handler = get_metrics, .query = ""},
    {.method = "GET", .pattern = API, .handler = forward, .run_on = LL_HTTP_POOL},
    {.method = "POST", .pattern = API, .handler = forward, .body_limit = BODY_MOST, .run_on = LL_HTTP_TASK},
    {.method = "PUT", .pattern = API, .handler = forward, .body_limit = BODY_MOST, .run_on = LL_HTTP_TASK},
    {.method = "PATCH", .pattern = API, .handler = forward, .body_limit = BODY_MOST, .run_on = LL_HTTP_TASK},
    {.method = "DELETE", .pattern = API, .handler = forward, .body_limit = BODY_MOST, .run_on = LL_HTTP_TASK},
};

static void done(void *context, const ll_http_request *request, const ll_http_route *route, int status,
                 double seconds)
{
    (void)request, (void)route;
    relay *r = context;
    ll_answered_count(&r->answered, status, seconds);
}

/* ---- running ---- */

static void log_web_server(void *context, const char *level, const char *message)
{
    (void)context;
    ll_log_write(level, "web server", "%s", message);
}

static ll_status start(relay *r)
{
    ll_web_server *web_server = NULL;
    ll_status status = ll_owner_parse(r->config.of, r->config.ca_file, &r->owner);
    LL_THEN(status, ll_relay_streams_new(&r->config, &r->owner, &r->streams));
    LL_THEN(status, ll_tasks_start(TURNS, &r->tasks));
    if (ll_failed(&status))
        return status;
    r->forward = ll_forward_new(&r->config, &r->owner, r->streams);
    if (r->forward == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: relay");
    ll_http_app app = {.routes = routes,
                       .route_count = sizeof routes / sizeof routes[0],
                       .context = r,
                       .tasks = r->tasks,
                       .done = done};
    ll_ws_hooks hooks = ll_relay_hooks(r->streams);
    LL_TRY(ll_web_server_open(&r->web_server_config, &app, &hooks, log_web_server, NULL, &web_server));
    atomic_store(&r->web_server, web_server);
    LL_TRY(ll_relay_streams_start(r->streams, ll_web_server_ws(web_server)));
    atomic_store(&r->ready, true);
    return status;
}

/* In the reverse order of the start; also after a failed one. */
static void stop(relay *r)
{
    ll_web_server *web_server = atomic_load(&r->web_server);
    if (r->tasks != NULL)
        ll_tasks_drain(r->tasks);
    if (web_server != NULL)
        ll_web_server_drain(web_server);
    ll_relay_streams_stop(r->streams);
    ll_web_server_close(web_server);
    ll_tasks_free(r->tasks);
    ll_forward_free(r->forward);
    ll_relay_streams_free(r->streams);
}

/* A second signal exits at once: nothing is lost. */
static void *exit_at_once(void *argument)
{
    (void)argument;
    sigset_t signals;
    int got;
    ll_process_ending(&signals);
    sigwait(&signals, &got);
    _Exit(1);
}

static int fail(const ll_status *status)
{
    fprintf(stderr, "laglab: %s\n", status->text);
    return status->code == LL_BAD_INPUT ? 2 : 1;
}

static void wait_for_end(relay *r)
{
    int got = 0;
    pthread_t impatient;
    sigwait(&r->signals, &got);
    atomic_store(&r->ready, false);
    ll_log_write("info", "stopping", "Signal: %s.", ll_process_signal_name(got));
    if (pthread_create(&impatient, NULL, exit_at_once, NULL) == 0)
        pthread_detach(impatient);
}

int ll_relay(const ll_relay_config *config, const ll_web_server_config *web_server)
{
    relay *r = calloc(1, sizeof *r);
    if (r == NULL)
        return 1;
    r->config = *config;
    r->web_server_config = *web_server;
    r->started_ns = ll_relay_now();
    if (r->web_server_config.www[0] == '\0')
        ll_program_sibling("www", r->web_server_config.www, sizeof r->web_server_config.www);
    ll_process_prepare(&r->signals);
    curl_global_init(CURL_GLOBAL_DEFAULT);
    ll_status status = start(r);
    if (!ll_failed(&status)) {
        printf("laglab listening on http://%s/\n", ll_web_server_address(atomic_load(&r->web_server)));
        fflush(stdout);
        wait_for_end(r);
    }
    stop(r);
    free(r);
    curl_global_cleanup();
    return ll_failed(&status) ? fail(&status) : 0;
}

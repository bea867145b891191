#include "daemon/serve/waiting.h"

#include "daemon/api/api.h"
#include "daemon/http/http_problem.h"

enum { RETRY_S = 2, BODY_MOST = 1 << 20 };

static void answer(const ll_http_request *request, ll_http_response *response, int status)
{
    ll_status error = ll_error(LL_UNAVAILABLE, "The daemon is starting: it waits for its store.");
    ll_http_problem_later(response, request, status, RETRY_S, &error);
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* As of a daemon that drains: proxies send requests elsewhere. */
static void get_readyz(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    answer(request, response, 404);
}

static void refuse(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    answer(request, response, 503);
}

/* The last pattern takes all paths but the first one. */
static const ll_http_route routes[] = {
    {.method = "GET", .pattern = "/healthz", .handler = ll_get_healthz, .query = ""},
    {.method = "GET", .pattern = "/readyz", .handler = get_readyz, .query = ""},
    {.method = "GET", .pattern = "/", .handler = refuse},
    {.method = "GET", .pattern = "/{path*}", .handler = refuse},
    {.method = "POST", .pattern = "/{path*}", .handler = refuse, .body_limit = BODY_MOST},
    {.method = "PUT", .pattern = "/{path*}", .handler = refuse, .body_limit = BODY_MOST},
    {.method = "PATCH", .pattern = "/{path*}", .handler = refuse, .body_limit = BODY_MOST},
    {.method = "DELETE", .pattern = "/{path*}", .handler = refuse, .body_limit = BODY_MOST},
};

/* A viewer that comes back asks again. */
static ll_ws_known find_stream(void *context, ll_stream_kind kind, const char *id)
{
    (void)context, (void)kind, (void)id;
    return LL_WS_LATER;
}

ll_status ll_waiting_open(const ll_web_server_config *config, ll_web_server **web_server)
{
    ll_web_server_config small = *config;
    ll_http_app app = {.routes = routes, .route_count = sizeof routes / sizeof routes[0]};
    ll_ws_hooks hooks = {.unknown = find_stream, .every_kind = true};
    small.www[0] = '\0';
    small.http_threads = small.stream_threads = small.control_threads = 1;
    small.io_uring = 0;
    return ll_web_server_open(&small, &app, &hooks, web_server);
}

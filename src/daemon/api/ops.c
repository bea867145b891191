/* For operations: liveness and readiness. */
#include "daemon/api/api.h"
#include "daemon/support/tasks.h"

void ll_get_healthz(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    ll_http_text(response, 200, "{\"status\":\"ok\"}");
    ll_http_set_header(response, "Cache-Control", "no-store");
}

#define STUCK_S 5.0

/* Not work that waits in a queue which goes on, however long. Stuck is a daemon in which nothing has ended
 * for long. */
static ll_status find_stuck(ll_api *api)
{
    ll_web_server *web_server = atomic_load(&api->web_server);
    double control_s = web_server ? ll_web_server_get_stats(web_server).stalled_s : 0;
    double work_s = ll_tasks_get_stats(api->tasks).stalled_s;
    if (control_s > STUCK_S)
        return ll_error(LL_UNAVAILABLE, "Short requests wait, and none was answered for %.0f s.", control_s);
    if (work_s > STUCK_S)
        return ll_error(LL_UNAVAILABLE, "Long requests wait, and none got a turn for %.0f s.", work_s);
    return ll_ok();
}

void ll_get_readyz(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    int phase = atomic_load(&api->phase);
    ll_status stuck = phase == LL_API_READY ? find_stuck(api) : ll_ok();
    if (ll_failed(&stuck)) {
        ll_http_problem_later(response, request, 503, 5, &stuck);
    } else if (phase == LL_API_READY) {
        ll_http_text(response, 200, "{\"status\":\"ready\"}");
    } else {
        ll_status error = ll_error(LL_LIMIT, phase == LL_API_STARTING ? "The daemon is starting."
                                                                      : "The daemon is stopping.");
        ll_http_problem_later(response, request, 503, 5, &error);
    }
    ll_http_set_header(response, "Cache-Control", "no-store");
}

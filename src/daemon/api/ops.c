/* For operations: liveness, readiness, metrics. None of them names or lists single sessions. */
#include "daemon/api/api.h"
#include "daemon/class/classes.h"
#include "daemon/http/http_problem.h"
#include "daemon/listener/prometheus.h"
#include "daemon/support/access.h"
#include "daemon/support/tasks.h"

void ll_get_healthz(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    ll_http_text(response, 200, "application/json", "{\"status\":\"ok\"}");
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
        ll_http_text(response, 200, "application/json", "{\"status\":\"ready\"}");
    } else {
        ll_status error = ll_error(LL_LIMIT, phase == LL_API_STARTING ? "The daemon is starting."
                                                                      : "The daemon is stopping.");
        ll_http_problem_later(response, request, 503, 5, &error);
    }
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* ---- /metrics ---- */

static void write_sessions(ll_http_response *r, const ll_host_stats *s)
{
    ll_prometheus_gauge(r, "sessions", (double)s->sessions, "Sessions, in total.");
    ll_prometheus_family(r, "sessions_by_status", "gauge",
                         "Sessions by status; unloaded: only on disk since the start.");
    ll_prometheus_labelled(r, "sessions_by_status", "status", "playing", (uint64_t)s->playing);
    ll_prometheus_labelled(r, "sessions_by_status", "status", "paused", (uint64_t)s->paused);
    ll_prometheus_labelled(r, "sessions_by_status", "status", "ended", (uint64_t)s->ended);
    ll_prometheus_labelled(r, "sessions_by_status", "status", "failed", (uint64_t)s->failed);
    ll_prometheus_labelled(r, "sessions_by_status", "status", "unloaded", (uint64_t)s->unloaded);
    ll_prometheus_gauge(r, "sessions_parked", (double)s->parked, "Parked sessions.");
    ll_prometheus_gauge(r, "sessions_memory_bytes", (double)s->memory,
                        "Memory reserved by sessions in memory.");
    ll_prometheus_gauge(r, "log_bytes", (double)s->log_bytes, "Bytes of the logs of all sessions.");
    ll_prometheus_gauge(r, "sessions_memory_max_bytes", (double)s->memory_max,
                        "Maximum of that memory; sessions beyond it are refused.");
    ll_prometheus_counter(r, "sessions_created_total", s->created, "Sessions created, forks included.");
    ll_prometheus_counter(r, "sessions_deleted_total", s->deleted,
                          "Sessions deleted, expired ones included.");
    ll_prometheus_counter(r, "sessions_expired_total", s->expired,
                          "Sessions deleted after session_ttl_s without a request.");
    ll_prometheus_counter(r, "ticks_total", s->ticks, "Ticks of virtual time simulated for sessions.");
    ll_prometheus_counter(r, "frames_published_total", s->frames,
                          "Frames published, each for all viewers of its session.");
    ll_prometheus_counter(r, "commands_total", s->commands, "Commands accepted by REST.");
    ll_prometheus_counter(r, "inputs_total", s->inputs, "Inputs accepted from streams.");
}

static void write_refused(ll_http_response *r, const ll_host_stats *s, const ll_web_server_stats *d)
{
    ll_prometheus_family(r, "refused_total", "counter", "Refusals, by limit.");
    ll_prometheus_labelled(r, "refused_total", "limit", "sessions", s->refused_sessions);
    ll_prometheus_labelled(r, "refused_total", "limit", "new_sessions_per_min", s->refused_creations);
    ll_prometheus_labelled(r, "refused_total", "limit", "code_lookups_per_min", s->refused_lookups);
    ll_prometheus_labelled(r, "refused_total", "limit", "commands_per_s", s->refused_commands);
    ll_prometheus_labelled(r, "refused_total", "limit", "store", s->refused_store);
    ll_prometheus_labelled(r, "refused_total", "limit", "memory", s->refused_memory);
    ll_prometheus_labelled(r, "refused_total", "limit", "log_mib", s->refused_logs);
    ll_prometheus_refused(r, d);
}

static void write_store(ll_http_response *r, ll_api *api)
{
    ll_store_stats store = ll_store_get_stats(api->store);
    int64_t commits = 0;
    ll_prometheus_gauge(r, "store_queue", (double)store.queued, "Records waiting to be stored.");
    ll_prometheus_counter(r, "store_commits_total", (uint64_t)store.commits, "Commits of the database.");
    ll_prometheus_counter(r, "store_failures_total", (uint64_t)store.failures,
                          "Failed commits, which are retried.");
    ll_prometheus_gauge(r, "store_failing", ll_store_failing(api->store, NULL), "1 while the store fails.");
    ll_prometheus_family(r, "store_commit_seconds", "histogram", "Time of a commit.");
    for (int i = 0; i < LL_STORE_TIMES; i++) {
        char limit[24] = "+Inf";
        commits += store.times[i];
        if (i < LL_STORE_TIMES - 1)
            snprintf(limit, sizeof limit, "%g", ll_store_time_limits[i]);
        ll_prometheus_labelled(r, "store_commit_seconds_bucket", "le", limit, (uint64_t)commits);
    }
    ll_http_printf(r, "laglab_store_commit_seconds_sum %.6f\nlaglab_store_commit_seconds_count %lld\n",
                   store.commit_s, (long long)commits);
}

/* Names of keys need no quoting. */
static void write_keys(ll_http_response *r, ll_api *api)
{
    static const struct {
        const char *name, *help;
    } uses[LL_KEY_USES] = {
        [LL_KEY_CLASSES] = {"class_key_classes", "Open classes, by the class key that opened them."},
        [LL_KEY_SESSIONS] = {"class_key_sessions", "Sessions, by the class key that made them."},
        [LL_KEY_EXPERIMENTS] = {"class_key_experiments", "Experiments, by the class key that made them."},
        [LL_KEY_LOGS] = {"class_key_log_bytes", "Bytes of the logs of these sessions."}};
    const ll_access *access = ll_host_get_config(api->host)->access;
    int count = access ? access->class_keys.count : 0;
    const ll_class_key *keys = count > 0 ? access->class_keys.keys : NULL;
    if (!keys || !keys[0].name[0])
        return;
    for (int use = 0; use < LL_KEY_USES; use++) {
        ll_prometheus_family(r, uses[use].name, "gauge", uses[use].help);
        for (int i = 0; i < count; i++) {
            int64_t used = atomic_load(&keys[i].used[use]);
            ll_prometheus_labelled(r, uses[use].name, "name", keys[i].name, used > 0 ? (uint64_t)used : 0);
        }
    }
    ll_prometheus_family(r, "class_key_refused_total", "counter",
                         "Requests that a quota of the class key refused here.");
    for (int i = 0; i < count; i++)
        ll_prometheus_labelled(r, "class_key_refused_total", "name", keys[i].name,
                               atomic_load(&keys[i].refused));
}

void ll_get_prometheus(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)request;
    ll_api *api = context;
    ll_web_server *web_server = atomic_load(&api->web_server);
    ll_web_server_stats d = {0};
    if (web_server)
        d = ll_web_server_get_stats(web_server);
    ll_host_stats s = ll_host_get_stats(api->host);
    ll_tasks_stats tasks = ll_tasks_get_stats(api->tasks);
    ll_prometheus_begin(response);
    ll_prometheus_process(response, (double)(ll_host_now() - api->started) / 1e9);
    write_sessions(response, &s);
    if (atomic_load(&api->phase) != LL_API_STARTING)
        ll_prometheus_gauge(response, "classes", (double)ll_classes_count(api->classes), "Open classes.");
    ll_prometheus_web_server(response, &d);
    ll_prometheus_answered(response, &api->answered);
    ll_prometheus_tasks(response, &tasks, &d);
    write_refused(response, &s, &d);
    write_keys(response, api);
    write_store(response, api);
}

/* For operations: liveness, readiness, metrics. None of them names or lists single sessions. */
#include <stdio.h>

#include "base/version.h"
#include "daemon/api/api.h"
#include "daemon/class/classes.h"
#include "daemon/http/http_problem.h"
#include "daemon/support/memory.h"
#include "daemon/support/tasks.h"

void ll_get_healthz(void *context, const ll_http_request *request, ll_http_response *response)
{
    (void)context;
    (void)request;
    ll_http_text(response, 200, "application/json", "{\"status\":\"ok\"}");
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* Longer than any task waits for its turn under load: another one does not return its turn. */
#define STUCK_S 5.0

static ll_status find_stuck(ll_api *api)
{
    ll_web_server *web_server = atomic_load(&api->web_server);
    double control_s = web_server ? ll_web_server_get_stats(web_server).control_s : 0;
    double work_s = ll_tasks_get_stats(api->tasks).longest_s;
    if (control_s > STUCK_S)
        return ll_error(LL_UNAVAILABLE, "A short request is unanswered after %.0f s.", control_s);
    if (work_s > STUCK_S)
        return ll_error(LL_UNAVAILABLE, "A long request has waited %.0f s for its turn.", work_s);
    return ll_ok();
}

void ll_get_readyz(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    int phase = atomic_load(&api->phase);
    ll_status stuck = phase == LL_API_READY ? find_stuck(api) : ll_ok();
    ll_status lease = ll_store_check_lease(api->store);
    if (ll_failed(&stuck)) {
        ll_http_problem_later(response, request, 503, 5, &stuck);
    } else if (phase == LL_API_READY && !ll_failed(&lease)) {
        ll_http_text(response, 200, "application/json", "{\"status\":\"ready\"}");
    } else {
        ll_status error = ll_failed(&lease)
                              ? lease
                              : ll_error(LL_LIMIT, phase == LL_API_STARTING ? "The daemon is starting."
                                                                            : "The daemon is stopping.");
        /* With 404 a proxy leaves streams alone, and sends new requests to other daemons. */
        ll_http_problem_later(response, request, ll_store_is_shared(api->store) ? 404 : 503, 5, &error);
    }
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* ---- /metrics ---- */

static void family(ll_http_response *r, const char *name, const char *type, const char *help)
{
    ll_http_printf(r, "# HELP laglab_%s %s\n# TYPE laglab_%s %s\n", name, help, name, type);
}

static void gauge(ll_http_response *r, const char *name, double value, const char *help)
{
    family(r, name, "gauge", help);
    ll_http_printf(r, "laglab_%s %.17g\n", name, value);
}

static void counter(ll_http_response *r, const char *name, uint64_t value, const char *help)
{
    family(r, name, "counter", help);
    ll_http_printf(r, "laglab_%s %llu\n", name, (unsigned long long)value);
}

static void labelled(ll_http_response *r, const char *name, const char *label, const char *value,
                     uint64_t number)
{
    ll_http_printf(r, "laglab_%s{%s=\"%s\"} %llu\n", name, label, value, (unsigned long long)number);
}

static void write_sessions(ll_http_response *r, const ll_host_stats *s)
{
    gauge(r, "sessions", (double)s->sessions, "Sessions, in total.");
    family(r, "sessions_by_status", "gauge", "Sessions by status; unloaded: only on disk since the start.");
    labelled(r, "sessions_by_status", "status", "playing", (uint64_t)s->playing);
    labelled(r, "sessions_by_status", "status", "paused", (uint64_t)s->paused);
    labelled(r, "sessions_by_status", "status", "ended", (uint64_t)s->ended);
    labelled(r, "sessions_by_status", "status", "failed", (uint64_t)s->failed);
    labelled(r, "sessions_by_status", "status", "unloaded", (uint64_t)s->unloaded);
    gauge(r, "sessions_parked", (double)s->parked, "Parked sessions.");
    gauge(r, "sessions_memory_bytes", (double)s->memory, "Memory reserved by sessions in memory.");
    gauge(r, "log_bytes", (double)s->log_bytes, "Bytes of the logs of all sessions.");
    gauge(r, "sessions_memory_max_bytes", (double)s->memory_max,
          "Maximum of that memory; sessions beyond it are refused.");
    counter(r, "sessions_created_total", s->created, "Sessions created, forks included.");
    counter(r, "sessions_deleted_total", s->deleted, "Sessions deleted, expired ones included.");
    counter(r, "sessions_expired_total", s->expired,
            "Sessions deleted after session_ttl_s without a request.");
    counter(r, "ticks_total", s->ticks, "Ticks of virtual time simulated for sessions.");
    counter(r, "frames_published_total", s->frames, "Frames published, each for all viewers of its session.");
    counter(r, "commands_total", s->commands, "Commands accepted by REST.");
    counter(r, "inputs_total", s->inputs, "Inputs accepted from streams.");
}

static void write_refused(ll_http_response *r, const ll_host_stats *s, const ll_web_server_stats *d)
{
    family(r, "refused_total", "counter", "Refusals, by limit.");
    labelled(r, "refused_total", "limit", "sessions", s->refused_sessions);
    labelled(r, "refused_total", "limit", "new_sessions_per_min", s->refused_creations);
    labelled(r, "refused_total", "limit", "code_lookups_per_min", s->refused_lookups);
    labelled(r, "refused_total", "limit", "commands_per_s", s->refused_commands);
    labelled(r, "refused_total", "limit", "store", s->refused_store);
    labelled(r, "refused_total", "limit", "memory", s->refused_memory);
    labelled(r, "refused_total", "limit", "log_mib", s->refused_logs);
    labelled(r, "refused_total", "limit", "answers_mib", d->refused_answers);
    labelled(r, "refused_total", "limit", "connections", d->refused_total);
    labelled(r, "refused_total", "limit", "connections_per_ip", d->refused_per_ip);
    labelled(r, "refused_total", "limit", "head", d->refused_head);
    labelled(r, "refused_total", "limit", "slow_request", d->cut);
    labelled(r, "refused_total", "limit", "slow_viewer", d->ws.closed_slow);
    labelled(r, "refused_total", "limit", "viewer_policy", d->ws.closed_policy);
}

static void write_web_server(ll_http_response *r, const ll_web_server_stats *d)
{
    gauge(r, "connections", (double)d->connections, "Open connections of every kind.");
    counter(r, "connections_total", d->accepted, "Connections accepted.");
    gauge(r, "answer_bytes", (double)d->answer_bytes, "Bytes of large answers being sent.");
    counter(r, "bridged_total", d->bridged, "Streams opened on a kept connection.");
    gauge(r, "viewers", (double)d->ws.viewers, "Viewers of streams.");
    counter(r, "viewers_total", d->ws.opened, "Viewers since the start.");
    gauge(r, "streams", (double)d->ws.streams, "Open streams.");
    counter(r, "frames_sent_total", d->ws.frames, "Frames sent to viewers.");
    counter(r, "frame_bytes_total", d->ws.bytes, "Bytes of frames sent to viewers.");
    counter(r, "frames_skipped_total", d->ws.skipped, "Frames skipped because the viewer was not ready.");
    counter(r, "frames_dropped_total", d->ws.dropped, "Frames dropped because a stream thread was late.");
    counter(r, "messages_received_total", d->ws.messages, "Messages of viewers, acknowledgements included.");
}

static void write_store(ll_http_response *r, ll_api *api)
{
    ll_store_stats store = ll_store_get_stats(api->store);
    int64_t commits = 0;
    gauge(r, "store_queue", (double)store.queued, "Records waiting to be stored.");
    counter(r, "store_commits_total", (uint64_t)store.commits, "Commits of the database.");
    counter(r, "store_failures_total", (uint64_t)store.failures, "Failed commits, which are retried.");
    gauge(r, "store_failing", ll_store_failing(api->store, NULL), "1 while the store fails.");
    family(r, "store_commit_seconds", "histogram", "Time of a commit.");
    for (int i = 0; i < LL_STORE_TIMES; i++) {
        char limit[24] = "+Inf";
        commits += store.times[i];
        if (i < LL_STORE_TIMES - 1)
            snprintf(limit, sizeof limit, "%g", ll_store_time_limits[i]);
        labelled(r, "store_commit_seconds_bucket", "le", limit, (uint64_t)commits);
    }
    ll_http_printf(r, "laglab_store_commit_seconds_sum %.6f\nlaglab_store_commit_seconds_count %lld\n",
                   store.commit_s, (long long)commits);
}

/* Of a store that several daemons share. */
static void write_sharing(ll_http_response *r, ll_api *api, const ll_host_stats *s)
{
    if (!ll_store_is_shared(api->store))
        return;
    double left = ll_store_lease_left_s(api->store);
    gauge(r, "lease_left_seconds", left > 0 ? left : 0,
          "Time until this daemon stops its sessions, unless it can renew its lease; 0: they are stopped.");
    family(
        r, "claims_total", "counter",
        "Sessions claimed: without an owner, this daemon's own, of a dead daemon, or given by a living one.");
    for (int i = 0; i < LL_CLAIM_WHYS; i++)
        labelled(r, "claims_total", "why", ll_claim_whys[i], s->claims[i]);
    counter(r, "sessions_given_total", s->given, "Sessions given to other daemons.");
    counter(r, "replay_mismatch_total", s->mismatches,
            "Claimed sessions whose log leads to another state than they had.");
}

static void write_tasks(ll_http_response *r, ll_api *api, const ll_web_server_stats *d)
{
    ll_tasks_stats t = ll_tasks_get_stats(api->tasks);
    gauge(r, "control_requests", (double)d->control, "Short requests, waiting or running.");
    gauge(r, "control_longest_seconds", d->control_s, "Age of the oldest short request.");
    gauge(r, "tasks_running", (double)t.running, "Long requests and waking sessions that run now.");
    gauge(r, "tasks_waiting", (double)t.waiting, "Tasks that wait for their turn.");
    gauge(r, "tasks_longest_wait_seconds", t.longest_s, "Longest present wait of a task for its turn.");
    counter(r, "tasks_total", t.done, "Tasks finished or stopped.");
    counter(r, "tasks_ended_total", t.ended,
            "Tasks stopped before they were done: by budget, client, daemon or a cancellation.");
    counter(r, "tasks_refused_total", t.refused, "Tasks refused because too many were waiting.");
}

static void write_requests(ll_http_response *r, ll_api *api)
{
    static const char *const class[] = {"other", "1xx", "2xx", "3xx", "4xx", "5xx"};
    family(r, "http_requests_total", "counter", "Answered requests, by class of status.");
    for (int i = 1; i < 6; i++)
        labelled(r, "http_requests_total", "class", class[i], atomic_load(&api->answers[i]));
    uint64_t us = 0;
    for (int i = 0; i < 6; i++)
        us += atomic_load(&api->duration_us[i]);
    family(r, "http_request_seconds_total", "counter", "Total time of requests.");
    ll_http_printf(r, "laglab_http_request_seconds_total %.6f\n", (double)us * 1e-6);
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
    snprintf(response->type, sizeof response->type, "text/plain; version=0.0.4; charset=utf-8");
    family(response, "build_info", "gauge", "Version of the daemon.");
    labelled(response, "build_info", "version", ll_version, 1);
    gauge(response, "uptime_seconds", (double)(ll_host_now() - api->started) / 1e9, "Time since the start.");
    ll_memory_stats memory = ll_memory_get_stats();
    gauge(response, "heap_used_bytes", (double)memory.used, "Bytes of allocated blocks of memory.");
    gauge(response, "heap_kept_bytes", (double)memory.kept,
          "Bytes that the C library holds for blocks, free ones included.");
    write_sessions(response, &s);
    if (atomic_load(&api->phase) != LL_API_STARTING)
        gauge(response, "classes", (double)ll_classes_count(api->classes), "Open classes.");
    write_web_server(response, &d);
    write_requests(response, api);
    write_tasks(response, api, &d);
    write_refused(response, &s, &d);
    write_store(response, api);
    write_sharing(response, api, &s);
}

/* GET /metrics in Prometheus' text format. It names and lists no single session. */
#include <stdio.h>

#include "base/version.h"
#include "daemon/api/api.h"
#include "daemon/class/classes.h"
#include "daemon/jobs/experiments.h"
#include "daemon/support/access.h"
#include "daemon/support/memory.h"
#include "daemon/support/tasks.h"
#include "threads/clock.h"

/* ---- lines ---- */

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

/* A line of the family before it. */
static void labelled(ll_http_response *r, const char *name, const char *label, const char *value,
                     uint64_t number)
{
    ll_http_printf(r, "laglab_%s{%s=\"%s\"} %llu\n", name, label, value, (unsigned long long)number);
}

/* ---- the process and its port ---- */

static void write_process(ll_http_response *r, double uptime_s)
{
    ll_memory_stats memory = ll_memory_get_stats();
    family(r, "build_info", "gauge", "Version of the daemon.");
    labelled(r, "build_info", "version", ll_version, 1);
    gauge(r, "uptime_seconds", uptime_s, "Time since the start.");
    gauge(r, "heap_used_bytes", (double)memory.used, "Bytes of allocated blocks of memory.");
    gauge(r, "heap_kept_bytes", (double)memory.kept,
          "Bytes that the C library holds for blocks, free ones included.");
}

static void write_web_server(ll_http_response *r, const ll_web_server_stats *d)
{
    gauge(r, "connections", (double)d->connections, "Open connections of every kind.");
    counter(r, "connections_total", d->accepted, "Connections accepted.");
    gauge(r, "answer_bytes", (double)d->answer_bytes, "Bytes of large answers being sent.");
    counter(r, "bridged_total", d->bridged, "Streams opened on a kept connection, or with a query.");
    gauge(r, "viewers", (double)d->ws.viewers, "Viewers of streams.");
    counter(r, "viewers_total", d->ws.opened, "Viewers since the start.");
    gauge(r, "streams", (double)d->ws.streams, "Open streams.");
    counter(r, "frames_sent_total", d->ws.frames, "Frames sent to viewers.");
    counter(r, "frame_bytes_total", d->ws.bytes, "Bytes of frames sent to viewers.");
    counter(r, "frames_skipped_total", d->ws.skipped, "Frames skipped because the viewer was not ready.");
    counter(r, "frames_dropped_total", d->ws.dropped, "Frames dropped because a stream thread was late.");
    counter(r, "messages_received_total", d->ws.messages, "Messages of viewers, acknowledgements included.");
}

static void write_tasks(ll_http_response *r, const ll_tasks_stats *t, const ll_web_server_stats *d)
{
    gauge(r, "control_requests", (double)d->control, "Short requests, waiting or running.");
    gauge(r, "control_longest_seconds", d->control_s, "Age of the oldest short request.");
    gauge(r, "tasks_running", (double)t->running, "Long requests and waking sessions that run now.");
    gauge(r, "tasks_waiting", (double)t->waiting, "Tasks that wait for their turn.");
    gauge(r, "tasks_longest_wait_seconds", t->longest_s, "Longest present wait of a task for its turn.");
    counter(r, "tasks_total", t->done, "Tasks finished or stopped.");
    counter(r, "tasks_ended_total", t->ended,
            "Tasks stopped before they were done: by budget, client, daemon or a cancellation.");
    counter(r, "tasks_refused_total", t->refused, "Tasks refused because too many were waiting.");
}

static void write_answered(ll_http_response *r, ll_api *api)
{
    static const char *const class[] = {"other", "1xx", "2xx", "3xx", "4xx", "5xx"};
    family(r, "http_requests_total", "counter", "Answered requests, by class of status.");
    for (int i = 1; i < 6; i++)
        labelled(r, "http_requests_total", "class", class[i], atomic_load(&api->answered.count[i]));
    uint64_t us = 0;
    for (int i = 0; i < 6; i++)
        us += atomic_load(&api->answered.duration_us[i]);
    family(r, "http_request_seconds_total", "counter", "Total time of requests.");
    ll_http_printf(r, "laglab_http_request_seconds_total %.6f\n", (double)us * 1e-6);
}

/* ---- sessions, classes, the store ---- */

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
    const struct {
        const char *limit;
        uint64_t count;
    } lines[] = {{"sessions", s->refused_sessions},
                 {"new_sessions_per_min", s->refused_creations},
                 {"code_lookups_per_min", s->refused_lookups},
                 {"commands_per_s", s->refused_commands},
                 {"store", s->refused_store},
                 {"memory", s->refused_memory},
                 {"log_mib", s->refused_logs},
                 {"answers_mib", d->refused_answers},
                 {"connections", d->refused_total},
                 {"connections_per_ip", d->refused_per_ip},
                 {"head", d->refused_head},
                 {"slow_request", d->cut},
                 {"slow_viewer", d->ws.closed_slow},
                 {"viewer_policy", d->ws.closed_policy}};
    family(r, "refused_total", "counter", "Refusals, by limit.");
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        labelled(r, "refused_total", "limit", lines[i].limit, lines[i].count);
}

static void write_store(ll_http_response *r, ll_api *api)
{
    ll_store_stats store = ll_store_get_stats(api->store);
    int64_t commits = 0;
    gauge(r, "store_queue", (double)store.queued, "Records waiting to be stored.");
    counter(r, "store_commits_total", (uint64_t)store.commits, "Commits of the database.");
    counter(r, "store_failures_total", (uint64_t)store.failures, "Failed commits, which are retried.");
    gauge(r, "store_failing",
          ll_store_failing(api->store, NULL) ||
              ll_result_store_failing(ll_experiments_store(api->experiments), NULL),
          "1 while the store of sessions and classes, or that of experiments, fails.");
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
        family(r, uses[use].name, "gauge", uses[use].help);
        for (int i = 0; i < count; i++) {
            int64_t used = atomic_load(&keys[i].used[use]);
            labelled(r, uses[use].name, "name", keys[i].name, used > 0 ? (uint64_t)used : 0);
        }
    }
    family(r, "class_key_refused_total", "counter", "Requests that a quota of the class key refused here.");
    for (int i = 0; i < count; i++)
        labelled(r, "class_key_refused_total", "name", keys[i].name, atomic_load(&keys[i].refused));
}

void ll_get_prometheus(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_admits_inside(api, request, response))
        return;
    ll_web_server *web_server = atomic_load(&api->web_server);
    ll_web_server_stats d = {0};
    if (web_server)
        d = ll_web_server_get_stats(web_server);
    ll_host_stats s = ll_host_get_stats(api->host);
    ll_tasks_stats tasks = ll_tasks_get_stats(api->tasks);
    snprintf(response->type, sizeof response->type, "text/plain; version=0.0.4; charset=utf-8");
    write_process(response, (double)(ll_now_ns() - api->started) / 1e9);
    write_sessions(response, &s);
    if (atomic_load(&api->phase) != LL_API_STARTING)
        gauge(response, "classes", (double)ll_classes_count(api->classes), "Open classes.");
    write_web_server(response, &d);
    write_answered(response, api);
    write_tasks(response, &tasks, &d);
    write_refused(response, &s, &d);
    write_keys(response, api);
    write_store(response, api);
}

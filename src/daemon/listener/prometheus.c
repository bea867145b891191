#include "daemon/listener/prometheus.h"

#include <stdio.h>

#include "base/version.h"
#include "daemon/support/memory.h"

void ll_prometheus_family(ll_http_response *r, const char *name, const char *type, const char *help)
{
    ll_http_printf(r, "# HELP laglab_%s %s\n# TYPE laglab_%s %s\n", name, help, name, type);
}

void ll_prometheus_gauge(ll_http_response *r, const char *name, double value, const char *help)
{
    ll_prometheus_family(r, name, "gauge", help);
    ll_http_printf(r, "laglab_%s %.17g\n", name, value);
}

void ll_prometheus_counter(ll_http_response *r, const char *name, uint64_t value, const char *help)
{
    ll_prometheus_family(r, name, "counter", help);
    ll_http_printf(r, "laglab_%s %llu\n", name, (unsigned long long)value);
}

void ll_prometheus_labelled(ll_http_response *r, const char *name, const char *label, const char *value,
                            uint64_t number)
{
    ll_http_printf(r, "laglab_%s{%s=\"%s\"} %llu\n", name, label, value, (unsigned long long)number);
}

void ll_prometheus_begin(ll_http_response *r)
{
    snprintf(r->type, sizeof r->type, "text/plain; version=0.0.4; charset=utf-8");
}

void ll_prometheus_process(ll_http_response *r, double uptime_s)
{
    ll_memory_stats memory = ll_memory_get_stats();
    ll_prometheus_family(r, "build_info", "gauge", "Version of the daemon.");
    ll_prometheus_labelled(r, "build_info", "version", ll_version, 1);
    ll_prometheus_gauge(r, "uptime_seconds", uptime_s, "Time since the start.");
    ll_prometheus_gauge(r, "heap_used_bytes", (double)memory.used, "Bytes of allocated blocks of memory.");
    ll_prometheus_gauge(r, "heap_kept_bytes", (double)memory.kept,
                        "Bytes that the C library holds for blocks, free ones included.");
}

void ll_prometheus_refused(ll_http_response *r, const ll_web_server_stats *d)
{
    const struct {
        const char *limit;
        uint64_t count;
    } lines[] = {{"answers_mib", d->refused_answers},
                 {"connections", d->refused_total},
                 {"connections_per_ip", d->refused_per_ip},
                 {"head", d->refused_head},
                 {"slow_request", d->cut},
                 {"slow_viewer", d->ws.closed_slow},
                 {"viewer_policy", d->ws.closed_policy}};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        ll_prometheus_labelled(r, "refused_total", "limit", lines[i].limit, lines[i].count);
}

void ll_prometheus_web_server(ll_http_response *r, const ll_web_server_stats *d)
{
    ll_prometheus_gauge(r, "connections", (double)d->connections, "Open connections of every kind.");
    ll_prometheus_counter(r, "connections_total", d->accepted, "Connections accepted.");
    ll_prometheus_gauge(r, "answer_bytes", (double)d->answer_bytes, "Bytes of large answers being sent.");
    ll_prometheus_counter(r, "bridged_total", d->bridged, "Streams opened on a kept connection.");
    ll_prometheus_gauge(r, "viewers", (double)d->ws.viewers, "Viewers of streams.");
    ll_prometheus_counter(r, "viewers_total", d->ws.opened, "Viewers since the start.");
    ll_prometheus_gauge(r, "streams", (double)d->ws.streams, "Open streams.");
    ll_prometheus_counter(r, "frames_sent_total", d->ws.frames, "Frames sent to viewers.");
    ll_prometheus_counter(r, "frame_bytes_total", d->ws.bytes, "Bytes of frames sent to viewers.");
    ll_prometheus_counter(r, "frames_skipped_total", d->ws.skipped,
                          "Frames skipped because the viewer was not ready.");
    ll_prometheus_counter(r, "frames_dropped_total", d->ws.dropped,
                          "Frames dropped because a stream thread was late.");
    ll_prometheus_counter(r, "messages_received_total", d->ws.messages,
                          "Messages of viewers, acknowledgements included.");
}

void ll_prometheus_tasks(ll_http_response *r, const ll_tasks_stats *t, const ll_web_server_stats *d)
{
    ll_prometheus_gauge(r, "control_requests", (double)d->control, "Short requests, waiting or running.");
    ll_prometheus_gauge(r, "control_longest_seconds", d->control_s, "Age of the oldest short request.");
    ll_prometheus_gauge(r, "tasks_running", (double)t->running,
                        "Long requests and waking sessions that run now.");
    ll_prometheus_gauge(r, "tasks_waiting", (double)t->waiting, "Tasks that wait for their turn.");
    ll_prometheus_gauge(r, "tasks_longest_wait_seconds", t->longest_s,
                        "Longest present wait of a task for its turn.");
    ll_prometheus_counter(r, "tasks_total", t->done, "Tasks finished or stopped.");
    ll_prometheus_counter(
        r, "tasks_ended_total", t->ended,
        "Tasks stopped before they were done: by budget, client, daemon or a cancellation.");
    ll_prometheus_counter(r, "tasks_refused_total", t->refused,
                          "Tasks refused because too many were waiting.");
}

void ll_prometheus_answered(ll_http_response *r, ll_answered *answered)
{
    static const char *const class[] = {"other", "1xx", "2xx", "3xx", "4xx", "5xx"};
    ll_prometheus_family(r, "http_requests_total", "counter", "Answered requests, by class of status.");
    for (int i = 1; i < 6; i++)
        ll_prometheus_labelled(r, "http_requests_total", "class", class[i],
                               atomic_load(&answered->answers[i]));
    uint64_t us = 0;
    for (int i = 0; i < 6; i++)
        us += atomic_load(&answered->duration_us[i]);
    ll_prometheus_family(r, "http_request_seconds_total", "counter", "Total time of requests.");
    ll_http_printf(r, "laglab_http_request_seconds_total %.6f\n", (double)us * 1e-6);
}

void ll_answered_count(ll_answered *answered, int status, double seconds)
{
    int class = status >= 100 && status < 600 ? status / 100 : 0;
    atomic_fetch_add_explicit(&answered->answers[class], 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&answered->duration_us[class], (uint64_t)(seconds * 1e6), memory_order_relaxed);
}

/* GET /metrics in Prometheus' text format: its lines, and what every process with a web server says. */
#pragma once

#include <stdatomic.h>

#include "daemon/http/http.h"
#include "daemon/listener/web_server.h"
#include "daemon/support/tasks.h"

void ll_prometheus_begin(ll_http_response *r);
void ll_prometheus_family(ll_http_response *r, const char *name, const char *type, const char *help);
void ll_prometheus_gauge(ll_http_response *r, const char *name, double value, const char *help);
void ll_prometheus_counter(ll_http_response *r, const char *name, uint64_t value, const char *help);
/* A line of the family before it. */
void ll_prometheus_labelled(ll_http_response *r, const char *name, const char *label, const char *value,
                            uint64_t number);

/* Version, time since the start, memory. */
void ll_prometheus_process(ll_http_response *r, double uptime_s);
void ll_prometheus_web_server(ll_http_response *r, const ll_web_server_stats *stats);
void ll_prometheus_refused(ll_http_response *r,
                           const ll_web_server_stats *stats); /* lines of refused_total */
void ll_prometheus_tasks(ll_http_response *r, const ll_tasks_stats *tasks, const ll_web_server_stats *stats);

/* Answered requests, by class of status: 1xx .. 5xx; 0: any other. */
typedef struct ll_answered {
    _Atomic uint64_t answers[6], duration_us[6]; /* durations: sums */
} ll_answered;

void ll_answered_count(ll_answered *answered, int status, double seconds);
void ll_prometheus_answered(ll_http_response *r, ll_answered *answered);

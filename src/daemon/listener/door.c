#include "daemon/listener/door.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "daemon/listener/acceptor.h"
#include "daemon/net/gate.h"
#include "daemon/net/proxies.h"
#include "daemon/net/upgrade.h"

#define TEXT(name_, default_, help_)                                                                         \
    {                                                                                                        \
        .name = #name_, .type = LL_PARAM_TEXT, .offset = offsetof(ll_door_config, name_),                    \
        .max = sizeof(((ll_door_config *)0)->name_) - 1, .text = default_, .help = help_                     \
    }
#define COUNT(name_, min_, max_, default_, unit_, help_)                                                     \
    {                                                                                                        \
        .name = #name_, .type = LL_PARAM_INT, .offset = offsetof(ll_door_config, name_), .min = min_,        \
        .max = max_, .standard = default_, .unit = unit_, .help = help_                                      \
    }
#define REAL(name_, min_, max_, default_, unit_, help_)                                                      \
    {                                                                                                        \
        .name = #name_, .type = LL_PARAM_REAL, .offset = offsetof(ll_door_config, name_), .min = min_,       \
        .max = max_, .standard = default_, .unit = unit_, .help = help_                                      \
    }

static const ll_param rows[] = {
    TEXT(listen, "127.0.0.1:8080", "Address and port, ADDR:PORT or [ADDR6]:PORT; port 0 picks a free one."),
    TEXT(www, "", "Folder of the page; empty serves none."),
    TEXT(allow_origin, "", "Origins beside the daemon's own whose pages may use it, comma separated."),
    TEXT(allow_host, "",
         "Host names beside localhost and addresses under which the daemon may be reached, comma separated."),
    TEXT(trusted_proxy, "",
         "Addresses or networks of proxies that say by X-Forwarded-For whom they speak for, comma separated; "
         "each client then has its own limits."),
    COUNT(http_threads, 1, 16, 2, NULL, "Threads that read requests and run fast handlers."),
    COUNT(control_threads, 1, 64, 4, NULL,
          "Threads for requests that are short but wait until their change is stored."),
    REAL(
        request_cpu_s, 0.01, 86400, 20, "s",
        "Processor time that one request may use; then it is answered with a 503 that says how far it came."),
    COUNT(stream_threads, 1, 16, 1, NULL, "Threads that send frames; a session's viewers share one."),
    COUNT(max_connections, 16, 30000, 4096, NULL, "Connections at once, of every kind; more get a 503."),
    COUNT(max_connections_per_ip, 4, 30000, 2048, NULL,
          "Connections at once of one address; more get a 429."),
    COUNT(max_viewers, 1, 30000, 1000, NULL, "Viewers of one session; more are closed with 4429."),
    COUNT(max_head_bytes, 1024, 65536, 16384, "B", "Size of a request head; more is a 431."),
    COUNT(max_answers_mib, 1, 1048576, 256, "MiB",
          "Large answers (above 64 KiB) in memory at once, until they are sent; more get a 503."),
    REAL(head_timeout_s, 0.1, 60, 5, "s", "Time for a whole request head; longer is a 408."),
    REAL(body_timeout_s, 0.1, 600, 30, "s", "Time for a whole request body; then the connection is cut."),
    REAL(idle_timeout_s, 0.1, 3600, 65, "s", "Time between two requests of a connection; then it is closed."),
    REAL(response_timeout_s, 1, 3600, 300, "s",
         "Time for a client to take a whole response; then the connection is cut."),
    COUNT(max_message_bytes, 256, 1048576, 65536, "B",
          "Size of a viewer's message; more is closed with 1009."),
    REAL(max_messages_per_s, 1, 100000, 300, "1/s",
         "Messages of one viewer, acks included, twice that in a burst; more is closed with 1008."),
    REAL(hello_timeout_s, 0.1, 600, 20, "s",
         "Time for a session to greet a viewer; then it is closed with 1013."),
    REAL(ack_timeout_s, 0.1, 600, 5, "s",
         "Time for a viewer that acknowledges to go on doing so; then it is closed with 1013."),
    REAL(drain_s, 0, 60, 3, "s", "Time for viewers to say goodbye when the daemon stops."),
};

const ll_param_table ll_door_table = {
    .name = "door",
    .help = "The one port of the daemon and its limits.",
    .rows = rows,
    .count = sizeof rows / sizeof *rows,
    .size = sizeof(ll_door_config),
};

struct ll_door {
    ll_door_config config;
    ll_allow allow; /* texts of `config` */
    ll_proxies proxies;
    ll_door_log *log;
    void *log_context;
    ll_gate *gate;
    ll_ws *ws;
    ll_http *http;
    ll_acceptor *acceptor;
    bool drained;
};

/* Not raised to what some containers give, a thousand million: libraries size tables by it. */
static void set_descriptor_limit(const ll_door_config *config)
{
    struct rlimit limit;
    rlim_t wanted = (rlim_t)config->max_connections + 1024;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) {
        return;
    }
    if (limit.rlim_cur < wanted || limit.rlim_cur > 1000000) {
        limit.rlim_cur = wanted < limit.rlim_max ? wanted : limit.rlim_max;
        setrlimit(RLIMIT_NOFILE, &limit);
    }
}

/* A socket that the service manager opened (sd_listen_fds(3)): descriptor 3, when it is meant for this
 * process. */
static int inherited_listener(void)
{
    const char *process = getenv("LISTEN_PID"), *count = getenv("LISTEN_FDS");
    bool meant =
        process != NULL && count != NULL && strtol(process, NULL, 10) == (long)getpid() && atoi(count) >= 1;
    return meant ? 3 : -1;
}

static ll_status start(ll_door *door, const ll_http_app *app, const ll_ws_hooks *hooks)
{
    const ll_door_config *config = &door->config;
    ll_status status = ll_proxies_parse(config->trusted_proxy, &door->proxies);
    if (ll_failed(&status)) {
        return status;
    }
    status = ll_acceptor_listen(config, inherited_listener(), &door->acceptor);
    if (ll_failed(&status)) {
        return status;
    }
    door->gate = ll_gate_new((int)config->max_connections, (int)config->max_connections_per_ip);
    if (door->gate == NULL) {
        return ll_error(LL_NO_MEMORY, "no memory for %d connections", (int)config->max_connections);
    }
    status = ll_ws_start(config, hooks, door->gate, &door->ws);
    if (ll_failed(&status)) {
        return status;
    }
    status = ll_http_start(config, app, &door->allow, &door->proxies, door->gate, door->ws, &door->http);
    if (ll_failed(&status)) {
        return status;
    }
    return ll_acceptor_start(door->acceptor, &door->allow, &door->proxies, door->gate, door->http, door->ws);
}

ll_status ll_door_open(const ll_door_config *config, const ll_http_app *app, const ll_ws_hooks *hooks,
                       ll_door_log *log, void *log_context, ll_door **result)
{
    ll_door *door = calloc(1, sizeof *door);
    if (door == NULL) {
        return ll_error(LL_NO_MEMORY, "no memory for the front door");
    }
    door->config = *config;
    door->allow = (ll_allow){.hosts = door->config.allow_host, .origins = door->config.allow_origin};
    door->log = log;
    door->log_context = log_context;
    set_descriptor_limit(config);
    ll_status status = start(door, app, hooks);
    if (ll_failed(&status)) {
        ll_door_close(door);
        return status;
    }
    if (log != NULL) {
        log(log_context, "info", "the front door is open");
    }
    *result = door;
    return status;
}

uint16_t ll_door_port(const ll_door *door)
{
    return ll_acceptor_port(door->acceptor);
}

const char *ll_door_address(const ll_door *door)
{
    return ll_acceptor_address(door->acceptor);
}

ll_ws *ll_door_ws(ll_door *door)
{
    return door->ws;
}

ll_door_stats ll_door_get_stats(ll_door *door)
{
    ll_acceptor_counts counts = ll_acceptor_get_counts(door->acceptor);
    ll_door_stats stats = {.accepted = counts.accepted,
                           .refused_total = counts.refused_total,
                           .refused_per_ip = counts.refused_per_ip,
                           .refused_head = counts.refused_head,
                           .connections = (uint64_t)ll_gate_count(door->gate),
                           .ws = ll_ws_get_stats(door->ws)};
    ll_http_counted counted = ll_http_counts(door->http);
    stats.requests = counted.requests;
    stats.cut = counted.cut;
    stats.bridged = counted.upgrades;
    stats.refused_answers = counted.refused_answers;
    stats.answer_bytes = counted.answer_bytes;
    stats.control = counted.control;
    stats.control_s = counted.control_s;
    return stats;
}

void ll_door_drain(ll_door *door)
{
    if (door->drained) {
        return;
    }
    door->drained = true;
    if (door->acceptor != NULL) {
        ll_acceptor_close_listener(door->acceptor);
    }
    if (door->ws != NULL) {
        ll_ws_drain(door->ws, door->config.drain_s);
    }
    if (door->log != NULL) {
        door->log(door->log_context, "info", "the front door is closed; viewers have left");
    }
}

void ll_door_close(ll_door *door)
{
    if (door == NULL) {
        return;
    }
    ll_door_drain(door);
    /* Its thread watches HTTP connections; nothing may arrive at a side that is gone. */
    if (door->acceptor != NULL) {
        ll_acceptor_stop(door->acceptor);
    }
    if (door->http != NULL) {
        ll_http_stop(door->http);
    }
    if (door->ws != NULL) {
        ll_ws_free(door->ws);
    }
    ll_gate_free(door->gate);
    free(door);
}

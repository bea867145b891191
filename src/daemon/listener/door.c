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

#include "daemon/listener/web_server.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "daemon/listener/acceptor.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/proxies.h"
#include "daemon/net/upgrade.h"
#include "daemon/support/log.h"

struct ll_web_server {
    ll_web_server_config config;
    ll_allow allow; /* points into `config` */
    ll_proxies proxies;
    ll_connection_limiter *connection_limiter;
    ll_ws *ws;
    ll_http *http;
    ll_acceptor *acceptor;
    bool drained;
};

/* A connection takes one descriptor; an upgrade on a kept one a second for a moment, a large answer one of
 * its file. Connections beyond the descriptors would wait without an answer: the limit comes first, with its
 * 503. The process gets what it needs and not the maximum, which is 10^9 in some containers: libraries size
 * tables by it, libwebsockets 16 bytes a descriptor for each stream thread. */
static void fit_descriptors(ll_web_server_config *config)
{
    struct rlimit limit;
    int64_t wanted = config->max_connections, needed = wanted + wanted / 4 + 64;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0)
        return;
    rlim_t ample = (rlim_t)needed + 1024;
    limit.rlim_cur = ample < limit.rlim_max ? ample : limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
    if (limit.rlim_cur >= (rlim_t)needed)
        return;
    config->max_connections = limit.rlim_cur > 84 ? ((int64_t)limit.rlim_cur - 64) * 4 / 5 : 16;
    ll_log_write(
        "warn", "descriptors",
        "%lld descriptors (ulimit -n) are too few for %lld connections (--max-connections): %lld are "
        "needed. At most %lld connections are accepted, more get a 503.",
        (long long)limit.rlim_cur, (long long)wanted, (long long)needed, (long long)config->max_connections);
}

/* A socket that the service manager opened (sd_listen_fds(3)): descriptor 3, if LISTEN_PID names this
 * process. */
static int inherited_listener(void)
{
    const char *process = getenv("LISTEN_PID"), *count = getenv("LISTEN_FDS");
    bool meant =
        process != NULL && count != NULL && strtol(process, NULL, 10) == (long)getpid() && atoi(count) >= 1;
    return meant ? 3 : -1;
}

static ll_status start(ll_web_server *web_server, const ll_http_app *app)
{
    const ll_web_server_config *config = &web_server->config;
    ll_status status = ll_proxies_parse(config->trusted_proxy, &web_server->proxies);
    if (ll_failed(&status))
        return status;
    status = ll_acceptor_listen(config, inherited_listener(), &web_server->acceptor);
    if (ll_failed(&status))
        return status;
    web_server->connection_limiter =
        ll_connection_limiter_new((int)config->max_connections, (int)config->max_connections_per_ip);
    if (web_server->connection_limiter == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: %d connections", (int)config->max_connections);
    status = ll_ws_start(config, web_server->connection_limiter, &web_server->ws);
    if (ll_failed(&status))
        return status;
    status = ll_http_start(config, app, &web_server->allow, &web_server->proxies,
                           web_server->connection_limiter, web_server->ws, &web_server->http);
    if (ll_failed(&status))
        return status;
    return ll_acceptor_start(web_server->acceptor, &web_server->allow, &web_server->proxies,
                             web_server->connection_limiter, web_server->http, web_server->ws);
}

ll_status ll_web_server_open(const ll_web_server_config *config, const ll_http_app *app,
                             ll_web_server **result)
{
    ll_web_server *web_server = calloc(1, sizeof *web_server);
    if (web_server == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: web server");
    web_server->config = *config;
    web_server->allow =
        (ll_allow){.hosts = web_server->config.allow_host, .origins = web_server->config.allow_origin};
    fit_descriptors(&web_server->config);
    ll_status status = start(web_server, app);
    if (ll_failed(&status)) {
        ll_web_server_close(web_server);
        return status;
    }
    ll_log_write("info", "web server", "web server started");
    *result = web_server;
    return status;
}

uint16_t ll_web_server_port(const ll_web_server *web_server)
{
    return ll_acceptor_port(web_server->acceptor);
}

const char *ll_web_server_address(const ll_web_server *web_server)
{
    return ll_acceptor_address(web_server->acceptor);
}

ll_ws *ll_web_server_ws(ll_web_server *web_server)
{
    return web_server->ws;
}

ll_web_server_stats ll_web_server_get_stats(ll_web_server *web_server)
{
    ll_acceptor_counts counts = ll_acceptor_get_counts(web_server->acceptor);
    ll_web_server_stats stats = {.accepted = counts.accepted,
                                 .refused_total = counts.refused_total,
                                 .refused_per_ip = counts.refused_per_ip,
                                 .refused_head = counts.refused_head,
                                 .connections =
                                     (uint64_t)ll_connection_limiter_count(web_server->connection_limiter),
                                 .ws = ll_ws_get_stats(web_server->ws)};
    ll_http_counted counted = ll_http_counts(web_server->http);
    stats.requests = counted.requests;
    stats.cut = counted.cut;
    stats.bridged = counted.upgrades;
    stats.refused_answers = counted.refused_answers;
    stats.answer_bytes = counted.answer_bytes;
    stats.control = counted.control;
    stats.control_s = counted.control_s;
    stats.stalled_s = counted.stalled_s;
    return stats;
}

void ll_web_server_drain(ll_web_server *web_server)
{
    if (web_server->drained)
        return;
    web_server->drained = true;
    if (web_server->acceptor != NULL)
        ll_acceptor_close_listener(web_server->acceptor);
    if (web_server->ws != NULL)
        ll_ws_drain(web_server->ws, web_server->config.drain_s);
    ll_log_write("info", "web server", "web server stopped accepting; viewers have left");
}

void ll_web_server_close(ll_web_server *web_server)
{
    if (web_server == NULL)
        return;
    ll_web_server_drain(web_server);
    /* Its thread watches HTTP connections, and must not hand one over to a part that is stopped. */
    if (web_server->acceptor != NULL)
        ll_acceptor_stop(web_server->acceptor);
    if (web_server->http != NULL)
        ll_http_stop(web_server->http);
    if (web_server->ws != NULL)
        ll_ws_free(web_server->ws);
    ll_connection_limiter_free(web_server->connection_limiter);
    free(web_server);
}

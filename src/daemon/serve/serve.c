#include "daemon/serve/serve.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "daemon/api/api.h"
#include "daemon/class/classes.h"
#include "daemon/hosting/host.h"
#include "daemon/jobs/experiments.h"
#include "daemon/listener/web_server.h"
#include "daemon/support/access.h"
#include "daemon/support/log.h"
#include "daemon/support/memory.h"
#include "daemon/support/tasks.h"
#include "library/program.h"

#define FORCED_EXIT_S 0.7 /* after the time that viewers have to close */

typedef struct daemon_parts {
    ll_web_server_config web_server_config;
    ll_host_config host_config;
    ll_access_config access_config;
    ll_classes_config classes_config;
    ll_access access;
    ll_store *store;
    ll_tasks *tasks;
    ll_host *host;
    ll_experiments *experiments;
    ll_api api;
    ll_web_server *web_server;
    sigset_t signals;
    atomic_flag saving; /* set by the first that ends the process: stop() or the forced exit */
} daemon_parts;

/* ---- the process ---- */

/* Those that end it. */
static void ending_signals(sigset_t *signals)
{
    sigemptyset(signals);
    sigaddset(signals, SIGTERM);
    sigaddset(signals, SIGINT);
    sigaddset(signals, SIGHUP);
}

/* Before the first thread, which inherits what is blocked: `signals` gets the ending ones, which main waits
 * for. */
static void prepare_process(sigset_t *signals)
{
    ll_memory_prepare();
    umask(077); /* a session's id permits reading it, so files are readable by their owner only */
    signal(SIGPIPE, SIG_IGN);
    /* A file that may not grow is reported as an error of the store, like a full disk. */
    signal(SIGXFSZ, SIG_IGN);
    ending_signals(signals);
    pthread_sigmask(SIG_BLOCK, signals, NULL);
}

static const char *signal_name(int ending)
{
    return ending == SIGTERM ? "SIGTERM" : ending == SIGINT ? "SIGINT" : "SIGHUP";
}

static int print_error(const ll_status *status, int exit_status)
{
    fprintf(stderr, "laglab: %s\n", status->text);
    return exit_status;
}

/* ---- before the start ---- */

/* Default: the folder `name` next to the program. */
static void default_folder(char *folder, size_t size, const char *name)
{
    if (!folder[0])
        ll_program_sibling(name, folder, size);
}

static bool default_data(char *folder, size_t size)
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    int written = -1;
    if (state && state[0] == '/')
        written = snprintf(folder, size, "%s/laglab", state);
    else if (home && home[0] == '/')
        written = snprintf(folder, size, "%s/.local/state/laglab", home);
    return written > 0 && (size_t)written < size;
}

/* A folder that was given must work; the default one may be missing. */
static ll_status open_store(daemon_parts *d)
{
    char *folder = d->host_config.data;
    if (strcmp(folder, "memory") == 0) {
        ll_log_write("info", "no store", "Sessions are kept in memory only.");
        return ll_ok();
    }
    bool asked = folder[0] != '\0';
    if (!asked && !default_data(folder, sizeof d->host_config.data)) {
        ll_log_write("warn", "no store",
                     "Sessions are kept in memory only: no --data and no home directory.");
        return ll_ok();
    }
    ll_status status = ll_store_open(folder, &d->store);
    if (ll_failed(&status) && !asked) {
        ll_log_write("warn", "no store", "Sessions are kept in memory only: %s", status.text);
        return ll_ok();
    }
    return status;
}

/* ---- running ---- */

/* An operator who has exchanged name and key sees it. */
static void log_class_keys(const ll_class_keys *keys)
{
    char names[1000];
    ll_class_keys_list(keys, names, sizeof names);
    if (names[0])
        ll_log_write("info", "class keys", "%s", names);
}

static ll_status start(daemon_parts *d)
{
    LL_TRY(ll_shard_check(d->host_config.shard));
    ll_status status = ll_access_open(&d->access_config, &d->access);
    if (!ll_failed(&status))
        log_class_keys(&d->access.class_keys);
    d->host_config.access = &d->access;
    LL_THEN(status, open_store(d));
    if (!ll_failed(&status) && d->store)
        setenv("TMPDIR", d->host_config.data, 1); /* it may be the only writable folder */
    LL_THEN(status, ll_tasks_start((int)d->host_config.work_threads, &d->tasks));
    LL_THEN(status, ll_host_create(&d->host_config, d->store, d->tasks, &d->host));
    LL_THEN(status,
            ll_experiments_open(d->store ? d->host_config.data : NULL, &d->host_config, &d->experiments));
    LL_THEN(status, ll_api_init(&d->api, d->host, d->store, d->experiments, d->tasks));
    LL_THEN(status, ll_api_describe(&d->api, d->web_server_config.www));
    if (ll_failed(&status))
        return status;
    ll_http_app app = {
        .routes = d->api.routes,
        .route_count = d->api.route_count,
        .context = &d->api,
        .started = ll_api_started,
        .shard = d->host_config.shard,
        .documents = &d->api.documents,
        .tasks = d->tasks,
        .done = ll_api_done,
    };
    LL_TRY(ll_web_server_open(&d->web_server_config, &app, &d->web_server));
    atomic_store(&d->api.web_server, d->web_server);
    status = ll_experiments_open_streams(d->experiments, ll_web_server_ws(d->web_server));
    LL_THEN(status, ll_host_start(d->host, ll_web_server_ws(d->web_server)));
    if (!ll_failed(&status))
        status = ll_classes_start(&d->classes_config, d->host, d->store, d->tasks,
                                  ll_web_server_ws(d->web_server), &d->api.classes);
    if (!ll_failed(&status))
        atomic_store(&d->api.phase, LL_API_READY);
    return status;
}

/* A second signal exits at once. Everything that was acknowledged is stored. */
static void *exit_at_once(void *argument)
{
    (void)argument;
    sigset_t signals;
    int got;
    ending_signals(&signals);
    sigwait(&signals, &got);
    _exit(1);
}

/* Exits in time when something cannot be interrupted, as a tick of many seconds. Everything that was
 * acknowledged is stored, and also all clocks, except those of sessions that are locked. */
static void *end_in_time(void *argument)
{
    daemon_parts *d = argument;
    double left = d->web_server_config.drain_s + FORCED_EXIT_S;
    struct timespec wait = {(time_t)left, (long)((left - floor(left)) * 1e9)};
    nanosleep(&wait, NULL);
    if (atomic_flag_test_and_set(&d->saving))
        return NULL; /* the other one has begun */
    ll_log_write("warn", "stopping", "Forced exit: some work cannot be interrupted.");
    /* The store stays open: other threads may still use it. */
    ll_status status = ll_store_wait(d->store, ll_host_save(d->host, false));
    if (ll_failed(&status))
        ll_log_write("error", "not everything was stored", "%s", status.text);
    _exit(ll_failed(&status));
}

static void wait_for_end(daemon_parts *d)
{
    int got = 0;
    sigwait(&d->signals, &got);
    atomic_store(&d->api.phase, LL_API_DRAINING);
    ll_log_write("info", "stopping", "Signal: %s.", signal_name(got));
    pthread_t impatient;
    if (pthread_create(&impatient, NULL, exit_at_once, NULL) == 0)
        pthread_detach(impatient);
    if (pthread_create(&impatient, NULL, end_in_time, d) == 0)
        pthread_detach(impatient);
}

/* Stops in the reverse order of the start; also after a failed start. */
static ll_status stop(daemon_parts *d)
{
    if (d->tasks)
        ll_tasks_drain(d->tasks);
    ll_experiments_request_stop(d->experiments);
    if (d->web_server)
        ll_web_server_drain(d->web_server);
    if (d->host)
        ll_host_stop(d->host);
    ll_classes_stop(d->api.classes);
    ll_experiments_stop(d->experiments);
    ll_web_server_close(d->web_server);
    ll_tasks_free(d->tasks);
    ll_experiments_close(d->experiments);
    if (atomic_flag_test_and_set(&d->saving))
        pause(); /* the forced exit came first, and ends the process */
    if (d->host)
        ll_host_save(d->host, true);
    ll_status status = ll_store_close(d->store);
    ll_classes_free(d->api.classes); /* both after the store, whose thread uses them */
    ll_host_free(d->host);
    ll_api_end(&d->api);
    return status;
}

int ll_serve(const ll_serve_config *config)
{
    daemon_parts *d = calloc(1, sizeof *d);
    if (!d)
        return 1;
    d->web_server_config = config->web_server;
    d->host_config = config->host;
    d->access_config = config->access;
    d->classes_config = config->classes;
    default_folder(d->web_server_config.www, sizeof d->web_server_config.www, "www");
    default_folder(d->host_config.scenarios, sizeof d->host_config.scenarios, "scenarios");
    default_folder(d->host_config.api, sizeof d->host_config.api, "api");
    prepare_process(&d->signals);
    ll_status status = start(d);
    if (ll_failed(&status)) {
        stop(d);
        ll_access_close(&d->access);
        free(d);
        return print_error(&status, status.code == LL_BAD_INPUT ? 2 : 1);
    }
    printf("laglab listening on http://%s/\n", ll_web_server_address(d->web_server));
    fflush(stdout);
    wait_for_end(d);
    status = stop(d);
    ll_access_close(&d->access);
    free(d);
    if (ll_failed(&status)) {
        ll_log_write("error", "not everything was stored",
                     "%s What was acknowledged is stored; clocks are where they were before.", status.text);
        return 1;
    }
    return 0;
}

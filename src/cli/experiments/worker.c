/* `laglab worker`: works on the experiments of a store that other machines may share. The only process that a
 * cluster's machines need to run. */
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "cli/arguments.h"
#include "cli/verbs.h"
#include "experiment/run/work.h"

enum { LEASE_S = 60, LOOKS = 100 };

typedef struct worker {
    const char *store_url, *id, *jobs, *lease;
    bool drain;
    int64_t threads, lease_s;
    ll_result_store *store;
} worker;

static ll_status parse(worker *w, int argc, char **argv)
{
    const ll_option options[] = {
        {"--store", "URL",
         "Store of the experiments: sqlite:FILE, or postgresql://USER@HOST/DATABASE; default: $LAGLAB_STORE.",
         .value = &w->store_url},
        {"--experiment", "ID", "Only this experiment; default: all running ones.", .value = &w->id},
        {"--drain", .help = "End when no work is left; default: wait for more.", .flag = &w->drain},
        {"--jobs", "N", "Threads, 1 to 256; default: one per core.", .value = &w->jobs},
        {"--lease-s", "N", "Seconds after which other workers may take over an unfinished chunk, 60.",
         .value = &w->lease},
        {0}};
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    w->threads = ll_cores();
    w->lease_s = LEASE_S;
    ll_status status = ll_arguments(
        "worker [OPTION]...: work on the experiments of a store, together with workers on other machines",
        argc, argv, options, positional, &count);
    if (!ll_failed(&status) && count > 0)
        status = ll_error(LL_BAD_INPUT, "unexpected argument %.100s", positional[0]);
    w->store_url = ll_result_store_url(w->store_url);
    if (!ll_failed(&status) && !w->store_url)
        status = ll_error(LL_BAD_INPUT, "--store: required, or set LAGLAB_STORE");
    if (!ll_failed(&status) && w->jobs)
        status = ll_argument_whole("--jobs", w->jobs, 1, 256, &w->threads);
    if (!ll_failed(&status) && w->lease)
        status = ll_argument_whole("--lease-s", w->lease, 1, LL_LEASE_MAX_S, &w->lease_s);
    return status;
}

/* Reports experiments of other versions, which wait for workers of their version, as they appear. */
static void report_versions(const worker *w, ll_status *reported)
{
    ll_status status = w->id ? ll_ok() : ll_result_store_check_versions(w->store);
    if (status.code != LL_CONFLICT || strcmp(status.text, reported->text) == 0)
        return;
    *reported = status;
    fprintf(stderr, "laglab: %s\n", status.text);
}

/* After the first signal the threads return their chunks, the second one ends the process at once. */
static void wait_for_end(const worker *w, ll_workers *workers, sigset_t *signals)
{
    const struct timespec check_store = {.tv_nsec = 100000000};
    ll_status reported = ll_ok();
    bool ending = false;
    for (int k = 0; !ending && ll_workers_busy(workers); k++) {
        if (!w->drain && k % LOOKS == 0)
            report_versions(w, &reported);
        ending = sigtimedwait(signals, NULL, &check_store) > 0;
    }
    if (!ending)
        return;
    pthread_sigmask(SIG_UNBLOCK, signals, NULL);
    ll_workers_request_stop(workers);
    while (ll_workers_busy(workers))
        nanosleep(&check_store, NULL);
}

static ll_status work(const worker *w)
{
    sigset_t signals;
    ll_workers *workers;
    ll_workers_config config = {.store = w->store,
                                .id = w->id,
                                .threads = (int)w->threads,
                                .lease_s = (double)w->lease_s,
                                .drain = w->drain};
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals, NULL); /* before threads are made, which inherit it */
    LL_TRY(ll_workers_start(&config, &workers));
    wait_for_end(w, workers, &signals);
    printf("{\"runs\":%" PRId64 "}\n", ll_workers_runs(workers));
    return ll_workers_join(workers);
}

/* Reports a missing experiment, one of another version, or one with a failed chunk. */
static ll_status check_store(const worker *w)
{
    ll_experiment_record record;
    if (!w->id)
        return ll_ok();
    ll_status status = w->store->kind->record(w->store, w->id, &record);
    LL_THEN(status, ll_result_store_check_version(w->store, &record));
    if (!ll_failed(&status) && record.state == LL_EXPERIMENT_FAILED)
        status =
            ll_error(LL_IO, "experiment %s failed: %d workers lost the same chunk", w->id, LL_ATTEMPTS_MAX);
    return status;
}

int ll_verb_worker(int argc, char **argv)
{
    worker w = {0};
    signal(SIGXFSZ,
           SIG_IGN); /* a file that may not grow is reported as an error of the store, like a full disk */
    ll_status status = parse(&w, argc, argv);
    LL_THEN(status, ll_result_store_open(w.store_url, &w.store));
    LL_THEN(status, check_store(&w));
    LL_THEN(status, work(&w));
    LL_THEN(status, check_store(&w));
    if (!ll_failed(&status) && w.drain && !w.id) /* work is left that it may not do */
        status = ll_result_store_check_versions(w.store);
    ll_result_store_close(w.store);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}

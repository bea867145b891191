/* `laglab sweep`: runs an experiment on this machine, and resumes an interrupted one. */
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli/arguments.h"
#include "cli/experiments/results.h"
#include "cli/input.h"
#include "cli/verbs.h"
#include "experiment/run/traces.h"
#include "experiment/run/work.h"
#include "experiment/spec/shard.h"
#include "experiment/spec/until.h"
#include "threads/clock.h"

typedef struct sweep {
    ll_results results;
    const char *jobs, *shard, *scenarios, *traces;
    bool dry_run, anew;
    ll_experiment *experiment;
    ll_result_store *store;
    char id[LL_EXPERIMENT_ID_MAX + 1];
    char own_store[4096]; /* next to the output, deleted when that is written; empty: in memory */
    int64_t threads, from, to;
} sweep;

/* ---- before ---- */

/* Runs the first run to estimate the time of all. */
static ll_status dry_run(const sweep *s)
{
    ll_row row;
    int64_t begun = ll_thread_cpu_ns();
    LL_TRY(ll_experiment_run(s->experiment, s->from, NULL, NULL, &row));
    double run_s = (double)(ll_thread_cpu_ns() - begun) * 1e-9;
    printf("{\"points\":%" PRId64 ",\"repeats\":%" PRId64 ",\"runs\":%" PRId64
           ",\"run_s\":%.3g,\"threads\":%" PRId64 ",\"estimated_s\":%.3g}\n",
           s->experiment->points, s->experiment->head.repeats, s->to - s->from, run_s, s->threads,
           run_s * (double)(s->to - s->from) / (double)s->threads);
    return ll_ok();
}

static ll_status open_store(sweep *s)
{
    if (s->results.out)
        snprintf(s->own_store, sizeof s->own_store, "%s.runs", s->results.out);
    ll_status status = ll_result_store_open(s->results.out ? s->own_store : ":memory:", &s->store);
    if (!ll_failed(&status) && !s->anew)
        status = ll_experiment_check_version(s->store, s->experiment, s->from, s->to);
    LL_THEN(status, ll_experiment_register(s->store, s->experiment, s->from, s->to, s->id));
    return status;
}

/* ---- running ---- */

static void show_bar(const sweep *s, int64_t done, double elapsed, int64_t here)
{
    enum { WIDTH = 30 };
    int64_t all = s->to - s->from;
    double rate = elapsed > 0 ? (double)here / elapsed : 0;
    int filled = (int)(WIDTH * done / (all ? all : 1));
    fprintf(stderr, "\r[%.*s%*s] %" PRId64 "/%" PRId64 "  %.0f runs/s  %.0f s left \033[K", filled,
            "##############################", WIDTH - filled, "", done, all, rate,
            rate > 0 ? (double)(all - done) / rate : NAN);
    fflush(stderr);
}

static ll_status work_here(sweep *s)
{
    ll_experiment_record record;
    ll_workers *workers = NULL;
    ll_workers_config config = {.store = s->store, .id = s->id, .threads = (int)s->threads, .drain = true};
    LL_TRY(ll_result_store_record(s->store, s->id, &record));
    LL_TRY(ll_workers_start(&config, &workers));
    int64_t started = ll_now_ns();
    while (isatty(STDERR_FILENO) && ll_workers_busy(workers)) {
        int64_t here = ll_workers_runs(workers);
        show_bar(s, record.done + here, (double)(ll_now_ns() - started) * 1e-9, here);
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    }
    return ll_workers_join(workers);
}

static ll_status run_all(sweep *s)
{
    ll_experiment_record record;
    ll_status status = work_here(s);
    if (isatty(STDERR_FILENO))
        fputs("\r\033[K", stderr);
    LL_THEN(status, ll_result_store_record(s->store, s->id, &record));
    if (!ll_failed(&status) && record.state != LL_EXPERIMENT_DONE)
        status = ll_error(LL_IO, "the experiment is %s with %" PRId64 " of %" PRId64 " runs done",
                          ll_experiment_state_names[record.state], record.done, record.to - record.from);
    return status;
}

/* ---- after ---- */

static ll_status write_results(const sweep *s)
{
    ll_stored_rows rows;
    ll_status status = ll_stored_rows_open(&rows, s->store, s->id);
    LL_THEN(status, ll_results_write(&s->results, s->experiment,
                                     &(ll_results_rows){.next = ll_stored_rows_next,
                                                        .seek = ll_stored_rows_seek,
                                                        .context = &rows,
                                                        .version = ll_version}));
    ll_stored_rows_close(&rows);
    return status;
}

/* Into the given folder, or one next to the output when the specification wants traces. */
static ll_status write_traces(const sweep *s)
{
    char folder[4200];
    if (!s->traces && !s->experiment->head.traces)
        return ll_ok();
    snprintf(folder, sizeof folder, "%s.traces", s->results.out ? s->results.out : "");
    return ll_traces_write(s->experiment, s->from, s->to, s->traces ? s->traces : folder, (int)s->threads);
}

static void remove_own_store(const sweep *s)
{
    static const char *const parts[] = {"", "-wal"};
    for (size_t i = 0; s->own_store[0] && i < sizeof parts / sizeof parts[0]; i++) {
        char path[4200];
        snprintf(path, sizeof path, "%s%s", s->own_store, parts[i]);
        unlink(path);
    }
}

/* ---- the verb ---- */

/* Shards are whole points where earlier runs of a point decide which further runs are made. */
static ll_status find_shard(sweep *s)
{
    int64_t unit = ll_until_is_set(s->experiment) ? s->experiment->head.repeats : 1;
    ll_status status = ll_shard(s->shard, s->experiment->runs / unit, &s->from, &s->to);
    s->from *= unit;
    s->to *= unit;
    const char *of_all = ll_results_of_all(&s->results);
    if (!ll_failed(&status) && s->shard && of_all)
        status =
            ll_error(LL_BAD_INPUT,
                     "%s: must be without --shard, since it uses all runs; give it to laglab merge, with "
                     "the rows of all shards",
                     of_all);
    return status;
}

static ll_status read_arguments(sweep *s, int argc, char **argv, const char **name)
{
    const ll_option options[] = {
        {"--jobs", "N", "Threads, 1 to 256; default: one per core.", .value = &s->jobs},
        LL_RESULTS_OPTIONS(&s->results),
        {"--traces", "DIR", "Writes a CSV of each run over time.", .value = &s->traces},
        {"--shard", "I/N", "Only this part of the runs; auto: the batch system's array index.",
         .value = &s->shard},
        {"--scenarios", "DIR", "Folder of the scenario library; default: next to the program.",
         .value = &s->scenarios},
        {"--anew", .help = "Run all, also if another version of laglab has started it.", .flag = &s->anew},
        {"--dry-run", .help = "Check and count, run one, and estimate the time of all.", .flag = &s->dry_run},
        {0}};
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    ll_status status = ll_arguments("sweep EXPERIMENT [OPTION]...: run an experiment; one row per run, or "
                                    "per point. With --out FILE, run "
                                    "again, it continues from FILE.runs",
                                    argc, argv, options, positional, &count);
    if (!ll_failed(&status) && count > 1)
        status = ll_error(LL_BAD_INPUT, "unexpected argument %.100s", positional[1]);
    *name = count ? positional[0] : NULL;
    return status;
}

static ll_status prepare(sweep *s, int argc, char **argv)
{
    const char *name = NULL;
    s->threads = ll_cores();
    ll_status status = read_arguments(s, argc, argv, &name);
    if (!ll_failed(&status) && s->jobs)
        status = ll_argument_whole("--jobs", s->jobs, 1, 256, &s->threads);
    LL_THEN(status, ll_experiment_load(name, s->scenarios, &s->experiment));
    LL_THEN(status, ll_results_check(&s->results, s->experiment, &name, 1));
    LL_THEN(status, find_shard(s));
    if (!ll_failed(&status) && s->traces && s->to - s->from > LL_EXPERIMENT_TRACES_MAX)
        status = ll_error(LL_BAD_INPUT, "--traces takes at most %d runs; there are %" PRId64,
                          LL_EXPERIMENT_TRACES_MAX, s->to - s->from);
    if (!ll_failed(&status) && s->experiment->head.traces && !s->traces && !s->results.out && !s->dry_run)
        status = ll_error(LL_BAD_INPUT, "the experiment wants traces: give their folder by --traces, or a "
                                        "file by --out, next to which they are written");
    return status;
}

int ll_verb_sweep(int argc, char **argv)
{
    sweep s = {0};
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is reported as an error, like a full disk */
    ll_status status = prepare(&s, argc, argv);
    if (!ll_failed(&status))
        ll_print_notices(ll_experiment_notices(s.experiment));
    if (!ll_failed(&status) && s.dry_run) {
        status = dry_run(&s);
    } else if (!ll_failed(&status)) {
        status = open_store(&s);
        LL_THEN(status, run_all(&s));
        LL_THEN(status, write_results(&s));
        LL_THEN(status, write_traces(&s));
        ll_result_store_close(s.store);
        if (!ll_failed(&status))
            remove_own_store(&s);
    }
    ll_experiment_free(s.experiment);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}

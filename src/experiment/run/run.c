/* Runs a run of an experiment, from its first tick to its row or its trace. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/run_status.h"
#include "base/utf8.h"
#include "experiment/run/windows.h"
#include "experiment/spec/experiment.h"
#include "experiment/spec/metric_path.h"
#include "session/session.h"
#include "threads/clock.h"

static bool stops(const ll_experiment *e, ll_session *session)
{
    cJSON *metrics = ll_session_metric_values(session);
    double value = ll_metric_value(metrics, e->head.stop.metric);
    cJSON_Delete(metrics);
    return value > e->head.stop.above;
}

/* The tick of the k-th check of the stop rule; the end without a rule. */
static int64_t check_tick(const ll_experiment *e, const ll_session_info *info, int64_t k)
{
    int64_t tick = e->head.stop.metric[0]
                       ? ll_tick_at((ll_time)((double)k * e->head.stop.every_s * 1e9), info->tick_freq)
                       : info->end_tick;
    return tick < info->end_tick ? tick : info->end_tick;
}

/* To its end, or to where the stop rule ends it. `windows`: what is counted on the way; NULL: nothing. */
static ll_status advance(const ll_experiment *e, ll_session *session, const ll_interrupt *interrupt,
                         ll_windows *windows, bool *stopped)
{
    ll_status status = ll_ok();
    int64_t checks = 1;
    ll_session_info info = ll_session_get_info(session);
    while (!ll_failed(&status) && !*stopped && info.tick < info.end_tick) {
        int64_t check = check_tick(e, &info, checks), next = windows ? ll_windows_next(windows) : check;
        if (windows)
            status = ll_windows_visit(windows);
        LL_THEN(status, ll_session_run_within(session, next < check ? next : check, interrupt));
        info = ll_session_get_info(session);
        if (next < check)
            continue;
        checks++;
        *stopped = !ll_failed(&status) && info.tick < info.end_tick && stops(e, session);
    }
    if (windows && !ll_failed(&status))
        ll_windows_end(windows);
    return status;
}

/* Removes a partial character at the end of a truncated message: text databases reject it. */
static void set_error(ll_row *row, const ll_status *status)
{
    snprintf(row->error, sizeof row->error, "%.*s", (int)sizeof row->error - 1, status->text);
    for (char *at = row->error; *at;) {
        int length = ll_utf8_printable(at);
        if (length == 0)
            *at = '?';
        at += length ? length : 1;
    }
}

/* Reports the failed part that has metric `i`. */
static void set_failed_part(ll_row *row, const cJSON *part, const char *where)
{
    const cJSON *reason = cJSON_GetObjectItemCaseSensitive(part, "reason");
    const char *status = cJSON_GetObjectItemCaseSensitive(part, "status")->valuestring;
    bool diverged = strcmp(status, ll_run_status_names[LL_RUN_DIVERGED]) == 0;
    row->status = diverged ? LL_ROW_DIVERGED : LL_ROW_FAILED;
    ll_status failure = ll_error(LL_DIVERGED, "%s%s%s", where, where[0] ? ": " : "",
                                 cJSON_IsString(reason) ? reason->valuestring : status);
    set_error(row, &failure);
}

/* A failed run has no metrics; a run with a failed part has those of the other parts. */
static void read_row(const ll_experiment *e, ll_session *session, const ll_windows *windows, ll_row *row)
{
    cJSON *metrics = ll_session_metric_values(session);
    bool good = ll_row_good(row);
    row->hash = ll_session_hash(session);
    row->t_s = ll_to_s(ll_session_get_info(session).time);
    for (int i = 0; i < e->metric_count && good; i++) {
        char where[LL_EXPERIMENT_PATH_MAX + 8];
        const cJSON *part = ll_metric_failed_part(metrics, e->metrics[i], where, sizeof where);
        if (!part)
            row->metrics[i] = e->windowed[i].as == LL_WINDOWED_NOT ? ll_metric_value(metrics, e->metrics[i])
                                                                   : ll_windows_value(windows, i);
        else if (ll_row_good(row))
            set_failed_part(row, part, where);
    }
    cJSON_Delete(metrics);
}

/* A run observes no more than the metrics of its row need; for columns of the trace everything. */
static void observe_only_what_is_read(const ll_experiment *e, ll_session *session)
{
    if (ll_windows_read_columns(e))
        return;
    const char *paths[LL_EXPERIMENT_METRICS_MAX + 1];
    int count = 0;
    for (; count < e->metric_count; count++)
        paths[count] = e->metrics[count];
    if (e->head.stop.metric[0])
        paths[count++] = e->head.stop.metric;
    ll_session_observe_only(session, paths, count);
}

/* Before the first tick. */
static ll_status open_session(const ll_experiment *e, int64_t run, ll_kept_block *kept, ll_session **session)
{
    ll_scenario scenario;
    *session = NULL;
    ll_status status = ll_experiment_open(e, run, &scenario);
    LL_THEN(status, ll_session_open_forward(&scenario, kept, session));
    if (!ll_failed(&status))
        observe_only_what_is_read(e, *session);
    if (!ll_failed(&status) && e->workload) {
        status = ll_session_load(*session, e->workload);
        if (status.code == LL_CONFLICT) /* at this point scripts control all players */
            status = ll_ok();
    }
    if (ll_failed(&status)) {
        ll_session_destroy(*session);
        *session = NULL;
    }
    return status;
}

/* ---- cost ---- */

enum { COST_RUNS_MIN = 3, COST_RUNS_MAX = 7 }; /* minimum and maximum of runs to measure the cost */

#define COST_SHORT_NS 5e7 /* total time below which more than the minimum are run */

static int cost_metric_of(const ll_experiment *e)
{
    for (int i = 0; i < e->metric_count; i++)
        if (ll_metric_is_cost(e->metrics[i]))
            return i;
    return -1;
}

/* Repeats the run and takes the minimum, which other processes disturb least. `first_ns` is the time of the
 * run itself. */
static ll_status measure_cost(const ll_experiment *e, int metric, double first_ns,
                              const ll_interrupt *interrupt, ll_kept_block *kept, ll_row *row)
{
    double least = first_ns, all = first_ns;
    ll_status status = ll_ok();
    for (int n = 1; !ll_failed(&status) && (n < COST_RUNS_MIN || (n < COST_RUNS_MAX && all < COST_SHORT_NS));
         n++) {
        ll_session *session = NULL;
        bool stopped = false;
        status = open_session(e, row->run, kept, &session);
        int64_t from = ll_thread_cpu_ns();
        LL_THEN(status, advance(e, session, interrupt, NULL, &stopped));
        double took = (double)(ll_thread_cpu_ns() - from);
        all += took;
        least = took < least ? took : least;
        ll_session_destroy(session);
    }
    row->metrics[metric] = !ll_failed(&status) && row->t_s > 0 ? least / row->t_s : NAN;
    return status;
}

/* NULL where no metric is in a window: then a run costs what it did. */
static ll_status count_windows(const ll_experiment *e, ll_session *session, ll_windows **windows)
{
    if (!ll_windows_wanted(e))
        return ll_ok();
    *windows = malloc(sizeof **windows);
    if (!*windows)
        return ll_error(LL_NO_MEMORY, "out of memory: windows of a run");
    ll_windows_begin(e, session, *windows);
    return ll_ok();
}

static void forget_windows(ll_windows *windows)
{
    if (windows)
        ll_windows_free(windows);
    free(windows);
}

ll_status ll_experiment_run(const ll_experiment *e, int64_t run, const ll_interrupt *interrupt,
                            ll_kept_block *kept, ll_row *row)
{
    ll_session *session = NULL;
    bool stopped = false;
    ll_row_clear(row);
    row->run = run;
    ll_status status = open_session(e, run, kept, &session);
    if (status.code == LL_NO_MEMORY)
        return status;
    if (ll_failed(&status)) {
        row->status = LL_ROW_REFUSED;
        set_error(row, &status);
        return ll_ok();
    }
    ll_windows *windows = NULL;
    int64_t from = ll_thread_cpu_ns();
    status = count_windows(e, session, &windows);
    LL_THEN(status, advance(e, session, interrupt, windows, &stopped));
    double took = (double)(ll_thread_cpu_ns() - from);
    if (status.code == LL_INTERRUPTED || status.code == LL_NO_MEMORY) {
        forget_windows(windows);
        ll_session_destroy(session);
        return status;
    }
    row->status = ll_failed(&status) ? LL_ROW_DIVERGED : stopped ? LL_ROW_STOPPED : LL_ROW_OK;
    if (ll_failed(&status))
        set_error(row, &status);
    read_row(e, session, windows, row);
    forget_windows(windows);
    ll_session_destroy(session);
    int cost = cost_metric_of(e);
    if (cost >= 0 && ll_row_good(row))
        status = measure_cost(e, cost, took, interrupt, kept, row);
    return status.code == LL_INTERRUPTED || status.code == LL_NO_MEMORY ? status : ll_ok();
}

ll_status ll_experiment_read_run(const ll_experiment *e, int64_t run, const ll_interrupt *interrupt,
                                 ll_run_reader *read, void *context)
{
    ll_session *session = NULL;
    bool stopped = false;
    LL_TRY(open_session(e, run, NULL, &session));
    ll_status ended = advance(e, session, interrupt, NULL, &stopped);
    int64_t tick = ll_session_get_info(session).tick;
    ll_session *copy = NULL;
    ll_status status = ended.code == LL_INTERRUPTED ? ended : ll_session_copy(session, tick, &copy);
    if (copy)
        status = read(context, copy, ll_failed(&ended) && tick > 0 ? tick - 1 : tick);
    ll_session_destroy(copy);
    ll_session_destroy(session);
    return status;
}

typedef struct csv_writer {
    const ll_interrupt *interrupt;
    void (*write)(void *context, const char *text, size_t length);
    void *context;
} csv_writer;

static ll_status write_csv(void *context, ll_session *copy, int64_t to)
{
    const csv_writer *w = context;
    return ll_session_write_trace(copy, 0, to, w->interrupt, w->write, w->context);
}

ll_status ll_experiment_trace(const ll_experiment *e, int64_t run, const ll_interrupt *interrupt,
                              void (*write)(void *context, const char *text, size_t length), void *context)
{
    csv_writer w = {interrupt, write, context};
    return ll_experiment_read_run(e, run, interrupt, write_csv, &w);
}

/* Runs a run of an experiment, from its first tick to its row or its trace. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/run_status.h"
#include "base/utf8.h"
#include "experiment/spec/experiment.h"
#include "experiment/spec/metric_path.h"
#include "session/session.h"

static bool stops(const ll_experiment *e, ll_session *session)
{
    cJSON *report = ll_session_metrics(session);
    double value = ll_metric_value(cJSON_GetObjectItem(report, "metrics"), e->head.stop.metric);
    cJSON_Delete(report);
    return value > e->head.stop.above;
}

static ll_status advance(const ll_experiment *e, ll_session *session, const ll_interrupt *interrupt,
                         bool *stopped)
{
    ll_session_info info = ll_session_get_info(session);
    if (!e->head.stop.metric[0])
        return ll_session_run_within(session, info.end_tick, interrupt);
    ll_status status = ll_ok();
    for (int64_t k = 1; !ll_failed(&status) && !*stopped && info.tick < info.end_tick; k++) {
        int64_t to = ll_tick_at((ll_time)((double)k * e->head.stop.every_s * 1e9), info.tick_freq);
        status = ll_session_run_within(session, to < info.end_tick ? to : info.end_tick, interrupt);
        info = ll_session_get_info(session);
        *stopped = !ll_failed(&status) && info.tick < info.end_tick && stops(e, session);
    }
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
static void read_row(const ll_experiment *e, ll_session *session, ll_row *row)
{
    cJSON *report = ll_session_metrics(session), *metrics = cJSON_GetObjectItem(report, "metrics");
    bool good = ll_row_good(row);
    row->hash = ll_session_hash(session);
    row->t_s = ll_to_s(ll_session_get_info(session).time);
    for (int i = 0; i < e->metric_count && good; i++) {
        char where[LL_EXPERIMENT_PATH_MAX + 8];
        const cJSON *part = ll_metric_failed_part(metrics, e->metrics[i], where, sizeof where);
        if (!part)
            row->metrics[i] = ll_metric_value(metrics, e->metrics[i]);
        else if (ll_row_good(row))
            set_failed_part(row, part, where);
    }
    cJSON_Delete(report);
}

/* A run observes no more than the metrics of its row need. */
static void observe_only_what_is_read(const ll_experiment *e, ll_session *session)
{
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

static double thread_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

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
        double from = thread_ns();
        LL_THEN(status, advance(e, session, interrupt, &stopped));
        double took = thread_ns() - from;
        all += took;
        least = took < least ? took : least;
        ll_session_destroy(session);
    }
    row->metrics[metric] = !ll_failed(&status) && row->t_s > 0 ? least / row->t_s : NAN;
    return status;
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
    double from = thread_ns();
    status = advance(e, session, interrupt, &stopped);
    double took = thread_ns() - from;
    if (status.code == LL_INTERRUPTED) {
        ll_session_destroy(session);
        return status;
    }
    row->status = ll_failed(&status) ? LL_ROW_DIVERGED : stopped ? LL_ROW_STOPPED : LL_ROW_OK;
    if (ll_failed(&status))
        set_error(row, &status);
    read_row(e, session, row);
    ll_session_destroy(session);
    int cost = cost_metric_of(e);
    if (cost >= 0 && ll_row_good(row))
        status = measure_cost(e, cost, took, interrupt, kept, row);
    return status.code == LL_INTERRUPTED || status.code == LL_NO_MEMORY ? status : ll_ok();
}

ll_status ll_experiment_trace(const ll_experiment *e, int64_t run, const ll_interrupt *interrupt,
                              void (*write)(void *context, const char *text, size_t length), void *context)
{
    ll_session *session = NULL;
    bool stopped = false;
    LL_TRY(open_session(e, run, NULL, &session));
    ll_status ended = advance(e, session, interrupt, &stopped);
    int64_t tick = ll_session_get_info(session).tick;
    ll_session *copy = NULL;
    ll_status status = ended.code == LL_INTERRUPTED ? ended : ll_session_copy(session, tick, &copy);
    if (copy)
        status = ll_session_write_trace(copy, 0, ll_failed(&ended) && tick > 0 ? tick - 1 : tick, interrupt,
                                        write, context);
    ll_session_destroy(copy);
    ll_session_destroy(session);
    return status;
}

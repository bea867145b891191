#include "experiment/run/windows.h"

#include <cjson/cJSON.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "experiment/spec/metric_path.h"

static const ll_window *window_at(const ll_windows *w, int i)
{
    return &w->experiment->head.windows[i];
}

bool ll_windows_wanted(const ll_experiment *e)
{
    for (int i = 0; i < e->metric_count; i++)
        if (e->windowed[i].as != LL_WINDOWED_NOT)
            return true;
    return false;
}

bool ll_windows_read_columns(const ll_experiment *e)
{
    bool reads = false;
    for (int i = 0; i < e->metric_count; i++) {
        const ll_windowed *windowed = &e->windowed[i];
        if (windowed->as != LL_WINDOWED_NOT)
            reads |= windowed->as == LL_WINDOWED_COLUMN ||
                     e->head.windows[windowed->window].condition.value[0] != '\0';
    }
    return reads;
}

void ll_windows_begin(const ll_experiment *e, ll_session *session, ll_windows *w)
{
    *w = (ll_windows){.experiment = e, .session = session, .visited = -1};
    w->each_tick = w->reads_columns = ll_windows_read_columns(e);
    if (!ll_session_parameter(session, "warmup_s", &w->warmup_s))
        w->warmup_s = 0;
    for (int i = 0; i < e->head.window_count; i++) {
        const char *value = window_at(w, i)->condition.value;
        w->condition_column[i] = value[0] ? ll_column_find(session, value) : -1;
    }
    for (int i = 0; i < e->metric_count; i++)
        w->metrics[i] = (ll_window_metric){.min = INFINITY,
                                           .max = -INFINITY,
                                           .column = e->windowed[i].as == LL_WINDOWED_COLUMN
                                                         ? ll_column_find(session, e->windowed[i].path)
                                                         : -1};
}

void ll_windows_free(ll_windows *w)
{
    for (int i = 0; i < LL_EXPERIMENT_METRICS_MAX; i++)
        free(w->metrics[i].values);
}

/* ---- which ticks ---- */

static ll_time ns_of(double s)
{
    return ll_ms(s * 1e3);
}

/* The first tick at or after that time. */
static int64_t tick_from(double s, ll_freq freq)
{
    ll_time time = ns_of(s);
    int64_t tick = ll_tick_at(time, freq);
    return ll_tick_time(tick, freq) < time ? tick + 1 : tick;
}

int64_t ll_windows_next(const ll_windows *w)
{
    ll_session_info info = ll_session_get_info(w->session);
    int64_t next = w->each_tick ? info.tick + 1 : INT64_MAX;
    for (int i = 0; i < w->experiment->head.window_count && !w->each_tick; i++) {
        const double borders[] = {window_at(w, i)->from_s, window_at(w, i)->to_s};
        for (int k = 0; k < 2; k++) {
            int64_t tick = tick_from(borders[k], info.tick_freq);
            if (tick > info.tick && tick < next)
                next = tick;
        }
    }
    return next;
}

static bool holds(const ll_windows *w, int i)
{
    double value = NAN;
    const ll_window *window = window_at(w, i);
    if (window->condition.value[0] == '\0')
        return true;
    if (w->condition_column[i] >= 0)
        value = w->columns[w->condition_column[i]];
    else if (!ll_session_parameter(w->session, window->condition.value, &value))
        return false;
    return value > window->condition.above && value < window->condition.below;
}

static bool is_within(const ll_windows *w, int i, ll_time now)
{
    const ll_window *window = window_at(w, i);
    return now >= ns_of(window->from_s) && now < ns_of(window->to_s) && holds(w, i);
}

/* ---- metrics of the engine ---- */

static double part(const cJSON *metrics, const ll_windowed *windowed, const char *name)
{
    char path[LL_WINDOW_PATH_MAX + 32];
    snprintf(path, sizeof path, "%s.%s", windowed->path, name);
    return ll_metric_value(metrics, path);
}

static ll_window_sum product(double mean, double weight)
{
    return (ll_window_sum){weight > 0 && isfinite(mean) ? mean * weight : 0, weight > 0 ? weight : 0};
}

/* What has been counted from the start up to the present tick. Infinite values of a latency count, but are
 * not in its mean. */
static ll_window_sum counted_so_far(const ll_windows *w, const cJSON *metrics, const ll_windowed *windowed)
{
    double now_s = ll_to_s(ll_session_get_info(w->session).time);
    if (windowed->as == LL_WINDOWED_CHANGE)
        return (ll_window_sum){.sum = ll_metric_value(metrics, windowed->path)};
    if (windowed->as == LL_WINDOWED_RATE)
        return product(ll_metric_value(metrics, windowed->path), now_s - w->warmup_s);
    double lost = part(metrics, windowed, "lost_ratio"), count = part(metrics, windowed, "count");
    double finite = isfinite(lost) ? round(count * (1 - lost)) : count;
    if (windowed->as == LL_WINDOWED_MEAN)
        return product(part(metrics, windowed, "mean"), finite);
    double rms = part(metrics, windowed, "rms");
    return product(rms * rms, finite);
}

/* A difference of two sums that is no larger than their rounding is none. */
static double difference(double after, double before)
{
    double d = after - before;
    return fabs(d) <= 8 * DBL_EPSILON * fabs(after) ? 0 : d;
}

static void read_metrics(ll_windows *w, int window, const cJSON *metrics, bool opens)
{
    const ll_experiment *e = w->experiment;
    for (int i = 0; i < e->metric_count; i++) {
        const ll_windowed *windowed = &e->windowed[i];
        ll_window_metric *m = &w->metrics[i];
        if (windowed->window != window || windowed->as < LL_WINDOWED_CHANGE ||
            windowed->as == LL_WINDOWED_COLUMN)
            continue;
        ll_window_sum now = counted_so_far(w, metrics, windowed);
        if (!opens) {
            m->closed.sum += difference(now.sum, m->at_opening.sum);
            m->closed.weight += now.weight - m->at_opening.weight;
        }
        m->at_opening = now;
    }
}

/* Opens and closes windows. The metrics are read at most once. */
static ll_status set_open(ll_windows *w, const bool *open)
{
    cJSON *metrics = NULL;
    for (int i = 0; i < w->experiment->head.window_count; i++) {
        if (open[i] == w->open[i])
            continue;
        if (!metrics && !(metrics = ll_session_metric_values(w->session)))
            return ll_error(LL_NO_MEMORY, "out of memory: metrics");
        w->open[i] = open[i];
        read_metrics(w, i, metrics, open[i]);
    }
    cJSON_Delete(metrics);
    return ll_ok();
}

/* ---- columns ---- */

static bool keeps_values(ll_column_statistic statistic)
{
    return statistic >= LL_COLUMN_P50;
}

static ll_status add_value(ll_window_metric *m, ll_column_statistic statistic, double value)
{
    if (keeps_values(statistic) && m->count == m->capacity) {
        int64_t capacity = m->capacity ? 2 * m->capacity : 256;
        double *values = realloc(m->values, (size_t)capacity * sizeof *values);
        if (!values)
            return ll_error(LL_NO_MEMORY, "out of memory: values of a window");
        m->values = values;
        m->capacity = capacity;
    }
    if (keeps_values(statistic))
        m->values[m->count] = value;
    m->count++;
    m->sum += value;
    m->sum_squares += value * value;
    m->min = value < m->min ? value : m->min;
    m->max = value > m->max ? value : m->max;
    return ll_ok();
}

static ll_status add_columns(ll_windows *w)
{
    const ll_experiment *e = w->experiment;
    ll_status status = ll_ok();
    for (int i = 0; i < e->metric_count && !ll_failed(&status); i++) {
        ll_window_metric *m = &w->metrics[i];
        if (m->column >= 0 && w->open[e->windowed[i].window] && isfinite(w->columns[m->column]))
            status = add_value(m, e->windowed[i].statistic, w->columns[m->column]);
    }
    return status;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The smallest value that the fraction `q` of all values does not exceed, as of a distribution. */
static double quantile(const ll_window_metric *m, double q)
{
    qsort(m->values, (size_t)m->count, sizeof *m->values, compare);
    int64_t rank = (int64_t)ceil(q * (double)m->count - 1e-9);
    return m->values[rank < 1 ? 0 : rank - 1];
}

static double column_value(const ll_window_metric *m, ll_column_statistic statistic)
{
    static const double quantiles[LL_COLUMN_STATISTICS] = {
        [LL_COLUMN_P50] = 0.5, [LL_COLUMN_P95] = 0.95, [LL_COLUMN_P99] = 0.99};
    if (m->count == 0)
        return NAN;
    if (keeps_values(statistic))
        return quantile(m, quantiles[statistic]);
    const double values[] = {[LL_COLUMN_MEAN] = m->sum / (double)m->count,
                             [LL_COLUMN_RMS] = sqrt(m->sum_squares / (double)m->count),
                             [LL_COLUMN_MIN] = m->min,
                             [LL_COLUMN_MAX] = m->max};
    return values[statistic];
}

/* ---- whole ---- */

static void add_time(ll_windows *w, ll_time now)
{
    for (int i = 0; i < w->experiment->head.window_count && w->visited >= 0; i++)
        if (w->open[i])
            w->counted[i] += now - w->visited_at;
    w->visited_at = now;
}

ll_status ll_windows_visit(ll_windows *w)
{
    bool open[LL_WINDOWS_MAX] = {false};
    ll_session_info info = ll_session_get_info(w->session);
    if (info.tick == w->visited)
        return ll_ok();
    add_time(w, info.time);
    w->visited = info.tick;
    if (w->reads_columns) {
        ll_trace_line line = {.values = w->columns};
        ll_session_trace_line(w->session, &line);
    }
    for (int i = 0; i < w->experiment->head.window_count; i++)
        open[i] = is_within(w, i, info.time);
    LL_TRY(set_open(w, open));
    return add_columns(w);
}

void ll_windows_end(ll_windows *w)
{
    static const bool closed[LL_WINDOWS_MAX] = {false};
    add_time(w, ll_session_get_info(w->session).time);
    ll_status status = set_open(w, closed);
    (void)status; /* without memory what is still open counts nothing */
}

/* The column's values are sorted for a percentile, which is all that changes. */
double ll_windows_value(const ll_windows *w, int metric)
{
    const ll_windowed *windowed = &w->experiment->windowed[metric];
    const ll_window_metric *m = &w->metrics[metric];
    ll_time counted = w->counted[windowed->window];
    double ratio = m->closed.weight > 0 ? m->closed.sum / m->closed.weight : NAN;
    if (windowed->as == LL_WINDOWED_TIME)
        return ll_to_s(counted);
    if (windowed->as == LL_WINDOWED_CHANGE)
        return counted > 0 ? m->closed.sum : NAN;
    if (windowed->as == LL_WINDOWED_COLUMN)
        return column_value(m, windowed->statistic);
    return windowed->as == LL_WINDOWED_RMS && isfinite(ratio) ? sqrt(fmax(ratio, 0)) : ratio;
}

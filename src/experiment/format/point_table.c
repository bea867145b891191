/* Rows of points: each metric over the repeats, and compared with a baseline. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/format/table_internal.h"
#include "experiment/spec/metric_path.h"
#include "experiment/spec/until.h"

/* NaN: missing. Measured metrics are excluded: they always differ. */
static bool same_metrics(const ll_experiment *e, const double *a, const double *b)
{
    for (int i = 0; i < e->metric_count; i++)
        if (a[i] != b[i] && !(isnan(a[i]) && isnan(b[i])) && !ll_metric_is_cost(e->metrics[i]))
            return false;
    return true;
}

/* The runs of a point; those that ended well are compared. */
typedef struct repeats {
    int64_t good, failed;
    bool differ, equally_long;
    double first[LL_EXPERIMENT_METRICS_MAX], t_s;
} repeats;

static void hold_run(const ll_experiment *e, const ll_row *row, double *values)
{
    int64_t repeat = row->run % e->head.repeats;
    for (int i = 0; i < e->metric_count; i++)
        values[i * e->head.repeats + repeat] = row->metrics[i];
}

static void add_run(ll_result_table *t, repeats *r, const ll_row *row)
{
    const ll_experiment *e = t->experiment;
    if (row->status == LL_ROW_SKIPPED)
        return;
    for (int i = 0; i < e->metric_count; i++)
        ll_sums_add(&t->sums[i], row->metrics[i]);
    hold_run(e, row, t->held);
    ll_table_note(t, row);
    if (!ll_row_good(row)) {
        r->failed++;
        return;
    }
    if (r->good++ == 0) {
        memcpy(r->first, row->metrics, sizeof r->first);
        r->t_s = row->t_s;
    }
    r->equally_long = r->equally_long && row->t_s == r->t_s;
    r->differ = r->differ || !same_metrics(e, r->first, row->metrics);
}

static void forget(const ll_experiment *e, double *values)
{
    for (int64_t k = 0; k < e->metric_count * e->head.repeats; k++)
        values[k] = NAN;
}

/* ---- intervals ---- */

static void summarise(ll_result_table *t, int metric, const repeats *r)
{
    int64_t count = t->experiment->head.repeats;
    const double *x = t->held + metric * count;
    ll_interval_request request =
        ll_experiment_interval_request(t->experiment, metric, t->point, r->equally_long ? r->t_s : NAN);
    request.values = t->scratch;
    for (int64_t k = 0; k < count; k++)
        if (isfinite(x[k]))
            t->scratch[request.n++] = x[k];
    t->summaries[metric] = ll_summarise(&request, t->scratch, &t->resampler);
    ll_summary_text(&t->summaries[metric], t->texts[0][metric]);
}

ll_interval_request ll_difference_request(const ll_experiment *e, int metric, int64_t point)
{
    ll_interval_request request = ll_experiment_interval_request(e, metric, point, NAN);
    request.difference = true;
    if (request.scale == LL_SCALE_COUNT || request.scale == LL_SCALE_FLAG)
        request.scale = LL_SCALE_AMOUNT;
    return request;
}

/* Over the seeds that both points have. */
static void compare(ll_result_table *t, int metric)
{
    int64_t count = t->experiment->head.repeats;
    const double *x = t->held + metric * count, *base = t->baseline + metric * count;
    ll_interval_request request = ll_difference_request(t->experiment, metric, t->point);
    request.values = t->scratch;
    for (int64_t k = 0; k < count; k++)
        if (isfinite(x[k]) && isfinite(base[k]))
            t->scratch[request.n++] = x[k] - base[k];
    t->differences[metric] = ll_summarise(&request, t->scratch, &t->resampler);
    ll_summary_text(&t->differences[metric], t->texts[1][metric]);
}

/* ---- columns and cells ---- */

#define POINT_COLUMNS(X) X(count, point, NULL, t->point, "number of the point, from 0", NULL)

#define COUNT_COLUMNS(X)                                                                                     \
    X(count, runs, NULL, r.good, "runs that ended well", NULL)                                               \
    X(count, failed, NULL, r.failed, "runs that did not", NULL)                                              \
    X(optional_flag, identical, NULL, r.good > 1 ? !r.differ : NAN,                                          \
      "whether the runs that ended well have the same metrics", "Fewer than two runs ended well.")

#define FEW "Too few runs have the metric."

#define STATISTICS_COLUMNS(X)                                                                                \
    X(number, ci95, NULL, ll_interval_half(&s->of_mean), "half of the width of the mean's 95 % interval",    \
      FEW)                                                                                                   \
    X(number, ci95_low, NULL, bound(s->of_mean.low), "lower bound of the mean's 95 % interval",              \
      FEW " Or there is no bound.")                                                                          \
    X(number, ci95_high, NULL, bound(s->of_mean.high), "upper bound of the mean's 95 % interval",            \
      FEW " Or there is no bound.")                                                                          \
    X(text, ci95_method, NULL, t->texts[0][i], "method of the interval, or the reason why there is none",    \
      "No run has the metric.")                                                                              \
    X(text, ci95_covers, NULL, s->covers, "how often such intervals contain the mean, in words",             \
      "There is no interval.")                                                                               \
    X(number, sd, NULL, s->deviation, "standard deviation", FEW)                                             \
    X(number, p25, NULL, s->quartiles[0], "lower quartile", FEW)                                             \
    X(number, p50, NULL, s->quartiles[1], "median", FEW)                                                     \
    X(number, p75, NULL, s->quartiles[2], "upper quartile", FEW)                                             \
    X(number, p50_low, NULL, bound(s->of_median.low), "lower bound of the median's 95 % interval",           \
      FEW " Or there is no bound.")                                                                          \
    X(number, p50_high, NULL, bound(s->of_median.high), "upper bound of the median's 95 % interval",         \
      FEW " Or there is no bound.")

#define DIFFERENCE_COLUMNS(X)                                                                                \
    X(number, diff, NULL, s->mean, "mean of the differences from the baseline's runs with the same seeds",   \
      "No pair of runs has the metric.")                                                                     \
    X(number, diff_low, NULL, bound(s->of_mean.low), "lower bound of its 95 % interval",                     \
      "Too few pairs of runs have the metric, or there is no bound.")                                        \
    X(number, diff_high, NULL, bound(s->of_mean.high), "upper bound of its 95 % interval",                   \
      "Too few pairs of runs have the metric, or there is no bound.")                                        \
    X(text, diff_method, NULL, t->texts[1][i], "method of that interval, or the reason why there is none",   \
      "No pair of runs has the metric.")                                                                     \
    X(text, diff_covers, NULL, s->covers, "how often such intervals contain the difference, in words",       \
      "There is no interval.")                                                                               \
    X(count, diff_pairs, NULL, s->n, "pairs of runs with the same seed", "There is no baseline.")

const ll_metric_table ll_point_columns = {.path = "",
                                          .when = "Tables of points.",
                                          .help = "Before the parameters.",
                                          LL_METRICS_FROM(POINT_COLUMNS)};
const ll_metric_table ll_count_columns = {.path = "",
                                          .when = "Tables of points.",
                                          .help = "Between the parameters and the metrics.",
                                          LL_METRICS_FROM(COUNT_COLUMNS)};
const ll_metric_table ll_statistics_columns = {
    .path = "*",
    .when = "Tables of points.",
    .help = "Of a metric, after its mean, which has the name of the metric itself.",
    LL_METRICS_FROM(STATISTICS_COLUMNS)};
const ll_metric_table ll_difference_columns = {.path = "*",
                                               .when = "Tables of points with a baseline.",
                                               .help = "Of a metric, after its statistics.",
                                               LL_METRICS_FROM(DIFFERENCE_COLUMNS)};

static void add_metric(ll_result_table *t, int i)
{
    char before[LL_COLUMN_NAME_MAX];
    snprintf(before, sizeof before, "%s.", t->experiment->metrics[i]);
    ll_table_add(t, t->experiment->metrics[i], LL_CELL_REAL, true);
    ll_table_add_columns(t, before, &ll_statistics_columns);
    if (t->compares)
        ll_table_add_columns(t, before, &ll_difference_columns);
}

static double bound(double value)
{
    return isfinite(value) ? value : NAN;
}

static ll_cell *write_metric(const ll_result_table *t, int i, ll_cell *cells)
{
    const ll_summary *s = &t->summaries[i];
    *cells++ = ll_cell_number(s->mean);
    return LL_CELLS_PUT(cells, &ll_statistics_columns, STATISTICS_COLUMNS);
}

static ll_cell *write_difference(const ll_result_table *t, int i, ll_cell *cells)
{
    const ll_summary *s = &t->differences[i];
    return LL_CELLS_PUT(cells, &ll_difference_columns, DIFFERENCE_COLUMNS);
}

/* ---- the table ---- */

/* The rows of the next point. */
static bool read_point(ll_result_table *t, repeats *r, ll_status *status)
{
    const ll_experiment *e = t->experiment;
    if (!t->row_held && !t->source(t->context, &t->row, status))
        return false;
    int64_t point = t->row.run / e->head.repeats;
    memset(t->sums, 0, sizeof t->sums);
    forget(e, t->held);
    do {
        add_run(t, r, &t->row);
        t->row_held = t->source(t->context, &t->row, status);
    } while (t->row_held && t->row.run / e->head.repeats == point);
    if (!ll_failed(status))
        ll_table_hold(t, point);
    return !ll_failed(status);
}

static bool next_point(void *context, ll_cell *cells, ll_status *status)
{
    ll_result_table *t = context;
    const ll_experiment *e = t->experiment;
    repeats r = {.equally_long = true};
    if (!read_point(t, &r, status))
        return false;
    t->identical += r.good > 1 && !r.differ;
    cells = LL_CELLS_PUT(cells, &ll_point_columns, POINT_COLUMNS);
    for (int i = 0; i < t->parameter_count; i++)
        *cells++ = ll_table_parameter(t, i);
    cells = LL_CELLS_PUT(cells, &ll_count_columns, COUNT_COLUMNS);
    for (int i = 0; i < e->metric_count; i++) {
        summarise(t, i, &r);
        t->unreached += i == e->until_metric && r.good + r.failed == e->head.repeats &&
                        !ll_until_is_met(e, &t->summaries[i]);
        cells = write_metric(t, i, cells);
        if (!t->compares)
            continue;
        compare(t, i);
        cells = write_difference(t, i, cells);
    }
    return true;
}

static ll_status add_room(ll_result_table *t)
{
    const ll_experiment *e = t->experiment;
    size_t all = (size_t)(e->metric_count * e->head.repeats);
    t->held = malloc(all * sizeof *t->held);
    t->scratch = malloc((size_t)e->head.repeats * sizeof *t->scratch);
    return t->held && t->scratch ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: repeats of a point");
}

ll_status ll_result_table_points(const ll_experiment *e, ll_row_source *source, void *context,
                                 ll_result_table **table)
{
    return ll_result_table_compared(e, NULL, -1, source, context, table);
}

ll_status ll_result_table_compared(const ll_experiment *e, const ll_row *baseline, int64_t count,
                                   ll_row_source *source, void *context, ll_result_table **table)
{
    ll_status status = ll_table_make(e, source, context, table);
    LL_THEN(status, add_room(*table));
    if (!ll_failed(&status) && baseline &&
        !((*table)->baseline = malloc((size_t)(e->metric_count * e->head.repeats) * sizeof(double))))
        status = ll_error(LL_NO_MEMORY, "out of memory: baseline");
    if (ll_failed(&status)) {
        ll_result_table_free(*table);
        *table = NULL;
        return status;
    }
    ll_result_table *t = *table;
    t->compares = baseline != NULL;
    if (baseline)
        forget(e, t->baseline);
    for (int64_t k = 0; baseline && k < count; k++)
        hold_run(e, &baseline[k], t->baseline);
    ll_table_add_columns(t, "", &ll_point_columns);
    ll_table_add_parameters(t);
    ll_table_add_columns(t, "", &ll_count_columns);
    for (int i = 0; i < e->metric_count; i++)
        add_metric(t, i);
    t->table = (ll_table){t->columns, t->column_count, next_point, t};
    return status;
}

int64_t ll_result_table_identical(const ll_result_table *t)
{
    return t->identical;
}

const ll_sums *ll_result_table_sums(const ll_result_table *t)
{
    return t->sums;
}

const ll_summary *ll_result_table_summaries(const ll_result_table *t)
{
    return t->summaries;
}

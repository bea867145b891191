#include "experiment/report/differences.h"

#include <math.h>
#include <stdlib.h>

static int64_t values_of(const ll_experiment *e, int dimension)
{
    int a = 0;
    while (e->dimension[a] != dimension)
        a++;
    return e->axes[a].count;
}

/* Points between two successive values. */
static int64_t stride_of(const ll_experiment *e, int dimension)
{
    int64_t stride = 1;
    for (int d = dimension + 1; d < e->dimension_count; d++) /* the last one varies fastest */
        stride *= values_of(e, d);
    return stride;
}

typedef struct maker {
    const ll_report_rows *rows;
    ll_differences *to;
    ll_resampler resampler;
    double *values, *scratch; /* by repeat */
    int64_t resampled, details;
} maker;

/* The differences of a setting by repeat, NaN: no pair. Returns the number of pairs. */
static int64_t take(const maker *m, const ll_difference *d, int64_t setting, double *values)
{
    const ll_experiment *e = m->rows->experiment;
    int64_t stride = stride_of(e, d->dimension), pairs = 0;
    int64_t first = setting / stride * stride * values_of(e, d->dimension) + setting % stride;
    const double *from = ll_report_rows_at(m->rows, d->metric, first + d->from * stride),
                 *of = ll_report_rows_at(m->rows, d->metric, first + d->of * stride);
    for (int64_t r = 0; r < e->head.repeats; r++) {
        bool pair = isfinite(from[r]) && isfinite(of[r]);
        values[r] = pair ? of[r] - from[r] : NAN;
        pairs += pair;
    }
    return pairs;
}

static ll_summary summarise(maker *m, int metric, const double *values)
{
    const ll_experiment *e = m->rows->experiment;
    ll_interval_request request = ll_difference_request(e, metric, 0);
    request.values = m->scratch;
    for (int64_t r = 0; r < e->head.repeats; r++)
        if (isfinite(values[r]))
            m->scratch[request.n++] = values[r];
    m->resampled += request.n;
    return ll_summarise(&request, m->scratch, &m->resampler);
}

static void compare_all(maker *m, ll_difference *d, double *mean)
{
    int64_t repeats = m->rows->experiment->head.repeats;
    for (int64_t r = 0; r < repeats; r++)
        mean[r] = 0;
    for (int64_t s = 0; s < d->settings; s++) {
        if (take(m, d, s, m->values) < repeats)
            continue;
        d->complete++;
        for (int64_t r = 0; r < repeats; r++)
            mean[r] += (m->values[r] - mean[r]) / (double)d->complete;
    }
    for (int64_t r = 0; r < repeats && d->complete == 0; r++)
        mean[r] = NAN;
    d->all = summarise(m, d->metric, mean);
}

static ll_status add_details(maker *m, ll_difference *d)
{
    int64_t work = d->settings * m->rows->experiment->head.repeats;
    if (m->details + d->settings > LL_DIFFERENCE_DETAILS_MAX ||
        m->resampled + work > LL_DIFFERENCE_RESAMPLED_MAX)
        return ll_ok();
    m->details += d->settings;
    d->details = malloc((size_t)d->settings * sizeof *d->details);
    if (!d->details)
        return ll_error(LL_NO_MEMORY, "out of memory: differences");
    for (int64_t s = 0; s < d->settings; s++) {
        take(m, d, s, m->values);
        d->details[s] = summarise(m, d->metric, m->values);
    }
    return ll_ok();
}

static int count_of(const ll_experiment *e, int dimension)
{
    int64_t values = values_of(e, dimension);
    return values > LL_DIFFERENCE_VALUES_MAX ? 0 : (int)(values * (values - 1) / 2) * e->metric_count;
}

/* All pairs of all dimensions, the error metric first: its details have the first claim on the time. */
static void list_all(maker *m)
{
    const ll_experiment *e = m->rows->experiment;
    for (int k = 0; k < e->metric_count; k++)
        for (int d = 0; d < e->dimension_count; d++)
            for (int from = 0, n = count_of(e, d) ? (int)values_of(e, d) : 0; from < n; from++)
                for (int of = from + 1; of < n; of++)
                    m->to->list[m->to->count++] = (ll_difference){.dimension = d,
                                                                  .metric = k == 0 ? e->error_metric
                                                                            : k <= e->error_metric ? k - 1
                                                                                                   : k,
                                                                  .from = from,
                                                                  .of = of,
                                                                  .settings = e->points / values_of(e, d)};
}

ll_status ll_differences_make(const ll_report_rows *rows, ll_differences *to)
{
    const ll_experiment *e = rows->experiment;
    size_t repeats = (size_t)e->head.repeats, count = 0;
    maker m = {.rows = rows, .to = to};
    ll_status status = ll_ok();
    bool none = e->head.sample.method != LL_SAMPLE_NONE || rows->kept < e->head.repeats;
    *to = (ll_differences){0};
    for (int d = 0; d < e->dimension_count && !none; d++)
        count += (size_t)count_of(e, d);
    if (count == 0)
        return ll_ok();
    to->list = calloc(count, sizeof *to->list);
    double *space = malloc(3 * repeats * sizeof *space);
    if (!to->list || !space) {
        free(space);
        ll_differences_free(to);
        return ll_error(LL_NO_MEMORY, "out of memory: differences");
    }
    m.values = space;
    m.scratch = space + repeats;
    list_all(&m);
    for (int i = 0; i < to->count; i++)
        compare_all(&m, &to->list[i], space + 2 * repeats);
    for (int i = 0; i < to->count && !ll_failed(&status); i++)
        status = add_details(&m, &to->list[i]);
    ll_resampler_free(&m.resampler);
    free(space);
    return status;
}

void ll_differences_free(ll_differences *d)
{
    for (int i = 0; i < d->count; i++)
        free(d->list[i].details);
    free(d->list);
    *d = (ll_differences){0};
}

#include "experiment/spec/until.h"

#include <math.h>
#include <stdlib.h>

#include "experiment/spec/metric_path.h"
#include "experiment/statistics/summary.h"

#define ERROR_95 0.05

/* Reduction of the error per check after the first: found with normal, exponential and lognormal values, so
 * that the coverage of the final interval has the level again. */
#define PER_LOOK 0.125

bool ll_until_is_set(const ll_experiment *e)
{
    return e->head.until.half_width > 0 || e->head.until.relative > 0;
}

/* Number of runs at the check after the one with `made` runs. */
static int64_t next_check(const ll_experiment *e, int64_t made)
{
    return 2 * made < e->head.repeats ? 2 * made : e->head.repeats;
}

int ll_until_checks(const ll_experiment *e)
{
    int looks = 1;
    for (int64_t n = e->head.until.least; ll_until_is_set(e) && n < e->head.repeats; n = next_check(e, n))
        looks++;
    return looks;
}

static bool is_check(const ll_experiment *e, int64_t made)
{
    int64_t n = e->head.until.least;
    while (n < made)
        n = next_check(e, n);
    return n == made;
}

/* Seconds of a run that count for rates. */
static double counted_s(const ll_experiment *e, int64_t point, double t_s)
{
    ll_scenario scenario = {0};
    void *warmup = NULL;
    ll_status status = ll_experiment_open(e, point * e->head.repeats, &scenario);
    if (!ll_failed(&status) && ll_param_find(scenario.kind->table, scenario.config, "warmup_s", &warmup) &&
        warmup)
        t_s -= *(const double *)warmup;
    ll_scenario_free(&scenario);
    return t_s;
}

ll_interval_request ll_experiment_interval_request(const ll_experiment *e, int metric, int64_t point,
                                                   double t_s)
{
    ll_interval_request request = {.scale = e->scales[metric],
                                   .error = ERROR_95 / (1 + (ll_until_checks(e) - 1) * PER_LOOK),
                                   .use_t = e->head.interval == LL_INTERVALS_T};
    if (request.scale == LL_SCALE_COUNT && ll_metric_is_rate(e->metrics[metric])) {
        double seconds = isfinite(t_s) ? counted_s(e, point, t_s) : 0;
        if (seconds > 0)
            request.unit = 1 / seconds;
        else
            request.scale = LL_SCALE_AMOUNT;
    }
    return request;
}

bool ll_until_is_met(const ll_experiment *e, const ll_summary *s)
{
    double half = ll_interval_half(&s->of_mean);
    return !ll_until_is_set(e) || half <= e->head.until.half_width ||
           half <= e->head.until.relative * fabs(s->mean);
}

bool ll_until_reached(const ll_experiment *e, const ll_row *rows, int64_t made, ll_resampler *resampler)
{
    if (!ll_until_is_set(e) || !is_check(e, made))
        return false;
    double *values = malloc((size_t)made * sizeof *values), t_s = rows[0].t_s;
    int metric = e->until_metric;
    int64_t n = 0;
    for (int64_t k = 0; values && k < made; k++) {
        if (isfinite(rows[k].metrics[metric]))
            values[n++] = rows[k].metrics[metric];
        t_s = rows[k].t_s == t_s ? t_s : NAN;
    }
    ll_interval_request request =
        ll_experiment_interval_request(e, metric, rows[0].run / e->head.repeats, t_s);
    request.values = values;
    request.n = n;
    bool reached = false;
    if (values && n > 0) {
        ll_summary summary = ll_summarise(&request, values, resampler);
        reached = ll_until_is_met(e, &summary);
    }
    free(values);
    return reached;
}

void ll_until_skip(int64_t run, ll_row *row)
{
    ll_row_clear(row);
    row->run = run;
    row->status = LL_ROW_SKIPPED;
}

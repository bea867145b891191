/* Rows of sensitivity indices: one per metric and dimension of the axes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/format/table_internal.h"
#include "experiment/statistics/sensitivity.h"

/* Means of one metric over the repeats of each point. */
static ll_status read_means(ll_result_table *t, double *means)
{
    const ll_experiment *e = t->experiment;
    ll_status status = ll_ok();
    int64_t all = e->metric_count * e->points;
    double *counts = calloc((size_t)all, sizeof *counts);
    if (!counts)
        return ll_error(LL_NO_MEMORY, "out of memory: means of points");
    memset(means, 0, (size_t)all * sizeof *means);
    while (t->source(t->context, &t->row, &status))
        for (int i = 0; i < e->metric_count; i++) {
            int64_t at = i * e->points + t->row.run / e->head.repeats;
            double value = t->row.metrics[i];
            if (!isfinite(value))
                continue;
            counts[at]++;
            means[at] += (value - means[at]) / counts[at];
        }
    for (int64_t k = 0; k < all; k++)
        if (counts[k] == 0)
            means[k] = NAN;
    free(counts);
    return status;
}

/* Name of zipped axes, `a + b`. */
static void name_dimension(const ll_experiment *e, int dimension, char *name, size_t size)
{
    size_t used = 0;
    name[0] = '\0';
    for (int a = 0; a < e->axis_count && used < size; a++)
        if (e->dimension[a] == dimension)
            used += (size_t)snprintf(name + used, size - used, "%s%s", used ? " + " : "", e->axes[a].path);
}

#define SENSITIVITY_COLUMNS(X)                                                                               \
    X(text, metric, NULL, e->metrics[metric], "path of the metric", NULL)                                    \
    X(text, parameter, NULL, t->paths[0], "path of the parameter; of zipped axes all", NULL)                 \
    X(number, first, NULL, s->first, "first-order Sobol index: share of the variance by it alone", MISSING)  \
    X(number, first_low, NULL, s->first_low, "lower bound of its 95 % interval", MISSING)                    \
    X(number, first_high, NULL, s->first_high, "upper bound of its 95 % interval", MISSING)                  \
    X(number, total, NULL, s->total, "total Sobol index: share of the variance with all interactions",       \
      MISSING)                                                                                               \
    X(number, total_low, NULL, s->total_low, "lower bound of its 95 % interval", MISSING)                    \
    X(number, total_high, NULL, s->total_high, "upper bound of its 95 % interval", MISSING)                  \
    X(count, samples, NULL, s->samples, "base samples whose points all have the metric", NULL)
#define MISSING "Too few points have the metric, or it does not vary."

const ll_metric_table ll_sensitivity_columns = {.path = "",
                                                .when = "Tables of sensitivity.",
                                                .help = "A metric and a parameter.",
                                                LL_METRICS_FROM(SENSITIVITY_COLUMNS)};

static bool next_index(void *context, ll_cell *cells, ll_status *status)
{
    ll_result_table *t = context;
    const ll_experiment *e = t->experiment;
    (void)status;
    if (t->point == e->metric_count * e->dimension_count)
        return false;
    int metric = (int)(t->point / e->dimension_count), dimension = (int)(t->point % e->dimension_count);
    const ll_sensitivity *s = &t->indices[t->point++];
    name_dimension(e, dimension, t->paths[0], sizeof t->paths[0]);
    LL_CELLS_PUT(cells, &ll_sensitivity_columns, SENSITIVITY_COLUMNS);
    return true;
}

static ll_status find_indices(ll_result_table *t)
{
    const ll_experiment *e = t->experiment;
    int d = e->dimension_count;
    t->held = malloc((size_t)(e->metric_count * e->points) * sizeof *t->held);
    t->indices = calloc((size_t)(e->metric_count * d), sizeof *t->indices);
    ll_status status = t->held && t->indices ? read_means(t, t->held)
                                             : ll_error(LL_NO_MEMORY, "out of memory: sensitivity indices");
    for (int i = 0; i < e->metric_count && !ll_failed(&status); i++)
        status =
            ll_sensitivity_of(t->held + i * e->points, e->head.sample.count, d, t->indices + (int64_t)i * d);
    return status;
}

ll_status ll_result_table_sensitivity(const ll_experiment *e, ll_row_source *source, void *context,
                                      ll_result_table **table)
{
    *table = NULL;
    if (e->head.sample.method != LL_SAMPLE_SALTELLI || e->dimension_count == 0)
        return ll_field_error(LL_BAD_INPUT, "sample.method", "sensitivity: sample.method: must be saltelli");
    ll_status status = ll_table_make(e, source, context, table);
    LL_THEN(status, find_indices(*table));
    if (ll_failed(&status)) {
        ll_result_table_free(*table);
        *table = NULL;
        return status;
    }
    ll_result_table *t = *table;
    t->point = 0;
    ll_table_add_columns(t, "", &ll_sensitivity_columns);
    t->table = (ll_table){t->columns, t->column_count, next_index, t};
    return status;
}

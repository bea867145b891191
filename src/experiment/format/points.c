#include "experiment/format/points.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"

/* Position of a value of an axis in plots: see `places`. */
static double axis_place(const ll_axis *axis, const cJSON *value)
{
    const cJSON *item;
    int k = 0;
    if (axis->type == LL_CELL_REAL || axis->type == LL_CELL_INT)
        return value->valuedouble;
    cJSON_ArrayForEach(item, axis->values)
    {
        if (cJSON_Compare(item, value, true))
            return k;
        k++;
    }
    return k;
}

/* Reads the columns of ll_result_table_points: point, parameters, runs, failed, identical, then those of
 * metrics. */
static ll_status take(const ll_experiment *e, ll_result_table *table, const ll_cell *cells, ll_point *p)
{
    const ll_table *t = ll_result_table_get(table);
    const ll_sums *sums = ll_result_table_sums(table);
    int at = 0;
    while (strcmp(t->columns[at].name, "runs") != 0 || strcmp(t->columns[at + 1].name, "failed") != 0)
        at++;
    p->point = (int64_t)cells[0].number;
    p->runs = (int64_t)cells[at].number;
    p->failed = (int64_t)cells[at + 1].number;
    cJSON *values = ll_experiment_point(e, p->point);
    if (!values)
        return ll_error(LL_NO_MEMORY, "out of memory: points");
    for (int a = 0; a < e->axis_count; a++)
        p->places[a] = axis_place(&e->axes[a], cJSON_GetObjectItemCaseSensitive(values, e->axes[a].path));
    cJSON_Delete(values);
    memcpy(p->metrics, ll_result_table_summaries(table), (size_t)e->metric_count * sizeof *p->metrics);
    for (int i = 0; i < e->metric_count; i++)
        p->size[i] = sums[i].n > 0 && sums[i].n == p->runs + p->failed ? sums[i].size : NAN;
    return ll_ok();
}

static ll_status add_room(const ll_experiment *e, int64_t most, ll_points *points)
{
    size_t metrics = (size_t)e->metric_count, numbers = metrics + (size_t)e->axis_count, n = (size_t)most;
    points->points = calloc(n, sizeof *points->points);
    points->numbers = malloc(n * numbers * sizeof *points->numbers);
    points->summaries = malloc(n * metrics * sizeof *points->summaries);
    if (!points->points || !points->numbers || !points->summaries)
        return ll_error(LL_NO_MEMORY, "out of memory: points");
    for (size_t i = 0; i < n; i++) {
        points->points[i].size = points->numbers + i * numbers;
        points->points[i].places = points->points[i].size + metrics;
        points->points[i].metrics = points->summaries + i * metrics;
    }
    return ll_ok();
}

/* If there are more points than the limit, keeps slightly fewer, chosen at random: every n-th point would
 * have the same value of the fastest axis. */
static bool is_held(const ll_experiment *e, int64_t point, int64_t most)
{
    enum { STREAM = 0x504f };
    return e->points <= most ||
           ll_rng_unit(0, STREAM, (uint64_t)point) * (double)e->points < 0.98 * (double)most;
}

ll_status ll_points_read(const ll_experiment *e, ll_row_source *source, void *context, ll_points *points)
{
    ll_result_table *table = NULL;
    ll_cell cells[LL_COLUMNS_MAX];
    int64_t room = LL_POINTS_CELLS_MAX / e->metric_count, most = e->points < room ? e->points : room;
    *points = (ll_points){0};
    ll_status status = add_room(e, most, points);
    LL_THEN(status, ll_result_table_points(e, source, context, &table));
    const ll_table *t = table ? ll_result_table_get(table) : NULL;
    while (!ll_failed(&status) && t->next(t->context, cells, &status))
        if (points->count == most || !is_held(e, (int64_t)cells[0].number, most))
            continue;
        else
            status = take(e, table, cells, &points->points[points->count++]);
    if (table) {
        points->identical = ll_result_table_identical(table);
        points->notices = ll_result_table_notices(table);
    }
    ll_result_table_free(table);
    if (ll_failed(&status))
        ll_points_free(points);
    return status;
}

void ll_points_free(ll_points *points)
{
    cJSON_Delete(points->notices);
    free(points->points);
    free(points->numbers);
    free(points->summaries);
    *points = (ll_points){0};
}

/* ---- the front ---- */

typedef struct ranked {
    const ll_points *points;
    const int *metrics;
    int count;
} ranked;

static int by_all(const void *a, const void *b, void *context)
{
    const ranked *r = context;
    int x = *(const int *)a, y = *(const int *)b;
    for (int i = 0; i < r->count; i++) {
        double p = r->points->points[x].size[r->metrics[i]], q = r->points->points[y].size[r->metrics[i]];
        if (p != q)
            return p < q ? -1 : 1;
    }
    return x - y;
}

static bool dominates(const ranked *r, const ll_point *a, const ll_point *b)
{
    bool better = false;
    for (int i = 0; i < r->count; i++) {
        double x = a->size[r->metrics[i]], y = b->size[r->metrics[i]];
        if (x > y)
            return false;
        better |= x < y;
    }
    return better;
}

/* In order of the first metric, a point can be beaten only by earlier ones; of these, comparing with those on
 * the front is enough (Kung, Luccio and Preparata 1975, without its division). */
void ll_points_mark_front(ll_points *points, const int *metrics, int count)
{
    ranked r = {points, metrics, count};
    int *order = malloc((size_t)points->count * sizeof *order),
        *front = malloc((size_t)points->count * sizeof *front);
    int n = 0, on = 0;
    for (int i = 0; order && front && i < points->count; i++) {
        bool known = true;
        for (int k = 0; k < count; k++)
            known &= (bool)isfinite(points->points[i].size[metrics[k]]);
        points->points[i].front = false;
        if (known)
            order[n++] = i;
    }
    if (n > 0)
        qsort_r(order, (size_t)n, sizeof *order, by_all, &r);
    for (int i = 0; i < n; i++) {
        ll_point *p = &points->points[order[i]];
        bool beaten = false;
        int least = count == 2 && on > 0
                        ? on - 1
                        : 0; /* with two metrics, the last one on the front has the smallest second metric */
        for (int k = on - 1; k >= least && !beaten; k--)
            beaten = dominates(&r, &points->points[front[k]], p);
        p->front = !beaten;
        if (!beaten)
            front[on++] = order[i];
    }
    free(order);
    free(front);
}

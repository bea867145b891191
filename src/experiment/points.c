#include "experiment/points.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

char *ll_point_name(const cJSON *values)
{
    char *text = NULL;
    size_t size;
    FILE *memory = open_memstream(&text, &size);
    const cJSON *item;
    if (!memory)
        return NULL;
    cJSON_ArrayForEach(item, values)
    {
        fprintf(memory, "%s%s ", item == values->child ? "" : ", ", item->string);
        if (cJSON_IsString(item))
            fputs(item->valuestring, memory);
        else if (cJSON_IsBool(item))
            fputs(cJSON_IsTrue(item) ? "true" : "false", memory);
        else
            fprintf(memory, "%.6g", item->valuedouble);
    }
    fclose(memory);
    return text;
}

/* The columns of ll_result_table_points: point, parameters, runs, failed, identical, then those of metrics.
 */
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
    p->values = ll_experiment_point(e, p->point);
    p->name = ll_point_name(p->values);
    p->metrics = malloc((size_t)e->metric_count * sizeof *p->metrics);
    if (!p->values || !p->name || !p->metrics)
        return ll_error(LL_NO_MEMORY, "no memory for points");
    memcpy(p->metrics, ll_result_table_summaries(table), (size_t)e->metric_count * sizeof *p->metrics);
    for (int i = 0; i < e->metric_count; i++)
        p->size[i] = sums[i].n > 0 && sums[i].n == p->runs + p->failed ? sums[i].size : NAN;
    return ll_ok();
}

ll_status ll_points_read(const ll_experiment *e, ll_row_source *source, void *context, ll_points *points)
{
    ll_result_table *table = NULL;
    ll_cell cells[LL_COLUMNS_MAX];
    int64_t most = e->points < LL_POINTS_MAX ? e->points : LL_POINTS_MAX;
    *points = (ll_points){.points = calloc((size_t)most, sizeof *points->points)};
    ll_status status = points->points ? ll_result_table_points(e, source, context, &table)
                                      : ll_error(LL_NO_MEMORY, "no memory for points");
    const ll_table *t = table ? ll_result_table_get(table) : NULL;
    while (!ll_failed(&status) && t->next(t->context, cells, &status))
        if (points->count == most)
            points->left_out++;
        else
            status = take(e, table, cells, &points->points[points->count++]);
    if (table)
        points->identical = ll_result_table_identical(table);
    ll_result_table_free(table);
    if (ll_failed(&status))
        ll_points_free(points);
    return status;
}

void ll_points_free(ll_points *points)
{
    for (int i = 0; i < points->count; i++) {
        cJSON_Delete(points->points[i].values);
        free(points->points[i].name);
        free(points->points[i].metrics);
    }
    free(points->points);
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

/* In the order of the metrics what beats a point is before it; of these those on the front are enough (Kung,
 * Luccio and Preparata 1975, without its division). */
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
        for (int k = 0; k < on && !beaten; k++)
            beaten = dominates(&r, &points->points[front[k]], p);
        p->front = !beaten;
        if (!beaten)
            front[on++] = order[i];
    }
    free(order);
    free(front);
}

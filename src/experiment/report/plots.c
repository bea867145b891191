#include "experiment/report/plots.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/report/plot.h"
#include "experiment/spec/metric_path.h"

enum { NAMED_MAX = 16, NAME_MAX = 64 }; /* NAMED_MAX: values of a dimension that get names */

/* A dimension: an axis, or several zipped ones. */
typedef struct dimension {
    int first, axes;
    int values; /* named values; 0: x is numeric, and the dimension makes no series */
    bool named; /* x is the index of the value */
    char name[NAMED_MAX][NAME_MAX];
    double places[NAMED_MAX][LL_EXPERIMENT_AXES_MAX];
    char title[LL_COLUMN_NAME_MAX];
} dimension;

typedef struct plots {
    const ll_experiment *e;
    const ll_points *points;
    const char *where;
    dimension *dimensions;
    ll_plot_point *drawn; /* space for all points */
    FILE *file;
} plots;

static bool numeric(const ll_axis *axis)
{
    return axis->type == LL_CELL_REAL || axis->type == LL_CELL_INT;
}

static void value_text(const cJSON *value, char text[NAME_MAX])
{
    if (cJSON_IsString(value))
        snprintf(text, NAME_MAX, "%s", value->valuestring);
    else if (cJSON_IsBool(value))
        snprintf(text, NAME_MAX, "%s", cJSON_IsTrue(value) ? "on" : "off");
    else
        snprintf(text, NAME_MAX, "%.6g", value ? value->valuedouble : NAN);
}

static void append(char *text, size_t size, const char *more)
{
    size_t used = strlen(text);
    snprintf(text + used, size - used, "%s%s", used ? ", " : "", more);
}

static void read_values(const ll_experiment *e, dimension *d)
{
    for (int k = 0; k < d->values; k++)
        for (int a = 0; a < d->axes; a++) {
            char text[NAME_MAX];
            const ll_axis *axis = &e->axes[d->first + a];
            cJSON *value = ll_axis_at(axis, k);
            d->places[k][a] = ll_axis_place(axis, value);
            value_text(value, text);
            append(d->name[k], NAME_MAX, text);
            cJSON_Delete(value);
        }
}

static void read_dimension(const ll_experiment *e, int which, dimension *d)
{
    bool drawn = false, choice = false;
    *d = (dimension){0};
    while (e->dimension[d->first] != which)
        d->first++;
    for (int a = d->first; a < e->axis_count && e->dimension[a] == which; a++, d->axes++) {
        const ll_param *row = ll_param_find(e->base.kind->table, e->base.config, e->axes[a].path, NULL);
        char column[LL_COLUMN_NAME_MAX];
        ll_axis_column(e->axes[a].path, row ? row->unit : NULL, column, sizeof column);
        append(d->title, sizeof d->title, column);
        drawn |= e->axes[a].sampled;
        choice |= !numeric(&e->axes[a]);
    }
    if (!drawn && e->axes[d->first].count <= NAMED_MAX)
        d->values = (int)e->axes[d->first].count;
    d->named = d->values > 0 && choice;
    read_values(e, d);
}

/* Index of a point's value; of duplicate values the first. */
static int value_of(const dimension *d, const ll_point *p)
{
    for (int k = 0; k < d->values; k++) {
        bool same = true;
        for (int a = 0; a < d->axes; a++)
            same &= d->places[k][a] == p->places[d->first + a];
        if (same)
            return k;
    }
    return 0;
}

/* The dimension that colours a plot along `but`: preferably one with names. */
static const dimension *series_of(const plots *r, const dimension *but)
{
    const dimension *found = NULL;
    for (int k = 0; k < r->e->dimension_count; k++) {
        const dimension *d = &r->dimensions[k];
        bool fits = d != but && d->values > 1 && d->values <= LL_PLOT_COLOURS;
        if (fits && (!found || (d->named && !found->named)))
            found = d;
    }
    return found;
}

/* ---- one plot ---- */

static int by_x(const void *a, const void *b)
{
    const ll_plot_point *p = a, *q = b;
    if (p->x != q->x)
        return (p->x > q->x) - (p->x < q->x);
    return (p->point > q->point) - (p->point < q->point);
}

/* Name of what is drawn and compared of a metric: its magnitude, if it is signed. */
static const char *name_of(const ll_experiment *e, int metric, char name[LL_COLUMN_NAME_MAX])
{
    bool is_signed = ll_metric_is_signed(e->base.kind, e->metrics[metric]);
    snprintf(name, LL_COLUMN_NAME_MAX, is_signed ? "|%s|" : "%s", e->metrics[metric]);
    return name;
}

/* A point as drawn, by magnitude: with bounds only if all runs have the same sign. */
static ll_plot_point drawn(const ll_point *from, int metric)
{
    const ll_summary *m = &from->metrics[metric];
    double size = from->size[metric], rest = 1e-9 * size;
    ll_plot_point p = {.y = size, .low = NAN, .high = NAN, .point = from->point};
    if (fabs(m->mean - size) <= rest) {
        p.low = m->of_mean.low;
        p.high = m->of_mean.high;
    } else if (fabs(m->mean + size) <= rest) {
        p.low = -m->of_mean.high;
        p.high = -m->of_mean.low;
    }
    return p;
}

static void write_point_name(const void *context, int64_t point, FILE *file)
{
    cJSON *values = ll_experiment_point(context, point);
    char *name = ll_point_name(values);
    ll_html_text(name ? name : "", file);
    free(name);
    cJSON_Delete(values);
}

/* Draws a metric over the x of `drawn`, which the caller has set. */
static ll_status write(const plots *r, ll_plot *plot, const dimension *series)
{
    const char *names[LL_PLOT_COLOURS];
    for (int i = 0; series && i < r->points->count; i++)
        r->drawn[i].series = value_of(series, &r->points->points[i]);
    for (int k = 0; series && k < series->values; k++)
        names[k] = series->name[k];
    qsort(r->drawn, (size_t)r->points->count, sizeof *r->drawn, by_x);
    plot->points = r->drawn;
    plot->count = r->points->count;
    plot->series = series ? names : NULL;
    plot->series_count = series ? series->values : 0;
    plot->series_name = series ? series->title : NULL;
    plot->write_name = write_point_name;
    plot->context = r->e;
    plot->marks_max = LL_REPORT_MARKS_MAX;
    plot->rows_max = LL_REPORT_ROWS_SHOWN;
    plot->where = r->where;
    return ll_plot_write(plot, r->file);
}

static ll_status write_trade(const plots *r)
{
    const ll_experiment *e = r->e;
    int x = e->cost_metric, y = e->error_metric;
    char x_name[LL_COLUMN_NAME_MAX], y_name[LL_COLUMN_NAME_MAX];
    for (int i = 0; i < r->points->count; i++) {
        const ll_point *from = &r->points->points[i];
        r->drawn[i] = drawn(from, y);
        r->drawn[i].x = from->size[x];
        r->drawn[i].front = from->front;
    }
    fputs("<h2>Error against cost</h2><p>Left is cheap, low is accurate. Marked points are the Pareto front: "
          "no other point is better in both. Points with a failed run are not drawn.</p>\n",
          r->file);
    return write(r,
                 &(ll_plot){.title = "Error against cost",
                            .x_name = name_of(e, x, x_name),
                            .y_name = name_of(e, y, y_name),
                            .log_x = true,
                            .log_y = true,
                            .apart = e->front_count > 2,
                            .width = 760,
                            .height = 420},
                 series_of(r, NULL));
}

static ll_status write_along(const plots *r, const dimension *d, int metric)
{
    const ll_axis *axis = &r->e->axes[d->first];
    const char *choices[NAMED_MAX];
    char name[LL_COLUMN_NAME_MAX], title[2 * LL_COLUMN_NAME_MAX + 8];
    for (int i = 0; i < r->points->count; i++) {
        const ll_point *from = &r->points->points[i];
        r->drawn[i] = drawn(from, metric);
        r->drawn[i].x = d->named ? value_of(d, from) : from->places[d->first];
    }
    for (int k = 0; k < d->values; k++)
        choices[k] = d->name[k];
    snprintf(title, sizeof title, "%s along %s", name_of(r->e, metric, name), d->title);
    return write(r,
                 &(ll_plot){.title = title,
                            .x_name = d->title,
                            .y_name = name,
                            .choices = d->named ? choices : NULL,
                            .choice_count = d->values,
                            .log_x = axis->scale == 1,
                            .log_y = true,
                            .width = 400,
                            .height = 260},
                 series_of(r, d));
}

/* ---- all ---- */

/* The k-th metric in the order of drawing: the error first. */
static int metric_at(const ll_experiment *e, int k)
{
    return k == 0 ? e->error_metric : k <= e->error_metric ? k - 1 : k;
}

static ll_status write_multiples(const plots *r)
{
    const ll_experiment *e = r->e;
    int all = e->metric_count * e->dimension_count, left = LL_REPORT_MULTIPLES_MAX;
    ll_status status = ll_ok();
    fputs("<h2>Along each axis</h2><div class=\"multiples\">\n", r->file);
    for (int k = 0; k < e->metric_count && !ll_failed(&status); k++)
        for (int d = 0; d < e->dimension_count && left > 0 && !ll_failed(&status); d++, left--)
            status = write_along(r, &r->dimensions[d], metric_at(e, k));
    fputs("</div>\n", r->file);
    if (all > LL_REPORT_MULTIPLES_MAX)
        fprintf(r->file,
                "<p class=\"note\">%d of %d plots are shown: the error first, then the other metrics along "
                "each axis. All values are in %s.</p>\n",
                LL_REPORT_MULTIPLES_MAX, all, r->where);
    return status;
}

ll_status ll_report_plots_write(const ll_experiment *e, const ll_points *points, const char *where,
                                FILE *file)
{
    plots r = {.e = e, .points = points, .where = where, .file = file};
    ll_status status = ll_ok();
    r.dimensions = calloc((size_t)e->dimension_count + 1, sizeof *r.dimensions);
    r.drawn = calloc((size_t)points->count + 1, sizeof *r.drawn);
    if (!r.dimensions || !r.drawn)
        status = ll_error(LL_NO_MEMORY, "out of memory: plots");
    for (int d = 0; d < e->dimension_count && !ll_failed(&status); d++)
        read_dimension(e, d, &r.dimensions[d]);
    if (!ll_failed(&status) && e->cost_metric >= 0)
        status = write_trade(&r);
    if (!ll_failed(&status) && e->dimension_count > 0)
        status = write_multiples(&r);
    free(r.dimensions);
    free(r.drawn);
    return status;
}

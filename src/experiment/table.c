#include "experiment/table.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct ll_result_table {
    const ll_experiment *experiment;
    const char *version;
    ll_row_source *source;
    void *context;
    ll_column columns[LL_COLUMNS_MAX];
    int column_count, parameter_count;
    char paths[LL_COLUMNS_MAX][LL_EXPERIMENT_PATH_MAX + 8]; /* of the parameters' columns */
    bool varied[LL_COLUMNS_MAX];
    int64_t point; /* whose values are held */
    cJSON *values;
    ll_row row; /* the one being written, or the first of the next point */
    bool row_held;
    int64_t identical;                       /* points so far whose repeats gave the same */
    ll_sums sums[LL_EXPERIMENT_METRICS_MAX]; /* of the point */
    char hash[17];
    ll_table table;
};

/* ---- columns ---- */

static ll_column *add_column(ll_result_table *t, const char *name, ll_cell_type type, bool nullable)
{
    ll_column *column = &t->columns[t->column_count++];
    snprintf(column->name, sizeof column->name, "%s", name);
    column->type = type;
    column->nullable = nullable;
    return column;
}

static void add_parameter(ll_result_table *t, const char *path, bool varied)
{
    const ll_scenario *base = &t->experiment->base;
    const ll_param *row = ll_param_find(base->kind->table, base->config, path, NULL);
    char name[LL_COLUMN_NAME_MAX];
    if (!row || row->type >= LL_PARAM_OBJECT ||
        t->column_count > LL_COLUMNS_MAX - 3 * LL_EXPERIMENT_METRICS_MAX)
        return; /* an object or an array among the fixed ones: the specification tells it */
    ll_axis_column(path, row->unit, name, sizeof name);
    snprintf(t->paths[t->parameter_count], sizeof t->paths[0], "%s", path);
    t->varied[t->parameter_count++] = varied;
    add_column(t, name, ll_axis_type(row), false);
}

static bool on_axis(const ll_experiment *e, const char *path)
{
    for (int i = 0; i < e->axis_count; i++)
        if (strcmp(e->axes[i].path, path) == 0)
            return true;
    return false;
}

static void add_parameters(ll_result_table *t)
{
    const cJSON *item;
    for (int i = 0; i < t->experiment->axis_count; i++)
        add_parameter(t, t->experiment->axes[i].path, true);
    cJSON_ArrayForEach(item, t->experiment->set) if (!on_axis(t->experiment, item->string))
        add_parameter(t, item->string, false);
}

static ll_status make(const ll_experiment *e, ll_row_source *source, void *context, ll_result_table **table)
{
    ll_result_table *t = *table = calloc(1, sizeof *t);
    if (!t)
        return ll_error(LL_NO_MEMORY, "no memory for a table");
    t->experiment = e;
    t->source = source;
    t->context = context;
    t->point = -1;
    return ll_ok();
}

/* ---- cells ---- */

static ll_cell number(double value)
{
    return (ll_cell){.null = isnan(value), .number = value};
}

static ll_cell text(const char *value)
{
    return (ll_cell){.null = value[0] == '\0', .text = value};
}

/* Fixed values stay those that were given; varied ones change with the point. */
static ll_cell parameter(const ll_result_table *t, int i)
{
    const cJSON *from = t->varied[i] ? t->values : t->experiment->set;
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(from, t->paths[i]);
    if (cJSON_IsString(value))
        return (ll_cell){.text = value->valuestring};
    return number(cJSON_IsBool(value) ? cJSON_IsTrue(value) : value ? value->valuedouble : NAN);
}

static void hold_point(ll_result_table *t, int64_t point)
{
    if (t->point == point)
        return;
    cJSON_Delete(t->values);
    t->values = ll_experiment_point(t->experiment, point);
    t->point = point;
}

static bool next_row(void *context, ll_cell *cells, ll_status *status)
{
    ll_result_table *t = context;
    const ll_experiment *e = t->experiment;
    ll_row *r = &t->row;
    if (!t->source(t->context, r, status))
        return false;
    hold_point(t, r->run / e->head.repeats);
    *cells++ = number((double)r->run);
    *cells++ = number((double)t->point);
    *cells++ = number((double)(r->run % e->head.repeats));
    *cells++ = number((double)ll_experiment_seed(e, r->run));
    for (int i = 0; i < t->parameter_count; i++)
        *cells++ = parameter(t, i);
    snprintf(t->hash, sizeof t->hash, "%016" PRIx64, r->hash);
    *cells++ = text(ll_row_status_names[r->status]);
    *cells++ = text(r->error);
    *cells++ = text(t->hash);
    *cells++ = number(r->t_s);
    for (int i = 0; i < e->metric_count; i++)
        *cells++ = number(r->metrics[i]);
    *cells++ = text(t->version);
    return true;
}

ll_status ll_result_table_rows(const ll_experiment *e, const char *version, ll_row_source *source,
                               void *context, ll_result_table **table)
{
    ll_status status = make(e, source, context, table);
    if (ll_failed(&status))
        return status;
    ll_result_table *t = *table;
    t->version = version;
    add_column(t, "run", LL_CELL_INT, false);
    add_column(t, "point", LL_CELL_INT, false);
    add_column(t, "repeat", LL_CELL_INT, false);
    add_column(t, "seed", LL_CELL_INT, false);
    add_parameters(t);
    add_column(t, "status", LL_CELL_TEXT, false);
    add_column(t, "error", LL_CELL_TEXT, true);
    add_column(t, "hash", LL_CELL_TEXT, false);
    add_column(t, "t_s", LL_CELL_REAL, false);
    for (int i = 0; i < e->metric_count; i++)
        add_column(t, e->metrics[i], LL_CELL_REAL, true);
    add_column(t, "version", LL_CELL_TEXT, true);
    t->table = (ll_table){t->columns, t->column_count, next_row, t};
    return status;
}

/* ---- points ---- */

double ll_interval_95(int64_t n, double squares)
{
    /* Quantile 0.975 of Student's t; beyond the table by Cornish and Fisher's expansion from the normal's. */
    static const double quantiles[] = {12.7062047364, 4.3026527297, 3.1824463053, 2.7764451052, 2.5705818366,
                                       2.4469118511,  2.3646242516, 2.3060041352, 2.2621571628, 2.2281388520};
    enum { KNOWN = sizeof quantiles / sizeof quantiles[0] };
    const double z = 1.9599639845400545, z2 = z * z;
    double df = (double)(n - 1), t;
    if (df <= KNOWN)
        t = quantiles[n - 2];
    else
        t = z * (1 + (z2 + 1) / (4 * df) + ((5 * z2 + 16) * z2 + 3) / (96 * df * df) +
                 (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * df * df * df) +
                 ((((79 * z2 + 776) * z2 + 1482) * z2 - 1920) * z2 - 945) / (92160 * df * df * df * df));
    return t * sqrt(squares / df / (double)n);
}

void ll_sums_add(ll_sums *s, double value)
{
    if (isnan(value))
        return;
    s->n++;
    double delta = value - s->mean;
    s->mean += delta / (double)s->n;
    s->squares += delta * (value - s->mean);
    s->size += (fabs(value) - s->size) / (double)s->n;
}

const ll_sums *ll_result_table_sums(const ll_result_table *t)
{
    return t->sums;
}

/* NaN: there is none. */
static bool same_metrics(const ll_experiment *e, const double *a, const double *b)
{
    for (int i = 0; i < e->metric_count; i++)
        if (a[i] != b[i] && !(isnan(a[i]) && isnan(b[i])))
            return false;
    return true;
}

/* The runs of a point; those that ended well are compared. */
typedef struct repeats {
    int64_t good, failed;
    bool differ;
    double first[LL_EXPERIMENT_METRICS_MAX];
    ll_sums *sums;
} repeats;

static void add_run(repeats *r, const ll_experiment *e, const ll_row *row)
{
    for (int i = 0; i < e->metric_count; i++)
        ll_sums_add(&r->sums[i], row->metrics[i]);
    if (!ll_row_good(row)) {
        r->failed++;
        return;
    }
    if (r->good++ == 0)
        memcpy(r->first, row->metrics, sizeof r->first);
    r->differ = r->differ || !same_metrics(e, r->first, row->metrics);
}

static bool next_point(void *context, ll_cell *cells, ll_status *status)
{
    ll_result_table *t = context;
    const ll_experiment *e = t->experiment;
    repeats r = {.sums = t->sums};
    if (!t->row_held && !t->source(t->context, &t->row, status))
        return false;
    int64_t point = t->row.run / e->head.repeats;
    memset(t->sums, 0, sizeof t->sums);
    do {
        add_run(&r, e, &t->row);
        t->row_held = t->source(t->context, &t->row, status);
    } while (t->row_held && t->row.run / e->head.repeats == point);
    if (ll_failed(status))
        return false;
    hold_point(t, point);
    *cells++ = number((double)point);
    for (int i = 0; i < t->parameter_count; i++)
        *cells++ = parameter(t, i);
    bool known = r.good > 1 && r.differ;
    t->identical += r.good > 1 && !r.differ;
    *cells++ = number((double)r.good);
    *cells++ = number((double)r.failed);
    *cells++ = number(r.good > 1 ? !r.differ : NAN);
    for (int i = 0; i < e->metric_count; i++) {
        const ll_sums *s = &t->sums[i];
        *cells++ = number(s->n > 0 ? s->mean : NAN);
        *cells++ = number(known && s->n > 1 ? ll_interval_95(s->n, s->squares) : NAN);
    }
    return true;
}

ll_status ll_result_table_points(const ll_experiment *e, ll_row_source *source, void *context,
                                 ll_result_table **table)
{
    ll_status status = make(e, source, context, table);
    if (ll_failed(&status))
        return status;
    ll_result_table *t = *table;
    add_column(t, "point", LL_CELL_INT, false);
    add_parameters(t);
    add_column(t, "runs", LL_CELL_INT, false);
    add_column(t, "failed", LL_CELL_INT, false);
    add_column(t, "identical", LL_CELL_BOOL, true);
    for (int i = 0; i < e->metric_count; i++) {
        char name[LL_COLUMN_NAME_MAX];
        add_column(t, e->metrics[i], LL_CELL_REAL, true);
        snprintf(name, sizeof name, "%s.ci95", e->metrics[i]);
        add_column(t, name, LL_CELL_REAL, true);
    }
    t->table = (ll_table){t->columns, t->column_count, next_point, t};
    return status;
}

int64_t ll_result_table_identical(const ll_result_table *t)
{
    return t->identical;
}

const ll_table *ll_result_table_get(ll_result_table *t)
{
    return &t->table;
}

void ll_result_table_free(ll_result_table *t)
{
    if (t)
        cJSON_Delete(t->values);
    free(t);
}

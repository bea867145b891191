#include "experiment/format/table_internal.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"

/* ---- columns ---- */

ll_column *ll_table_add(ll_result_table *t, const char *name, ll_cell_type type, bool nullable)
{
    LL_ASSERT(t->column_count < LL_COLUMNS_MAX);
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
        t->column_count > LL_COLUMNS_MAX - LL_METRIC_COLUMNS * LL_EXPERIMENT_METRICS_MAX - 16)
        return; /* an object or array among the fixed values: only the specification has it */
    ll_axis_column(path, row->unit, name, sizeof name);
    snprintf(t->paths[t->parameter_count], sizeof t->paths[0], "%s", path);
    t->varied[t->parameter_count++] = varied;
    ll_table_add(t, name, ll_axis_type(row), false);
}

static bool on_axis(const ll_experiment *e, const char *path)
{
    for (int i = 0; i < e->axis_count; i++)
        if (strcmp(e->axes[i].path, path) == 0)
            return true;
    return false;
}

void ll_table_add_parameters(ll_result_table *t)
{
    const cJSON *item;
    for (int i = 0; i < t->experiment->axis_count; i++)
        add_parameter(t, t->experiment->axes[i].path, true);
    cJSON_ArrayForEach(item, t->experiment->set) if (!on_axis(t->experiment, item->string))
        add_parameter(t, item->string, false);
}

ll_status ll_table_make(const ll_experiment *e, ll_row_source *source, void *context, ll_result_table **table)
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

static ll_cell_type cell_type(ll_metric_type type)
{
    static const ll_cell_type types[] = {[LL_METRIC_NUMBER] = LL_CELL_REAL,
                                         [LL_METRIC_COUNT] = LL_CELL_INT,
                                         [LL_METRIC_FLAG] = LL_CELL_BOOL,
                                         [LL_METRIC_TEXT] = LL_CELL_TEXT};
    LL_ASSERT(type <= LL_METRIC_TEXT);
    return types[type];
}

void ll_table_add_columns(ll_result_table *t, const char *before, const ll_metric_table *columns)
{
    char name[LL_COLUMN_NAME_MAX];
    for (int i = 0; i < columns->count; i++) {
        const ll_metric_field *field = &columns->fields[i];
        snprintf(name, sizeof name, "%s%s", before, field->name);
        ll_table_add(t, name, cell_type(field->type), field->null != NULL);
    }
}

/* ---- cells ---- */

ll_cell ll_cell_number(double value)
{
    return (ll_cell){.null = isnan(value), .number = value};
}

/* Empty: null. */
static ll_cell text_cell(const char *value)
{
    return (ll_cell){.null = value[0] == '\0', .text = value};
}

ll_cell *ll_cells_put(ll_cell *cells, const ll_metric_table *columns, const ll_metric_reading *values)
{
    for (int i = 0; i < columns->count; i++)
        *cells++ = columns->fields[i].type == LL_METRIC_TEXT ? text_cell(values[i].text)
                                                             : ll_cell_number(values[i].number);
    return cells;
}

/* Fixed values are those of the specification; varied ones are the point's. */
ll_cell ll_table_parameter(const ll_result_table *t, int i)
{
    const cJSON *from = t->varied[i] ? t->values : t->experiment->set;
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(from, t->paths[i]);
    if (cJSON_IsString(value))
        return (ll_cell){.text = value->valuestring};
    return ll_cell_number(cJSON_IsBool(value) ? cJSON_IsTrue(value) : value ? value->valuedouble : NAN);
}

void ll_table_hold(ll_result_table *t, int64_t point)
{
    if (t->point == point)
        return;
    cJSON_Delete(t->values);
    t->values = ll_experiment_point(t->experiment, point);
    t->point = point;
}

/* ---- a row per run ---- */

#define RUN_COLUMNS(X)                                                                                       \
    X(count, run, NULL, r->run, "number of the run, from 0", NULL)                                           \
    X(count, point, NULL, t->point, "number of its point", NULL)                                             \
    X(count, repeat, NULL, r->run % e->head.repeats, "number of the repeat at this point", NULL)             \
    X(count, seed, NULL, ll_experiment_seed(e, r->run), "seed of the run", NULL)

#define END_COLUMNS(X)                                                                                       \
    X(text, status, NULL, ll_row_status_names[r->status], "how the run ended", NULL)                         \
    X(text, error, NULL, r->error, "reason for another end than ok", "The run ended well.")                  \
    X(text, hash, NULL, t->hash, "hash of the state at the end", NULL)                                       \
    X(number, t_s, "s", r->t_s, "virtual time at the end", NULL)

#define VERSION_COLUMNS(X)                                                                                   \
    X(text, version, NULL, t->version, "version of laglab that made the runs", "It is not known.")

const ll_metric_table ll_run_columns = {
    .path = "", .when = "Tables of runs.", .help = "Before the parameters.", LL_METRICS_FROM(RUN_COLUMNS)};
const ll_metric_table ll_end_columns = {.path = "",
                                        .when = "Tables of runs.",
                                        .help = "Between the parameters and the metrics.",
                                        LL_METRICS_FROM(END_COLUMNS)};
const ll_metric_table ll_version_columns = {
    .path = "", .when = "Tables of runs.", .help = "After the metrics.", LL_METRICS_FROM(VERSION_COLUMNS)};

static bool next_row(void *context, ll_cell *cells, ll_status *status)
{
    ll_result_table *t = context;
    const ll_experiment *e = t->experiment;
    ll_row *r = &t->row;
    if (!t->source(t->context, r, status))
        return false;
    ll_table_hold(t, r->run / e->head.repeats);
    ll_table_note(t, r);
    snprintf(t->hash, sizeof t->hash, "%016" PRIx64, r->hash);
    cells = LL_CELLS_PUT(cells, &ll_run_columns, RUN_COLUMNS);
    for (int i = 0; i < t->parameter_count; i++)
        *cells++ = ll_table_parameter(t, i);
    cells = LL_CELLS_PUT(cells, &ll_end_columns, END_COLUMNS);
    for (int i = 0; i < e->metric_count; i++)
        *cells++ = ll_cell_number(r->metrics[i]);
    LL_CELLS_PUT(cells, &ll_version_columns, VERSION_COLUMNS);
    return true;
}

ll_status ll_result_table_rows(const ll_experiment *e, const char *version, ll_row_source *source,
                               void *context, ll_result_table **table)
{
    LL_TRY(ll_table_make(e, source, context, table));
    ll_result_table *t = *table;
    t->version = version;
    ll_table_add_columns(t, "", &ll_run_columns);
    ll_table_add_parameters(t);
    ll_table_add_columns(t, "", &ll_end_columns);
    for (int i = 0; i < e->metric_count; i++)
        ll_table_add(t, e->metrics[i], LL_CELL_REAL, true);
    ll_table_add_columns(t, "", &ll_version_columns);
    t->table = (ll_table){t->columns, t->column_count, next_row, t};
    return ll_ok();
}

/* ---- sums ---- */

double ll_interval_95(int64_t n, double squares)
{
    /* 0.975 quantiles of Student's t; beyond the table Cornish and Fisher's expansion of the normal's. */
    static const double quantiles[] = {12.7062047364, 4.3026527297, 3.1824463053, 2.7764451052, 2.5705818366,
                                       2.4469118511,  2.3646242516, 2.3060041352, 2.2621571628, 2.2281388520};
    enum { KNOWN = sizeof quantiles / sizeof quantiles[0] };
    const double z = 1.9599639845400545, z2 = z * z;
    LL_ASSERT(n >= 2);
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
    LL_ASSERT(s->n >= 0 && !(s->squares < 0)); /* Welford's sum cannot cancel below 0 */
    s->n++;
    double delta = value - s->mean;
    s->mean += delta / (double)s->n;
    s->squares += delta * (value - s->mean);
    s->size += (fabs(value) - s->size) / (double)s->n;
}

const ll_table *ll_result_table_get(ll_result_table *table)
{
    return &table->table;
}

void ll_result_table_free(ll_result_table *t)
{
    if (!t)
        return;
    cJSON_Delete(t->values);
    ll_resampler_free(&t->resampler);
    free(t->held);
    free(t->baseline);
    free(t->scratch);
    free(t->indices);
    free(t);
}

/* For the files of result tables only. */
#pragma once

#include "experiment/format/table.h"
#include "experiment/statistics/sensitivity.h"
#include "experiment/statistics/summary.h"
#include "record/metric.h"

struct cJSON;

enum { LL_METRIC_COLUMNS = 18 }; /* maximum for a metric in a table of points */

struct ll_result_table {
    const ll_experiment *experiment;
    const char *version;
    ll_row_source *source;
    void *context;
    ll_column columns[LL_COLUMNS_MAX];
    int column_count, parameter_count;
    char paths[LL_COLUMNS_MAX][LL_EXPERIMENT_PATH_MAX + 8]; /* of the parameters' columns */
    bool varied[LL_COLUMNS_MAX];
    int64_t point; /* of the values in memory */
    struct cJSON *values;
    ll_row row; /* the present row, or the first of the next point */
    bool row_held;
    int64_t identical; /* points so far with identical runs */
    int64_t made,
        has[LL_EXPERIMENT_METRICS_MAX]; /* has: by metric, runs so far that ended well and have it */
    int64_t unreached;                  /* points so far that made all repeats without reaching `until` */
    ll_sums sums[LL_EXPERIMENT_METRICS_MAX]; /* of the point */
    ll_summary summaries[LL_EXPERIMENT_METRICS_MAX], differences[LL_EXPERIMENT_METRICS_MAX];
    char texts[2][LL_EXPERIMENT_METRICS_MAX][LL_SUMMARY_TEXT_MAX]; /* texts of the summaries */
    /* By metric and repeat, NaN: missing. Of the point, and of the baseline. */
    double *held, *baseline;
    bool compares;
    double *scratch; /* values of one metric, without NaN */
    ll_resampler resampler;
    ll_sensitivity *indices; /* of a sensitivity table, by metric and dimension */
    char hash[17];
    ll_table table;
};

/* Everything except the columns. */
ll_status ll_table_make(const ll_experiment *experiment, ll_row_source *source, void *context,
                        ll_result_table **table);
ll_column *ll_table_add(ll_result_table *table, const char *name, ll_cell_type type, bool nullable);
void ll_table_add_parameters(ll_result_table *table);
/* The columns of a list (record/metric.h): numbers, counts, flags and texts that may be null if their rows
 * say when. `before`: beginning of the names. */
void ll_table_add_columns(ll_result_table *table, const char *before, const ll_metric_table *columns);

/* The columns of tables of runs, of points, of comparisons, and of sensitivity. */
extern const ll_metric_table ll_run_columns, ll_end_columns, ll_version_columns;
extern const ll_metric_table ll_point_columns, ll_count_columns, ll_statistics_columns, ll_difference_columns,
    ll_sensitivity_columns;

void ll_table_note(ll_result_table *table, const ll_row *row); /* for the notices */
ll_cell ll_cell_number(double value);                          /* NaN: null */
/* Fills in the cells of these columns; returns the cell behind them. */
ll_cell *ll_cells_put(ll_cell *cells, const ll_metric_table *columns, const ll_metric_reading *values);
#define LL_CELLS_PUT(cells, columns, LIST)                                                                   \
    ll_cells_put(cells, columns, (const ll_metric_reading[]){LIST(LL_METRIC_READING)})
ll_cell ll_table_parameter(const ll_result_table *table, int i); /* of the present point */
void ll_table_hold(ll_result_table *table, int64_t point);

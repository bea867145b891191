/* Results as a table: one row per run, or per point. Formats can write any table. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "experiment/spec/experiment.h"
#include "experiment/statistics/summary.h"
#include "record/metric.h"

enum { LL_COLUMN_NAME_MAX = 160, LL_COLUMNS_MAX = 768 };

typedef struct ll_column {
    char name[LL_COLUMN_NAME_MAX];
    ll_cell_type type;
    bool nullable;
} ll_column;

typedef struct ll_cell {
    bool null;
    double number;    /* for INT (whole, below 2^53), REAL and BOOL */
    const char *text; /* for TEXT; valid until the next row */
} ll_cell;

typedef struct ll_table {
    const ll_column *columns;
    int column_count;
    /* Fills the cells of the next row; false at the end or on an error. */
    bool (*next)(void *context, ll_cell *cells, ll_status *status);
    void *context;
} ll_table;

/* ---- the rows of an experiment ---- */

/* Source of rows, in order of runs. */
typedef bool ll_row_source(void *context, ll_row *row, ll_status *status);

typedef struct ll_result_table ll_result_table;

/* Columns: run, point, repeat, seed; every fixed or varied parameter with its unit in the name; status,
 * error, hash, t_s; the metrics; version (that of the laglab that made the rows; must outlive the table). */
ll_status ll_result_table_rows(const ll_experiment *experiment, const char *version, ll_row_source *source,
                               void *context, ll_result_table **table);

/* One row per point: its parameters, `runs` that ended well and `failed` ones, whether the former gave
 * `identical` metrics, and for each metric, over the runs that have it: the mean; `.ci95`, half width of its
 * 95 % interval; `.ci95_low` and `.ci95_high`, its bounds, which may be asymmetric; `.ci95_method`
 * (interval.h), or the reason why there is none; `.ci95_covers`, the coverage of such intervals in words; the
 * standard deviation `.sd`; the quartiles `.p25`, `.p50`, `.p75`, and the bounds of the median's 95 %
 * interval. */
ll_status ll_result_table_points(const ll_experiment *experiment, ll_row_source *source, void *context,
                                 ll_result_table **table);

/* The same with each metric's difference from a baseline, whose rows are all given: `.diff` is the mean of
 * the differences of runs with the same seed, with its bounds, method, coverage, and the number
 * `.diff_pairs`. `baseline` NULL: no comparison; if it has no rows (yet), differences are null. */
ll_status ll_result_table_compared(const ll_experiment *experiment, const ll_row *baseline, int64_t count,
                                   ll_row_source *source, void *context, ll_result_table **table);

/* One row per metric and dimension of the axes: `metric`, `parameter`, its first and total Sobol' index with
 * the bounds of their 95 % intervals, and the number of base `samples` (sensitivity.h). Reads all rows at
 * once. LL_BAD_INPUT: the experiment is not sampled by saltelli. */
ll_status ll_result_table_sensitivity(const ll_experiment *experiment, ll_row_source *source, void *context,
                                      ll_result_table **table);

/* The columns of these tables, as lists of the form of metrics, NULL-terminated: of runs, points, comparisons
 * and sensitivity. Parameters and metrics are described by their own tables. */
extern const ll_metric_table *const ll_result_columns[];

/* Points with identical runs, of those read so far. */
int64_t ll_result_table_identical(const ll_result_table *table);

/* Notices for readers of the table: metrics that no run has, and points that made all repeats before `until`
 * was reached. Of the rows or points read so far; a list of sentences. Caller deletes. */
struct cJSON *ll_result_table_notices(const ll_result_table *table);

/* A metric over the runs of a point: Welford's sums. */
typedef struct ll_sums {
    int64_t n; /* runs that have it */
    double mean, squares;
    double size; /* mean magnitude, used in comparisons */
} ll_sums;

void ll_sums_add(ll_sums *sums, double value); /* NaN is ignored */

/* Of the last point of a table of points. */
const ll_sums *ll_result_table_sums(const ll_result_table *table);

/* Of paired differences of a metric, without the values. A difference is signed for every metric. */
ll_interval_request ll_difference_request(const ll_experiment *experiment, int metric, int64_t point);

const ll_summary *ll_result_table_summaries(const ll_result_table *table); /* by metric */

const ll_table *ll_result_table_get(ll_result_table *table);
void ll_result_table_free(ll_result_table *table);

/* Half width of the 95 % interval of a mean of n >= 2 values with this sum of squared deviations. */
double ll_interval_95(int64_t n, double squares);

/* ---- formats ---- */

typedef struct ll_format {
    const char *name, *type, *help; /* `csv`, `text/csv; charset=utf-8` */
    ll_status (*write)(const ll_table *table, FILE *file);
} ll_format;

extern const ll_format *const ll_formats[]; /* NULL-terminated */
const ll_format *ll_format_find(const char *name, size_t length);

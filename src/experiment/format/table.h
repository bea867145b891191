/* Results as a table: one tidy row per run, or per point. Formats write any table. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "experiment/spec/experiment.h"
#include "experiment/statistics/summary.h"

enum { LL_COLUMN_NAME_MAX = 160, LL_COLUMNS_MAX = 768 };

typedef struct ll_column {
    char name[LL_COLUMN_NAME_MAX];
    ll_cell_type type;
    bool nullable;
} ll_column;

typedef struct ll_cell {
    bool null;
    double number;    /* of INT (whole, below 2^53), REAL and BOOL */
    const char *text; /* of TEXT; until the next row */
} ll_cell;

typedef struct ll_table {
    const ll_column *columns;
    int column_count;
    /* Fills the cells of the next row; false at the end or on an error. */
    bool (*next)(void *context, ll_cell *cells, ll_status *status);
    void *context;
} ll_table;

/* ---- the rows of an experiment ---- */

/* Where rows come from, in the order of their runs. */
typedef bool ll_row_source(void *context, ll_row *row, ll_status *status);

typedef struct ll_result_table ll_result_table;

/* run, point, repeat, seed; every fixed or varied parameter with its unit in the name; status, error, hash,
 * t_s; the metrics; version, of the laglab that made the rows, which outlives the table. */
ll_status ll_result_table_rows(const ll_experiment *experiment, const char *version, ll_row_source *source,
                               void *context, ll_result_table **table);

/* One row per point: its parameters, `runs` that ended well and `failed` that did not, whether all that ended
 * well gave `identical` metrics, and for each metric over the runs that have it: the mean; `.ci95`, half the
 * width of its 95 % interval, `.ci95_low` and `.ci95_high`, its bounds, which need not be as far from the
 * mean, `.ci95_method` (interval.h), or why there is none, and `.ci95_covers`, how often such intervals hold
 * the mean, in words; the standard deviation `.sd`; the quartiles
 * `.p25`, `.p50`, `.p75`, and the bounds of the median's 95 % interval. */
ll_status ll_result_table_points(const ll_experiment *experiment, ll_row_source *source, void *context,
                                 ll_result_table **table);

/* The same with each metric's difference to a baseline, of which all rows are given: `.diff` is the mean of
 * the differences of runs with the same seed, with its bounds, method, coverage, and how many `.diff_pairs`
 * there are. With `baseline` NULL nothing is compared; where it has no rows (yet), differences are null. */
ll_status ll_result_table_compared(const ll_experiment *experiment, const ll_row *baseline, int64_t count,
                                   ll_row_source *source, void *context, ll_result_table **table);

/* One row per metric and dimension of the axes: `metric`, `parameter`, its first and total Sobol' index with
 * the bounds of their 95 % intervals, and over how many base `samples` (sensitivity.h). Reads all rows at
 * once. LL_BAD_INPUT: the experiment is not sampled for that. */
ll_status ll_result_table_sensitivity(const ll_experiment *experiment, ll_row_source *source, void *context,
                                      ll_result_table **table);

/* Of the points that were read from a table of points. */
int64_t ll_result_table_identical(const ll_result_table *table);

/* What who reads the table must know of it: metrics that no run has, and points that made all repeats before
 * `until` was reached. Of the rows or points that were read from it; a list of sentences. Caller deletes. */
struct cJSON *ll_result_table_notices(const ll_result_table *table);

/* A metric over the runs of a point: Welford's sums. */
typedef struct ll_sums {
    int64_t n; /* runs that have it */
    double mean, squares;
    double size; /* mean magnitude: what is compared */
} ll_sums;

void ll_sums_add(ll_sums *sums, double value); /* NaN is passed over */

/* Of the point that a table of points gave last. */
const ll_sums *ll_result_table_sums(const ll_result_table *table);

const ll_summary *ll_result_table_summaries(const ll_result_table *table); /* by metric */

const ll_table *ll_result_table_get(ll_result_table *table);
void ll_result_table_free(ll_result_table *table);

/* Half width of the 95 % interval of a mean of n >= 2 values with this sum and sum of squared deviations. */
double ll_interval_95(int64_t n, double squares);

/* ---- formats ---- */

typedef struct ll_format {
    const char *name, *type, *help; /* `csv`, `text/csv; charset=utf-8` */
    ll_status (*write)(const ll_table *table, FILE *file);
} ll_format;

extern const ll_format *const ll_formats[]; /* NULL-terminated */
const ll_format *ll_format_find(const char *name, size_t length);

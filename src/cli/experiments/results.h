/* Results of an experiment's rows, for verbs that have such rows: a table of runs, of points or of
 * sensitivity, in any format, and the report. */
#pragma once

#include "experiment/format/table.h"

typedef struct ll_results {
    const char *out, *format_name, *compare, *report;
    bool points, sensitivity;
    const ll_format *format;
    int64_t baseline; /* the point of --compare */
} ll_results;

/* For a verb's list of options. */
#define LL_RESULTS_OPTIONS(r)                                                                                \
    {"--out", "FILE", "Output file; default: standard output.", .value = &(r)->out},                         \
        {"--format", "NAME", "csv, ndjson, json or sqlite; default: by the ending of FILE.",                 \
         .value = &(r)->format_name},                                                                        \
        {"--points", .help = "Means and 95 % intervals of points instead of single runs.",                   \
         .flag = &(r)->points},                                                                              \
        {"--compare", "POINT",                                                                               \
         "With --points: differences from this point, between runs of the same seed: first, a number, or "   \
         "PATH=VALUE[,PATH=VALUE].",                                                                         \
         .value = &(r)->compare},                                                                            \
        {"--sensitivity",                                                                                    \
         .help = "First and total Sobol' indices of each metric instead of runs, for experiments sampled "   \
                 "by saltelli.",                                                                             \
         .flag = &(r)->sensitivity},                                                                         \
    {                                                                                                        \
        "--report", "FILE.html", "Writes a page with the plots and their tables.", .value = &(r)->report     \
    }

/* Checks the options, before there are rows. `inputs`: the verb's files, which it must not write over. */
ll_status ll_results_check(ll_results *results, const ll_experiment *experiment, const char *const *inputs,
                           int count);

/* The option that needs all runs of a point or of the experiment; NULL: none. */
const char *ll_results_of_all(const ll_results *results);

/* Rows of all runs, which are read more than once. */
typedef struct ll_results_rows {
    ll_row_source *next;
    void (*seek)(void *context, int64_t run); /* the next row is that of `run` */
    void *context;
    const char *version; /* of laglab, which made them */
} ll_results_rows;

/* Writes all that the options ask for, and notices to standard error. */
ll_status ll_results_write(const ll_results *results, const ll_experiment *experiment,
                           const ll_results_rows *rows);

void ll_print_notices(struct cJSON *notices); /* to standard error; deletes the list */

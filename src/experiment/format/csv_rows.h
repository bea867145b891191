/* Rows of an experiment read back from files of CSV, such as those of its shards. A row is taken only if the
 * experiment's table would write the same text: with the point, seed and values of its run. */
#pragma once

#include "base/version.h"
#include "experiment/format/table.h"

typedef struct ll_csv_rows {
    const ll_experiment *experiment;
    char **lines;                     /* by run; NULL: missing */
    char version[LL_VERSION_MAX + 1]; /* of the first row, and so of all */
    int64_t at;
    ll_result_table *table; /* which writes `row` */
    ll_row row;
    FILE *memory; /* what it writes: `text` */
    char *text;
    size_t size;
} ll_csv_rows;

ll_status ll_csv_rows_open(ll_csv_rows *rows, const ll_experiment *experiment);
/* Rows in any order, and again if they are the same. LL_BAD_INPUT names the file and what is wrong in it. */
ll_status ll_csv_rows_read(ll_csv_rows *rows, const char *path);
ll_status ll_csv_rows_check_whole(const ll_csv_rows *rows); /* LL_BAD_INPUT: runs are missing */

bool ll_csv_rows_next(void *rows, ll_row *row, ll_status *status); /* an ll_row_source function */
void ll_csv_rows_seek(void *rows, int64_t run);                    /* the next row is that of `run` */
void ll_csv_rows_close(ll_csv_rows *rows);

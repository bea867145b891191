/* The table of formats, and what the text formats share. */
#pragma once

#include "experiment/format/table.h"

extern const ll_format ll_format_csv, ll_format_ndjson, ll_format_json, ll_format_sqlite;

/* A number with the fewest digits that read back as the same. */
void ll_format_number(FILE *file, double value);

/* The lines of CSV. */
void ll_csv_put_header(const ll_table *table, FILE *file);
void ll_csv_put_row(const ll_table *table, const ll_cell *cells, FILE *file);
/* The fields of such a line, without quotes, of which there are at most `most`; writes into the line. Returns
 * their number. */
int ll_csv_split(char *line, char **fields, int most);

/* Flushes; the error when the file could not be written. */
ll_status ll_format_end(FILE *file, const ll_status *status);

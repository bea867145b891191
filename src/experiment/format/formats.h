/* The table of formats, and what the text formats share. */
#pragma once

#include "experiment/format/table.h"

extern const ll_format ll_format_csv, ll_format_ndjson, ll_format_json, ll_format_parquet, ll_format_sqlite;

/* A number with the fewest digits that read back as the same. */
void ll_format_number(FILE *file, double value);

/* Flushes; the error when the file could not be written. */
ll_status ll_format_end(FILE *file, const ll_status *status);

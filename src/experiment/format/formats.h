/* The rows of the table of formats, and what the text formats share. */
#pragma once

#include "experiment/format/table.h"

extern const ll_format ll_format_csv, ll_format_ndjson, ll_format_json, ll_format_parquet, ll_format_sqlite;

/* A number as short as it can be read back. */
void ll_format_number(FILE *file, double value);

/* What a file that could not be written says. */
ll_status ll_format_end(FILE *file, const ll_status *status);

/* What verbs write. */
#pragma once

#include <stdio.h>

#include "experiment/format/table.h"

/* The format of `--format`, of the ending of `--out`, or CSV. */
ll_status ll_argument_format(const char *name, const char *out, const ll_format **format);

/* Into the file `out`, under another name until it is whole; NULL: to standard output. */
ll_status ll_argument_write(const char *out, const ll_format *format, const ll_table *table);

int ll_print_json(struct cJSON *json); /* on standard output; deletes it, and is 0 */

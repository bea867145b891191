/* Output of verbs. */
#pragma once

#include <stdio.h>

#include "experiment/format/table.h"

/* The format named by `--format`, else by the ending of `--out`, else CSV. */
ll_status ll_argument_format(const char *name, const char *out, const ll_format **format);

/* Writes the file `out`, under a temporary name until it is complete, or what a device or link `out` leads
 * to; NULL: to standard output. */
ll_status ll_argument_write(const char *out, const ll_format *format, const ll_table *table);

/* Fills the next cell of a row; a number that is not finite is null. */
void ll_put_text(ll_cell **cell, const char *text);
void ll_put_number(ll_cell **cell, double value);

int ll_print_json(struct cJSON *json); /* on standard output; deletes it, and returns 0 */

/* Options that stand for the rows of tables of parameters: `--name VALUE` or `--name=VALUE`, with - for _. */
#pragma once

#include "cli/arguments.h"

typedef struct ll_parameter_object {
    const ll_param_table *table;
    void *object; /* gets the defaults */
} ll_parameter_object;

/* The end of `objects` has no table. NULL without memory; the caller frees what was made, by
 * ll_parameter_options_free. */
ll_option *ll_parameter_options(const ll_parameter_object *objects);
void ll_parameter_options_free(ll_option *options); /* NULL is fine */

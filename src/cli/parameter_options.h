/* Options that set the parameters of tables: `--name VALUE` or `--name=VALUE`, with - for _. */
#pragma once

#include "cli/arguments.h"

typedef struct ll_parameter_object {
    const ll_param_table *table;
    void *object; /* set to the defaults */
} ll_parameter_object;

/* The last of `objects` has no table. NULL without memory; the caller frees the result by
 * ll_parameter_options_free. */
ll_option *ll_parameter_options(const ll_parameter_object *objects);
void ll_parameter_options_free(ll_option *options); /* NULL: no effect */

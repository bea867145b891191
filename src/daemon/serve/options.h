/* Options of `laglab serve`: every row of the tables given is `--name VALUE` (or `--name=VALUE`), with - for
 * _. */
#pragma once

#include <stdio.h>

#include "param/param.h"

typedef struct ll_options {
    const ll_param_table *table;
    void *object; /* gets the defaults first */
} ll_options;

/* LL_BAD_INPUT names the option. `help` is set by --help. */
ll_status ll_options_parse(const ll_options *options, int count, int argc, char **argv, bool *help);
void ll_options_help(const ll_options *options, int count, FILE *file);

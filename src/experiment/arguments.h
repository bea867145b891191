/* Arguments of the verbs here. */
#pragma once

#include <stdbool.h>

#include "experiment/experiment.h"

enum { LL_POSITIONAL_MAX = 4096 };

/* An option takes a value, or is a flag. The table ends with an empty name. */
typedef struct ll_option {
    const char *name;
    const char **value;
    bool *flag;
} ll_option;

/* `positional` gets what is no option, at most LL_POSITIONAL_MAX. */
ll_status ll_arguments(int argc, char **argv, const ll_option *options, const char **positional, int *count);

/* A whole number in [low, high]. */
ll_status ll_argument_whole(const char *name, const char *text, int64_t low, int64_t high, int64_t *value);

/* Prints the sentence on stderr; gives the exit status. */
int ll_argument_fail(const ll_status *status);

/* A file, `-` for standard input, or an id of the library. `scenarios` NULL: beside the program. */
ll_status ll_experiment_load(const char *name, const char *scenarios, ll_experiment **experiment);

/* The one parser of arguments. A verb tells its usage and a table of options; `laglab VERB --help` prints
 * both. */
#pragma once

#include <stdbool.h>

#include "param/param.h"

enum { LL_POSITIONAL_MAX = 4096 };

typedef struct ll_option_list {
    const char *items[256];
    int count;
} ll_option_list;

/* An option takes a value, or is a flag, or takes a value and may be given again, or sets the row of a table
 * (cli/parameter_options.h). A table of options ends with an empty name. */
typedef struct ll_option {
    const char *name;
    const char *takes, *help; /* `FILE`; NULL for a flag */
    const char **value;
    bool *flag;
    ll_option_list *list;
    const ll_param_table *table; /* of `row`; its help stands above the first of its options */
    const ll_param *row;         /* its value may also stand behind a =, and its range is told */
    void *object;                /* that the row belongs to */
} ll_option;

/* `positional` gets what is no option, at most LL_POSITIONAL_MAX. --help prints `usage` and the options, and
 * ends the program. */
ll_status ll_arguments(const char *usage, int argc, char **argv, const ll_option *options,
                       const char **positional, int *count);

/* The same for verbs that take one argument that is no option, or none: then `positional` is NULL. It is NULL
 * too when it was not given. */
ll_status ll_arguments_one(const char *usage, int argc, char **argv, const ll_option *options,
                           const char **positional);

/* A whole number in [low, high]. */
ll_status ll_argument_whole(const char *name, const char *text, int64_t low, int64_t high, int64_t *value);

/* Prints the sentence on stderr; gives the exit status. */
int ll_argument_fail(const ll_status *status);

/* The parser of command line arguments. A verb has a usage text and a table of options; `laglab VERB --help`
 * prints both. */
#pragma once

#include <stdbool.h>

#include "param/param.h"

enum { LL_POSITIONAL_MAX = 4096 };

typedef struct ll_option_list {
    const char *items[256];
    int count;
} ll_option_list;

/* An option with a value, a flag, an option that may be repeated, or one that sets a parameter. A table of
 * options ends with an empty name. */
typedef struct ll_option {
    const char *name;
    const char *takes, *help; /* takes: `FILE`; NULL for a flag */
    const char **value;
    bool *flag;
    ll_option_list *list;
    const ll_param_table *table; /* table of `row`; its help is printed above its first option */
    const ll_param *row;         /* the parameter; accepts NAME=VALUE too, and --help prints its range */
    void *object;                /* object that has the parameter */
} ll_option;

/* `positional` gets the arguments that are not options, at most LL_POSITIONAL_MAX. --help prints `usage` and
 * the options, and ends the program. */
ll_status ll_arguments(const char *usage, int argc, char **argv, const ll_option *options,
                       const char **positional, int *count);

/* The same for verbs with at most one such argument: NULL when missing. Verbs without one pass `positional`
 * NULL. */
ll_status ll_arguments_one(const char *usage, int argc, char **argv, const ll_option *options,
                           const char **positional);

/* A whole number in [low, high]. */
ll_status ll_argument_whole(const char *name, const char *text, int64_t low, int64_t high, int64_t *value);

/* Prints the message on stderr; returns the exit status. */
int ll_argument_fail(const ll_status *status);

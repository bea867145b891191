/* Arguments of the verbs here. */
#pragma once

#include <stdbool.h>

#include "experiment/format/table.h"

enum { LL_POSITIONAL_MAX = 4096 };

typedef struct ll_option_list {
    const char *items[256];
    int count;
} ll_option_list;

/* An option takes a value, or is a flag, or takes a value and may be given again. The table ends with an
 * empty name. */
typedef struct ll_option {
    const char *name;
    const char *takes, *help; /* `FILE`; NULL for a flag */
    const char **value;
    bool *flag;
    ll_option_list *list;
} ll_option;

/* `positional` gets what is no option, at most LL_POSITIONAL_MAX. --help prints `usage` and the options, and
 * ends the program. */
ll_status ll_arguments(const char *usage, int argc, char **argv, const ll_option *options,
                       const char **positional, int *count);

/* A whole number in [low, high]. */
ll_status ll_argument_whole(const char *name, const char *text, int64_t low, int64_t high, int64_t *value);

/* Prints the sentence on stderr; gives the exit status. */
int ll_argument_fail(const ll_status *status);

/* The format of `--format`, of the ending of `--out`, or CSV. */
ll_status ll_argument_format(const char *name, const char *out, const ll_format **format);

/* Into the file `out`, under another name until it is whole; NULL: to standard output. */
ll_status ll_argument_write(const char *out, const ll_format *format, const ll_table *table);

/* The text of a file. Caller frees. */
ll_status ll_argument_text(const char *path, char **text);

/* JSON of a file, of `-` for standard input, or of an id of the library: an experiment or a scenario.
 * `scenarios` NULL: beside the program. Where an experiment names a file of its workload, relative to its own
 * (of standard input, to the folder that one is in), its text is put in place of the name. Caller deletes. */
ll_status ll_argument_json(const char *name, const char *scenarios, struct cJSON **json);

ll_status ll_experiment_load(const char *name, const char *scenarios, ll_experiment **experiment);
/* From JSON, with the same library. */
ll_status ll_experiment_from(const struct cJSON *json, const char *scenarios, ll_experiment **experiment);

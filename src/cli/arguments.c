#include "cli/arguments.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Length of the name of an option that sets a parameter, up to its =. */
static size_t name_length(const ll_option *option, const char *given)
{
    size_t length = strlen(given);
    return option->row ? strcspn(given, "=") : length;
}

static const ll_option *find(const ll_option *options, const char *given)
{
    for (; options->name; options++) {
        size_t length = name_length(options, given);
        if (strlen(options->name) == length && memcmp(options->name, given, length) == 0)
            return options;
    }
    return NULL;
}

/* ---- help ---- */

static void print_range(const ll_param *row)
{
    if (row->type == LL_PARAM_REAL || row->type == LL_PARAM_INT)
        printf(" %.10g to %.10g%s%s, default %.10g.", row->min, row->max, row->unit ? " " : "",
               row->unit ? row->unit : "", row->default_value);
    else if (row->text)
        printf(" Default: %s.", row->text);
}

static void print_help(const char *usage, const ll_option *options)
{
    const ll_param_table *table = NULL;
    printf("laglab %s\n", usage);
    for (; options->name; options++) {
        if (options->table != table && options->table)
            printf("\n%s\n", options->table->help);
        table = options->table;
        printf("  %s%s%s\n      %s%s", options->name, options->takes ? " " : "",
               options->takes ? options->takes : "", options->help ? options->help : "",
               options->list ? " May be given again." : "");
        if (options->row)
            print_range(options->row);
        putchar('\n');
    }
}

/* ---- reading ---- */

static ll_status set_row(const ll_option *option, const char *value)
{
    ll_status status = ll_param_set(option->table, option->object, option->row->name, value, false);
    if (!ll_failed(&status))
        return status;
    return ll_field_error(LL_BAD_INPUT, option->row->name, "%s: %.200s", option->name, status.text);
}

static ll_status take(const ll_option *option, const char *value)
{
    if (option->row)
        return set_row(option, value);
    if (!option->list) {
        *option->value = value;
        return ll_ok();
    }
    const int most = sizeof option->list->items / sizeof *option->list->items;
    if (option->list->count == most)
        return ll_error(LL_BAD_INPUT, "%s: must be given at most %d times", option->name, most);
    option->list->items[option->list->count++] = value;
    return ll_ok();
}

ll_status ll_arguments(const char *usage, int argc, char **argv, const ll_option *options,
                       const char **positional, int *count)
{
    ll_status status = ll_ok();
    *count = 0;
    for (int i = 0; i < argc && !ll_failed(&status); i++) {
        const ll_option *option = find(options, argv[i]);
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help(usage, options);
            exit(0);
        }
        if (!option && argv[i][0] == '-' && argv[i][1] != '\0')
            return ll_error(LL_BAD_INPUT, "unknown option %.100s", argv[i]);
        if (!option && *count == LL_POSITIONAL_MAX)
            return ll_error(LL_BAD_INPUT, "files: must be at most %d", LL_POSITIONAL_MAX);
        if (!option) {
            positional[(*count)++] = argv[i];
        } else if (option->flag) {
            *option->flag = true;
        } else {
            const char *equals = option->row ? strchr(argv[i], '=') : NULL;
            if (!equals && i + 1 == argc)
                return ll_error(LL_BAD_INPUT, "%s needs a value", argv[i]);
            status = take(option, equals ? equals + 1 : argv[++i]);
        }
    }
    return status;
}

ll_status ll_arguments_one(const char *usage, int argc, char **argv, const ll_option *options,
                           const char **positional)
{
    const char *given[LL_POSITIONAL_MAX];
    int count = 0, most = positional ? 1 : 0;
    ll_status status = ll_arguments(usage, argc, argv, options, given, &count);
    if (positional)
        *positional = count > 0 ? given[0] : NULL;
    if (!ll_failed(&status) && count > most)
        status = ll_error(LL_BAD_INPUT, "unexpected argument %.100s", given[most]);
    return status;
}

ll_status ll_argument_whole(const char *name, const char *text, int64_t low, int64_t high, int64_t *value)
{
    char *end;
    errno = 0;
    long long number = strtoll(text, &end, 10);
    if (end == text || *end || errno || number < low || number > high)
        return ll_error(LL_BAD_INPUT, "%s: must be a whole number from %lld to %lld; got %.40s", name,
                        (long long)low, (long long)high, text);
    *value = number;
    return ll_ok();
}

int ll_argument_fail(const ll_status *status)
{
    fprintf(stderr, "laglab: %s\n", status->text);
    bool failed = status->code == LL_IO || status->code == LL_UNAVAILABLE || status->code == LL_NO_MEMORY ||
                  status->code == LL_DIVERGED;
    return failed ? 1 : 2;
}

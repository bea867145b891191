#include "daemon/serve/options.h"

#include <string.h>

static void option_name(const char *row, char *name, size_t size)
{
    snprintf(name, size, "--%s", row);
    for (char *p = name; *p; p++) {
        if (*p == '_')
            *p = '-';
    }
}

static const ll_param *find(const ll_options *options, int count, const char *given, size_t length,
                            int *which)
{
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < options[i].table->count; j++) {
            char name[80];
            option_name(options[i].table->rows[j].name, name, sizeof name);
            if (strlen(name) == length && memcmp(name, given, length) == 0) {
                *which = i;
                return &options[i].table->rows[j];
            }
        }
    }
    return NULL;
}

static ll_status set(const ll_options *option, const ll_param *row, const char *name, const char *value)
{
    ll_status status = ll_param_set(option->table, option->object, row->name, value, false);
    if (!ll_failed(&status))
        return status;
    return ll_field_error(LL_BAD_INPUT, row->name, "%s: %.200s", name, status.text);
}

ll_status ll_options_parse(const ll_options *options, int count, int argc, char **argv, bool *help)
{
    *help = false;
    for (int i = 0; i < count; i++)
        ll_param_defaults(options[i].table, options[i].object);
    for (int i = 0; i < argc; i++) {
        const char *given = argv[i], *equals = strchr(given, '=');
        size_t length = equals ? (size_t)(equals - given) : strlen(given);
        if (strcmp(given, "--help") == 0 || strcmp(given, "-h") == 0) {
            *help = true;
            return ll_ok();
        }
        int which = 0;
        const ll_param *row = find(options, count, given, length, &which);
        if (!row)
            return ll_error(LL_BAD_INPUT, "There is no option %.60s; `laglab serve --help` lists them.",
                            given);
        if (!equals && i + 1 == argc)
            return ll_error(LL_BAD_INPUT, "%s needs a value.", given);
        char name[80];
        option_name(row->name, name, sizeof name);
        ll_status status = set(&options[which], row, name, equals ? equals + 1 : argv[++i]);
        if (ll_failed(&status))
            return status;
    }
    return ll_ok();
}

static void print_row(FILE *file, const ll_param *row)
{
    char name[80];
    option_name(row->name, name, sizeof name);
    fprintf(file, "  %s %s\n      %s", name, row->type == LL_PARAM_TEXT ? "TEXT" : "N",
            row->help ? row->help : "");
    if (row->type == LL_PARAM_REAL || row->type == LL_PARAM_INT)
        fprintf(file, " %.10g to %.10g%s%s, default %.10g.", row->min, row->max, row->unit ? " " : "",
                row->unit ? row->unit : "", row->standard);
    else if (row->text)
        fprintf(file, " Default: %s.", row->text);
    fputc('\n', file);
}

void ll_options_help(const ll_options *options, int count, FILE *file)
{
    fputs("laglab serve [OPTION VALUE]...: hosts sessions; page, API and streams on one port.\n", file);
    for (int i = 0; i < count; i++) {
        fprintf(file, "\n%s\n", options[i].table->help);
        for (int j = 0; j < options[i].table->count; j++)
            print_row(file, &options[i].table->rows[j]);
    }
}

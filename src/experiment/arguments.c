#include "experiment/arguments.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/program.h"

static const ll_option *find(const ll_option *options, const char *name)
{
    for (; options->name; options++)
        if (strcmp(options->name, name) == 0)
            return options;
    return NULL;
}

static void print_help(const char *usage, const ll_option *options)
{
    printf("laglab %s\n", usage);
    for (; options->name; options++)
        printf("  %s%s%s\n      %s%s\n", options->name, options->takes ? " " : "",
               options->takes ? options->takes : "", options->help,
               options->list ? " May be given again." : "");
}

ll_status ll_arguments(const char *usage, int argc, char **argv, const ll_option *options,
                       const char **positional, int *count)
{
    *count = 0;
    for (int i = 0; i < argc; i++) {
        const ll_option *option = find(options, argv[i]);
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help(usage, options);
            exit(0);
        }
        if (!option && argv[i][0] == '-' && argv[i][1] != '\0')
            return ll_error(LL_BAD_INPUT, "unknown option %.100s", argv[i]);
        if (!option && *count == LL_POSITIONAL_MAX)
            return ll_error(LL_BAD_INPUT, "more than %d files", LL_POSITIONAL_MAX);
        if (!option)
            positional[(*count)++] = argv[i];
        else if (option->flag)
            *option->flag = true;
        else if (i + 1 == argc)
            return ll_error(LL_BAD_INPUT, "%s needs a value", argv[i]);
        else if (option->list &&
                 option->list->count == sizeof option->list->items / sizeof *option->list->items)
            return ll_error(LL_BAD_INPUT, "%s is given too often", argv[i]);
        else if (option->list)
            option->list->items[option->list->count++] = argv[++i];
        else
            *option->value = argv[++i];
    }
    return ll_ok();
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

ll_status ll_argument_format(const char *name, const char *out, const ll_format **format)
{
    const char *dot = out ? strrchr(out, '.') : NULL;
    if (!name)
        name = dot && ll_format_find(dot + 1, strlen(dot + 1)) ? dot + 1 : "csv";
    *format = ll_format_find(name, strlen(name));
    if (*format)
        return ll_ok();
    char known[80] = "";
    for (int i = 0; ll_formats[i]; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "",
                 ll_formats[i]->name);
    return ll_error(LL_BAD_INPUT, "--format: must be one of %s; got %.40s", known, name);
}

ll_status ll_argument_write(const char *out, const ll_format *format, const ll_table *table)
{
    char temporary[4096];
    if (!out)
        return format->write(table, stdout);
    snprintf(temporary, sizeof temporary, "%s.part", out);
    FILE *file = fopen(temporary, "wb");
    if (!file)
        return ll_error(LL_IO, "cannot write %.200s", temporary);
    ll_status status = format->write(table, file);
    bool good = fclose(file) == 0;
    if (!ll_failed(&status) && (!good || rename(temporary, out) != 0))
        status = ll_error(LL_IO, "cannot write %.200s", out);
    if (ll_failed(&status))
        unlink(temporary);
    return status;
}

static ll_status read_input(cJSON **json)
{
    char *text = NULL;
    size_t capacity = 0;
    ssize_t length = getdelim(&text, &capacity, '\0', stdin); /* JSON has no such byte: the whole input */
    ll_status status = ll_json_parse(text, length > 0 ? (size_t)length : 0, json);
    free(text);
    return status;
}

static const char *library(const char *scenarios, char folder[PATH_MAX])
{
    if (scenarios)
        return scenarios;
    ll_beside_program("scenarios", folder, PATH_MAX);
    return folder;
}

ll_status ll_argument_text(const char *path, char **text)
{
    size_t capacity = 0;
    FILE *file = fopen(path, "rb");
    *text = NULL;
    if (!file)
        return ll_error(LL_BAD_INPUT, "cannot read %.200s", path);
    ssize_t length = getdelim(text, &capacity, '\0', file); /* text has no such byte: the whole file */
    bool bad = length < 0 && !feof(file);
    fclose(file);
    if (length >= 0)
        return ll_ok();
    free(*text);
    *text = NULL;
    return ll_error(LL_BAD_INPUT, bad ? "cannot read %.200s" : "%.200s is empty", path);
}

/* A text that begins like a log is one. */
static ll_status read_workload(const char *beside, cJSON *experiment)
{
    const cJSON *workload = cJSON_GetObjectItemCaseSensitive(experiment, "workload");
    const char *name = cJSON_IsString(workload) ? workload->valuestring : NULL;
    if (!name || name[strspn(name, " \t\r\n")] == '{')
        return ll_ok();
    char path[PATH_MAX], *text;
    const char *slash = strrchr(beside, '/');
    int folder = name[0] == '/' || !slash ? 0 : (int)(slash - beside) + 1;
    snprintf(path, sizeof path, "%.*s%s", folder, beside, name);
    ll_status status = ll_argument_text(path, &text);
    if (ll_failed(&status))
        return ll_field_error(status.code, "workload", "workload: %s", status.text);
    cJSON_ReplaceItemInObjectCaseSensitive(experiment, "workload", cJSON_CreateString(text));
    free(text);
    return ll_ok();
}

/* `beside` gets the name of the file, or nothing. */
static ll_status read_json(const char *name, const char *scenarios, char beside[PATH_MAX], cJSON **json)
{
    char folder[PATH_MAX];
    *json = NULL;
    beside[0] = '\0';
    if (!name)
        return ll_error(LL_BAD_INPUT,
                        "which experiment? A file, an id such as experiments/lag_techniques, or - for "
                        "standard input");
    if (strcmp(name, "-") == 0)
        return read_input(json);
    ll_status status = ll_scenario_load(library(scenarios, folder), name, json);
    bool of_library = status.code != LL_NOT_FOUND;
    int length = of_library ? snprintf(beside, PATH_MAX, "%s/%s", library(scenarios, folder), name)
                            : snprintf(beside, PATH_MAX, "%s", name);
    if (length >= PATH_MAX)
        return ll_error(LL_BAD_INPUT, "%.100s... is too long a name", name);
    if (of_library)
        return status;
    if (access(name, R_OK) == 0)
        return ll_scenario_read(name, json);
    return ll_error(LL_BAD_INPUT, "there is no %.100s, neither as a file nor in the library", name);
}

ll_status ll_argument_json(const char *name, const char *scenarios, cJSON **json)
{
    char beside[PATH_MAX];
    ll_status status = read_json(name, scenarios, beside, json);
    if (!ll_failed(&status))
        status = read_workload(beside, *json);
    if (ll_failed(&status)) {
        cJSON_Delete(*json);
        *json = NULL;
    }
    return status;
}

ll_status ll_experiment_from(const cJSON *json, const char *scenarios, ll_experiment **experiment)
{
    char folder[PATH_MAX];
    return ll_experiment_parse(json, library(scenarios, folder), experiment);
}

ll_status ll_experiment_load(const char *name, const char *scenarios, ll_experiment **experiment)
{
    cJSON *json;
    *experiment = NULL;
    ll_status status = ll_argument_json(name, scenarios, &json);
    if (!ll_failed(&status))
        status = ll_experiment_from(json, scenarios, experiment);
    cJSON_Delete(json);
    return status;
}

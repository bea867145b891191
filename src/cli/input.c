#include "cli/input.h"

#include <cjson/cJSON.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "library/library.h"
#include "library/program.h"
#include "session/scenario.h"

#define INPUT_MAX (64u << 20)

static ll_status read_input(cJSON **json)
{
    char *text = NULL;
    size_t capacity = 0;
    ssize_t length =
        getdelim(&text, &capacity, '\0', stdin); /* JSON has no NUL, so this reads the whole input */
    ll_status status = ll_json_parse(text, length > 0 ? (size_t)length : 0, json);
    free(text);
    return status;
}

const char *ll_scenario_folder(const char *scenarios, char folder[PATH_MAX])
{
    if (scenarios)
        return scenarios;
    ll_program_sibling("scenarios", folder, PATH_MAX);
    return folder;
}

ll_status ll_argument_text(const char *path, char **text)
{
    size_t capacity = 0;
    FILE *file = fopen(path, "rb");
    *text = NULL;
    if (!file)
        return ll_error(LL_BAD_INPUT, "cannot read %.200s", path);
    ssize_t length =
        getdelim(text, &capacity, '\0', file); /* text has no NUL, so this reads the whole file */
    bool bad = length < 0 && !feof(file);
    fclose(file);
    if (length >= 0)
        return ll_ok();
    free(*text);
    *text = NULL;
    return ll_error(LL_BAD_INPUT, bad ? "cannot read %.200s" : "%.200s is empty", path);
}

/* A text that begins like a log is read as a log. */
static ll_status read_workload(const char *file_name, cJSON *experiment)
{
    const cJSON *workload = cJSON_GetObjectItemCaseSensitive(experiment, "workload");
    const char *name = cJSON_IsString(workload) ? workload->valuestring : NULL;
    if (!name || name[strspn(name, " \t\r\n")] == '{')
        return ll_ok();
    char path[PATH_MAX], *text;
    const char *slash = strrchr(file_name, '/');
    int folder = name[0] == '/' || !slash ? 0 : (int)(slash - file_name) + 1;
    snprintf(path, sizeof path, "%.*s%s", folder, file_name, name);
    ll_status status = ll_argument_text(path, &text);
    if (ll_failed(&status))
        return ll_field_error(status.code, "workload", "workload: %s", status.text);
    cJSON_ReplaceItemInObjectCaseSensitive(experiment, "workload", cJSON_CreateString(text));
    free(text);
    return ll_ok();
}

/* `file_name` gets the name of the file, or an empty string. */
static ll_status read_json(const char *name, const char *scenarios, char file_name[PATH_MAX], cJSON **json)
{
    char folder[PATH_MAX];
    *json = NULL;
    file_name[0] = '\0';
    if (!name)
        return ll_error(LL_BAD_INPUT, "EXPERIMENT: required; a file, an id such as "
                                      "experiments/lag_techniques, or - for standard input");
    if (strcmp(name, "-") == 0)
        return read_input(json);
    ll_status status = ll_scenario_load(ll_scenario_folder(scenarios, folder), name, json);
    bool of_library = status.code != LL_NOT_FOUND;
    int length = of_library
                     ? snprintf(file_name, PATH_MAX, "%s/%s", ll_scenario_folder(scenarios, folder), name)
                     : snprintf(file_name, PATH_MAX, "%s", name);
    if (length >= PATH_MAX)
        return ll_error(LL_BAD_INPUT, "name %.100s... is too long", name);
    if (of_library)
        return status;
    if (access(name, R_OK) == 0)
        return ll_scenario_read(name, json);
    return ll_error(LL_BAD_INPUT, "%.100s not found, neither as a file nor in the library", name);
}

ll_status ll_argument_json(const char *name, const char *scenarios, cJSON **json)
{
    char file_name[PATH_MAX];
    ll_status status = read_json(name, scenarios, file_name, json);
    LL_THEN(status, read_workload(file_name, *json));
    if (ll_failed(&status)) {
        cJSON_Delete(*json);
        *json = NULL;
    }
    return status;
}

ll_status ll_experiment_from(const cJSON *json, const char *scenarios, ll_experiment **experiment)
{
    char folder[PATH_MAX];
    return ll_experiment_parse(json, ll_scenario_folder(scenarios, folder), NULL, experiment);
}

ll_status ll_experiment_load(const char *name, const char *scenarios, ll_experiment **experiment)
{
    cJSON *json;
    *experiment = NULL;
    ll_status status = ll_argument_json(name, scenarios, &json);
    LL_THEN(status, ll_experiment_from(json, scenarios, experiment));
    cJSON_Delete(json);
    return status;
}

ll_status ll_input_whole(FILE *f, const char *name, char **text, size_t *length)
{
    size_t capacity = 1 << 16;
    *length = 0;
    *text = malloc(capacity);
    while (*text) {
        *length += fread(*text + *length, 1, capacity - *length, f);
        if (*length < capacity)
            break;
        if (capacity >= INPUT_MAX) {
            free(*text);
            return ll_error(LL_BAD_INPUT, "%s: must have at most %u bytes", name, INPUT_MAX);
        }
        capacity *= 2;
        char *bigger = realloc(*text, capacity);
        if (!bigger)
            free(*text);
        *text = bigger;
    }
    return *text ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: %s", name);
}

ll_status ll_scenario_argument(const char *name, const char *scenarios, cJSON **json)
{
    char folder[PATH_MAX];
    *json = NULL;
    if (!name)
        return ll_error(
            LL_BAD_INPUT,
            "SCENARIO: required; an id (see `laglab scenarios`), a file, or - for standard input");
    if (strcmp(name, "-") == 0) {
        char *text = NULL;
        size_t length = 0;
        ll_status status = ll_input_whole(stdin, "standard input", &text, &length);
        if (!ll_failed(&status)) {
            status = ll_json_parse(text, length, json);
            free(text);
        }
        return status;
    }
    ll_status status = ll_scenario_load(ll_scenario_folder(scenarios, folder), name, json);
    if (status.code == LL_NOT_FOUND && access(name, R_OK) == 0)
        return ll_scenario_read(name, json);
    return status;
}

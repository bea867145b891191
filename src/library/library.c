#include "library/library.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "session/scenario.h"

#define SCENARIO_BYTES_MAX (1 << 20)
#define ID_MAX 120

static bool good_id(const char *id)
{
    size_t n = strlen(id);
    if (n == 0 || n > ID_MAX || id[0] == '/' || id[n - 1] == '/' || strstr(id, "//"))
        return false;
    return strspn(id, "abcdefghijklmnopqrstuvwxyz0123456789_/-") == n;
}

static ll_status read_file(const char *path, char **text, size_t *length)
{
    FILE *f = fopen(path, "rb");
    if (!f)
        return ll_error(LL_NOT_FOUND, "cannot read %.150s", path);
    ll_status status = ll_ok();
    *text = malloc(SCENARIO_BYTES_MAX);
    *length = *text ? fread(*text, 1, SCENARIO_BYTES_MAX, f) : 0;
    if (!*text)
        status = ll_error(LL_NO_MEMORY, "out of memory: scenario");
    else if (*length == SCENARIO_BYTES_MAX)
        status = ll_error(LL_BAD_INPUT, "%.150s: must have at most %d bytes", path, SCENARIO_BYTES_MAX);
    else if (ferror(f))
        status = ll_error(LL_IO, "cannot read %.150s", path);
    fclose(f);
    if (ll_failed(&status)) {
        free(*text);
        *text = NULL;
    }
    return status;
}

ll_status ll_scenario_read(const char *path, cJSON **json)
{
    char *text = NULL;
    size_t length = 0;
    ll_status status = read_file(path, &text, &length);
    LL_THEN(status, ll_json_parse(text, length, json));
    free(text);
    return status;
}

ll_status ll_scenario_load(const char *directory, const char *id, cJSON **json)
{
    char path[4096];
    *json = NULL;
    if (!good_id(id))
        return ll_field_error(LL_NOT_FOUND, "scenario", "there is no scenario %.100s", id);
    int n = snprintf(path, sizeof path, "%s/%s.json", directory, id);
    if (n < 0 || (size_t)n >= sizeof path)
        return ll_field_error(LL_NOT_FOUND, "scenario", "there is no scenario %.100s", id);
    ll_status status = ll_scenario_read(path, json);
    if (status.code == LL_NOT_FOUND)
        return ll_field_error(LL_NOT_FOUND, "scenario", "there is no scenario %.100s", id);
    return status;
}

static const char *text_of(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsString(item) ? item->valuestring : "";
}

/* One listed file. Scenarios have a `kind`, experiments do not. */
typedef struct listing {
    bool experiments;
    const char *names[6]; /* NULL-terminated */
} listing;

static const listing scenarios = {false, {"title", "paper", "kind", "game", "text"}},
                     experiments = {true, {"title", "text"}};

static void list_one(const char *directory, const char *id, const listing *what, cJSON *list)
{
    cJSON *json = NULL;
    ll_status status = ll_scenario_load(directory, id, &json);
    if (!ll_failed(&status) && cJSON_HasObjectItem(json, "kind") != what->experiments) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "id", id);
        for (int i = 0; what->names[i]; i++)
            cJSON_AddStringToObject(o, what->names[i], text_of(json, what->names[i]));
        cJSON_AddItemToArray(list, o);
    }
    cJSON_Delete(json);
}

static ll_status list_folder(const char *directory, const char *folder, const listing *what, cJSON *list)
{
    char path[4096];
    struct dirent **entries;
    snprintf(path, sizeof path, "%s/%s", directory, folder);
    int n = scandir(path, &entries, NULL, alphasort);
    if (n < 0)
        return ll_error(LL_IO, "cannot read the scenarios in %.150s", path);
    for (int i = 0; i < n; i++) {
        char id[512];
        struct stat st;
        const char *name = entries[i]->d_name;
        size_t length = strlen(name);
        snprintf(path, sizeof path, "%s/%s%s", directory, folder, name);
        snprintf(id, sizeof id, "%s%s", folder, name);
        if (name[0] == '.' || stat(path, &st) != 0) {
        } else if (S_ISDIR(st.st_mode) && folder[0] == '\0') {
            strncat(id, "/", sizeof id - strlen(id) - 1);
            list_folder(directory, id, what, list);
        } else if (length > 5 && strcmp(name + length - 5, ".json") == 0) {
            id[strlen(id) - 5] = '\0';
            list_one(directory, id, what, list);
        }
        free(entries[i]);
    }
    free(entries);
    return ll_ok();
}

static ll_status list_all(const char *directory, const listing *what, cJSON **list)
{
    *list = cJSON_CreateArray();
    ll_status status = list_folder(directory, "", what, *list);
    if (ll_failed(&status)) {
        cJSON_Delete(*list);
        *list = NULL;
    }
    return status;
}

ll_status ll_scenario_list(const char *directory, cJSON **list)
{
    return list_all(directory, &scenarios, list);
}

ll_status ll_scenario_list_experiments(const char *directory, cJSON **list)
{
    return list_all(directory, &experiments, list);
}

#include "session/scenario.h"

#include <cjson/cJSON.h>
#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/assert.h"
#include "session/internal.h"
#include "sim/kinds.h"

#define SCENARIO_BYTES_MAX (1 << 20)
#define ID_MAX 120

/* ---- JSON ---- */

/* cJSON's own limit of nesting is for the whole process; this one is for what a document of ours can need. */
static bool too_deep(const char *text, size_t length)
{
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < length; i++) {
        if (quoted) {
            if (text[i] == '\\')
                i++;
            else if (text[i] == '"')
                quoted = false;
        } else if (text[i] == '"') {
            quoted = true;
        } else if (text[i] == '{' || text[i] == '[') {
            if (++depth > LL_JSON_DEPTH)
                return true;
        } else if (text[i] == '}' || text[i] == ']') {
            depth--;
        }
    }
    return false;
}

static ll_status syntax_error(const char *text, size_t length, const char *at)
{
    int line = 1, column = 1;
    for (const char *p = text; p < at && p < text + length; p++) {
        column = *p == '\n' ? 1 : column + 1;
        line += *p == '\n';
    }
    return ll_error(LL_BAD_INPUT, "not valid JSON: line %d, column %d", line, column);
}

/* The first NUL, at which texts would be cut: as such, as \\u0000, or as an escape without four hexadecimal
 * digits, which cJSON reads as one. NULL when there is none. */
static const char *find_nul(const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        if (text[i] == '\0')
            return text + i;
        if (text[i] != '\\' || i + 1 == length)
            continue;
        size_t digits = 0;
        while (text[i + 1] == 'u' && digits < 4 && i + 2 + digits < length &&
               isxdigit((unsigned char)text[i + 2 + digits]))
            digits++;
        if (text[i + 1] == 'u' && (digits < 4 || memcmp(text + i + 2, "0000", 4) == 0))
            return text + i;
        i += text[i + 1] != '\0'; /* what is escaped */
    }
    return NULL;
}

ll_status ll_json_parse(const char *text, size_t length, cJSON **json)
{
    *json = NULL;
    if (too_deep(text, length))
        return ll_error(LL_BAD_INPUT, "the JSON is nested more than %d levels deep", LL_JSON_DEPTH);
    const char *nul = find_nul(text, length);
    if (nul)
        return syntax_error(text, length, nul);
    const char *end = NULL;
    cJSON *parsed = cJSON_ParseWithLengthOpts(text, length, &end, false);
    if (!parsed)
        return syntax_error(text, length, end ? end : text);
    while (end < text + length && isspace((unsigned char)*end))
        end++;
    if (end < text + length) {
        cJSON_Delete(parsed);
        return syntax_error(text, length, end);
    }
    *json = parsed;
    return ll_ok();
}

/* ---- scenarios ---- */

static ll_status kind_of(const cJSON *json, const ll_sim_kind **kind)
{
    if (!cJSON_IsObject(json))
        return ll_error(LL_BAD_INPUT, "a scenario is a JSON object");
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(json, "kind");
    for (int i = 0; cJSON_IsString(name) && ll_sim_kinds[i]; i++)
        if (strcmp(name->valuestring, ll_sim_kinds[i]->name) == 0) {
            *kind = ll_sim_kinds[i];
            return ll_ok();
        }
    char names[160] = "";
    for (int i = 0; ll_sim_kinds[i]; i++)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", i ? ", " : "",
                 ll_sim_kinds[i]->name);
    return ll_field_error(LL_BAD_INPUT, "kind", "kind: must be one of: %s", names);
}

ll_status ll_scenario_parse(const cJSON *json, ll_scenario *scenario)
{
    const ll_sim_kind *kind = NULL;
    ll_status status = kind_of(json, &kind);
    if (ll_failed(&status))
        return status;
    void *config = calloc(1, kind->table->size), *before = calloc(1, kind->table->size);
    if (!config || !before) {
        status = ll_error(LL_NO_MEMORY, "no memory for a scenario");
        goto cleanup;
    }
    ll_param_defaults(kind->table, config);
    status = ll_param_parse(kind->table, json, config);
    if (ll_failed(&status))
        goto cleanup;
    kind->settle(config, before);
    status = ll_timeline_check(kind, config);
    if (ll_failed(&status))
        goto cleanup;
    memset(before, 0, kind->table->size);
    ll_param_copy(kind->table, before, config); /* memory that was never written is none */
    *scenario = (ll_scenario){kind, before};
    before = NULL;
cleanup:
    free(config);
    free(before);
    return status;
}

void ll_scenario_free(ll_scenario *scenario)
{
    free(scenario->config);
    *scenario = (ll_scenario){0};
}

/* The definitions of a kind move to the root, where references look for them; kinds that share a table share
 * its definition. */
static void merge_kind(cJSON *any, cJSON *defs, const ll_sim_kind *kind)
{
    cJSON *one = ll_param_schema(kind->table), *def;
    cJSON *own = cJSON_DetachItemFromObject(one, "$defs");
    while ((def = cJSON_DetachItemFromArray(own, 0)) != NULL)
        if (cJSON_GetObjectItemCaseSensitive(defs, def->string)) {
            LL_ASSERT(cJSON_Compare(cJSON_GetObjectItemCaseSensitive(defs, def->string), def, true));
            cJSON_Delete(def);
        } else {
            cJSON_AddItemToArray(defs, def); /* it brings its name */
        }
    cJSON_Delete(own);
    cJSON_DeleteItemFromObject(one, "$schema");
    cJSON *name = cJSON_GetObjectItem(cJSON_GetObjectItem(one, "properties"), "kind");
    cJSON_DeleteItemFromObject(name, "enum");
    cJSON_AddStringToObject(name, "const", kind->name);
    cJSON_AddItemToArray(any, one);
}

ll_status ll_scenario_schema(const char *kind, cJSON **schema)
{
    cJSON *any, *defs;
    char known[80] = "";
    *schema = cJSON_CreateObject();
    cJSON_AddStringToObject(*schema, "$schema", "https://json-schema.org/draft/2020-12/schema");
    cJSON_AddStringToObject(*schema, "title", "scenario");
    any = cJSON_AddArrayToObject(*schema, "oneOf");
    defs = cJSON_AddObjectToObject(*schema, "$defs");
    for (int i = 0; ll_sim_kinds[i]; i++) {
        const char *name = ll_sim_kinds[i]->name;
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "", name);
        if (!kind || strcmp(kind, name) == 0)
            merge_kind(any, defs, ll_sim_kinds[i]);
    }
    if (cJSON_GetArraySize(any) > 0)
        return ll_ok();
    cJSON_Delete(*schema);
    *schema = NULL;
    return ll_field_error(LL_BAD_INPUT, "kind", "kind: must be one of %s; got %.40s", known, kind);
}

/* ---- the library ---- */

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
        status = ll_error(LL_NO_MEMORY, "no memory for a scenario");
    else if (*length == SCENARIO_BYTES_MAX)
        status = ll_error(LL_BAD_INPUT, "%.150s is longer than %d bytes", path, SCENARIO_BYTES_MAX);
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
    if (!ll_failed(&status))
        status = ll_json_parse(text, length, json);
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

/* What is listed of a file; an experiment is told from a scenario by what it lacks: a kind. */
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

#include "session/scenario.h"

#include <cjson/cJSON.h>
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"
#include "sim/core/scenario_rows.h"

/* ---- JSON ---- */

/* Before a value is read: 64 bytes are kept of each, of one digit too. cJSON's nesting limit is for the whole
 * process; this one is for laglab's documents, which need less. */
static ll_status check_size(const char *text, size_t length)
{
    int depth = 0, values = 1;
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
                return ll_error(LL_BAD_INPUT, "JSON: must have at most %d levels of nesting", LL_JSON_DEPTH);
            values++;
        } else if (text[i] == '}' || text[i] == ']') {
            depth--;
        } else if (text[i] == ',' && ++values > LL_JSON_VALUES) {
            return ll_error(LL_BAD_INPUT, "JSON: must have at most %d values", LL_JSON_VALUES);
        }
    }
    return ll_ok();
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

/* First NUL, at which C strings would end: a NUL byte, \\u0000, or a \\u escape without four hexadecimal
 * digits, which cJSON reads as NUL. NULL if there is none. */
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
        i += text[i + 1] != '\0'; /* skips the escaped character */
    }
    return NULL;
}

ll_status ll_json_parse(const char *text, size_t length, cJSON **json)
{
    *json = NULL;
    LL_TRY(check_size(text, length));
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
        return ll_error(LL_BAD_INPUT, "scenario: must be a JSON object");
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

ll_status ll_scenario_parse_running(const cJSON *json, ll_scenario *scenario)
{
    const ll_sim_kind *kind = NULL;
    LL_TRY(kind_of(json, &kind));
    void *config = calloc(1, kind->table->size);
    if (!config)
        return ll_error(LL_NO_MEMORY, "out of memory: scenario");
    ll_param_defaults_in_zeros(kind->table, config);
    ll_status status = ll_param_parse(kind->table, json, config);
    if (ll_failed(&status)) {
        free(config);
        return status;
    }
    kind->settle(config, NULL);
    *scenario = (ll_scenario){kind, config};
    return status;
}

ll_status ll_scenario_parse(const cJSON *json, ll_scenario *scenario)
{
    ll_scenario parsed;
    LL_TRY(ll_scenario_parse_running(json, &parsed));
    ll_status status = ll_timeline_check(parsed.kind, parsed.config);
    if (ll_failed(&status))
        ll_scenario_free(&parsed);
    else
        *scenario = parsed;
    return status;
}

void ll_scenario_free(ll_scenario *scenario)
{
    free(scenario->config);
    *scenario = (ll_scenario){0};
}

ll_status ll_scenario_override(cJSON **json, const char *const *sets, int count, const char *const *later)
{
    ll_scenario scenario = {0};
    LL_TRY(ll_scenario_parse(*json, &scenario));
    const ll_param_table *table = scenario.kind->table;
    void *before = ll_param_clone(table, scenario.config, NULL);
    ll_status status = before ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: scenario");
    LL_THEN(status, ll_param_put(table, scenario.config, sets, count));
    for (int i = 0; later[i]; i++)
        LL_THEN(status, ll_param_put(table, scenario.config, &later[i], 1));
    LL_THEN(status, ll_param_check(table, scenario.config));
    if (!ll_failed(&status)) {
        scenario.kind->settle(scenario.config, before);
        cJSON_Delete(*json);
        *json = ll_param_write(table, scenario.config);
    }
    free(before);
    ll_scenario_free(&scenario);
    return status;
}

/* The definitions of a kind move to the root, where references expect them. */
static void merge_kind(cJSON *any, cJSON *defs, const ll_sim_kind *kind)
{
    cJSON *one = ll_param_schema(kind->table);
    ll_param_schema_part(one, defs);
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

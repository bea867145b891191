/* The verb `link-trace`, and the option --link-trace of `run`. */
#include "cli/link_trace.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/input.h"
#include "cli/verbs.h"
#include "link/profile/trace_text.h"

/* The samples that a file has, as rows of a profile. Caller deletes. */
static ll_status read_profile(const char *file, cJSON **profile)
{
    char *text = NULL;
    ll_profile_params *params = malloc(sizeof *params);
    *profile = NULL;
    if (!params)
        return ll_error(LL_NO_MEMORY, "out of memory: trace");
    ll_status status = ll_argument_text(file, &text);
    LL_THEN(status, ll_trace_read(file, text, params));
    if (!ll_failed(&status)) {
        cJSON *all = ll_param_write(&ll_profile_table, params);
        const char *const rows[] = {"capacity_ms", "trace_t_ms", "trace_delay_ms", "trace_lost"};
        *profile = cJSON_CreateObject();
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            cJSON *row = cJSON_DetachItemFromObject(all, rows[i]);
            if (cJSON_GetArraySize(row) > 0)
                cJSON_AddItemToObject(*profile, rows[i], row);
            else
                cJSON_Delete(row);
        }
        cJSON_Delete(all);
    }
    free(text);
    free(params);
    return status;
}

/* The object at a dotted path, made where a name is missing; NULL: there is no such element of an array. */
static cJSON *object_at(cJSON *json, const char *path, size_t length)
{
    while (json && length > 0) {
        char name[32];
        size_t n = strcspn(path, ".");
        n = n < length ? n : length;
        if (n >= sizeof name)
            return NULL;
        memcpy(name, path, n);
        name[n] = '\0';
        cJSON *next = cJSON_IsArray(json) ? cJSON_GetArrayItem(json, atoi(name))
                                          : cJSON_GetObjectItemCaseSensitive(json, name);
        if (!next && cJSON_IsObject(json))
            next = cJSON_AddObjectToObject(json, name);
        json = next;
        path += n + (n < length);
        length -= n + (n < length);
    }
    return json;
}

static ll_status add(const char *trace, cJSON *json)
{
    size_t length = strcspn(trace, "=");
    cJSON *profiles = cJSON_GetObjectItemCaseSensitive(json, "profiles"), *profile;
    if (length == 0 || trace[length] == '\0')
        return ll_error(LL_BAD_INPUT, "--link-trace: must be PATH=FILE; got %.100s", trace);
    LL_TRY(read_profile(trace + length + 1, &profile));
    if (!profiles)
        profiles = cJSON_AddArrayToObject(json, "profiles");
    char name[32];
    snprintf(name, sizeof name, "profile_%d", cJSON_GetArraySize(profiles));
    cJSON *way = object_at(json, trace, length);
    if (!cJSON_AddItemToArray(profiles, profile) || !cJSON_IsObject(way)) {
        return ll_error(
            LL_BAD_INPUT,
            "--link-trace: must name a direction of a link, such as players.0.link.down; got %.*s",
            (int)(length < 100 ? length : 100), trace);
    }
    cJSON_DeleteItemFromObjectCaseSensitive(way, "profile");
    cJSON_AddStringToObject(way, "profile", name);
    return ll_ok();
}

ll_status ll_link_traces_add(const ll_option_list *traces, cJSON *json)
{
    ll_status status = ll_ok();
    for (int i = 0; i < traces->count && !ll_failed(&status); i++)
        status = add(traces->items[i], json);
    return status;
}

int ll_verb_link_trace(int argc, char **argv)
{
    const char *file = NULL;
    const ll_option none[] = {{0}};
    cJSON *profile = NULL;
    ll_status status = ll_arguments_one("link-trace FILE: print a trace of Mahimahi, or CSV with the header "
                                        "t_ms,delay_ms,lost, as an element of a scenario's `profiles`",
                                        argc, argv, none, &file);
    if (!ll_failed(&status) && !file)
        status = ll_error(LL_BAD_INPUT, "link-trace: FILE is missing");
    LL_THEN(status, read_profile(file, &profile));
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    char *text = cJSON_PrintUnformatted(profile);
    puts(text);
    cJSON_free(text);
    cJSON_Delete(profile);
    return 0;
}

/* What a teacher does with the members of a class: sees them, removes them, frees seats. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "threads/clock.h"

void ll_get_members(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_own_class(context, request, response);
    const ll_class *c = entry ? ll_api_lock_class(entry, request, response) : NULL;
    if (c) {
        cJSON *json = ll_class_describe_members(c);
        ll_class_entry_unlock(entry);
        cJSON_DeleteItemFromObjectCaseSensitive(json, "type");
        ll_http_json(response, 200, json);
        ll_http_set_header(response, "Cache-Control", "no-store");
    }
    ll_class_entry_release(entry);
}

/* ---- removing ---- */

/* The number in the path; -1: none. */
static int64_t read_number(const char *text)
{
    size_t length = strlen(text);
    return length > 0 && length < 10 && strspn(text, "0123456789") == length ? strtoll(text, NULL, 10) : -1;
}

static ll_status read_reach(const ll_http_request *request, ll_class_reach *reach)
{
    const char *with = ll_http_query(request, "and");
    *reach = LL_CLASS_ONE;
    for (int i = LL_CLASS_LATER; with && ll_class_reaches[i]; i++)
        if (strcmp(with, ll_class_reaches[i]) == 0)
            *reach = (ll_class_reach)i;
    if (!with || *reach != LL_CLASS_ONE)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, "and", "and: must be later or address; got `%.40s`.", with);
}

typedef struct copies { /* of members that were removed, to be deleted when the class is not locked */
    char (*ids)[LL_ID_LENGTH + 1];
    int count;
} copies;

static void note(void *context, const char *copy)
{
    copies *list = context;
    memcpy(list->ids[list->count++], copy, LL_ID_LENGTH + 1);
}

void ll_delete_members(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_reach reach;
    ll_class_entry *entry = ll_api_own_class(context, request, response);
    ll_class *c = entry ? ll_api_change_class(entry, request, response) : NULL;
    if (c) {
        int64_t number = read_number(request->parameter[1]);
        copies list = {.ids = calloc((size_t)c->capacity, sizeof *list.ids)};
        ll_status status = list.ids ? read_reach(request, &reach) : ll_error(LL_NO_MEMORY, "out of memory");
        LL_THEN(status, ll_class_remove(c, number < 0 ? 0 : (uint32_t)number, reach, note, &list));
        bool stored = ll_api_store_class(entry, request, response, &status);
        for (int i = 0; stored && i < list.count; i++)
            ll_api_delete_copy(context, list.ids[i]);
        free(list.ids);
        if (stored)
            response->status = 204;
    }
    ll_class_entry_release(entry);
}

void ll_delete_seat(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_own_class(context, request, response);
    ll_class *c = entry ? ll_api_change_class(entry, request, response) : NULL;
    if (c) {
        int64_t player = read_number(request->parameter[1]);
        ll_status status = player < 0 || player >= LL_PLAYERS_MAX
                               ? ll_error(LL_NOT_FOUND, "The board has no such player.")
                               : ll_class_free_seat(c, (int)player, ll_now_ns());
        if (ll_api_store_class(entry, request, response, &status))
            response->status = 204;
    }
    ll_class_entry_release(entry);
}

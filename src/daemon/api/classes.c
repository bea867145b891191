/* Classes: opening, the teacher's changes, the board. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/class/origins.h"
#include "threads/clock.h"

/* ---- the class of a request, and who asks ---- */

ll_class_entry *ll_api_class(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = NULL;
    if (!ll_api_started(api, request, response))
        return NULL;
    ll_status status = ll_classes_find(api->classes, request->parameter[0], request->peer, &entry);
    ll_api_good(response, request, &status);
    return entry;
}

const ll_class *ll_api_lock_class(ll_class_entry *entry, const ll_http_request *request,
                                  ll_http_response *response)
{
    const ll_class *c = ll_class_entry_lock(entry);
    ll_status ended = ll_error(LL_NOT_FOUND, "The class has ended.");
    if (!c)
        ll_api_problem(response, request, &ended);
    return c;
}

ll_class *ll_api_change_class(ll_class_entry *entry, const ll_http_request *request,
                              ll_http_response *response)
{
    ll_class *c;
    ll_status status = ll_class_entry_begin(entry, &c);
    ll_api_good(response, request, &status);
    return c;
}

bool ll_api_store_class(ll_class_entry *entry, const ll_http_request *request, ll_http_response *response,
                        const ll_status *made)
{
    ll_status status = ll_class_entry_store(entry, made);
    return ll_api_good(response, request, &status);
}

ll_class_entry *ll_api_own_class(ll_api *api, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_class(api, request, response);
    const char *key = entry ? ll_api_key(request, response, "the class's teacher_key") : NULL;
    const ll_class *c = key ? ll_api_lock_class(entry, request, response) : NULL;
    bool good = c && (ll_key_matches(&c->teacher, key, strlen(key)) || ll_api_is_operator(api, key));
    if (c)
        ll_class_entry_unlock(entry);
    if (good)
        return entry;
    ll_status error = ll_error(LL_FORBIDDEN, "Not the teacher's key of this class.");
    if (c)
        ll_api_problem(response, request, &error);
    ll_class_entry_release(entry);
    return NULL;
}

/* ---- description ---- */

static void add_join(ll_api *api, const ll_http_request *request, const char *code, cJSON *json)
{
    ll_interface interfaces[LL_INTERFACES_MAX];
    ll_origins origins;
    const ll_web_server *web_server = atomic_load(&api->web_server);
    ll_origins_request wanted = {.bound = ll_web_server_address(web_server),
                                 .port = ll_web_server_port(web_server),
                                 .host = request->host,
                                 .proxied = request->proxied,
                                 .tls = request->tls,
                                 .interfaces = interfaces,
                                 .interface_count = ll_interfaces_list(interfaces)};
    ll_origins_choose(&wanted, &origins);
    cJSON *join = cJSON_AddObjectToObject(json, "join"), *urls = cJSON_AddArrayToObject(join, "urls");
    for (int i = 0; i < origins.count; i++) {
        char url[LL_ORIGIN_TEXT + 8];
        snprintf(url, sizeof url, "%s/%s", origins.text[i], code);
        cJSON_AddItemToArray(urls, cJSON_CreateString(url));
    }
    cJSON_AddBoolToObject(join, "local", origins.local);
}

void ll_api_class_links(const ll_class_entry *entry, cJSON *json)
{
    static const char *const parts[] = {"stream", "board", "seats", "members", "member", "vote"};
    char path[80];
    cJSON *links = cJSON_AddObjectToObject(json, "links");
    snprintf(path, sizeof path, "/api/v1/classes/%s", ll_class_entry_id(entry));
    cJSON_AddStringToObject(links, "self", path);
    snprintf(path, sizeof path, "/#class=%s", ll_class_entry_code(entry));
    cJSON_AddStringToObject(links, "page", path);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        snprintf(path, sizeof path, "/api/v1/classes/%s/%s", ll_class_entry_id(entry), parts[i]);
        cJSON_AddStringToObject(links, parts[i], path);
    }
}

static void answer_class(ll_api *api, const ll_http_request *request, ll_http_response *response, int status,
                         ll_class_entry *entry, const char *key)
{
    const ll_class *c = ll_api_lock_class(entry, request, response);
    if (!c)
        return;
    cJSON *json = cJSON_CreateObject(), *state = ll_class_describe(c, ll_now_ns());
    ll_class_entry_unlock(entry);
    cJSON_AddStringToObject(json, "id", ll_class_entry_id(entry));
    cJSON_AddStringToObject(json, "code", ll_class_entry_code(entry));
    if (key)
        cJSON_AddStringToObject(json, "teacher_key", key);
    add_join(api, request, ll_class_entry_code(entry), json);
    ll_api_class_links(entry, json);
    cJSON_AddItemToObject(json, "state", state);
    ll_http_json(response, status, json);
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* ---- the class ---- */

void ll_post_classes(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    char key[LL_KEY_LENGTH + 1], location[80];
    ll_class_entry *entry = NULL;
    ll_class_key *class_key = ll_api_class_key(api, request);
    if (!ll_api_started(api, request, response) || !ll_api_may_create(api, request, response) ||
        !ll_api_rate(api, request, response, class_key, NULL))
        return;
    cJSON *body = ll_api_optional_body(request, response);
    if (!body)
        return;
    ll_status status = ll_classes_open(api->classes, request->peer, class_key, body, key, &entry);
    if (ll_api_good(response, request, &status)) {
        answer_class(api, request, response, 201, entry, key);
        snprintf(location, sizeof location, "/api/v1/classes/%s", ll_class_entry_id(entry));
        ll_http_set_header(response, "Location", location);
    }
    ll_class_entry_release(entry);
    cJSON_Delete(body);
}

void ll_get_class(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_class(context, request, response);
    if (entry)
        answer_class(context, request, response, 200, entry, NULL);
    ll_class_entry_release(entry);
}

static void patch_class(ll_class_entry *entry, const cJSON *body, const ll_http_request *request,
                        ll_http_response *response)
{
    ll_class *c = ll_api_change_class(entry, request, response);
    if (!c)
        return;
    ll_status status = ll_class_change(c, body);
    cJSON *state = ll_class_describe(c, ll_now_ns());
    if (ll_api_store_class(entry, request, response, &status))
        ll_http_json(response, 200, state);
    else
        cJSON_Delete(state);
}

void ll_patch_class(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_own_class(context, request, response);
    cJSON *body = entry ? ll_api_body(request, response) : NULL;
    if (body)
        patch_class(entry, body, request, response);
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

void ll_delete_class(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_own_class(context, request, response);
    ll_status status = entry ? ll_class_entry_end(entry, "the teacher has ended the class") : ll_ok();
    if (entry && ll_api_good(response, request, &status))
        response->status = 204;
    ll_class_entry_release(entry);
}

/* ---- the board ---- */

/* A session whose owner the teacher is. NULL: the error was answered. */
static ll_session_entry *find_own(ll_api *api, const cJSON *body, const ll_http_request *request,
                                  ll_http_response *response)
{
    static const char *const names[] = {"session", "owner_key", NULL};
    const cJSON *id = cJSON_GetObjectItemCaseSensitive(body, "session");
    const cJSON *key = cJSON_GetObjectItemCaseSensitive(body, "owner_key");
    ll_status status = ll_api_only(body, names);
    if (!ll_failed(&status) && !cJSON_IsString(id))
        status = ll_field_error(LL_BAD_INPUT, "session", "session: must be the id of a session (text).");
    if (!ll_failed(&status) && !cJSON_IsString(key))
        status = ll_field_error(LL_BAD_INPUT, "owner_key", "owner_key: must be that of the session (text).");
    ll_session_entry *session = NULL;
    if (!ll_failed(&status)) {
        session = ll_host_find(api->host, id->valuestring);
        if (!session)
            status = ll_field_error(LL_BAD_INPUT, "session", "session: there is none with this id.");
    }
    if (session &&
        ll_session_entry_role(session, key->valuestring, strlen(key->valuestring)) != LL_ROLE_OWNER)
        status = ll_field_error(LL_FORBIDDEN, "owner_key", "owner_key: not that of this session.");
    if (!ll_failed(&status))
        return session;
    ll_session_entry_release(session);
    ll_api_problem(response, request, &status);
    return NULL;
}

static bool show(ll_api *api, ll_class_entry *entry, const ll_session_entry *session,
                 const ll_http_request *request, ll_http_response *response)
{
    char before[LL_ID_LENGTH + 1] = "";
    const ll_status good = ll_ok();
    ll_class *c = ll_api_change_class(entry, request, response);
    if (!c)
        return false;
    memcpy(before, c->board.link.session, sizeof before);
    ll_class_set_board(c, ll_session_entry_id(session));
    if (!ll_api_store_class(entry, request, response, &good))
        return false;
    ll_classes_revoke(api->classes, before);
    return true;
}

static void put_board(ll_api *api, ll_class_entry *entry, const cJSON *body, const ll_http_request *request,
                      ll_http_response *response)
{
    ll_created_session created = {.session_entry = NULL};
    bool given = cJSON_HasObjectItem(body, "session");
    ll_create_request made_here = {.seed = -1,
                                   .paused = true,
                                   .group = ll_class_entry_id(entry),
                                   .group_most = ll_classes_get_config(api->classes)->max_class_sessions,
                                   .class_key = ll_class_entry_class_key(entry)};
    if (given)
        created.session_entry = find_own(api, body, request, response);
    else if (!ll_api_class_rate(api, request, response, entry, NULL) ||
             !ll_api_create_session(api, request, response, body, &made_here, &created))
        created.session_entry = NULL;
    if (!created.session_entry)
        return;
    if (!show(api, entry, created.session_entry, request, response)) {
        if (!given)
            ll_host_discard(api->host, created.session_entry);
        ll_session_entry_release(created.session_entry);
        return;
    }
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "id", ll_session_entry_id(created.session_entry));
    cJSON_AddItemToObject(json, "owner_key",
                          given ? cJSON_CreateNull() : cJSON_CreateString(created.owner_key));
    ll_api_links(json, ll_session_entry_id(created.session_entry));
    ll_http_json(response, 200, json);
    ll_http_set_header(response, "Cache-Control", "no-store");
    ll_session_entry_release(created.session_entry);
}

void ll_put_board(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_entry *entry = ll_api_own_class(context, request, response);
    cJSON *body = entry ? ll_api_body(request, response) : NULL;
    if (body)
        put_board(context, entry, body, request, response);
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

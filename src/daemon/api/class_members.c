/* Members of a class: joining, seats, copies, votes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/http/http_problem.h"
#include "threads/clock.h"

/* Locks the class for a member. NULL: the error was answered. */
static ll_class *lock_for_member(ll_class_entry *entry, const ll_http_request *request,
                                 ll_http_response *response, int *place)
{
    const char *key = ll_api_key(request, response, "the member's token");
    ll_class *c = key ? ll_api_lock_class(entry, request, response) : NULL;
    if (!c)
        return NULL;
    *place = ll_class_find(c, key, strlen(key));
    if (*place >= 0)
        return c;
    bool removed = ll_class_has_removed(c, key, strlen(key));
    ll_class_entry_unlock(entry);
    ll_api_refuse(request, response,
                  removed ? LL_CLASS_OUT : "Unknown token: no member of this class has it. Join again.");
    return NULL;
}

/* A member between two locks: its place may become another's. */
typedef struct who {
    int place;
    uint32_t number;
} who;

static bool is_there(const ll_class *c, const who *w)
{
    return c->members[w->place].used && c->members[w->place].number == w->number;
}

/* The fork of the board; NULL: the error was answered. */
static bool fork_board(ll_api *api, ll_class_entry *entry, const ll_http_request *request,
                       ll_http_response *response, ll_created_session *created)
{
    char board[LL_ID_LENGTH + 1];
    ll_class *c = ll_api_lock_class(entry, request, response);
    if (!c)
        return false;
    memcpy(board, c->board.link.session, sizeof board);
    bool plays = c->board.status == LL_SESSION_PLAYING && !c->now.frozen;
    ll_class_entry_unlock(entry);
    ll_session_entry *origin = ll_host_find(api->host, board);
    if (!origin) {
        ll_status none = ll_field_error(LL_CONFLICT, "role", "role: there is no board to copy yet.");
        ll_api_problem(response, request, &none);
        return false;
    }
    ll_create_request create = {.origin = origin,
                                .seed = -1,
                                .paused = !plays,
                                .group = ll_class_entry_id(entry),
                                .group_most = ll_classes_get_config(api->classes)->max_class_sessions,
                                .peer = request->peer,
                                .class_key = ll_class_entry_class_key(entry),
                                .task = request->task};
    bool made = ll_api_rate(api, request, response, create.class_key, origin) &&
                ll_api_make_session(api, request, response, &create, created);
    ll_session_entry_release(origin);
    return made;
}

void ll_api_delete_copy(ll_api *api, const char *id, struct ll_task *task)
{
    ll_session_entry *session = ll_host_find(api->host, id);
    if (session)
        ll_host_delete(api->host, session, task);
    ll_session_entry_release(session);
}

/* Gives the member a copy of the board. With a copy that it has already, `created` stays empty. */
static bool give_copy(ll_api *api, ll_class_entry *entry, const who *w, bool fresh,
                      const ll_http_request *request, ll_http_response *response, ll_created_session *created)
{
    char unwanted[LL_ID_LENGTH + 1] = "";
    ll_class *c = ll_api_lock_class(entry, request, response);
    if (!c)
        return false;
    bool keeps = is_there(c, w) && c->members[w->place].copy.session[0] && !fresh;
    ll_class_entry_unlock(entry);
    if (!keeps && !fork_board(api, entry, request, response, created))
        return false;
    c = ll_class_entry_lock(entry);
    if (c && is_there(c, w)) {
        ll_class_member *m = &c->members[w->place];
        ll_class_watch(c, w->place);
        m->role = LL_CLASS_COPY;
        if (!keeps) {
            memcpy(unwanted, m->copy.session, sizeof unwanted);
            m->copy = (ll_class_link){.session = ""};
            memcpy(m->copy.session, ll_session_entry_id(created->session_entry), sizeof m->copy.session);
        }
    } else if (!keeps) {
        memcpy(unwanted, ll_session_entry_id(created->session_entry), sizeof unwanted);
    }
    if (c)
        ll_class_entry_unlock(entry);
    ll_api_delete_copy(api, unwanted, request->task);
    return true;
}

/* What the member may do now. False: the error was answered. */
static bool grant(ll_api *api, ll_class_entry *entry, const who *w, const ll_class_wish *wish,
                  const ll_http_request *request, ll_http_response *response, ll_created_session *created)
{
    ll_class *c = ll_api_lock_class(entry, request, response);
    if (!c)
        return false;
    ll_status status = is_there(c, w) ? ll_class_act(c, w->place, ll_now_ns())
                                      : ll_error(LL_NOT_FOUND, "The member has left.");
    if (!ll_failed(&status) && wish->role == LL_CLASS_PLAY)
        status = ll_class_claim(c, w->place, (int)wish->player, ll_now_ns());
    else if (!ll_failed(&status) && wish->role == LL_CLASS_WATCH)
        ll_class_watch(c, w->place);
    ll_class_entry_unlock(entry);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    else if (wish->role == LL_CLASS_COPY)
        return give_copy(api, entry, w, wish->fresh, request, response, created);
    return !ll_failed(&status);
}

static void answer_member(ll_class_entry *entry, const who *w, const char *token,
                          const ll_created_session *created, const ll_http_request *request,
                          ll_http_response *response)
{
    ll_class *c = ll_api_lock_class(entry, request, response);
    if (!c)
        return;
    cJSON *json = ll_class_describe_member(c, w->place), *state = ll_class_describe(c, ll_now_ns());
    ll_class_entry_unlock(entry);
    cJSON_DeleteItemFromObjectCaseSensitive(json, "type");
    cJSON_AddStringToObject(json, "class", ll_class_entry_id(entry));
    if (token)
        cJSON_AddStringToObject(json, "token", token);
    cJSON_AddItemToObject(json, "copy_key",
                          created && created->session_entry ? cJSON_CreateString(created->owner_key)
                                                            : cJSON_CreateNull());
    ll_api_class_links(entry, json);
    cJSON_AddItemToObject(json, "state", state);
    ll_http_json(response, token ? 201 : 200, json);
    ll_http_set_header(response, "Cache-Control", "no-store");
}

/* Reads the wish. A copy is made by a task; false also when the handler is to be called again as one. */
static bool read_wish(const cJSON *body, const ll_http_request *request, ll_http_response *response,
                      ll_class_wish *wish)
{
    ll_param_defaults(&ll_class_join_table, wish);
    ll_status status = ll_param_parse(&ll_class_join_table, body, wish);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    return !ll_failed(&status) && !(wish->role == LL_CLASS_COPY && ll_http_become_task(request, response));
}

static ll_status arrive(ll_class *c, ll_class_arrival *arrival, who *w, char copy[LL_ID_LENGTH + 1])
{
    arrival->now = ll_now_ns();
    arrival->unix_s = ll_unix_ms() / 1000;
    LL_TRY(ll_class_admits(c, arrival->client));
    LL_TRY(ll_class_join(c, arrival, &w->place, copy));
    w->number = c->members[w->place].number;
    return ll_ok();
}

static bool join(ll_api *api, ll_class_entry *entry, const ll_http_request *request,
                 ll_http_response *response, who *w, char token[LL_KEY_LENGTH + 1])
{
    ll_class_arrival arrival = {.client = ll_class_client(request->peer)};
    ll_status status = ll_error(LL_NO_MEMORY, "Random numbers for tokens not available.");
    char copy[LL_ID_LENGTH + 1] = "";
    bool made = ll_new_key(token) && ll_key_hash_make(token, &arrival.token);
    ll_class *c = made ? ll_api_lock_class(entry, request, response) : NULL;
    if (made && !c)
        return false;
    if (c) {
        status = arrive(c, &arrival, w, copy);
        ll_class_entry_unlock(entry);
    }
    ll_api_delete_copy(api, copy, request->task);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    return !ll_failed(&status);
}

static void leave(ll_api *api, ll_class_entry *entry, const who *w, struct ll_task *task)
{
    char copy[LL_ID_LENGTH + 1] = "";
    ll_class *c = ll_class_entry_lock(entry);
    if (!c)
        return;
    if (is_there(c, w)) {
        memcpy(copy, c->members[w->place].copy.session, sizeof copy);
        ll_class_leave(c, w->place);
    }
    ll_class_entry_unlock(entry);
    ll_api_delete_copy(api, copy, task);
}

/* The member that asks; false: the error was answered. */
static bool find_member(ll_class_entry *entry, const ll_http_request *request, ll_http_response *response,
                        who *w)
{
    const ll_class *c = lock_for_member(entry, request, response, &w->place);
    if (!c)
        return false;
    w->number = c->members[w->place].number;
    ll_class_entry_unlock(entry);
    return true;
}

/* Who comes with a token that the class knows: its device is not a new one. */
static bool comes_back(ll_class_entry *entry, const ll_http_request *request)
{
    const char *key = ll_api_find_key(request);
    ll_class *c = key ? ll_class_entry_lock(entry) : NULL;
    if (!c)
        return false;
    bool known = ll_class_find(c, key, strlen(key)) >= 0 || ll_class_has_removed(c, key, strlen(key));
    ll_class_entry_unlock(entry);
    return known;
}

static void enter(ll_api *api, ll_class_entry *entry, const ll_class_wish *wish,
                  const ll_http_request *request, ll_http_response *response)
{
    char token[LL_KEY_LENGTH + 1];
    who w;
    ll_created_session created = {.session_entry = NULL};
    bool known = comes_back(entry, request);
    bool entered =
        known ? find_member(entry, request, response, &w) : join(api, entry, request, response, &w, token);
    if (entered && grant(api, entry, &w, wish, request, response, &created))
        answer_member(entry, &w, known ? NULL : token, &created, request, response);
    else if (entered && !known)
        leave(api, entry, &w, request->task);
    ll_session_entry_release(created.session_entry);
}

void ll_post_members(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_wish wish;
    ll_class_entry *entry = ll_api_class(context, request, response);
    cJSON *body = entry ? ll_api_optional_body(request, response) : NULL;
    if (body && read_wish(body, request, response, &wish))
        enter(context, entry, &wish, request, response);
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

void ll_get_member(void *context, const ll_http_request *request, ll_http_response *response)
{
    who w;
    ll_class_entry *entry = ll_api_class(context, request, response);
    if (entry && find_member(entry, request, response, &w))
        answer_member(entry, &w, NULL, NULL, request, response);
    ll_class_entry_release(entry);
}

void ll_patch_member(void *context, const ll_http_request *request, ll_http_response *response)
{
    who w;
    ll_class_wish wish;
    ll_created_session created = {.session_entry = NULL};
    ll_class_entry *entry = ll_api_class(context, request, response);
    cJSON *body = entry && find_member(entry, request, response, &w) ? ll_api_body(request, response) : NULL;
    if (body && read_wish(body, request, response, &wish) &&
        grant(context, entry, &w, &wish, request, response, &created))
        answer_member(entry, &w, NULL, &created, request, response);
    ll_session_entry_release(created.session_entry);
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

void ll_delete_member(void *context, const ll_http_request *request, ll_http_response *response)
{
    who w;
    ll_class_entry *entry = ll_api_class(context, request, response);
    if (entry && find_member(entry, request, response, &w)) {
        leave(context, entry, &w, request->task);
        response->status = 204;
    }
    ll_class_entry_release(entry);
}

/* ---- votes ---- */

void ll_put_vote(void *context, const ll_http_request *request, ll_http_response *response)
{
    who w;
    ll_class_entry *entry = ll_api_class(context, request, response);
    cJSON *body = entry && find_member(entry, request, response, &w) ? ll_api_body(request, response) : NULL;
    ll_class_ballot ballot = {0};
    ll_status status = body ? ll_param_parse(&ll_class_vote_table, body, &ballot) : ll_ok();
    if (body && ll_failed(&status)) {
        ll_api_problem(response, request, &status);
    } else if (body) {
        ll_class *c = ll_api_lock_class(entry, request, response);
        if (c) {
            status = is_there(c, &w) ? ll_class_act(c, w.place, ll_now_ns())
                                     : ll_error(LL_FORBIDDEN, "Unknown token: the member has left.");
            LL_THEN(status, ll_class_vote(c, w.place, &ballot));
            ll_class_entry_unlock(entry);
            if (ll_failed(&status))
                ll_api_problem(response, request, &status);
            else
                response->status = 204;
        }
    }
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

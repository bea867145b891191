/* Members of a class: joining, seats, copies, votes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "threads/clock.h"

/* A member between two locks: its place may become another's. */
typedef struct who {
    int place;
    uint32_t number;
} who;

static bool is_there(const ll_class *c, const who *w)
{
    return c->members[w->place].used && c->members[w->place].number == w->number;
}

/* The member that asks; false: the error was answered. */
static bool find_member(ll_class_entry *entry, const ll_http_request *request, ll_http_response *response,
                        who *w)
{
    const char *key = ll_api_key(request, response, "the member's token");
    const ll_class *c = key ? ll_api_lock_class(entry, request, response) : NULL;
    if (!c)
        return false;
    w->place = ll_class_find(c, key, strlen(key));
    w->number = w->place >= 0 ? c->members[w->place].number : 0;
    bool removed = w->place < 0 && ll_class_has_removed(c, key, strlen(key));
    ll_class_entry_unlock(entry);
    ll_status no = removed
                       ? ll_field_error(LL_FORBIDDEN, "device", LL_CLASS_OUT)
                       : ll_error(LL_FORBIDDEN, "Unknown token: no member of this class has it. Join again.");
    if (w->place < 0)
        ll_api_problem(response, request, &no);
    return w->place >= 0;
}

/* The fork of the board; NULL: the error was answered. */
static bool fork_board(ll_api *api, ll_class_entry *entry, const ll_http_request *request,
                       ll_http_response *response, ll_created_session *created)
{
    char board[LL_ID_LENGTH + 1];
    const ll_class *c = ll_api_lock_class(entry, request, response);
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
    bool made = ll_api_class_rate(api, request, response, entry, origin) &&
                ll_api_make_session(api, request, response, &create, created);
    ll_session_entry_release(origin);
    return made;
}

/* What a request of a member asks for, and what comes of it. */
typedef struct granted {
    const ll_class_wish *wish;
    ll_created_session created;      /* a new copy; empty: it keeps its copy, or wants none */
    char unwanted[LL_ID_LENGTH + 1]; /* the copy before */
    char gone[LL_ID_LENGTH + 1];     /* the copy of the member that gave way for it */
} granted;

static ll_status give_copy(ll_class *c, int place, granted *g)
{
    ll_class_member *m = &c->members[place];
    ll_class_watch(c, place);
    m->role = LL_CLASS_COPY;
    if (!g->created.session_entry)
        return ll_ok();
    memcpy(g->unwanted, m->copy.session, sizeof g->unwanted);
    m->copy = (ll_class_link){.session = ""};
    memcpy(m->copy.session, ll_session_entry_id(g->created.session_entry), sizeof m->copy.session);
    return ll_ok();
}

static ll_status grant(ll_class *c, int place, granted *g)
{
    LL_TRY(ll_class_act(c, place, ll_now_ns()));
    if (g->wish->role == LL_CLASS_COPY)
        return give_copy(c, place, g);
    if (g->wish->role == LL_CLASS_PLAY)
        return ll_class_claim(c, place, (int)g->wish->player, ll_now_ns());
    ll_class_watch(c, place);
    return ll_ok();
}

void ll_api_delete_copy(ll_api *api, const char *id)
{
    ll_session_entry *session = ll_host_find(api->host, id);
    if (session)
        ll_host_discard(api->host, session);
    ll_session_entry_release(session);
}

/* Deletes the copies without an owner: those from before, or the new one if it was not given. */
static void end_grant(ll_api *api, granted *g, bool stored)
{
    if (stored) {
        ll_api_delete_copy(api, g->unwanted);
        ll_api_delete_copy(api, g->gone);
    } else if (g->created.session_entry) {
        ll_host_discard(api->host, g->created.session_entry);
    }
    ll_session_entry_release(g->created.session_entry);
}

static void answer_member(ll_class_entry *entry, const who *w, const char *token,
                          const ll_created_session *created, const ll_http_request *request,
                          ll_http_response *response)
{
    const ll_class *c = ll_api_lock_class(entry, request, response);
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
    return ll_api_good(response, request, &status) &&
           !(wish->role == LL_CLASS_COPY && ll_http_become_task(request, response));
}

static ll_status arrive(ll_class *c, ll_class_arrival *arrival, who *w, granted *g)
{
    arrival->now = ll_now_ns();
    arrival->unix_s = ll_unix_ms() / 1000;
    LL_TRY(ll_class_admits(c, arrival->client, arrival->now));
    w->place = ll_class_join(c, arrival, g->gone);
    w->number = c->members[w->place].number;
    return grant(c, w->place, g);
}

/* Joins with all that it wants, or not at all. */
static bool join(ll_class_entry *entry, const ll_http_request *request, ll_http_response *response,
                 granted *g, who *w, char token[LL_KEY_LENGTH + 1])
{
    ll_class_arrival arrival = {.client = ll_class_client(request->peer)};
    if (!ll_new_key(token) || !ll_key_hash_make(token, &arrival.token)) {
        ll_status no = ll_error(LL_NO_MEMORY, "Random numbers for tokens not available.");
        ll_api_problem(response, request, &no);
        return false;
    }
    ll_class *c = ll_api_change_class(entry, request, response);
    if (!c)
        return false;
    ll_status status = arrive(c, &arrival, w, g);
    return ll_api_store_class(entry, request, response, &status);
}

/* Changes the part of a member. */
static bool change_part(ll_class_entry *entry, const ll_http_request *request, ll_http_response *response,
                        granted *g, const who *w)
{
    ll_class *c = ll_api_change_class(entry, request, response);
    if (!c)
        return false;
    ll_status status =
        is_there(c, w) ? grant(c, w->place, g) : ll_error(LL_NOT_FOUND, "The member has left.");
    return ll_api_store_class(entry, request, response, &status);
}

/* Whether the member, if there is one, keeps the copy that it has. */
static bool keeps_copy(ll_class_entry *entry, const who *w, const ll_class_wish *wish)
{
    const ll_class *c = w && !wish->fresh ? ll_class_entry_lock(entry) : NULL;
    if (!c)
        return false;
    bool keeps = is_there(c, w) && c->members[w->place].copy.session[0];
    ll_class_entry_unlock(entry);
    return keeps;
}

/* Whether a copy may be made for it: the class is asked before the work, and again when it is given. */
static bool may_copy(ll_class_entry *entry, const who *w, const ll_http_request *request,
                     ll_http_response *response)
{
    const ll_class *c = ll_api_lock_class(entry, request, response);
    if (!c)
        return false;
    ll_status status = w ? ll_class_may_act(c, w->place, ll_now_ns())
                         : ll_class_admits(c, ll_class_client(request->peer), ll_now_ns());
    ll_class_entry_unlock(entry);
    return ll_api_good(response, request, &status);
}

/* Does what the wish says, for a member, or with `w` NULL for a new one. */
static void enter(ll_api *api, ll_class_entry *entry, const who *w, const ll_class_wish *wish,
                  const ll_http_request *request, ll_http_response *response)
{
    char token[LL_KEY_LENGTH + 1];
    who joined;
    granted g = {.wish = wish};
    if (wish->role == LL_CLASS_COPY && !keeps_copy(entry, w, wish) &&
        !(may_copy(entry, w, request, response) && fork_board(api, entry, request, response, &g.created)))
        return;
    bool stored =
        w ? change_part(entry, request, response, &g, w) : join(entry, request, response, &g, &joined, token);
    if (stored)
        answer_member(entry, w ? w : &joined, w ? NULL : token, &g.created, request, response);
    end_grant(api, &g, stored);
}

/* Who comes with a token that the class knows: its device is not a new one. */
static bool comes_back(ll_class_entry *entry, const ll_http_request *request)
{
    const char *key = ll_api_find_key(request);
    const ll_class *c = key ? ll_class_entry_lock(entry) : NULL;
    if (!c)
        return false;
    bool known = ll_class_find(c, key, strlen(key)) >= 0 || ll_class_has_removed(c, key, strlen(key));
    ll_class_entry_unlock(entry);
    return known;
}

void ll_post_members(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_class_wish wish;
    who w;
    ll_class_entry *entry = ll_api_class(context, request, response);
    cJSON *body = entry ? ll_api_optional_body(request, response) : NULL;
    if (body && read_wish(body, request, response, &wish)) {
        bool known = comes_back(entry, request);
        if (!known || find_member(entry, request, response, &w))
            enter(context, entry, known ? &w : NULL, &wish, request, response);
    }
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
    ll_class_entry *entry = ll_api_class(context, request, response);
    cJSON *body = entry && find_member(entry, request, response, &w) ? ll_api_body(request, response) : NULL;
    if (body && read_wish(body, request, response, &wish))
        enter(context, entry, &w, &wish, request, response);
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

void ll_delete_member(void *context, const ll_http_request *request, ll_http_response *response)
{
    who w;
    const ll_status good = ll_ok();
    char copy[LL_ID_LENGTH + 1] = "";
    ll_class_entry *entry = ll_api_class(context, request, response);
    ll_class *c = entry && find_member(entry, request, response, &w)
                      ? ll_api_change_class(entry, request, response)
                      : NULL;
    if (c && is_there(c, &w)) {
        memcpy(copy, c->members[w.place].copy.session, sizeof copy);
        ll_class_leave(c, w.place);
    }
    if (c && ll_api_store_class(entry, request, response, &good)) {
        ll_api_delete_copy(context, copy);
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
    bool good = body && ll_api_good(response, request, &status);
    ll_class *c = good ? ll_api_change_class(entry, request, response) : NULL;
    if (c) {
        status = is_there(c, &w) ? ll_class_act(c, w.place, ll_now_ns())
                                 : ll_error(LL_FORBIDDEN, "Unknown token: the member has left.");
        LL_THEN(status, ll_class_vote(c, w.place, &ballot));
        if (ll_api_store_class(entry, request, response, &status))
            response->status = 204;
    }
    cJSON_Delete(body);
    ll_class_entry_release(entry);
}

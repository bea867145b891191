/* Changes of a session: parameters, control, inputs. Each is answered when its line of the log is stored. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/http/http_problem.h"
#include "input/action_json.h"

typedef struct order {
    const cJSON *body;
    int player;
    ll_action action;
    cJSON *answer;
} order;

static void add_time(cJSON *json, const ll_session_info *info)
{
    cJSON_AddNumberToObject(json, "tick", (double)info->tick);
    cJSON_AddNumberToObject(json, "time_s", (double)info->time / 1e9);
}

static ll_status patch(void *context, ll_session *session, ll_time wall)
{
    order *o = context;
    ll_status status = ll_session_patch(session, wall, o->body);
    if (ll_failed(&status))
        return status;
    ll_session_info info = ll_session_get_info(session);
    o->answer = cJSON_CreateObject();
    add_time(o->answer, &info);
    cJSON_AddNumberToObject(o->answer, "params_version", info.params_version);
    cJSON_AddItemToObject(o->answer, "params", ll_session_params(session));
    return status;
}

static ll_status control(void *context, ll_session *session, ll_time wall)
{
    const order *o = context;
    return ll_session_begin_control(session, wall, o->body);
}

static void tell_control(void *context, ll_session *session)
{
    order *o = context;
    ll_session_info info = ll_session_get_info(session);
    char hash[17];
    ll_api_hash_text(ll_session_hash(session), hash);
    o->answer = cJSON_CreateObject();
    cJSON_AddStringToObject(o->answer, "status", ll_api_status_name(&info));
    add_time(o->answer, &info);
    cJSON_AddNumberToObject(o->answer, "log_end_s", (double)info.head / 1e9);
    cJSON_AddNumberToObject(o->answer, "speed", info.speed);
    cJSON_AddNumberToObject(o->answer, "generation", info.generation);
    cJSON_AddStringToObject(o->answer, "hash", hash);
}

static ll_status input(void *context, ll_session *session, ll_time wall)
{
    order *o = context;
    ll_status status = ll_session_input(session, wall, o->player, &o->action);
    if (ll_failed(&status))
        return status;
    ll_session_info info = ll_session_get_info(session);
    o->answer = cJSON_CreateObject();
    add_time(o->answer, &info);
    return status;
}

static void command(ll_api *api, const ll_http_request *request, ll_http_response *response,
                    ll_session_entry *session_entry, ll_create_requests *orders, order *o)
{
    orders->context = o;
    orders->task = request->task;
    ll_status status = ll_host_command(api->host, session_entry, orders);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    else
        ll_http_json(response, 200, o->answer);
    cJSON_Delete(o->answer);
}

/* What moves a session may have to run it for long. */
static bool moves(const cJSON *body)
{
    const cJSON *op = cJSON_GetObjectItemCaseSensitive(body, "op");
    return cJSON_IsString(op) &&
           (strcmp(op->valuestring, "seek") == 0 || strcmp(op->valuestring, "step") == 0);
}

static void owner_command(ll_api *api, const ll_http_request *request, ll_http_response *response,
                          ll_create_requests orders)
{
    ll_session_entry *session_entry = ll_api_session(api, request, response);
    if (!session_entry)
        return;
    if (ll_api_permits(request, response, session_entry, -1)) {
        cJSON *body = ll_api_body(request, response);
        order o = {.body = body};
        if (body && !(moves(body) && ll_http_to_work(request, response)))
            command(api, request, response, session_entry, &orders, &o);
        cJSON_Delete(body);
    }
    ll_session_entry_release(session_entry);
}

void ll_patch_params(void *context, const ll_http_request *request, ll_http_response *response)
{
    owner_command(context, request, response, (ll_create_requests){.change = patch});
}

void ll_post_control(void *context, const ll_http_request *request, ll_http_response *response)
{
    owner_command(context, request, response,
                  (ll_create_requests){.change = control, .clock = true, .tell = tell_control});
}

/* The body says which player it is for, hence whose key will do. Without any key nothing is read. */
void ll_post_input(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_session_entry *session_entry = ll_api_session(context, request, response);
    if (!session_entry)
        return;
    cJSON *body = NULL;
    if (ll_http_header(request, "Authorization"))
        body = ll_api_body(request, response);
    else
        ll_api_permits(request, response, session_entry, 0);
    if (body) {
        order o = {0};
        ll_create_requests orders = {.change = input};
        ll_status status = ll_action_parse(body, "", &o.player, &o.action);
        if (ll_failed(&status))
            ll_http_problem(response, request, &status);
        else if (ll_api_permits(request, response, session_entry, o.player))
            command(context, request, response, session_entry, &orders, &o);
    }
    cJSON_Delete(body);
    ll_session_entry_release(session_entry);
}

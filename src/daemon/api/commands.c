/* Changes of a session: parameters, control, inputs. Each is answered when its log line is stored. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "input/action_json.h"

typedef struct command_args {
    const cJSON *body;
    int player;
    ll_action action;
    cJSON *answer;
} command_args;

static void add_time(cJSON *json, const ll_session_info *info)
{
    cJSON_AddNumberToObject(json, "tick", (double)info->tick);
    cJSON_AddNumberToObject(json, "time_s", (double)info->time / 1e9);
}

static ll_status patch(void *context, ll_session *session, ll_time wall)
{
    command_args *o = context;
    LL_TRY(ll_session_patch(session, wall, o->body));
    ll_session_info info = ll_session_get_info(session);
    o->answer = cJSON_CreateObject();
    add_time(o->answer, &info);
    cJSON_AddNumberToObject(o->answer, "params_version", info.params_version);
    cJSON_AddItemToObject(o->answer, "params", ll_session_params(session));
    return ll_ok();
}

static ll_status control(void *context, ll_session *session, ll_time wall)
{
    const command_args *o = context;
    return ll_session_begin_control(session, wall, o->body);
}

static void answer_control(void *context, ll_session *session)
{
    command_args *o = context;
    ll_session_info info = ll_session_get_info(session);
    char hash[17];
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)ll_session_hash(session));
    o->answer = cJSON_CreateObject();
    cJSON_AddStringToObject(o->answer, "status", ll_session_status_names[info.status]);
    add_time(o->answer, &info);
    cJSON_AddNumberToObject(o->answer, "log_end_s", (double)info.head / 1e9);
    cJSON_AddNumberToObject(o->answer, "speed", info.speed);
    cJSON_AddNumberToObject(o->answer, "generation", info.generation);
    cJSON_AddStringToObject(o->answer, "hash", hash);
}

static ll_status input(void *context, ll_session *session, ll_time wall)
{
    command_args *o = context;
    LL_TRY(ll_session_input(session, wall, o->player, &o->action));
    ll_session_info info = ll_session_get_info(session);
    o->answer = cJSON_CreateObject();
    add_time(o->answer, &info);
    return ll_ok();
}

static void run_command(ll_api *api, const ll_http_request *request, ll_http_response *response,
                        ll_session_entry *session_entry, ll_command_request *command, command_args *o)
{
    uint32_t begun = request->begun;
    command->context = o;
    command->task = request->task;
    command->begun = &begun;
    ll_status status = ll_host_command(api->host, session_entry, command);
    response->begun = begun;
    ll_api_result(response, request, &status, o->answer);
}

static bool is_seek(const cJSON *body)
{
    const cJSON *op = cJSON_GetObjectItemCaseSensitive(body, "op");
    return cJSON_IsString(op) && strcmp(op->valuestring, "seek") == 0;
}

static void owner_command(ll_api *api, const ll_http_request *request, ll_http_response *response,
                          ll_command_request command)
{
    ll_session_entry *session_entry = ll_api_session(api, request, response);
    if (!session_entry)
        return;
    if (ll_api_permits(request, response, session_entry, -1)) {
        cJSON *body = ll_api_body(request, response);
        command_args o = {.body = body};
        if (body && !(is_seek(body) && ll_http_become_task(request, response)))
            run_command(api, request, response, session_entry, &command, &o);
        cJSON_Delete(body);
    }
    ll_session_entry_release(session_entry);
}

void ll_patch_params(void *context, const ll_http_request *request, ll_http_response *response)
{
    owner_command(context, request, response, (ll_command_request){.change = patch});
}

void ll_post_control(void *context, const ll_http_request *request, ll_http_response *response)
{
    owner_command(context, request, response,
                  (ll_command_request){.change = control, .clock = true, .report = answer_control});
}

/* The body names the player, and so which key is valid. Without any key the body is not read. */
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
        command_args o = {0};
        ll_command_request command = {.change = input};
        ll_status status = ll_action_parse(body, "", &o.player, &o.action);
        if (ll_failed(&status))
            ll_http_problem(response, request, &status);
        else if (ll_api_permits(request, response, session_entry, o.player))
            run_command(context, request, response, session_entry, &command, &o);
    }
    cJSON_Delete(body);
    ll_session_entry_release(session_entry);
}

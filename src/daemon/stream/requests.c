#include "daemon/stream/requests.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/net/problem_json.h"

/* ---- reading ---- */

ll_status ll_request_id(const cJSON *message, char reply_id[LL_REPLY_ID])
{
    const cJSON *id = cJSON_GetObjectItemCaseSensitive(message, "id");
    if (!id)
        return ll_ok();
    bool number = cJSON_IsNumber(id) && id->valuedouble == floor(id->valuedouble) &&
                  fabs(id->valuedouble) <= 9007199254740992.0;
    if (!number && !(cJSON_IsString(id) && strlen(id->valuestring) <= 16))
        return ll_field_error(LL_BAD_INPUT, "id",
                              "id: must be a whole number or a text of at most 16 bytes.");
    char *text = cJSON_PrintUnformatted(id);
    if (text && strlen(text) < LL_REPLY_ID)
        memcpy(reply_id, text, strlen(text) + 1);
    free(text);
    return ll_ok();
}

/* Frames between two sections, for the highest rate that is at most `hz` and divides LL_FRAME_HZ. */
static uint8_t frames_between(double hz)
{
    int every = (int)ceil(LL_FRAME_HZ / hz - 1e-9);
    while (LL_FRAME_HZ % every != 0)
        every++;
    return (uint8_t)every;
}

static ll_status read_rate(const cJSON *member, ll_ws_subscription *subscription)
{
    ll_channel channel = ll_channel_named(member->string);
    if (channel == LL_CHANNELS)
        return ll_field_error(LL_BAD_INPUT, "subscribe",
                              "subscribe: channel %.40s does not exist; the hello message lists all.",
                              member->string);
    if (!cJSON_IsNumber(member) || !(member->valuedouble >= 1 && member->valuedouble <= LL_FRAME_HZ))
        return ll_field_error(LL_BAD_INPUT, "subscribe", "subscribe: rate of %.40s must be 1 to %d Hz.",
                              member->string, LL_FRAME_HZ);
    subscription->every[channel] = frames_between(member->valuedouble);
    return ll_ok();
}

ll_status ll_request_rates(const cJSON *subscribe, ll_ws_subscription *subscription)
{
    const cJSON *member;
    *subscription = (ll_ws_subscription){{0}};
    if (!cJSON_IsObject(subscribe))
        return ll_field_error(LL_BAD_INPUT, "subscribe",
                              "subscribe: must be an object: of each channel its rate in Hz.");
    cJSON_ArrayForEach(member, subscribe)
    {
        LL_TRY(read_rate(member, subscription));
    }
    return ll_ok();
}

ll_status ll_request_ping(const cJSON *ping)
{
    if (!cJSON_IsNumber(ping) || !isfinite(ping->valuedouble))
        return ll_field_error(LL_BAD_INPUT, "ping", "ping: must be a number; the pong repeats it.");
    return ll_ok();
}

/* ---- answers ---- */

cJSON *ll_request_answer(const char *type, const char *reply_id)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "type", type);
    if (reply_id[0])
        cJSON_AddRawToObject(json, "id", reply_id);
    return json;
}

cJSON *ll_request_granted(const ll_ws_subscription *subscription, const char *reply_id)
{
    cJSON *json = ll_request_answer("reply", reply_id);
    cJSON_AddTrueToObject(json, "ok");
    cJSON *rates = cJSON_AddObjectToObject(json, "subscribed");
    for (int c = 0; c < LL_CHANNELS; c++)
        if (subscription->every[c] > 0)
            cJSON_AddNumberToObject(rates, ll_channels[c].name, (double)LL_FRAME_HZ / subscription->every[c]);
    return json;
}

cJSON *ll_request_pong(const cJSON *ping, int64_t wall_ns, const char *reply_id)
{
    char wall[24];
    cJSON *json = ll_request_answer("pong", reply_id);
    cJSON_AddNumberToObject(json, "ping", ping->valuedouble);
    snprintf(wall, sizeof wall, "%lld", (long long)wall_ns);
    cJSON_AddRawToObject(json, "wall_ns", wall);
    return json;
}

void ll_request_send(ll_ws *ws, ll_ws_viewer viewer, cJSON *json)
{
    char *text = cJSON_PrintUnformatted(json);
    if (text)
        ll_ws_send(ws, viewer, text, strlen(text));
    free(text);
    cJSON_Delete(json);
}

void ll_request_refuse(ll_ws *ws, ll_ws_viewer viewer, const char *reply_id, int http_status,
                       const ll_status *error)
{
    cJSON *json = ll_request_answer("error", reply_id);
    cJSON_AddItemToObject(json, "problem", ll_http_problem_json(http_status, error, NULL));
    ll_request_send(ws, viewer, json);
}

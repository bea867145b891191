/* Messages of viewers (keys, inputs, pings, subscriptions) and messages to them between frames.
 *
 * Hooks run on the stream's thread, which must not wait for a session: they put inputs into the session's
 * inbox, and the worker applies them in the next slot, which is also when their effect can be seen first. The
 * reply is sent when the input's line is stored. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/hosting/quota.h"
#include "daemon/hosting/session_entry.h"
#include "daemon/net/problem_json.h"
#include "daemon/stream/requests.h"
#include "input/action_json.h"
#include "session/scenario.h"

/* ---- replies ---- */

static int http_status(const ll_status *error)
{
    return error->code == LL_IO ? 507 : error->code == LL_LIMIT ? 429 : ll_http_problem_status(error->code);
}

static void send_error(ll_host *host, ll_ws_viewer viewer, const char *reply_id, const ll_status *error)
{
    ll_request_refuse(host->ws, viewer, reply_id, http_status(error), error);
}

static void send_durable(ll_host *host, ll_reply *reply, const ll_status *failed)
{
    if (failed)
        send_error(host, reply->viewer, reply->id, failed);
    else
        ll_ws_send(host->ws, reply->viewer, reply->good, strlen(reply->good));
    free(reply->good);
    free(reply);
}

/* Sends the replies that have become durable; errors for the others if the store fails. */
void ll_host_send_replies(void *context)
{
    ll_host *host = context;
    ll_status why;
    bool failing = ll_store_failing(host->store, &why);
    uint64_t durable = ll_store_durable(host->store);
    ll_reply *ready = NULL, **end = &ready;
    pthread_mutex_lock(&host->replies.lock);
    ll_reply **link = &host->replies.first;
    while (*link) {
        ll_reply *reply = *link;
        if (reply->ticket <= durable || failing) {
            *link = reply->next;
            reply->next = NULL;
            *end = reply;
            end = &reply->next;
        } else {
            link = &reply->next;
        }
    }
    host->replies.end = link;
    pthread_mutex_unlock(&host->replies.lock);
    while (ready) {
        ll_reply *next = ready->next;
        send_durable(host, ready, ready->ticket <= durable ? NULL : &why);
        ready = next;
    }
}

static void reply_when_stored(ll_session_entry *session_entry, ll_ws_viewer viewer, const char *reply_id,
                              cJSON *json)
{
    ll_host *host = session_entry->host;
    ll_reply *reply = calloc(1, sizeof *reply);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    if (!reply || !text) {
        free(reply);
        free(text);
        return;
    }
    *reply = (ll_reply){.ticket = session_entry->stored.ticket, .viewer = viewer, .good = text};
    snprintf(reply->id, sizeof reply->id, "%s", reply_id);
    pthread_mutex_lock(&host->replies.lock);
    *host->replies.end = reply;
    host->replies.end = &reply->next;
    pthread_mutex_unlock(&host->replies.lock);
    ll_host_send_replies(host); /* the store may have committed already */
}

/* ---- called by the worker; the session is locked ---- */

static void send_hello(ll_session_entry *session_entry, ll_ws_viewer viewer, ll_frame_format format)
{
    char *hello = ll_frame_hello(session_entry->session, session_entry->identity.id, format);
    if (hello)
        ll_ws_hello(session_entry->host->ws, viewer, hello, strlen(hello));
    else
        ll_ws_close(session_entry->host->ws, viewer, LL_WS_TRY_LATER, "no memory");
    free(hello);
}

void ll_viewers_send_hellos(ll_session_entry *session_entry)
{
    while (atomic_load(&session_entry->inbox.hellos) > 0) {
        ll_ws_viewer id = 0;
        ll_frame_format format = LL_FRAME_JSON;
        pthread_mutex_lock(&session_entry->inbox.lock);
        for (ll_viewer *v = session_entry->inbox.viewers; v && !id; v = v->next) {
            if (v->hello_sent)
                continue;
            v->hello_sent = true;
            atomic_fetch_sub(&session_entry->inbox.hellos, 1);
            id = v->id;
            format = v->format;
        }
        pthread_mutex_unlock(&session_entry->inbox.lock);
        if (!id)
            return;
        send_hello(session_entry, id, format);
    }
}

static ll_status apply_input(ll_session_entry *session_entry, ll_time wall, const ll_stream_input *input)
{
    ll_host *host = session_entry->host;
    LL_TRY(ll_store_check(host->store));
    double rate = host->config.max_commands_per_s;
    if (!ll_bucket_take(&session_entry->commands, rate, rate * 2, wall)) {
        atomic_fetch_add(&host->refused.commands, 1);
        return ll_error(LL_LIMIT, "commands: must be at most %g/s for one session", rate);
    }
    LL_TRY(ll_quota_check_line(session_entry, false));
    return ll_session_input(session_entry->session, wall, input->player, &input->action);
}

void ll_viewers_apply(ll_session_entry *session_entry, ll_time wall)
{
    if (!atomic_load(&session_entry->inbox.waiting))
        return;
    pthread_mutex_lock(&session_entry->inbox.lock);
    ll_stream_input *input = session_entry->inbox.inputs;
    atomic_store(&session_entry->inbox.waiting, false);
    session_entry->inbox.inputs = NULL;
    session_entry->inbox.inputs_end = &session_entry->inbox.inputs;
    pthread_mutex_unlock(&session_entry->inbox.lock);
    while (input) {
        ll_stream_input *next = input->next;
        ll_status status = apply_input(session_entry, wall, input);
        if (ll_failed(&status)) {
            send_error(session_entry->host, input->viewer, input->reply_id, &status);
        } else {
            atomic_fetch_add(&session_entry->host->counts.inputs, 1);
            if (session_entry->stored.rewound)
                ll_session_entry_save(session_entry);
            if (input->reply_id[0]) {
                cJSON *json = ll_request_answer("reply", input->reply_id);
                cJSON_AddTrueToObject(json, "ok");
                cJSON_AddNumberToObject(json, "tick",
                                        (double)ll_session_get_info(session_entry->session).tick);
                reply_when_stored(session_entry, input->viewer, input->reply_id, json);
            }
        }
        free(input);
        input = next;
    }
}

/* ---- messages, on the stream's thread ---- */

typedef struct message {
    ll_session_entry *session_entry;
    ll_ws_viewer viewer;
    const cJSON *json;
    char reply_id[LL_REPLY_ID];
} message;

static int role_of(ll_session_entry *session_entry, ll_ws_viewer id)
{
    int role = LL_ROLE_NONE;
    pthread_mutex_lock(&session_entry->inbox.lock);
    for (ll_viewer *v = session_entry->inbox.viewers; v; v = v->next)
        if (v->id == id)
            role = v->role;
    pthread_mutex_unlock(&session_entry->inbox.lock);
    return role;
}

static ll_status take_auth(message *m, const cJSON *value)
{
    if (!cJSON_IsString(value))
        return ll_field_error(LL_BAD_INPUT, "auth", "auth: must be a key (text).");
    bool guest;
    int role =
        ll_session_entry_find_role(m->session_entry, value->valuestring, strlen(value->valuestring), &guest);
    if (role == LL_ROLE_NONE)
        return ll_field_error(LL_FORBIDDEN, "auth", "Key of another session.");
    pthread_mutex_lock(&m->session_entry->inbox.lock);
    for (ll_viewer *v = m->session_entry->inbox.viewers; v; v = v->next) {
        if (v->id == m->viewer) {
            v->role = role;
            v->guest = guest;
        }
    }
    pthread_mutex_unlock(&m->session_entry->inbox.lock);
    cJSON *json = ll_request_answer("reply", m->reply_id);
    cJSON_AddTrueToObject(json, "ok");
    cJSON_AddStringToObject(json, "role", role == LL_ROLE_OWNER ? "owner" : "player");
    if (role != LL_ROLE_OWNER)
        cJSON_AddNumberToObject(json, "player", role);
    ll_request_send(m->session_entry->host->ws, m->viewer, json);
    return ll_ok();
}

static ll_status take_input(message *m, const cJSON *value)
{
    int player;
    ll_action action;
    LL_TRY(ll_action_parse(value, "input", &player, &action));
    int role = role_of(m->session_entry, m->viewer);
    if (role != LL_ROLE_OWNER && role != player)
        return ll_field_error(LL_FORBIDDEN, "input.player",
                              "Send {\"auth\":KEY} with the owner's or player %d's key first.", player);
    ll_stream_input *input = calloc(1, sizeof *input);
    if (!input)
        return ll_error(LL_NO_MEMORY, "Out of memory.");
    *input = (ll_stream_input){.viewer = m->viewer, .player = player, .action = action};
    memcpy(input->reply_id, m->reply_id, sizeof input->reply_id);
    pthread_mutex_lock(&m->session_entry->inbox.lock);
    *m->session_entry->inbox.inputs_end = input;
    m->session_entry->inbox.inputs_end = &input->next;
    atomic_store(&m->session_entry->inbox.waiting, true);
    pthread_mutex_unlock(&m->session_entry->inbox.lock);
    ll_session_entry_notify(m->session_entry);
    return ll_ok();
}

static ll_status take_ping(message *m, const cJSON *value)
{
    LL_TRY(ll_request_ping(value));
    ll_ws *ws = m->session_entry->host->ws;
    ll_request_send(ws, m->viewer, ll_request_pong(value, ll_now_ns(), m->reply_id));
    return ll_ok();
}

static ll_status take_subscribe(message *m, const cJSON *value)
{
    ll_ws *ws = m->session_entry->host->ws;
    ll_ws_subscription subscription;
    LL_TRY(ll_request_rates(value, &subscription));
    ll_ws_subscribe(ws, m->viewer, &subscription);
    ll_request_send(ws, m->viewer, ll_request_granted(&subscription, m->reply_id));
    return ll_ok();
}

static const struct {
    const char *name;
    ll_status (*take)(message *m, const cJSON *value);
} messages[] = {
    {"auth", take_auth}, {"input", take_input}, {"ping", take_ping}, {"subscribe", take_subscribe}};

static ll_status take_message(message *m)
{
    if (!cJSON_IsObject(m->json))
        return ll_error(LL_BAD_INPUT, "A message must be an object with one of ack, auth, input, ping or "
                                      "subscribe, and an id if a reply is wanted.");
    LL_TRY(ll_request_id(m->json, m->reply_id));
    const cJSON *member, *found = NULL;
    size_t kind = 0;
    cJSON_ArrayForEach(member, m->json)
    {
        size_t i = 0;
        while (i < sizeof messages / sizeof messages[0] && strcmp(member->string, messages[i].name) != 0)
            i++;
        if (i < sizeof messages / sizeof messages[0] && !found) {
            found = member;
            kind = i;
        } else if (strcmp(member->string, "id") != 0) {
            return ll_field_error(
                LL_BAD_INPUT, member->string,
                "A message must have one of ack, auth, input, ping or subscribe, and an id; not also %.40s.",
                member->string);
        }
    }
    if (!found)
        return ll_error(LL_BAD_INPUT, "A message must have one of ack, auth, input, ping or subscribe.");
    return messages[kind].take(m, found);
}

static void on_message(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length)
{
    message m = {.session_entry = session, .viewer = viewer};
    cJSON *json = NULL;
    ll_status status = ll_json_parse(text, length, &json);
    m.json = json;
    LL_THEN(status, take_message(&m));
    if (ll_failed(&status))
        send_error(context, viewer, m.reply_id, &status);
    cJSON_Delete(json);
}

/* ---- opening and closing, on the stream's thread ---- */

static void on_opened(void *context, void *session, ll_ws_viewer id, ll_frame_format format)
{
    ll_host *host = context;
    ll_session_entry *session_entry = session;
    ll_viewer *viewer = calloc(1, sizeof *viewer);
    if (!viewer) {
        ll_ws_close(host->ws, id, LL_WS_TRY_LATER, "no memory");
        return;
    }
    *viewer = (ll_viewer){.id = id, .format = format, .role = LL_ROLE_NONE};
    pthread_mutex_lock(&session_entry->inbox.lock);
    viewer->next = session_entry->inbox.viewers;
    session_entry->inbox.viewers = viewer;
    atomic_fetch_add(&session_entry->inbox.viewer_count, 1);
    atomic_fetch_add(&session_entry->inbox.hellos, 1);
    pthread_mutex_unlock(&session_entry->inbox.lock);
    atomic_store(&session_entry->shared.last_used, ll_now_ns());
    ll_session_entry_notify(session_entry);
}

static void on_closed(void *context, void *session, ll_ws_viewer id)
{
    (void)context;
    ll_session_entry *session_entry = session;
    ll_viewer *gone = NULL;
    pthread_mutex_lock(&session_entry->inbox.lock);
    for (ll_viewer **link = &session_entry->inbox.viewers; *link; link = &(*link)->next) {
        if ((*link)->id == id) {
            gone = *link;
            *link = gone->next;
            atomic_fetch_sub(&session_entry->inbox.viewer_count, 1);
            atomic_fetch_sub(&session_entry->inbox.hellos, !gone->hello_sent);
            break;
        }
    }
    pthread_mutex_unlock(&session_entry->inbox.lock);
    free(gone);
    atomic_store(&session_entry->shared.last_used, ll_now_ns());
    ll_session_entry_notify(session_entry);
}

static void on_wanted(void *context, void *session)
{
    (void)context;
    ll_session_entry_notify(session);
}

static void on_released(void *context, void *session)
{
    (void)context;
    ll_session_entry_release(session);
}

ll_ws_hooks ll_viewers_hooks(ll_host *host)
{
    return (ll_ws_hooks){.context = host,
                         .opened = on_opened,
                         .message = on_message,
                         .closed = on_closed,
                         .wanted = on_wanted,
                         .released = on_released};
}

/* Messages on the stream of a class. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/class/internal.h"
#include "daemon/net/problem_json.h"
#include "daemon/stream/requests.h"
#include "session/scenario.h"

#define GATHER_NS (500 * LL_MS) /* counts and measurements wait for each other this long */
#define PING_NS (2 * LL_SECOND) /* between two measurements of a round trip */

static bool has_member(const ll_class *c, const class_viewer *viewer)
{
    return viewer->place >= 0 && c->members[viewer->place].used &&
           c->members[viewer->place].number == viewer->number;
}

/* ---- sending; locked ---- */

static void send_hello(ll_class_entry *entry, class_viewer *viewer, ll_time now)
{
    cJSON *json = ll_class_describe(&entry->values, now);
    cJSON_ReplaceItemInObjectCaseSensitive(json, "type", cJSON_CreateString("hello"));
    cJSON_AddStringToObject(json, "class", entry->id);
    cJSON_AddStringToObject(json, "code", entry->code);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    if (text)
        ll_ws_hello(entry->classes->ws, viewer->id, text, strlen(text));
    viewer->hello_sent = true;
    free(text);
}

static void send_state(ll_class_entry *entry, ll_time now)
{
    ll_class *c = &entry->values;
    c->serial++;
    c->changed = c->stirred = false;
    entry->sent_at = now;
    cJSON *json = ll_class_describe(c, now);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    for (class_viewer *v = entry->viewers; v && text; v = v->next) {
        if (v->hello_sent)
            ll_ws_send(entry->classes->ws, v->id, text, strlen(text));
        if (v->hello_sent && v->teacher)
            ll_request_send(entry->classes->ws, v->id, ll_class_describe_members(c));
    }
    free(text);
}

/* To a viewer whose member has gone: it has left, its place is another device's, or the teacher has removed
 * it.
 */
static void send_removed(ll_class_entry *entry, class_viewer *viewer)
{
    cJSON *json = ll_request_answer("removed", "");
    cJSON_AddBoolToObject(json, "by_teacher", ll_class_has_removed_number(&entry->values, viewer->number));
    ll_request_send(entry->classes->ws, viewer->id, json);
    viewer->place = -1;
}

static void send_own(ll_class_entry *entry)
{
    ll_class *c = &entry->values;
    for (class_viewer *v = entry->viewers; v; v = v->next) {
        bool present = has_member(c, v);
        if (!present && v->place >= 0)
            send_removed(entry, v);
        else if (present && !c->members[v->place].notified)
            ll_request_send(entry->classes->ws, v->id, ll_class_describe_member(c, v->place));
    }
    for (int i = 0; i < c->capacity; i++)
        c->members[i].notified = true;
}

static void measure(ll_class_entry *entry)
{
    for (class_viewer *v = entry->viewers; v; v = v->next)
        if (has_member(&entry->values, v) && entry->values.members[v->place].player >= 0)
            ll_ws_ping(entry->classes->ws, v->id);
}

void ll_class_entry_tell(ll_class_entry *entry, ll_time now)
{
    const ll_class *c = &entry->values;
    for (class_viewer *v = entry->viewers; v; v = v->next)
        if (!v->hello_sent)
            send_hello(entry, v, now);
    if (c->changed || (c->stirred && now - entry->sent_at >= GATHER_NS))
        send_state(entry, now);
    send_own(entry);
    if (now - entry->pinged_at >= PING_NS) {
        entry->pinged_at = now;
        measure(entry);
    }
}

/* ---- hooks, on the stream's thread ---- */

static class_viewer *find_viewer(const ll_class_entry *entry, ll_ws_viewer id)
{
    class_viewer *viewer = entry->viewers;
    while (viewer && viewer->id != id)
        viewer = viewer->next;
    return viewer;
}

static void on_opened(void *context, void *session, ll_ws_viewer id, ll_frame_format format)
{
    ll_classes *classes = context;
    ll_class_entry *entry = session;
    class_viewer *viewer = calloc(1, sizeof *viewer);
    (void)format;
    if (!viewer) {
        ll_ws_close(classes->ws, id, LL_WS_TRY_LATER, "no memory");
        return;
    }
    *viewer = (class_viewer){.id = id, .place = -1};
    pthread_mutex_lock(&classes->lock);
    viewer->next = entry->viewers;
    entry->viewers = viewer;
    ll_classes_wake(classes);
    pthread_mutex_unlock(&classes->lock);
}

/* The version, if it has the member of this connection. */
static ll_class *version_with(ll_class_entry *entry, const class_viewer *viewer, int i)
{
    ll_class *c = ll_class_entry_version(entry, i);
    return c && has_member(c, viewer) ? c : NULL;
}

/* The member of this connection has gone, or the connection becomes another's. */
static void detach(ll_class_entry *entry, class_viewer *viewer, ll_time now)
{
    for (int i = 0; i < LL_CLASS_VERSIONS; i++) {
        ll_class *c = version_with(entry, viewer, i);
        if (c)
            ll_class_disconnected(c, viewer->place, now);
    }
    viewer->place = -1;
    viewer->teacher = false;
}

static ll_status authenticate(ll_class_entry *entry, class_viewer *viewer, const cJSON *key)
{
    if (!cJSON_IsString(key))
        return ll_field_error(LL_BAD_INPUT, "auth", "auth: must be a key or a token (text).");
    const ll_class *c = &entry->values;
    size_t length = strlen(key->valuestring);
    int place = ll_class_find(c, key->valuestring, length);
    if (place < 0 && ll_class_has_removed(c, key->valuestring, length))
        return ll_field_error(LL_FORBIDDEN, "device", LL_CLASS_OUT);
    bool teacher = place < 0 && ll_key_matches(&c->teacher, key->valuestring, length);
    if (place < 0 && !teacher)
        return ll_field_error(LL_FORBIDDEN, "auth", "auth: neither the teacher's key nor a member's token.");
    ll_time now = ll_now_ns();
    detach(entry, viewer, now);
    viewer->teacher = teacher;
    viewer->place = place;
    viewer->number = place >= 0 ? c->members[place].number : 0;
    for (int i = 0; i < LL_CLASS_VERSIONS; i++) {
        ll_class *any = ll_class_entry_version(entry, i), *with = version_with(entry, viewer, i);
        if (any)
            any->stirred = any->stirred || teacher; /* so that it receives the members */
        if (with)
            ll_class_connected(with, place, now);
    }
    return ll_ok();
}

static ll_status read_message(const char *text, size_t length, cJSON **json, const cJSON **key,
                              char reply_id[LL_REPLY_ID])
{
    ll_status status = ll_json_parse(text, length, json);
    LL_THEN(status, ll_request_id(*json, reply_id));
    if (ll_failed(&status))
        return status;
    *key = cJSON_GetObjectItemCaseSensitive(*json, "auth");
    if (!cJSON_IsObject(*json) || !*key || cJSON_GetArraySize(*json) != (reply_id[0] ? 2 : 1))
        return ll_error(LL_BAD_INPUT, "A message must be {\"auth\":KEY}, with the teacher's key or a "
                                      "member's token, and an \"id\" if it likes; all else is a request of "
                                      "HTTP.");
    return status;
}

static void on_message(void *context, void *session, ll_ws_viewer id, const char *text, size_t length)
{
    ll_classes *classes = context;
    ll_class_entry *entry = session;
    cJSON *json = NULL;
    const cJSON *key = NULL;
    char reply_id[LL_REPLY_ID] = "";
    ll_status status = read_message(text, length, &json, &key, reply_id);
    pthread_mutex_lock(&classes->lock);
    class_viewer *viewer = find_viewer(entry, id);
    if (viewer && !entry->ended && !ll_failed(&status))
        status = authenticate(entry, viewer, key);
    if (ll_failed(&status)) {
        ll_request_refuse(classes->ws, id, reply_id, ll_http_problem_status(status.code), &status);
    } else {
        cJSON *answer = ll_request_answer("reply", reply_id);
        cJSON_AddTrueToObject(answer, "ok");
        cJSON_AddStringToObject(answer, "role", viewer && viewer->teacher ? "teacher" : "member");
        ll_request_send(classes->ws, id, answer);
    }
    ll_classes_wake(classes);
    pthread_mutex_unlock(&classes->lock);
    cJSON_Delete(json);
}

static void on_pong(void *context, void *session, ll_ws_viewer id, int64_t round_trip_ns)
{
    ll_classes *classes = context;
    ll_class_entry *entry = session;
    pthread_mutex_lock(&classes->lock);
    const class_viewer *viewer = find_viewer(entry, id);
    for (int i = 0; viewer && i < LL_CLASS_VERSIONS; i++) {
        ll_class *c = version_with(entry, viewer, i);
        if (c)
            ll_class_heard(c, viewer->place, round_trip_ns, ll_now_ns());
    }
    pthread_mutex_unlock(&classes->lock);
}

static void on_closed(void *context, void *session, ll_ws_viewer id)
{
    ll_classes *classes = context;
    ll_class_entry *entry = session;
    class_viewer *gone = NULL;
    pthread_mutex_lock(&classes->lock);
    for (class_viewer **link = &entry->viewers; *link && !gone; link = &(*link)->next) {
        if ((*link)->id != id)
            continue;
        gone = *link;
        *link = gone->next;
        detach(entry, gone, ll_now_ns());
        break;
    }
    ll_classes_wake(classes);
    pthread_mutex_unlock(&classes->lock);
    free(gone);
}

static void on_released(void *context, void *session)
{
    (void)context;
    ll_class_entry_release(session);
}

ll_ws_hooks ll_classes_hooks(ll_classes *classes)
{
    return (ll_ws_hooks){.context = classes,
                         .opened = on_opened,
                         .message = on_message,
                         .closed = on_closed,
                         .pong = on_pong,
                         .released = on_released};
}

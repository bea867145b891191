/* Messages to one viewer, including the last, `bye`. Runs on its stream's thread. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/stream/internal.h"

void ll_ws_messages_drop(ws_viewer *viewer)
{
    while (viewer->messages.first != NULL) {
        ws_command *message = viewer->messages.first;
        viewer->messages.first = message->next;
        free(message);
    }
    viewer->messages.last = NULL;
    viewer->messages.count = 0;
    viewer->messages.bytes = 0;
}

void ll_ws_messages_flush(ws_viewer *viewer)
{
    while (viewer->messages.first != NULL && !viewer->dead && !ll_ws_socket_full(viewer)) {
        ws_command *message = viewer->messages.first;
        ll_ws_socket_write(viewer, message->text, message->size, LWS_WRITE_TEXT);
        viewer->messages.first = message->next;
        viewer->messages.last = message->next != NULL ? viewer->messages.last : NULL;
        viewer->messages.count--;
        viewer->messages.bytes -= message->size;
        free(message);
    }
}

static void enqueue(ws_viewer *viewer, ws_command *message)
{
    message->next = NULL;
    if (viewer->messages.last != NULL)
        viewer->messages.last->next = message;
    else
        viewer->messages.first = message;
    viewer->messages.last = message;
    viewer->messages.count++;
    viewer->messages.bytes += message->size;
}

static ws_command *message_of(cJSON *json) /* takes ownership */
{
    char *text = json != NULL ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    size_t size = text != NULL ? strlen(text) : 0;
    ws_command *message = text != NULL ? calloc(1, sizeof *message + size + 1) : NULL;
    if (message != NULL) {
        memcpy(message->text, text, size);
        message->size = size;
    }
    cJSON_free(text);
    return message;
}

void ll_ws_viewer_close(ws_viewer *viewer, int code, const char *reason)
{
    if (viewer->closing.code != 0 || viewer->dead)
        return;
    viewer->closing.code = code;
    snprintf(viewer->closing.reason, sizeof viewer->closing.reason, "%s", reason);
    cJSON *bye = cJSON_CreateObject();
    cJSON_AddStringToObject(bye, "type", "bye");
    cJSON_AddStringToObject(bye, "reason", viewer->closing.reason);
    ws_command *message = message_of(bye);
    if (message != NULL)
        enqueue(viewer, message);
    /* The close frame is sent after the messages. A viewer that does not read is cut off
     * (ll_ws_viewer_sweep). */
    viewer->closing.since_ns = viewer->thread->now_ns;
    lws_callback_on_writable(viewer->wsi);
}

static bool has_room(const ws_viewer *viewer, const ws_command *message)
{
    return viewer->messages.count < WS_MAX_MESSAGES &&
           viewer->messages.bytes + message->size <= WS_MAX_MESSAGE_BYTES;
}

/* A message waits until the socket is writable, as the library's pong does, which it would overtake. */
void ll_ws_viewer_send(ws_viewer *viewer, ws_command *message)
{
    if (viewer->closing.code != 0 || viewer->dead) {
        free(message);
        return;
    }
    if (!has_room(viewer, message)) { /* many in one turn */
        ll_ws_messages_flush(viewer);
    }
    if (!has_room(viewer, message)) {
        free(message);
        ll_ws_messages_drop(viewer);
        ll_ws_count(&viewer->thread->counts.closed_slow, 1);
        ll_ws_viewer_close(viewer, LL_WS_TRY_LATER, "viewer reads too slowly: too many messages queued");
        return;
    }
    enqueue(viewer, message);
    lws_callback_on_writable(viewer->wsi);
}

void ll_ws_viewer_send_json(ws_viewer *viewer, cJSON *json)
{
    ws_command *message = message_of(json);
    if (message != NULL)
        ll_ws_viewer_send(viewer, message);
}

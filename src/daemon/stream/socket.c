/* What is sent to a viewer, by libwebsockets. */
#include <string.h>
#include <sys/socket.h>

#include "daemon/stream/internal.h"

#define PING "ping" /* the library does not report empty pongs */

/* Between two calls of the library it may not free a viewer: its stream's list is being gone through. The
 * next turn finds the connection at its end. */
void ll_ws_socket_cut(ws_viewer *viewer)
{
    if (!viewer->dead) {
        viewer->dead = true;
        shutdown(lws_get_socket_fd(viewer->wsi), SHUT_RDWR);
        lws_callback_on_writable(viewer->wsi);
    }
}

bool ll_ws_socket_full(const ws_viewer *viewer)
{
    return lws_partial_buffered(viewer->wsi) != 0 || lws_get_close_length(viewer->wsi) > 0;
}

void ll_ws_socket_write(ws_viewer *viewer, unsigned char *payload, size_t size, enum lws_write_protocol kind)
{
    if (!viewer->dead && lws_write(viewer->wsi, payload, size, kind) < 0)
        ll_ws_socket_cut(viewer);
}

void ll_ws_socket_ping(ws_viewer *viewer)
{
    unsigned char bytes[LWS_PRE + sizeof PING] = {0};
    memcpy(bytes + LWS_PRE, PING, sizeof PING);
    viewer->pinged_ns = ll_now_ns();
    ll_ws_socket_write(viewer, bytes + LWS_PRE, sizeof PING - 1, LWS_WRITE_PING);
}

void ll_ws_socket_measure(ws_viewer *viewer)
{
    if (viewer->measured_ns == 0 && viewer->closing.code == 0 && !ll_ws_socket_full(viewer)) {
        ll_ws_socket_ping(viewer);
        viewer->measured_ns = viewer->pinged_ns;
    }
}

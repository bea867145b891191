/* Upgrades on a connection that libmicrohttpd owns (from a proxy that reuses its connections). The library
 * answers with 101 and lends its socket to the streams, which return it when the viewer has left. */
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/socket.h>

#include "daemon/http/internal.h"
#include "daemon/net/framing.h"

struct http_upgrade {
    ll_http *http;
    ll_upgrade upgrade;
};

static void return_socket(void *handle)
{
    MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
}

static void on_upgrade(void *closure, struct MHD_Connection *connection, void *context, const char *extra,
                       size_t extra_size, MHD_socket socket, struct MHD_UpgradeResponseHandle *handle)
{
    const http_upgrade *offer = closure;
    ll_ws_socket lent = {.fd = socket, .answered = true, .release = return_socket, .owner = handle};
    int on = 1, off = 0;
    (void)connection, (void)context;
    /* The library corks the socket. */
    setsockopt(socket, IPPROTO_TCP, TCP_CORK, &off, sizeof off);
    setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    atomic_fetch_add(&offer->http->upgrades, 1);
    /* Not counted by the connection limiter: HTTP has counted the connection, which stays the library's. */
    ll_ws_adopt(offer->http->ws, &offer->upgrade, &lent, extra, extra_size,
                &(ll_connection_limiter_pass){.valid = false});
}

struct MHD_Response *ll_http_accept_upgrade(ll_http *http, const ll_upgrade *upgrade, http_upgrade **offer)
{
    char accept[29];
    *offer = NULL;
    http_upgrade *made = ll_framing_accept(upgrade->key, accept) ? malloc(sizeof *made) : NULL;
    if (made == NULL) {
        return NULL;
    }
    *made = (http_upgrade){.http = http, .upgrade = *upgrade};
    struct MHD_Response *response = MHD_create_response_for_upgrade(on_upgrade, made);
    if (response == NULL || MHD_add_response_header(response, "Upgrade", "websocket") == MHD_NO ||
        MHD_add_response_header(response, "Sec-WebSocket-Accept", accept) == MHD_NO ||
        MHD_add_response_header(response, "Sec-WebSocket-Protocol", ll_stream_protocols[upgrade->format]) ==
            MHD_NO) {
        if (response != NULL) {
            MHD_destroy_response(response);
        }
        free(made);
        return NULL;
    }
    *offer = made;
    return response;
}

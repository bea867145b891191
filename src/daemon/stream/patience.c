/* When the socket of a viewer is read.
 *
 * Of one that only acknowledges, and soon, two acknowledgements are read at a time: reading costs more than
 * encoding a frame. The system reports its socket when more has come than one acknowledgement, which an input
 * of a player is by itself. A shorter message waits for the next acknowledgement; when that does not come,
 * the socket is read as before. */
#include <sys/socket.h>

#include "daemon/stream/internal.h"

enum { ACKS = 32, IN_FLIGHT = 1, HEAD_BYTES = 6 /* of a client's short message */ };
#define WITHIN_NS INT64_C(1300000000) /* for ACKS acknowledgements: 25 frames/s or more */
#define MISSED_NS INT64_C(100000000)

static bool await(const ws_viewer *viewer, size_t size)
{
    int least = (int)size;
    return setsockopt(viewer->socket.fd, SOL_SOCKET, SO_RCVLOWAT, &least, sizeof least) == 0;
}

static void await_more(ws_viewer *viewer, size_t bytes)
{
    viewer->flow.patient = await(viewer, bytes + 1) ? bytes : 0;
}

void ll_ws_patience_ends(ws_viewer *viewer)
{
    viewer->flow.acks = 0;
    if (viewer->flow.patient != 0) {
        viewer->flow.patient = 0;
        await(viewer, 1);
    }
}

void ll_ws_patience_grows(ws_viewer *viewer, size_t size)
{
    ws_viewer_flow *flow = &viewer->flow;
    int64_t now = viewer->thread->now_ns;
    if (flow->patient != 0) {
        if (HEAD_BYTES + size > flow->patient) { /* its numbers have become longer */
            await_more(viewer, HEAD_BYTES + size);
        }
        return;
    }
    if (flow->outstanding_count > IN_FLIGHT || viewer->closing.code != 0 || viewer->measured_ns != 0) {
        flow->acks = 0;
    }
    if (flow->acks++ == 0) {
        flow->acks_since_ns = now;
    }
    if (flow->acks > ACKS) {
        flow->acks = 0;
        if (now - flow->acks_since_ns < WITHIN_NS) {
            await_more(viewer, HEAD_BYTES + size);
        }
    }
}

void ll_ws_patience_sweep(ws_viewer *viewer)
{
    if (viewer->flow.patient != 0 && viewer->thread->now_ns - viewer->received_ns > MISSED_NS) {
        ll_ws_patience_ends(viewer);
    }
}

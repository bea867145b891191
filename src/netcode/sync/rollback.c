/* Rollback (GGPO, GGRS): deterministic lockstep that does not wait. A client guesses the inputs that have not
 * arrived, and resimulates the ticks with a wrong guess. */
#include "netcode/observe/desync.h"
#include "netcode/server/barrier.h"
#include "netcode/server/relay_server.h"
#include "netcode/state/peer.h"

const ll_sync_mode ll_sync_rollback = {
    .name = "rollback",
    .help = "Only inputs are sent; every client guesses missing ones, and rolls back when a guess was wrong.",
    .guesses = true,
    .sends_idle = true,
    .reports_refusals = true,
    .steps_by_inputs = true,
    .due = ll_relay_server_due,
    .step = ll_relay_server_step,
    .take = ll_relay_server_take,
    .stand_in = ll_relay_server_fill,
    .join = ll_barrier_join,
    .compose = ll_relay_server_compose,
    .start = ll_peer_start,
    .receive = ll_peer_receive,
    .tick = ll_peer_tick,
    .display = ll_peer_display,
    .observe = ll_desync_observe,
};

/* Deterministic lockstep (paper, "Deterministic Lockstep"; Fiedler): only inputs are sent, and every client
 * makes tick k when it has all inputs for k. Nothing is guessed and nothing corrected. The price: two lags
 * between an input and its effect, and equal arithmetic on every machine. */
#include "netcode/observe/desync.h"
#include "netcode/server/barrier.h"
#include "netcode/server/relay_server.h"
#include "netcode/state/peer.h"

const ll_sync_mode ll_sync_deterministic = {
    .name = "deterministic",
    .help = "Only inputs are sent; every client makes a tick when it has all inputs for it.",
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

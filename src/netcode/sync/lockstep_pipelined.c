/* Lockstep with inputs in flight: clients make one every interval, before the previous snapshot has arrived.
 * So the game keeps its rate at any lag, and an input is felt a round trip and an interval later. When a
 * player's inputs are missing, all wait. Then the server makes the delayed steps whose inputs have arrived at
 * a higher rate, and clients made no inputs meanwhile: latency returns to what it was. */
#include "netcode/server/lockstep.h"
#include "netcode/state/client.h"

const ll_sync_mode ll_sync_lockstep_pipelined = {
    .name = "lockstep_pipelined",
    .help =
        "The server waits for every player's input, which clients send without waiting for its snapshots.",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .waits = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .steps_by_inputs = true,
    .due = ll_lockstep_due_in_rhythm,
    .step = ll_lockstep_step_in_rhythm,
    .take = ll_server_receive,
    .compose = ll_server_compose,
    .receive = ll_client_receive,
    .tick = ll_client_tick,
    .display = ll_client_display,
    .interpolate = ll_interpolate_server_time,
};

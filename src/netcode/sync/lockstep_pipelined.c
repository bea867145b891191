/* Lockstep with inputs in flight: clients make one every interval, whether or not the state before has come.
 * So the game keeps its pace at any lag, and an input is felt a round trip and an interval later. When
 * somebody's inputs are missing everybody waits; then the server makes up for the steps whose inputs have
 * been there, and clients made none meanwhile: latency is what it was. */
#include "netcode/server/lockstep.h"
#include "netcode/state/client.h"

const ll_sync_mode ll_sync_lockstep_pipelined = {
    .name = "lockstep_pipelined",
    .help = "The server waits for every player's input, which clients send without waiting for its states.",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .waits = true,
    .sends_idle = true,
    .tells_refusals = true,
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

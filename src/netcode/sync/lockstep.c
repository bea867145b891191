/* Lockstep as in the paper (Figure 10): a client sends its input, waits for the snapshot that includes it,
 * and only then makes the next. A step takes the slowest player's round trip and an interval of the server:
 * one slow player slows all. Nothing is guessed, so nothing is corrected. An input without an answer is sent
 * again. */
#include "netcode/server/lockstep.h"
#include "netcode/state/client.h"

const ll_sync_mode ll_sync_lockstep = {
    .name = "lockstep",
    .help =
        "Stop and wait, as in the paper: a client sends an input and waits for the snapshot before the next.",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .waits = true,
    .answers = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .steps_by_inputs = true,
    .due = ll_lockstep_due,
    .step = ll_lockstep_step,
    .take = ll_server_receive,
    .compose = ll_server_compose,
    .receive = ll_client_receive,
    .tick = ll_client_tick,
    .display = ll_client_display,
    .interpolate = ll_interpolate_server_time,
};

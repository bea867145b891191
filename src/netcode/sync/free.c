/* Free: the server steps on its own clock and applies at step k the inputs meant for k. The parameter
 * `starved` selects the replacement of a missing input. An input that arrives after its step is late and is
 * not applied. Clients run ahead by their lag, so that this is rare. */
#include "netcode/server/by_clock.h"
#include "netcode/state/client.h"

const ll_sync_mode ll_sync_free = {
    .name = "free",
    .help = "The server steps on its own clock; clients run ahead of it.",
    .client_runs_ahead = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .due = ll_by_clock_due,
    .step = ll_by_clock_step,
    .take = ll_server_receive,
    .compose = ll_server_compose,
    .receive = ll_client_receive,
    .tick = ll_client_tick,
    .display = ll_client_display,
    .interpolate = ll_interpolate_server_time,
};

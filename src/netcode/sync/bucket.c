/* Bucket synchronisation (MiMaze: Gautier, Diot, Kurose, 1999; paper: "ignore lost packets and move on"). The
 * server steps on its own clock and does not wait. An input is applied at a fixed delay after it was made,
 * the same for all players, so that players of different lag act at the same time. What arrives later is
 * ignored: the step has the replacement that `starved` selects.
 *
 * The clocks of all machines are set before the game, as MiMaze's were by NTP: a client does not measure the
 * server's clock, and only `drift_ppm` sets them apart. A client makes one input in a bucket; none in a
 * bucket without a tick of its timer. */
#include "netcode/protocol/bucket.h"

#include "netcode/server/by_clock.h"
#include "netcode/state/client.h"

/* The next input is for the step of the present bucket; none if that has one already. */
static void align(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_time since = ll_client_local(s, now) - c->snapshots.game_start;
    int64_t step =
        c->snapshots.game_start_step + ll_bucket_step(since, s->bucket_delay_ms, c->ticks.clock.freq);
    c->ticks.skipped = 0;
    c->inputs.extra = step > c->inputs.tick ? 0 : -1;
    if (step <= c->inputs.tick + 1)
        return;
    ll_client_snap(c, step - 1);
    if (c->inputs.seq == 0)
        c->predicting = 0; /* of a client that has joined again: its prediction begins at this step */
}

static int tick(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
{
    if (ll_connection_plays(&c->connection))
        align(c, s, now);
    return ll_client_tick(c, s, now, packet);
}

const ll_sync_mode ll_sync_bucket = {
    .name = "bucket",
    .help = "An input is applied at a fixed delay after it was made; one that arrives later is ignored.",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .buckets = true,
    .due = ll_by_clock_due,
    .step = ll_by_clock_step,
    .take = ll_server_receive,
    .compose = ll_server_compose,
    .receive = ll_client_receive,
    .tick = tick,
    .display = ll_client_display,
    .interpolate = ll_interpolate_server_time,
};

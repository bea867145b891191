/* The step that the next input is for: when a client joins a game, and when its clock is measured again. */
#include <string.h>

#include "netcode/state/client.h"

/* Inputs, and the server's answers to them, belong to an earlier epoch. */
void ll_client_forget_inputs(ll_client *c, const ll_client_setup *s, uint16_t epoch, ll_time now)
{
    c->epoch = epoch;
    c->seq = c->acked = c->newest_sent = 0;
    c->run = 1;
    for (int i = 0; i < LL_PENDING_RING; i++)
        c->pending[i].seq = 0;
    c->extra_inputs = 0;
    c->settle = 0;
    c->least_slack = LL_SLACK_UNKNOWN;
    c->least_slack_since = now;
    c->least_slack_ns = LL_NEVER;
    c->clock_correction = 0;
    c->unsent = 0;
    c->played = 0;
    c->predicting = 0; /* its steps were not made while the player was disconnected */
    c->parts = 0;
    c->gap = -1;
    c->gap_deviation = c->late = 0;
    c->offset_quarter = c->last_arrival = -1;
    if (s->sync->applies_on_arrival)
        c->tick = 0;
}

void ll_client_join(ll_client *c, const ll_client_setup *s, uint16_t epoch, int64_t step, int64_t first,
                    const void *world, ll_time now)
{
    ll_client_metrics_resync(s->client_metrics);
    ll_client_forget_inputs(c, s, epoch, now);
    if (s->sync->waits) /* its inputs continue at the server's step */
        c->tick = c->confirmed = step;
    if (s->sync->answers && c->tick_due != LL_NEVER)
        c->tick_due = now; /* the server waits */
    if (s->sync->start && world)
        s->sync->start(c, s, step, first, world);
}

void ll_client_leave(ll_client *c, const ll_client_setup *s)
{
    (void)s;
    c->acked = c->seq;
    for (int i = 0; i < LL_PENDING_RING; i++)
        c->pending[i].seq = 0;
}

void ll_client_snap(ll_client *c, int64_t tick)
{
    if (c->seq > 0) {
        c->seq += (uint32_t)(tick - c->tick);
        c->run = c->seq + 1;
        c->newest_sent = c->seq;
        c->connection.clock.snaps++;
    }
    c->tick = tick;
    c->extra_inputs = 0;
    c->settle = c->seq + 1;
}

/* The first step that an input sent at `at` can reach in time. */
static int64_t step_reached(const ll_client *c, const ll_client_setup *s, ll_time at)
{
    const ll_clock_sync *clock = &c->connection.clock;
    ll_time way = (ll_clock_sync_round_trip(clock) + 1) / 2;
    ll_time comes = ll_client_local(s, at) + clock->offset + way, since = comes - c->latest_time;
    int64_t step = c->latest_tick + (since > 0 ? ll_tick_at(since, c->clock.freq) : 0);
    if (step <= c->latest_tick)
        step = c->latest_tick + 1;
    while (ll_client_step_time(c, step) < comes)
        step++;
    return step;
}

uint8_t ll_client_offset(const ll_client *c, const ll_client_setup *s)
{
    const ll_clock_sync *clock = &c->connection.clock;
    if (c->tick_due == LL_NEVER)
        return 0; /* the game has not begun */
    ll_time tick = ll_client_local(s, c->tick_due) + clock->offset - c->game_start;
    if (tick < 0)
        return 0;
    tick -= ll_tick_time(ll_tick_at(tick, c->clock.freq), c->clock.freq);
    int64_t whole = ll_tick_at(tick + (ll_clock_sync_round_trip(clock) + 1) / 2, c->clock.freq);
    return (uint8_t)(whole < UINT8_MAX ? whole : UINT8_MAX);
}

void ll_client_align(ll_client *c, const ll_client_setup *s, bool always, ll_time now)
{
    if (!s->sync->client_runs_ahead || c->tick_due == LL_NEVER)
        return; /* or the game has not begun */
    ll_time at = c->tick_due != LL_NEVER && c->tick_due > now ? c->tick_due : now;
    int64_t tick = step_reached(c, s, at) + s->config->slack_ticks - 1, error = tick - c->tick;
    if (!always && error * c->period < LL_CLOCK_SNAP && -error * c->period < LL_CLOCK_SNAP)
        return;
    if (error > 0 || c->seq == 0)
        ll_client_snap(c, tick);
    else
        c->extra_inputs = (int32_t)error; /* inputs already sent for those steps remain valid */
}

/* The step that the next input is for: when a client joins a game, and when its clock is measured again. */
#include <string.h>

#include "netcode/protocol/report.h"
#include "netcode/state/client.h"

/* Inputs, and the server's answers to them, belong to an earlier epoch. */
void ll_client_forget_inputs(ll_client *c, const ll_client_setup *s, uint16_t epoch, ll_time now)
{
    c->epoch = epoch;
    c->inputs.seq = c->inputs.acked = c->inputs.newest_sent = 0;
    c->inputs.run = 1;
    for (int i = 0; i < LL_PENDING_RING; i++)
        c->pending[i].seq = 0;
    c->inputs.extra = 0;
    c->inputs.settle = 0;
    c->inputs.least_slack = LL_SLACK_UNKNOWN;
    c->inputs.least_slack_since = now;
    c->inputs.least_slack_ns = LL_NEVER;
    c->inputs.correction = 0;
    c->inputs.unsent = 0;
    c->prediction.played = 0;
    c->predicting = 0; /* its steps were not made while the player was disconnected */
    c->results.parts = 0;
    c->arrivals.gap = -1;
    c->arrivals.gap_deviation = c->arrivals.late = 0;
    c->arrivals.quarter = c->arrivals.last = -1;
    if (s->reporter)
        *s->reporter = (ll_reporter){0};
    if (s->sync->applies_on_arrival)
        c->inputs.tick = 0;
}

void ll_client_join(ll_client *c, const ll_client_setup *s, const ll_client_begin *begin, ll_time now)
{
    ll_client_metrics_resync(s->client_metrics);
    ll_client_forget_inputs(c, s, begin->epoch, now);
    if (s->sync->waits) /* its inputs continue at the server's step */
        c->inputs.tick = c->snapshots.confirmed = begin->step;
    if (s->sync->answers && c->ticks.due != LL_NEVER)
        c->ticks.due = now; /* the server waits */
    if (s->sync->start && begin->world)
        s->sync->start(c, s, begin);
}

void ll_client_leave(ll_client *c, const ll_client_setup *s)
{
    (void)s;
    c->inputs.acked = c->inputs.seq;
    for (int i = 0; i < LL_PENDING_RING; i++)
        c->pending[i].seq = 0;
}

void ll_client_snap(ll_client *c, int64_t tick)
{
    if (c->inputs.seq > 0) {
        c->inputs.seq += (uint32_t)(tick - c->inputs.tick);
        c->inputs.run = c->inputs.seq + 1;
        c->inputs.newest_sent = c->inputs.seq;
        c->connection.clock.snaps++;
    }
    c->inputs.tick = tick;
    c->inputs.extra = 0;
    c->inputs.settle = c->inputs.seq + 1;
}

/* The first step that an input sent at `at` can reach in time. */
static int64_t step_reached(const ll_client *c, const ll_client_setup *s, ll_time at)
{
    const ll_clock_sync *clock = &c->connection.clock;
    ll_time way = (ll_clock_sync_round_trip(clock) + 1) / 2;
    ll_time comes = ll_client_local(s, at) + clock->offset + way, since = comes - c->latest.time;
    int64_t step = c->latest.tick + (since > 0 ? ll_tick_at(since, c->ticks.clock.freq) : 0);
    if (step <= c->latest.tick)
        step = c->latest.tick + 1;
    while (ll_client_step_time(c, step) < comes)
        step++;
    return step;
}

uint8_t ll_client_offset(const ll_client *c, const ll_client_setup *s)
{
    const ll_clock_sync *clock = &c->connection.clock;
    if (c->ticks.due == LL_NEVER)
        return 0; /* the game has not begun */
    ll_time tick = ll_client_local(s, c->ticks.due) + clock->offset - c->snapshots.game_start;
    if (tick < 0)
        return 0;
    tick -= ll_tick_time(ll_tick_at(tick, c->ticks.clock.freq), c->ticks.clock.freq);
    int64_t whole = ll_tick_at(tick + (ll_clock_sync_round_trip(clock) + 1) / 2, c->ticks.clock.freq);
    return (uint8_t)(whole < UINT8_MAX ? whole : UINT8_MAX);
}

void ll_client_align(ll_client *c, const ll_client_setup *s, bool always, ll_time now)
{
    if (!s->sync->client_runs_ahead || c->ticks.due == LL_NEVER)
        return; /* or the game has not begun */
    ll_time at = c->ticks.due != LL_NEVER && c->ticks.due > now ? c->ticks.due : now;
    int64_t tick = step_reached(c, s, at) + s->config->slack_ticks - 1, error = tick - c->inputs.tick;
    if (!always && error * c->ticks.period < LL_CLOCK_SNAP && -error * c->ticks.period < LL_CLOCK_SNAP)
        return;
    if (error > 0 || c->inputs.seq == 0) {
        ll_client_snap(c, tick);
        return;
    }
    c->inputs.extra = (int32_t)error; /* inputs already sent for those steps remain valid */
    if (error < 0) {                  /* and their slack asks for the same again */
        c->inputs.settle = c->inputs.seq + 1;
        c->inputs.least_slack = LL_SLACK_UNKNOWN;
    }
}

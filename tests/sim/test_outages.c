/* Networks that fail and heal: within two seconds and twice the round trip after it everything is as if
 * nothing had been. Random outages, in every way of keeping in step, beside an undisturbed twin at the same
 * time. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/rng.h"
#include "support/scene.h"

#if defined(__SANITIZE_ADDRESS__) || !defined(__OPTIMIZE__)
#define OUTAGES 8 /* per way of keeping in step; a tenth as fast */
#else
#define OUTAGES 90
#endif

#define WINDOW_S 20 /* over which both are compared */
#define FEW 8       /* of so many there is a mean */
#define LAG_MAX 300.0

typedef struct outage {
    const ll_sync *sync;
    int players, who; /* -1: all */
    bool up, down;
    double update_hz, at_s, length_s, lag_ms[4];
    char scenario[4096];
} outage;

static double draw(uint64_t number, int k, double low, double high)
{
    return low + (high - low) * ll_rng_unit(20261122, (uint64_t)k, number);
}

static bool chance(uint64_t number, int k, double share)
{
    return draw(number, k, 0, 1) < share;
}

static double heals_s(const outage *o)
{
    return o->at_s + o->length_s;
}

static double round_trip_s(const outage *o)
{
    double most = 0;
    for (int i = 0; i < o->players; i++)
        most = fmax(most, 2 * o->lag_ms[i]);
    return most / 1e3;
}

/* When all is to be as if nothing had been. */
static double recovered_s(const outage *o)
{
    return heals_s(o) + 2 + 2 * round_trip_s(o);
}

static int write_player(const outage *o, uint64_t n, int i, bool disturbed, char *at, size_t room)
{
    bool hit = disturbed && (o->who < 0 || o->who == i), predicts = chance(n, 40 + i, 0.5);
    char blackout[160] = "", up[180], down[180];
    if (hit)
        snprintf(blackout, sizeof blackout, "\"blackout_at_ms\":%.3f,\"blackout_length_ms\":%.3f",
                 o->at_s * 1e3, o->length_s * 1e3);
    snprintf(up, sizeof up, "%s", o->up ? blackout : "");
    snprintf(down, sizeof down, "%s", o->down ? blackout : "");
    return snprintf(at, room,
                    "%s{\"lag_ms\":%.3f,\"prediction\":%s,\"reconciliation\":%s,\"interpolation\":%s,"
                    "\"link\":{\"up\":{%s},\"down\":{%s}}}",
                    i > 0 ? "," : "", o->lag_ms[i], predicts ? "true" : "false", predicts ? "true" : "false",
                    chance(n, 50 + i, 0.5) ? "true" : "false", up, down);
}

static void write_scenario(outage *o, uint64_t n, bool disturbed)
{
    static const char *const codecs[] = {"full", "quantised", "delta"};
    char *at = o->scenario, *end = at + sizeof o->scenario;
    at += snprintf(
        at, (size_t)(end - at),
        "{\"kind\":\"netgame\",\"game\":\"%s\",\"duration_s\":3600,\"seed\":%d,\"warmup_s\":0,"
        "\"params\":{%s},\"server\":{\"sync\":\"%s\",\"update_hz\":%g,\"snapshot\":\"%s\"},\"players\":[",
        o->sync->drains ? "gambetta" : "race", (int)n, o->sync->drains ? "" : "\"laps\":10000", o->sync->name,
        o->update_hz, codecs[(int)draw(n, 2, 0, 3)]);
    for (int i = 0; i < o->players; i++)
        at += write_player(o, n, i, disturbed, at, (size_t)(end - at));
    snprintf(at, (size_t)(end - at), "]}");
}

static outage draw_outage(const ll_sync *sync, uint64_t n)
{
    static const double rates[] = {10, 20, 30, 60};
    outage o = {
        .sync = sync, .update_hz = rates[(int)draw(n, 3, 0, 4)], .players = 1 + (int)draw(n, 1, 0, 4)};
    int ways = (int)draw(n, 4, 0, 3);
    o.up = ways != 1;
    o.down = ways != 0;
    o.who = chance(n, 5, 0.3) ? -1 : (int)draw(n, 6, 0, o.players);
    o.at_s = chance(n, 7, 0.15) ? 0 : draw(n, 8, 0, 20);
    o.length_s = 0.1 * pow(600, draw(n, 9, 0, 1));
    for (int i = 0; i < o.players; i++)
        o.lag_ms[i] = draw(n, 10 + i, 1, LAG_MAX);
    return o;
}

/* ---- what is compared ---- */

enum { FELT, ACKED, AGE, OPEN, VALUES };
static const char *const names[VALUES] = {"input latency", "acknowledged after", "view age", "open inputs"};
static const ll_metric metrics[VALUES] = {LL_METRIC_INPUT_LATENCY, LL_METRIC_ACK_RTT, LL_METRIC_VIEW_AGE,
                                          LL_METRIC_UNACKED};

typedef struct sums {
    double sum[VALUES];
    int64_t count[VALUES], applied;
} sums;

static sums sums_of(const scene *s, int player)
{
    const ll_instruments *in = ll_netgame_instruments(s->game, player);
    sums now = {.applied = in->ledger.count[LL_INPUT_WAS_APPLIED]};
    for (int v = 0; v < VALUES; v++) {
        now.sum[v] = in->histogram[metrics[v]].sum;
        now.count[v] = in->histogram[metrics[v]].count;
    }
    return now;
}

typedef struct window {
    double mean[VALUES]; /* NaN: too few were counted */
    int64_t applied;
    int64_t refused; /* from the start */
} window;

static window window_of(const sums *before, const sums *after, const scene *s, int player)
{
    window w = {.applied = after->applied - before->applied};
    const ll_seat *seat = &ll_netgame_server(s->game)->seats[player];
    for (int v = 0; v < VALUES; v++) {
        int64_t count = after->count[v] - before->count[v];
        w.mean[v] = count >= FEW ? (after->sum[v] - before->sum[v]) / (double)count : NAN;
    }
    for (int rule = 1; rule < LL_RULES; rule++)
        w.refused += seat->refused[rule];
    return w;
}

static void run(const outage *o, window windows[4])
{
    sums before[4], after;
    scene s = scene_make(o->scenario, NULL);
    scene_run(&s, recovered_s(o), NULL);
    for (int i = 0; i < o->players; i++)
        before[i] = sums_of(&s, i);
    scene_run(&s, recovered_s(o) + WINDOW_S, NULL);
    for (int i = 0; i < o->players; i++) {
        after = sums_of(&s, i);
        windows[i] = window_of(&before[i], &after, &s, i);
    }
    scene_close(&s);
}

/* ---- the table ---- */

typedef struct row {
    int outages, players, unplayed, refused, off;
    double worst[VALUES]; /* relative */
} row;

/* Where everybody waits for everybody there is no clock that says when a step is: they fall between updates
 * and displays as the waiting had it, and an outage moves them. So far a mean may move beside the tenth: in a
 * lockstep by the update that an input waits for, and a display. Where clients exchange inputs, two updates
 * are on the way, and the ticks that are in flight keep the distance that the outage gave them: as many as
 * before in a round trip, but bunched otherwise. */
static double unit_ms(const outage *o)
{
    double display_ms = 1e3 / 60, update_ms = 1e3 / o->update_hz;
    if (o->sync->observe)
        return display_ms + 2 * update_ms + 1e3 * round_trip_s(o) / 2;
    return !o->sync->waits ? 0 : o->sync->answers ? display_ms : display_ms + update_ms;
}

static bool near(const outage *o, int value, double got, double twin)
{
    double unit = value == OPEN ? unit_ms(o) > 0 : unit_ms(o), off = fabs(got - twin);
    return isnan(got) || isnan(twin) || off <= fmax(0.1 * twin, unit) + 1e-6;
}

/* Whether the player plays as its twin does. */
static bool compare(row *r, const outage *o, const window *got, const window *twin)
{
    bool same = true, unplayed = got->applied < 0.9 * (double)twin->applied - 1;
    for (int v = 0; v < VALUES; v++) {
        double off = fabs(got->mean[v] - twin->mean[v]);
        if (off > 1e-6 && twin->mean[v] > 0)
            r->worst[v] = fmax(r->worst[v], off / twin->mean[v]);
        same = same && near(o, v, got->mean[v], twin->mean[v]);
    }
    r->players++;
    r->unplayed += unplayed;
    r->refused += got->refused > 0;
    r->off += !same;
    return same && !unplayed && got->refused == 0;
}

static bool try(row *r, const ll_sync *sync, uint64_t n)
{
    window got[4], twin[4];
    bool same = true;
    outage o = draw_outage(sync, n);
    write_scenario(&o, n, false);
    run(&o, twin);
    write_scenario(&o, n, true);
    run(&o, got);
    r->outages++;
    for (int p = 0; p < o.players; p++) {
        bool one = compare(r, &o, &got[p], &twin[p]);
        for (int v = 0; v < VALUES && !one; v++)
            printf("  outage %d, player %d, %s: %.2f, twin %.2f\n", (int)n, p, names[v], got[p].mean[v],
                   twin[p].mean[v]);
        same = same && one;
    }
    if (!same)
        printf("  %s\n", o.scenario);
    return same;
}

static void everything_is_as_before(void **state)
{
    (void)state;
    bool all = true;
    printf("%-20s %8s %8s %8s %8s %8s, and most, beside the twin's:", "sync", "outages", "players",
           "unplayed", "refused", "off");
    for (int v = 0; v < VALUES; v++)
        printf(" %18s", names[v]);
    printf("\n");
    for (int k = 0; ll_syncs[k]; k++) {
        row r = {0};
        for (int i = 0; i < OUTAGES; i++)
            all = try(&r, ll_syncs[k], (uint64_t)(1000 * (k + 1) + i)) && all;
        printf("%-20s %8d %8d %8d %8d %8d                             ", ll_sync_names[k], r.outages,
               r.players, r.unplayed, r.refused, r.off);
        for (int v = 0; v < VALUES; v++)
            printf(" %17.2f%%", 100 * r.worst[v]);
        printf("\n");
    }
    assert_true(all);
}

/* What comes at one instant comes before the client acts, also when it is let in again just then: the accept
 * and the state of one update that come together are drawn together. */
static void packets_come_before_clients_act(void **state)
{
    (void)state;
    int rejoined = 0;
    for (int k = 0; k < 80; k++) {
        char begins[64], lasts[64];
        snprintf(begins, sizeof begins, "players.0.link.up.blackout_at_ms=%d", 2000 + 7 * k);
        snprintf(lasts, sizeof lasts, "players.0.link.up.blackout_length_ms=%d", 1400 + 31 * (k % 8));
        const char *const sets[] = {begins,
                                    lasts,
                                    "players.0.clock_phase=0",
                                    "players.0.lag_ms=150",
                                    "server.update_hz=20",
                                    "server.timeout_s=0.7",
                                    NULL};
        tape t = {0};
        scene s = scene_open("race", sets);
        ll_recorder r = tape_recorder(&t);
        scene_run(&s, 6, &r);
        ll_time acted = -1;
        for (size_t i = 0; i < t.count; i++) {
            const ll_event *e = &t.events[i];
            if (e->player != 0)
                continue;
            if (e->type == LL_EVENT_INPUT || e->type == LL_EVENT_PING || e->type == LL_EVENT_CONNECT)
                acted = e->begin;
            assert_true(e->type != LL_EVENT_APPLIED || e->begin != acted);
        }
        rejoined += ll_netgame_client(s.game, 0)->connection.joins > 1;
        tape_free(&t);
        scene_close(&s);
    }
    assert_true(rejoined > 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packets_come_before_clients_act),
        cmocka_unit_test(everything_is_as_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

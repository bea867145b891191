/* Networks that fail and heal: two seconds plus twice the round trip after an outage its effect is gone. In
 * the 20 s from then on each mean is within a tenth of that of an undisturbed reference at the same time.
 * Random outages, in every sync mode. Means with a tolerance other than a tenth have it in `unit_ms`. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "support/many.h"
#include "support/near.h"
#include "support/scene.h"

#if defined(__SANITIZE_ADDRESS__) || !defined(__OPTIMIZE__)
enum { FEW_OUTAGES = 8, MANY_OUTAGES = 8, MORE = 1 }; /* a tenth of the cases when tests must be fast */
#else
/* MORE: factor for sync modes with fast games; others are slower than their clocks. */
enum { FEW_OUTAGES = 30, MANY_OUTAGES = 90, MORE = 7 };
#endif
static int outages = FEW_OUTAGES; /* per sync mode; `test_sim outages many`: of the tier all */

#define WINDOW_S 20 /* over which both are compared */
#define FEW 8       /* minimum number of values for a mean */
#define LAG_MAX 300.0
#define TICK_HZ 60

typedef struct outage {
    const ll_sync_mode *sync;
    int players, who; /* -1: all */
    bool up, down;
    double update_hz, at_s, length_s, lag_ms[4];
    bool shifted; /* the first second is slower: later steps have another phase to displays */
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
        most = larger(most, 2 * o->lag_ms[i]);
    return most / 1e3;
}

/* Time from which the outage must have no effect. */
static double recovered_s(const outage *o)
{
    return heals_s(o) + 2 + 2 * round_trip_s(o);
}

/* Whether persons play: in sync modes whose clients wait for each other's inputs. A single player never
 * waits, and inputs that change in every tick fill packets (docs/limits.md). */
static bool plays(const outage *o)
{
    return o->sync->observe && o->players > 1;
}

static int write_player(const outage *o, uint64_t n, int i, bool disturbed, char *at, size_t room)
{
    bool hit = disturbed && (o->who < 0 || o->who == i), predicts = chance(n, 40 + i, 0.5);
    char blackout[160] = "", up[180], down[180];
    if (hit)
        snprintf(blackout, sizeof blackout, "\"blackout_at_ms\":%.3f,\"blackout_length_ms\":%.3f",
                 o->at_s * 1e3, o->length_s * 1e3);
    if (o->shifted)
        snprintf(up, sizeof up, "\"spike_at_ms\":0,\"spike_length_ms\":1000,\"spike_add_ms\":%.3f",
                 draw(n, 60 + i, 0, 50));
    else
        snprintf(up, sizeof up, "%s", o->up ? blackout : "");
    snprintf(down, sizeof down, "%s", o->down ? blackout : "");
    return snprintf(at, room,
                    "%s{\"lag_ms\":%.3f,\"control\":\"%s\",\"prediction\":%s,\"reconciliation\":%s,"
                    "\"interpolation\":%s,\"link\":{\"up\":{%s},\"down\":{%s}}}",
                    i > 0 ? "," : "", o->lag_ms[i], plays(o) ? "person" : "script",
                    predicts ? "true" : "false", predicts ? "true" : "false",
                    chance(n, 50 + i, 0.5) ? "true" : "false", up, down);
}

static void write_scenario(outage *o, uint64_t n, bool disturbed)
{
    static const char *const codecs[] = {"full", "quantised", "delta"};
    char *at = o->scenario, *end = at + sizeof o->scenario;
    at += snprintf(at, (size_t)(end - at),
                   "{\"kind\":\"netgame\",\"game\":\"%s\",\"duration_s\":3600,\"seed\":%d,\"warmup_s\":0,"
                   "\"params\":{%s},\"server\":{\"sync\":\"%s\",\"update_hz\":%g,\"snapshot_encoding\":\"%"
                   "s\"},\"players\":[",
                   o->sync->applies_on_arrival ? "gambetta" : "race", (int)n,
                   o->sync->applies_on_arrival ? "" : "\"laps\":10000", o->sync->name, o->update_hz,
                   codecs[(int)draw(n, 2, 0, 3)]);
    for (int i = 0; i < o->players; i++)
        at += write_player(o, n, i, disturbed, at, (size_t)(end - at));
    snprintf(at, (size_t)(end - at), "]}");
}

static outage draw_outage(const ll_sync_mode *sync, uint64_t n)
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

/* ---- compared metrics ---- */

enum { FELT, ACKED, AGE, INFORMATION, OPEN, VALUES };
static const char *const names[VALUES] = {"input latency", "acknowledged after", "view age",
                                          "age of information", "open inputs"};
static const ll_metric metrics[VALUES] = {LL_METRIC_INPUT_LATENCY, LL_METRIC_ACK_RTT, LL_METRIC_VIEW_AGE,
                                          LL_METRIC_AGE_OF_INFORMATION, LL_METRIC_UNACKED};

typedef struct sums {
    double sum[VALUES];
    int64_t count[VALUES], applied;
} sums;

static sums sums_of(const scene *s, int player)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(s->game, player);
    sums now = {.applied = in->input_history.count[LL_INPUT_WAS_APPLIED]};
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
    bool recovers;   /* the server has held the game, or kept its rhythm */
} window;

static int64_t refused_of(const scene *s, int player)
{
    int64_t refused = 0;
    for (int rule = 1; rule < LL_RULES; rule++)
        refused += ll_netgame_server(s->game)->client_slots[player].counts.refused[rule];
    return refused;
}

/* A person's controls differ in every tick: each input is a change, whose latency counts. A script makes so
 * few changes that its latencies depend on when in a round trip they are made. */
static void play(scene *s, const outage *o, double from_s, double to_s)
{
    int64_t first = (int64_t)ceil(from_s * TICK_HZ), last = (int64_t)ceil(to_s * TICK_HZ);
    for (int64_t k = first; plays(o) && k < last; k++) {
        scene_run(s, (double)k / TICK_HZ, NULL);
        for (int p = 0; p < o->players; p++) {
            ll_action a = {.axis = {(float)ll_rng_unit(20261123, (uint64_t)p, (uint64_t)k)}};
            s->scenario.kind->input(s->game, p, &a);
        }
    }
    scene_run(s, to_s, NULL);
}

static void mean_of(double mean[VALUES], const sums *before, const sums *after)
{
    for (int v = 0; v < VALUES; v++) {
        int64_t count = after->count[v] - before->count[v];
        mean[v] = count >= FEW ? (after->sum[v] - before->sum[v]) / (double)count : NAN;
    }
}

static void open_windows(scene *s, const outage *o, double at_s, sums now[4])
{
    play(s, o, s->game->now / 1e9, at_s);
    for (int i = 0; i < o->players; i++)
        now[i] = sums_of(s, i);
}

static void run(const outage *o, window windows[4])
{
    sums begun[4], over[4];
    scene s = scene_make(o->scenario, NULL);
    open_windows(&s, o, recovered_s(o), begun);
    open_windows(&s, o, recovered_s(o) + WINDOW_S, over);
    for (int i = 0; i < o->players; i++) {
        window *w = &windows[i];
        *w = (window){.applied = over[i].applied - begun[i].applied,
                      .refused = refused_of(&s, i),
                      .recovers = ll_netgame_server(s.game)->barriers.recovery_until != 0};
        mean_of(w->mean, &begun[i], &over[i]);
    }
    scene_close(&s);
}

/* ---- the table ---- */

typedef struct row {
    int outages, players, unplayed, refused, off;
    int beyond[VALUES];                 /* players that are more than a tenth off */
    int shifted;                        /* in stop and wait: as many in a game of another phase */
    double worst[VALUES];               /* relative */
    double sum[VALUES], honest[VALUES]; /* over all players */
} row;

/* In stop-and-wait lockstep a predicted input is felt at the next display, and at no other (below). Inputs
 * are a round trip and an interval apart, so their waits depend on the time of the first one: where that
 * interval is near a multiple of a display's period, all waits are equal. After an outage the game continues
 * when the network heals, at another phase. So the reference has another wait, as has a game without an
 * outage whose first second took longer: in both cases the same number of players is more than a tenth off.
 * The tolerance is one display for a wait, and a tenth for the mean of all outages. */
static double unit_ms(const outage *o, int value)
{
    return value == FELT && o->sync->answers ? 1e3 / TICK_HZ : 0;
}

static bool near(const outage *o, int value, double got, double honest)
{
    double off = fabs(got - honest);
    return (isnan(got) && isnan(honest)) || off <= larger(0.1 * honest, unit_ms(o, value)) + 1e-6;
}

/* Records both in the table. */
static void note(row *r, int value, double got, double honest)
{
    double off = fabs(got - honest);
    if (isnan(off))
        return;
    r->sum[value] += got;
    r->honest[value] += honest;
    r->beyond[value] += off > 0.1 * honest + 1e-6;
    if (off > 1e-6 && honest > 0)
        r->worst[value] = larger(r->worst[value], off / honest);
}

/* Whether the player's metrics agree with its reference's. */
static bool compare(row *r, const outage *o, const window *got, const window *honest)
{
    bool same = true, unplayed = got->applied < 0.9 * (double)honest->applied - 1;
    for (int v = 0; v < VALUES; v++) {
        note(r, v, got->mean[v], honest->mean[v]);
        same = same && near(o, v, got->mean[v], honest->mean[v]);
    }
    r->players++;
    r->unplayed += unplayed;
    r->refused += got->refused > 0;
    r->off += !same;
    return same && !unplayed && got->refused == 0;
}

/* The same at another phase, without losses. */
static void note_shifted(row *r, const outage *o, uint64_t n, const window *honest)
{
    outage other = *o;
    window got[4];
    other.shifted = true;
    write_scenario(&other, n, false);
    run(&other, got);
    for (int p = 0; p < o->players; p++)
        r->shifted += fabs(got[p].mean[FELT] - honest[p].mean[FELT]) > 0.1 * honest[p].mean[FELT] + 1e-6;
}

static bool try(row *r, const ll_sync_mode *sync, uint64_t n)
{
    window got[4], honest[4];
    bool same = true;
    outage o = draw_outage(sync, n);
    write_scenario(&o, n, false);
    run(&o, honest);
    write_scenario(&o, n, true);
    run(&o, got);
    r->outages++;
    if (sync->answers)
        note_shifted(r, &o, n, honest);
    for (int p = 0; p < o.players; p++) {
        bool one = compare(r, &o, &got[p], &honest[p]) && !honest[p].recovers;
        for (int v = 0; v < VALUES && !one; v++)
            printf("  outage %d, player %d, %s: %.2f, twin %.2f\n", (int)n, p, names[v], got[p].mean[v],
                   honest[p].mean[v]);
        same = same && one;
    }
    if (!same)
        printf("  %s\n", o.scenario);
    return same;
}

/* Difference of the mean over all outages from the twins'. */
static double apart(const row *r, int value)
{
    return r->honest[value] > 0 ? fabs(r->sum[value] / r->honest[value] - 1) : 0;
}

static bool alike(const row *r)
{
    bool all = true;
    for (int v = 0; v < VALUES; v++)
        all = all && apart(r, v) <= 0.1;
    return all;
}

static void print_row(const char *name, const row *r)
{
    printf("%-20s %8d %8d %8d %8d %8d", name, r->outages, r->players, r->unplayed, r->refused, r->off);
    for (int v = 0; v < VALUES; v++)
        printf(" %4d %6.2f%% %6.2f%%", r->beyond[v], 100 * r->worst[v], 100 * apart(r, v));
    printf("\n");
}

static void everything_is_as_before(void **state)
{
    (void)state;
    bool all = true;
    printf("Players with a mean more than a tenth off the twin's; largest difference; mean of all players\n");
    printf("%-20s %8s %8s %8s %8s %8s", "sync", "outages", "players", "unplayed", "refused", "off");
    for (int v = 0; v < VALUES; v++)
        printf(" %20s", names[v]);
    printf("\n");
    for (int k = 0; ll_syncs[k]; k++) {
        row r = {0};
        int tries = ll_syncs[k]->guesses ? MORE * outages : outages;
        for (int i = 0; i < tries; i++)
            all = try(&r, ll_syncs[k], (uint64_t)(1000 * (k + 1) + i)) && all;
        all = all && alike(&r) && r.beyond[FELT] <= r.shifted + 3 * sqrt(2.0 * r.shifted);
        print_row(ll_sync_mode_names[k], &r);
        if (ll_syncs[k]->answers)
            printf("  input latency at other phases: %d\n", r.shifted);
    }
    assert_true(all);
}

/* Packets of one instant arrive before the client acts, also when it is accepted at that instant: an accept
 * and the snapshot of one update that arrive together are drawn together. */
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

/* ---- stop and wait: when an input is felt ---- */

/* The inputs that change the controls, and the time from each to the next display. */
typedef struct waits {
    const scene *s;
    int64_t count[4];
    uint32_t number[4];
    float axis[4];
    double sum_ms[4], last_ms[4];
} waits;

static void on_input(void *context, const void *record)
{
    const ll_event *event = record;
    waits *w = context;
    int p = event->player;
    if (event->type != LL_EVENT_INPUT || event->number == w->number[p])
        return; /* or it is sent again */
    w->number[p] = event->number;
    ll_client *client = ll_netgame_client(w->s->game, p);
    float axis = ll_client_pending(client, event->number)->action.axis[0];
    if (fabs((double)axis - (double)w->axis[p]) <= LL_CHANGE_EPSILON)
        return;
    w->axis[p] = axis;
    ll_time since = event->begin - client->displays.clock.epoch;
    int64_t next = (since * TICK_HZ + LL_SECOND - 1) / LL_SECOND;
    if (ll_tick_time(next, client->displays.clock.freq) < since)
        next++;
    w->last_ms[p] = ll_to_ms(ll_tick_time(next, client->displays.clock.freq) - since);
    w->sum_ms[p] += w->last_ms[p];
    w->count[p]++;
}

/* With outages and without: the only difference left is the phase at which inputs are made between two
 * displays. */
static void predicted_inputs_are_felt_at_the_next_display(void **state)
{
    (void)state;
    int players = 0;
    for (uint64_t n = 200; n < 200 + (uint64_t)outages; n++) {
        outage o = draw_outage(&ll_sync_lockstep, n);
        const char *const nobody_leaves[] = {"server.timeout_s=0", NULL};
        write_scenario(&o, n, n % 3 != 0);
        scene s = scene_make(o.scenario, nobody_leaves);
        waits w = {.s = &s};
        ll_recorder r = {.record = on_input, .context = &w};
        scene_run(&s, recovered_s(&o) + WINDOW_S, &r);
        for (int p = 0; p < o.players; p++) {
            const ll_histogram *felt =
                &ll_netgame_client_metrics(s.game, p)->histogram[LL_METRIC_INPUT_LATENCY];
            if (!s.game->config.players[p].prediction)
                continue;
            bool open = felt->count == w.count[p] - 1; /* the last has no result yet */
            assert_true(open || felt->count == w.count[p]);
            assert_true(felt->count > FEW);
            double sum_ms = w.sum_ms[p] - (open ? w.last_ms[p] : 0);
            assert_near(felt->sum, sum_ms, 1e-6 * (double)felt->count);
            players++;
        }
        scene_close(&s);
    }
    assert_true(players > outages / 2);
}

int main(int count, char **arguments)
{
    if (ll_test_many(count, arguments))
        outages = MANY_OUTAGES;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(predicted_inputs_are_felt_at_the_next_display),
        cmocka_unit_test(packets_come_before_clients_act),
        cmocka_unit_test(everything_is_as_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

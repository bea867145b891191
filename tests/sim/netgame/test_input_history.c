/* The inputs of players with reconciliation, as streamed: record `input_history`. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "support/near.h"
#include "support/scene.h"

typedef struct refinement_level {
    int player, state;
    uint32_t seq;
    double made_s, predicted_x, server_x, correction_m; /* NaN: unknown */
} refinement_level;

enum { OPEN, ACKNOWLEDGED, REFUSED, LATE, LOST };

enum { RUNGS_MAX = LL_PLAYERS_MAX * 32 };

static const double step_m = 1.0 / (1 << LL_BITS_M);

typedef struct history {
    int count;
    refinement_level refinement_levels[RUNGS_MAX];
} history;

static double value(const ll_rows *rows, int row, const char *name)
{
    const ll_record *record = rows->record;
    for (int i = 0; i < record->count; i++)
        if (strcmp(record->fields[i].name, name) == 0)
            return ll_field_value(&record->fields[i], ll_rows_at(rows, row)[i]);
    fail_msg("the record has no field %s", name);
    return NAN;
}

static void look(const scene *s, history *l)
{
    ll_row_set set = {0};
    int place = ll_row_set_add(&set, &ll_netgame_input_history_record, true);
    ll_netgame_fill_input_history(s->game, &set);
    assert_false(set.failed);
    const ll_rows *rows = set.rows[place];
    assert_true(rows->count <= RUNGS_MAX);
    l->count = rows->count;
    for (int i = 0; i < rows->count; i++)
        l->refinement_levels[i] = (refinement_level){.player = (int)value(rows, i, "player"),
                                                     .state = (int)value(rows, i, "state"),
                                                     .seq = (uint32_t)value(rows, i, "seq"),
                                                     .made_s = value(rows, i, "made_s"),
                                                     .predicted_x = value(rows, i, "predicted_x"),
                                                     .server_x = value(rows, i, "server_x"),
                                                     .correction_m = value(rows, i, "correction_m")};
    ll_row_set_free(&set);
}

static bool predicted(const refinement_level *r)
{
    return !isnan(r->predicted_x);
}

/* The predicted and the server's position are both known. */
static bool compared(const refinement_level *r)
{
    return predicted(r) && !isnan(r->server_x);
}

#define ON(p) "players." p ".prediction=true", "players." p ".reconciliation=true"

/* On a clean link: as many inputs are open as fit into the round trip. Of the others, those whose step has a
 * snapshot are confirmed where they were predicted. */
static void clean_link(void **state)
{
    (void)state;
    const char *const sets[] = {ON("0"), "players.0.lag_ms=50", NULL};
    static history l;
    scene s = scene_open("race", sets);
    for (int k = 0; k < 50; k++) {
        double now_s = 3 + k * 0.11;
        scene_run(&s, now_s, NULL);
        look(&s, &l);
        ll_client *c = ll_netgame_client(s.game, 0);
        int open = 0, confirmed = 0;
        assert_int_equal(l.count, 32); /* B does not reconcile */
        for (int i = 0; i < l.count; i++) {
            const refinement_level *r = &l.refinement_levels[i];
            assert_int_equal(r->player, 0);
            assert_int_equal(r->seq, c->inputs.seq - 31 + (uint32_t)i);
            assert_true(r->made_s <= now_s + 1e-6 && r->made_s > now_s - 0.6);
            assert_true(i == 0 || fabs(r->made_s - l.refinement_levels[i - 1].made_s - 1.0 / 60) < 1e-6);
            assert_true(predicted(r));
            assert_true((r->state == OPEN) == (r->seq > c->inputs.acked));
            assert_true(r->state == OPEN || r->state == ACKNOWLEDGED);
            assert_true(r->state == ACKNOWLEDGED || isnan(r->server_x));
            open += r->state == OPEN;
            confirmed += compared(r);
            if (compared(r))
                assert_true(r->correction_m == 0 && r->server_x == r->predicted_x);
        }
        assert_in_range(open, 6, 11); /* 100 ms, the slack and an update */
        assert_in_range(confirmed, (32 - open) / 2 - 1, (32 - open) / 2 + 1);
    }
    scene_close(&s);
}

/* Errors are reported by name, with the distance to the server's position. */
static void errors_are_reported_by_name(void **state)
{
    (void)state;
    static const struct {
        const char *set[3];
        int expected;
    } cases[] = {{{"players.0.link.up.loss_pct=20", "players.0.redundancy=0", NULL}, LOST},
                 {{"players.0.link.up.jitter_ms=60", "players.0.link.up.distribution=normal",
                   "players.0.slack_ticks=0"},
                  LATE},
                 {{"players.0.cheat=magnitude", NULL, NULL}, REFUSED}};
    static history l;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *sets[16] = {ON("0"), "players.0.control=person", "players.0.lag_ms=50",
                                "players.0.redundancy=0"};
        int n = 5, seen[5] = {0}, wrong = 0;
        for (int k = 0; k < 3 && cases[i].set[k]; k++)
            sets[n++] = cases[i].set[k];
        scene s = scene_open("gambetta_default", sets);
        for (int k = 0; k < 3000; k++) {
            ll_action any = {.axis = {(float)(2 * ll_rng_unit(4, 4, (uint64_t)k) - 1), 0}};
            s.scenario.kind->input(s.game, 0, &any);
            scene_run(&s, k / 50.0, NULL);
            look(&s, &l);
            for (int r = 0; r < l.count; r++) {
                seen[l.refinement_levels[r].state]++;
                wrong += compared(&l.refinement_levels[r]) && l.refinement_levels[r].correction_m != 0;
                if (compared(&l.refinement_levels[r]))
                    assert_near(l.refinement_levels[r].server_x - l.refinement_levels[r].predicted_x,
                                l.refinement_levels[r].correction_m, 1.5 * step_m);
            }
        }
        for (int k = REFUSED; k <= LOST; k++)
            if ((seen[k] > 0) != (k == cases[i].expected))
                fail_msg("%s: %d of state %d", cases[i].set[0], seen[k], k);
        assert_true(seen[OPEN] > 1000 && seen[ACKNOWLEDGED] > 1000 && wrong > 0);
        scene_close(&s);
    }
}

/* No rows for players without reconciliation, before the first input, and for clients with worlds of their
 * own. */
static void no_rows_without_reconciliation(void **state)
{
    (void)state;
    static history l;
    const char *const off[] = {"players.0.prediction=false", NULL};
    const char *const peers[] = {"server.sync=rollback", ON("0"), NULL};
    const char *const exact[] = {"players.0.clock_phase=0", NULL};
    scene s = scene_open("race", off), p = scene_open("race", peers), q = scene_open("race", exact);
    scene_run(&s, 3, NULL);
    scene_run(&p, 3, NULL);
    look(&s, &l);
    assert_int_equal(l.count, 0);
    look(&p, &l);
    assert_int_equal(l.count, 0);
    look(&q, &l);
    assert_int_equal(l.count, 0);
    scene_run(&q, 0.1, NULL);
    look(&q, &l);
    assert_int_equal(l.count, 7); /* of the first tenth of a second */
    scene_close(&s);
    scene_close(&p);
    scene_close(&q);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clean_link),
        cmocka_unit_test(errors_are_reported_by_name),
        cmocka_unit_test(no_rows_without_reconciliation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

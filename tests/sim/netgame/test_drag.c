/* Shells with drag in whole games: they hit as seen where the server traces drag, and what its neglect costs.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

static const ll_shot_tally *tally(const scene *s, int player)
{
    return &ll_netgame_shots(s->game)->shot_stats[player].tally[LL_PROJECTILE];
}

static const ll_drag_neglect_player *neglect(const scene *s, int player)
{
    return &ll_netgame_drag_neglect(s->game)->player[player];
}

static scene run(const char *trace, const char *lag, const char *drag)
{
    const char *const sets[] = {trace, lag, drag, NULL};
    scene s = scene_open("cannon_drag", sets);
    scene_run(&s, 60, NULL);
    return s;
}

#define PARABOLA "server.projectile_trace=parabola"
#define NEGLECTED "server.projectile_trace=drag_neglected"

/* For every lag: the scripts aim with the drag, and a server that traces it counts what they see. */
static void only_a_server_with_drag_agrees_with_the_view(void **state)
{
    (void)state;
    static const char *const lags[] = {"players.0.lag_ms=50", "players.0.lag_ms=150", "players.0.lag_ms=300"};
    for (int i = 0; i < 3; i++) {
        scene a = run(PARABOLA, lags[i], "params.drag_per_m=0.01");
        scene b = run(NEGLECTED, lags[i], "params.drag_per_m=0.01");
        const ll_shot_tally *with = tally(&a, 0), *without = tally(&b, 0);
        assert_true(with->shots > 40 && with->hits[LL_JUDGE_VIEW] > 30);
        assert_true((double)with->within_agreed >= 0.99 * (double)with->within);
        assert_true(without->agreed < with->agreed + (i == 0));
        assert_true(i < 2 || without->agreed < 0.92 * (double)without->shots);
        scene_close(&a);
        scene_close(&b);
    }
}

/* v t - log(1 + k v t) / k: without gravity. */
static double level(double v, double t)
{
    return v * t - log1p(0.01 * v * t) / 0.01;
}

/* The distance does not depend on the server's choice. Gravity makes a shell at most g t slower or faster. */
static void the_cost_is_told_whatever_the_server_does(void **state)
{
    (void)state;
    scene a = run(PARABOLA, "players.0.lag_ms=200", "params.drag_per_m=0.01");
    scene b = run(NEGLECTED, "players.0.lag_ms=200", "params.drag_per_m=0.01");
    for (int p = 0; p < 2; p++) {
        const ll_drag_neglect_player *x = neglect(&a, p), *y = neglect(&b, p);
        assert_memory_equal(&x->past, &y->past, sizeof x->past);
        assert_int_equal(x->traced, y->traced);
        assert_int_equal(x->differing, y->differing);
        assert_true(x->traced > 40 && x->differing > 0);
        assert_true(x->false_hits + x->false_misses >= x->differing);
        ll_summary past = ll_histogram_summary(&x->past);
        double t = ll_histogram_summary(&ll_netgame_shots(a.game)->shot_stats[p].rewind).max / 1e3;
        assert_int_equal(past.count, x->traced);
        assert_true(past.mean > level(60 - 9.81 * t, t) && past.max < level(60 + 9.81 * t, t));
        /* what the server traced was off by as much, or by nothing */
        ll_summary traced = ll_histogram_summary(&ll_netgame_shots(b.game)->shot_stats[p].trace_error);
        assert_near(traced.max, past.max, 1e-12);
        assert_true(ll_histogram_summary(&ll_netgame_shots(a.game)->shot_stats[p].trace_error).max == 0);
    }
    scene_close(&a);
    scene_close(&b);
}

/* Family A starts each flight in the present. */
static void without_a_past_part_there_is_nothing_to_neglect(void **state)
{
    (void)state;
    const char *const sets[] = {"server.projectile=none", NULL};
    scene s = scene_open("cannon_drag", sets);
    scene_run(&s, 30, NULL);
    assert_true(tally(&s, 0)->shots > 10);
    assert_int_equal(neglect(&s, 0)->traced, 0);
    assert_true(ll_histogram_summary(&neglect(&s, 0)->end).count > 10);
    scene_close(&s);
}

/* Neglecting nothing changes nothing, and a game without drag has not a byte of it. */
static void without_drag_there_is_no_difference(void **state)
{
    (void)state;
    scene a = run(PARABOLA, "players.0.lag_ms=200", "params.drag_per_m=0");
    scene b = run(NEGLECTED, "players.0.lag_ms=200", "params.drag_per_m=0");
    scene c = run(PARABOLA, "players.0.lag_ms=200", "params.drag_per_m=0.001");
    for (int p = 0; p < 2; p++)
        assert_memory_equal(tally(&a, p), tally(&b, p), sizeof *tally(&a, p));
    assert_null(ll_netgame_drag_neglect(a.game));
    assert_int_equal(ll_netgame_bytes(c.game) - ll_netgame_bytes(a.game), ll_drag_neglect_size(2));
    assert_int_equal(c.game->size, a.game->size);
    scene_close(&a);
    scene_close(&b);
    scene_close(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_a_server_with_drag_agrees_with_the_view),
        cmocka_unit_test(the_cost_is_told_whatever_the_server_does),
        cmocka_unit_test(without_a_past_part_there_is_nothing_to_neglect),
        cmocka_unit_test(without_drag_there_is_no_difference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

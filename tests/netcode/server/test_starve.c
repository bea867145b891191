/* Replacements of inputs that have not arrived. */
#include "netcode/toy.h"

#include <stdio.h>

#include "base/rng.h"
#include "netcode/server/starve.h"
#include "support/scene.h"

#define HELD_X 0.8f
#define HELD_Y (-0.5f)

static ll_action act(const char *name, int64_t age, double tau, int64_t steps)
{
    const ll_action last = {{HELD_X, HELD_Y}, LL_BUTTON_FIRE, 77};
    const ll_starve_config config = {tau, steps};
    for (int i = 0; ll_starves[i]; i++)
        if (strcmp(ll_starve_names[i], name) == 0)
            return ll_starves[i]->act(&last, age, &config);
    fail_msg("there is no policy %s", name);
    return last;
}

/* axes x max(0, 1 - age / tau); presses and view times are never repeated. */
static void policies_match_their_definitions(void **state)
{
    (void)state;
    static const char *const names[] = {"decay", "repeat", "repeat_n", "neutral"};
    for (int64_t age = 1; age < 400; age++)
        for (int n = 0; n < 4; n++) {
            const double tau = 7.5 + (double)(age % 5), left = 1 - (double)age / tau;
            const double shares[] = {left > 0 ? left : 0, 1, age <= 9 ? 1 : 0, 0};
            ll_action a = act(names[n], age, tau, 9);
            assert_float_equal(a.axis[0], (double)HELD_X * shares[n], 1e-7);
            assert_float_equal(a.axis[1], (double)HELD_Y * shares[n], 1e-7);
            assert_int_equal(a.buttons, 0);
            assert_int_equal(a.view_age_ns, 0);
        }
    assert_true(act("repeat_n", 1, 10, 0).axis[0] == 0);
}

/* Inputs for steps 1 to 4, of 0.75 each, and then none: the path, and the controls sent to the others. */
static void server_starves_by_its_policy(const char *const *sets, double (*share)(int age))
{
    ll_server *s = new_server(2, &ll_sync_free, 50, 50);
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message m = inputs(1, 4, (double[]){0.75, 0.75, 0.75, 0.75}),
                     back = inputs(41, 1, (double[]){-0.5});
    _Alignas(8) char state_packet[1024];
    double x = 0;
    configure(s, sets);
    s->client_slots[1].inputs.wants = LL_PART_AXES;
    ll_server_receive(s, &ll_sync_free, 0, &m, 0, v);
    for (int k = 1; k <= 42; k++) {
        ll_axes axes;
        if (k == 41)
            ll_server_receive(s, &ll_sync_free, 0, &back, 0, v);
        double axis = k <= 4 ? 0.75 : k < 41 ? 0.75 * share(k - 4) : k == 41 ? -0.5 : -0.5 * share(1);
        x += axis;
        ll_sync_free.step(s, &toy, &(ll_game_env){0}, NULL, ll_tick_time(k, HZ(50)));
        assert_float_equal(ll_server_world(s)->entity[0].x, x, 1e-5);
        ll_server_compose(s, &ll_sync_free, 1, NULL, state_packet);
        memcpy(&axes, state_packet + sizeof(ll_snapshot_message), sizeof axes);
        assert_float_equal(axes.axis[0], axis, 1e-6);
    }
    assert_int_equal(s->client_slots[0].counts.starved, 37);
    free(s);
}

static double decayed(int age) /* in 200 ms, 10 steps */
{
    return age < 10 ? 1 - age / 10.0 : 0;
}

static double by_default(int age) /* 250 ms */
{
    return age < 12.5 ? 1 - age / 12.5 : 0;
}

static double repeated(int age)
{
    (void)age;
    return 1;
}

static double five_times(int age)
{
    return age <= 5;
}

static double none(int age)
{
    (void)age;
    return 0;
}

static void every_policy_on_a_server(void **state)
{
    (void)state;
    server_starves_by_its_policy(NULL, by_default);
    server_starves_by_its_policy((const char *[]){"starved_tau_ms=200", NULL}, decayed);
    server_starves_by_its_policy((const char *[]){"starved=repeat", NULL}, repeated);
    server_starves_by_its_policy((const char *[]){"starved=repeat_n", "starved_ticks=5", NULL}, five_times);
    server_starves_by_its_policy((const char *[]){"starved=neutral", NULL}, none);
}

/* A refused input counts as its replacement: starvation starts from that. */
static void starving_behind_a_refusal(void **state)
{
    (void)state;
    ll_server *s = new_server(1, &ll_sync_free, 50, 50);
    ll_input_result v[LL_INPUTS_MAX];
    ll_input_message m = inputs(1, 2, (double[]){1, 3});
    configure(s, (const char *[]){"starved=repeat", NULL});
    ll_server_receive(s, &ll_sync_free, 0, &m, 0, v);
    for (int k = 1; k <= 20; k++)
        ll_sync_free.step(s, &toy, &(ll_game_env){0}, NULL, ll_tick_time(k, HZ(50)));
    assert_true(ll_server_world(s)->entity[0].x == 1);
    free(s);
}

/* A car whose link up is dead from 4 s on, at full throttle until then: whether it stands in the end. */
static void a_silent_player_stops(void **state)
{
    (void)state;
    static const struct {
        const char *policy;
        double after; /* s of throttle, maximum */
    } cases[] = {
        {"server.starved=decay", 0.25}, {"server.starved=neutral", 0}, {"server.starved=repeat_n", 0.2}};
    for (int i = 0; i < 3; i++) {
        const char *const sets[] = {cases[i].policy,     "players.0.script=steady", "params.drag_per_s=1",
                                    "params.laps=10000", "players.0.lag_ms=35",     NULL};
        scene s = scene_open("race", sets);
        const ll_entity *car = &ll_server_world(ll_netgame_server(s.game))->entity[0];
        scene_run(&s, 4, NULL);
        double x = car->x, v = car->vx;
        ll_netgame_config config = scene_config(s.game);
        config.players[0].link.up.loss_pct = 100;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 20, NULL);
        assert_true(v > 5 && car->vx < 1e-5);
        /* Inputs still on their way (4 ticks), the remaining throttle, and the distance v / drag of a
         * coasting car. */
        assert_true(car->x > x + v * 0.9 && car->x < x + v + 6 * (5.0 / 60 + cases[i].after) + 1e-9);
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(policies_match_their_definitions),
        cmocka_unit_test(every_policy_on_a_server),
        cmocka_unit_test(starving_behind_a_refusal),
        cmocka_unit_test(a_silent_player_stops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

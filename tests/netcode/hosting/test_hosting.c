/* Who hosts: elections, promises and leases, without any network. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/hosting/hosting.h"

static ll_hosting hosting_of(int players, int host, const char *election)
{
    ll_hosting h;
    ll_hosting_params params = {.host = host, .patience_s = 2, .by_player = true};
    while (strcmp(ll_election_names[params.election], election) != 0)
        params.election++;
    ll_hosting_init(&h, &params, players);
    return h;
}

static void names_are_in_the_order_of_the_table(void **state)
{
    (void)state;
    int i = 0;
    for (; ll_elections[i]; i++)
        assert_string_equal(ll_elections[i]->name, ll_election_names[i]);
    assert_null(ll_election_names[i]);
}

/* Player `p` has a state of tick `tick[p]` and a round trip of `trip[p]`; player 0 is lost. */
static int chosen(const char *election, const int64_t tick[4], const ll_time trip[4], int by)
{
    ll_hosting h = hosting_of(4, 0, election);
    const ll_candidacy own = {tick[by], trip[by]};
    ll_hosting_lose(&h, by, &own, 5 * LL_SECOND);
    for (int p = 1; p < 4; p++) {
        h.view[by].of[p] = (ll_candidacy){tick[p], trip[p]};
        h.view[by].heard |= UINT64_C(1) << p;
    }
    assert_true(ll_hosting_heard_all(&h, by));
    return ll_hosting_choose(&h, by);
}

static void each_election_chooses_its_best(void **state)
{
    (void)state;
    const int64_t tick[4] = {99, 10, 12, 12}, even[4] = {99, 7, 7, 7};
    const ll_time trip[4] = {1, 20, 50, 40}, same[4] = {1, 30, 30, 30};
    for (int by = 1; by < 4; by++) {
        assert_int_equal(chosen("lowest_index", tick, trip, by), 1);
        assert_int_equal(chosen("newest_state", tick, trip, by), 3);
        assert_int_equal(chosen("newest_state", tick, same, by), 2);
        assert_int_equal(chosen("newest_state", even, same, by), 1);
        assert_int_equal(chosen("best_connection", tick, trip, by), 1);
        assert_int_equal(chosen("best_connection", tick, same, by), 2);
    }
}

static void who_does_not_answer_is_passed_over(void **state)
{
    (void)state;
    ll_hosting h = hosting_of(4, 1, "lowest_index");
    ll_hosting_lose(&h, 3, &(ll_candidacy){0, 0}, 0);
    static const int order[] = {0, 2, 3, 0, 1, 2, 3, 0};
    for (int i = 0; i < 8; i++)
        assert_int_equal(ll_hosting_choose(&h, 3), order[i]); /* the second time round the lost one too */
}

/* Only who has spoken is asked where players report to each other, and oneself always has. */
static void who_was_not_heard_is_not_asked(void **state)
{
    (void)state;
    ll_hosting h = hosting_of(4, 0, "newest_state");
    ll_hosting_lose(&h, 3, &(ll_candidacy){5, 0}, 0);
    assert_false(ll_hosting_heard_all(&h, 3));
    assert_int_equal(ll_hosting_choose(&h, 3), 3);
}

/* More than half of all, the candidate among them. */
static void a_majority_elects(void **state)
{
    (void)state;
    for (int players = 3; players <= LL_PEERS_MAX; players++) {
        ll_hosting h = hosting_of(players, 0, "lowest_index");
        for (int p = players - 1, votes = 1; p >= 1; p--, votes++) {
            h.votes[1][p].until = 10;
            assert_int_equal(ll_hosting_elected(&h, 1, 9), p == 1 && 2 * votes > players);
            assert_false(ll_hosting_elected(&h, 1, 10));
        }
    }
}

/* Random promises, each binding until it ends, of players who lose a host no earlier than their lease says:
 * no one is elected while the host still holds the game. This is the whole argument for one host at a time.
 */
static void no_one_is_elected_while_the_host_holds(void **state)
{
    (void)state;
    int elected = 0, held = 0;
    for (uint64_t n = 0; n < 20000; n++) {
        const int players = 3 + (int)(ll_rng_unit(7, 1, n) * 6);
        ll_hosting h = hosting_of(players, 0, "lowest_index");
        const ll_time now = 1000;
        for (int p = 1; p < players; p++) {
            const ll_time lease = (ll_time)(ll_rng_unit(7, 10 + (uint64_t)p, n) * 2 * (double)now);
            ll_hosting_renew(&h, p, lease);
            const int asks = 1 + (int)(ll_rng_unit(7, 40 + (uint64_t)p, n) * (players - 1));
            if (lease <= now && ll_rng_unit(7, 60 + (uint64_t)p, n) < 0.9)
                h.votes[asks][p].until = now + 500;
        }
        int hosts = 0;
        for (int p = 1; p < players; p++)
            hosts += ll_hosting_elected(&h, p, now);
        const bool holds = ll_hosting_holds(&h, now);
        assert_true(hosts + holds <= 1);
        elected += hosts;
        held += holds;
    }
    assert_true(elected > 50 && held > 500);
}

/* A promise binds until the player knows that it was accepted; then only its time-out does. */
static void a_promise_is_worth_the_shorter_of_both(void **state)
{
    (void)state;
    assert_int_equal(ll_hosting_lease(100, 50, 20), 70);
    assert_int_equal(ll_hosting_lease(60, 50, 20), 60);
    ll_hosting h = hosting_of(3, 0, "lowest_index");
    assert_true(ll_hosting_holds(&h, 1000)); /* who has not begun to play cannot elect */
    ll_hosting_renew(&h, 1, 40);
    ll_hosting_renew(&h, 1, 30); /* overtaken */
    assert_int_equal(h.lease[1], 40);
}

static void times_without_a_host_add_up(void **state)
{
    (void)state;
    ll_hosting h = hosting_of(3, 2, "lowest_index");
    ll_hosting_stop(&h, 100);
    h.votes[0][0].until = h.votes[0][1].until = 500;
    ll_hosting_begin(&h, 0, 130, 1000);
    ll_hosting_join(&h, 0, 130);
    ll_hosting_join(&h, 1, 150);
    ll_hosting_join(&h, 1, 170); /* again, without an outage of a host */
    ll_hosting_stop(&h, 200);
    ll_hosting_join(&h, 1, 210);
    assert_int_equal(h.without, 30);
    assert_int_equal(h.changes, 1);
    assert_int_equal(h.view[0].without_sum, 30);
    assert_int_equal(h.view[1].without_sum, 60);
    assert_int_equal(h.view[1].without_max, 50);
    assert_int_equal(h.view[0].hosted, 70);
    assert_int_equal(h.view[2].without, 100); /* still */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(names_are_in_the_order_of_the_table),
                                       cmocka_unit_test(each_election_chooses_its_best),
                                       cmocka_unit_test(who_does_not_answer_is_passed_over),
                                       cmocka_unit_test(who_was_not_heard_is_not_asked),
                                       cmocka_unit_test(a_majority_elects),
                                       cmocka_unit_test(no_one_is_elected_while_the_host_holds),
                                       cmocka_unit_test(a_promise_is_worth_the_shorter_of_both),
                                       cmocka_unit_test(times_without_a_host_add_up)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Inconsistency, against values computed by hand. */
#include "netcode/observe/player_observer.h"
#include "netcode/toy.h"
#include "support/near.h"

#define STEP (20 * LL_MS)

/* Distances of 20 ms each; a divergence episode must last five of them. */
static ll_inconsistency of(const double *distances, int count)
{
    ll_inconsistency total = {0};
    ll_divergence_episode open = {0};
    for (int i = 0; i < count; i++)
        ll_inconsistency_in(&total, &open, distances[i], ll_frame_length_of(STEP));
    return total;
}

static void divergence_episodes_count_from_their_start(void **state)
{
    (void)state;
    const double five[] = {0, 1, 2, 3, 4, 5, 0}, four[] = {0, 9, 9, 9, 9, 0, 9, 9, 9, 9, 0},
                 at_the_edge[] = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1},
                 two[] = {1, 1, 1, 1, 1, 1, 0.1, 0.2, 0.2, 0.2, 0.2, 0.2};
    ll_inconsistency a = of(five, 7), b = of(four, 11), c = of(at_the_edge, 7), d = of(two, 12);
    assert_near(a.sum, 15 * 0.02, 1e-12);
    assert_true(a.time == 5 * STEP);
    assert_true(a.episodes == 1);
    assert_true(b.sum == 0 && b.time == 0 && b.episodes == 0); /* none lasts long enough */
    assert_true(c.episodes == 0);                              /* not above */
    assert_near(d.sum, (6 + 5 * 0.2) * 0.02, 1e-12);
    assert_true(d.time == 11 * STEP);
    assert_true(d.episodes == 2);
}

/* An episode that has not ended counts up to now. */
static void open_divergence_episodes_count_too(void **state)
{
    (void)state;
    double distances[50];
    for (int i = 0; i < 50; i++) {
        distances[i] = 0.5 + i;
        ll_inconsistency total = of(distances, i + 1);
        assert_near(total.sum, i < 4 ? 0 : (i + 1) * (i + 1) * 0.5 * 0.02, 1e-12);
        assert_int_equal(total.time, i < 4 ? 0 : (i + 1) * STEP);
    }
}

/* Three clients' views of three entities, ten frames long. On entity 0 they agree to 0.1 m. Entity 1 is at 0,
 * (3, 4) and (-9, -12): the farthest other view is 15, 20 and 20 m away. Entity 2 is 1 m off in the last view
 * alone. */
static void views_are_compared_with_the_farthest(void **state)
{
    (void)state;
    lone *l[3];
    ll_client_metrics *in[3];
    const ll_client *clients[3];
    const ll_entity places[3][3] = {{{.x = 0}, {.x = 0}, {.x = 7}},
                                    {{.y = 0.1}, {.x = 3, .y = 4}, {.x = 7}},
                                    {{.x = 0}, {.x = -9, .y = -12}, {.x = 8}}};
    const double farthest[3] = {15 + 1, 20 + 1, 20 + 1};
    for (int i = 0; i < 3; i++) {
        l[i] = new_lone(3, &toy, &ll_sync_free);
        in[i] = l[i]->client_metrics;
        clients[i] = l[i]->client;
        memcpy(ll_client_rendered(l[i]->client)->entity, places[i], sizeof places[i]);
    }
    for (int f = 0; f < 10; f++)
        ll_client_metrics_between(in, clients, 3, f * STEP, STEP);
    for (int i = 0; i < 3; i++) {
        assert_near(in[i]->clients.sum, farthest[i] * 10 * 0.02, 1e-12);
        assert_int_equal(in[i]->clients.time, 2 * 10 * STEP); /* of two entities */
        assert_int_equal(in[i]->clients.episodes, 2);
        assert_int_equal(in[i]->server.episodes, 0);
        free_lone(l[i]);
    }
}

/* Against the truth, by the frames of one client: the own entity counts too. */
static void views_are_compared_with_the_truth(void **state)
{
    (void)state;
    lone *l = new_lone(2, &toy, &ll_sync_free);
    ll_world *world = new_world(2);
    ll_history *truth = malloc(ll_history_size(2));
    ll_history_init(truth, 2);
    ll_history_add(truth, 0, world);
    ll_client_rendered(l->client)->entity[0].x = 0.3;
    ll_client_rendered(l->client)->entity[1].y = -2;
    l->client->displays.elapsed = STEP;
    for (int f = 0; f < 8; f++) {
        if (f == 6)
            ll_client_rendered(l->client)->entity[1].y = 0;
        ll_client_metrics_frame(l->client_metrics, l->client, &(ll_truth){.world = world, .history = truth},
                                f * STEP);
    }
    assert_near(l->client_metrics->server.sum, (8 * 0.3 + 6 * 2) * 0.02, 1e-12);
    assert_int_equal(l->client_metrics->server.time, 14 * STEP);
    assert_int_equal(l->client_metrics->server.episodes, 2);
    free(truth);
    free(world);
    free_lone(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(divergence_episodes_count_from_their_start),
        cmocka_unit_test(open_divergence_episodes_count_too),
        cmocka_unit_test(views_are_compared_with_the_farthest),
        cmocka_unit_test(views_are_compared_with_the_truth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The metrics of a client, against values computed by hand. */
#include "netcode/observe/player_observer.h"
#include "netcode/toy.h"
#include "support/near.h"

static ll_summary of(const lone *l, ll_metric metric)
{
    return ll_histogram_summary(&l->client_metrics->histogram[metric]);
}

/* ---- acknowledgement time: what the client measures itself ---- */

/* Inputs at 0, 20, 40, 60 and 80 ms; a snapshot that acknowledges two of them arrives at 65 ms and is drawn
 * at 80, one that acknowledges the third at 90 and is drawn at 100. */
static void run_latencies(lone *l, uint32_t applied)
{
    start_lone(l, 50, 0, 0);
    packet two = state_of(2, 40 * LL_MS, 2, 1, (double[]){0}),
           three = state_of(3, 60 * LL_MS, 3, 1, (double[]){0});
    for (int f = 0; f < 6; f++) {
        ll_time now = f * 20 * LL_MS;
        if (f == 4) {
            server_applies(l, 1, applied < 2 ? applied : 2, 2);
            give(l, &two, 65 * LL_MS);
        }
        if (f == 5) {
            server_applies(l, 3, applied, 3);
            give(l, &three, 90 * LL_MS);
        }
        frame(l, now, NULL);
    }
}

static void acknowledgements_take_a_round_trip(void **state)
{
    (void)state;
    for (int predicts = 0; predicts < 2; predicts++) {
        lone *l = new_lone(1, &toy, &ll_sync_free);
        l->config.prediction = l->config.reconciliation = predicts;
        run_latencies(l, 3);
        ll_summary ack_rtt = of(l, LL_METRIC_ACK_RTT), open = of(l, LL_METRIC_UNACKED);
        assert_int_equal(ack_rtt.count, 3); /* 65 - 0, 65 - 20, 90 - 40 */
        assert_near(ack_rtt.mean, 160.0 / 3, 1e-9);
        assert_true(ack_rtt.max == 65);
        assert_int_equal(open.count, 6); /* 1, 2, 3, 4, then 5 - 2, then 6 - 3 */
        assert_near(open.mean, 16.0 / 6, 1e-9);
        assert_true(open.max == 4);
        free_lone(l);
    }
}

/* One number acknowledges inputs that never arrived: they have no round trip. */
static void inputs_that_were_not_applied_have_no_round_trip(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    run_latencies(l, 1);
    assert_int_equal(of(l, LL_METRIC_ACK_RTT).count, 1);
    assert_true(of(l, LL_METRIC_ACK_RTT).mean == 65);
    assert_int_equal(l->client_metrics->input_history.wrong, 2);
    free_lone(l);
}

static void start_does_not_count(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    ll_client_metrics_init(l->client_metrics, 1, 100 * LL_MS);
    run_latencies(l, 3);
    assert_int_equal(of(l, LL_METRIC_ACK_RTT).count, 1); /* acknowledged at 100 ms: the one of 40 ms */
    assert_true(of(l, LL_METRIC_ACK_RTT).mean == 50);
    assert_true(of(l, LL_METRIC_UNACKED).count == 1 && of(l, LL_METRIC_UNACKED).mean == 3);
    free_lone(l);
}

/* ---- corrections ---- */

typedef struct last_event {
    ll_event event;
    int count;
} last_event;

static void keep(void *context, const void *row)
{
    const ll_event *event = row;
    last_event *l = context;
    l->event = *event;
    l->count++;
}

static void corrections_are_measured_at_the_same_input(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    last_event last = {0};
    const ll_recorder recorder = {.record = keep, .context = &last};
    l->setup.recorder = &recorder;
    l->config.prediction = l->config.reconciliation = true;
    l->config.slack_ticks = 0; /* input n is for step n */
    start_lone(l, 60, 0, 0);
    l->client->inputs.held = push(0.5);
    for (int f = 0; f < 4; f++)
        frame(l, f * LL_MS, NULL); /* predicted: 0.5, 1, 1.5, 2 */
    packet as_said = state_of(2, 2, 2, 1, (double[]){1}), other = state_of(3, 3, 3, 1, (double[]){4.5}),
           back = state_of(4, 4, 4, 1, (double[]){2});
    as_said.entity[0].vx = 0.5;
    give(l, &as_said, 4 * LL_MS);
    frame(l, 4 * LL_MS, NULL);
    assert_int_equal(last.count, 0);
    assert_true(of(l, LL_METRIC_POP).count == 5 && of(l, LL_METRIC_POP).max == 0); /* each frame */
    assert_int_equal(of(l, LL_METRIC_CORRECTION).count, 0);                        /* only those above 0 */

    other.entity[0].y = -4; /* 3 to the right of the predicted 1.5, 4 down: by 5 */
    give(l, &other, 5 * LL_MS);
    frame(l, 5 * LL_MS, NULL);
    assert_true(of(l, LL_METRIC_CORRECTION).count == 1 && of(l, LL_METRIC_CORRECTION).max == 5);
    assert_true(of(l, LL_METRIC_POP).count == 6 && of(l, LL_METRIC_POP).max == 5);
    assert_true(l->client_metrics->last.correction == 5 && l->client_metrics->corrections.count == 1);
    assert_int_equal(last.count, 1);
    assert_int_equal(last.event.type, LL_EVENT_CORRECTION);
    assert_int_equal(last.event.number, 3);
    assert_int_equal(last.event.begin, 5 * LL_MS);
    assert_true(last.event.value == 5);

    back.entity[0].y = -4; /* 5 was predicted for input 4; it is 2: 3 to the left */
    give(l, &back, 6 * LL_MS);
    frame(l, 6 * LL_MS, NULL);
    assert_true(l->client_metrics->last.correction == -3 && l->client_metrics->corrections.count == 2);
    assert_near(of(l, LL_METRIC_CORRECTION).mean, 4, 1e-9);
    assert_true(last.count == 2 && last.event.value == -3);
    free_lone(l);
}

/* ---- view age, own and remote errors, buffer: what the observer measures ---- */

static ll_history *new_history(int players)
{
    ll_history *truth = malloc(ll_history_size(players));
    ll_history_init(truth, players);
    return truth;
}

static void views_are_held_against_the_truth(void **state)
{
    (void)state;
    lone *l = new_lone(3, &toy, &ll_sync_free);
    ll_history *truth = new_history(3);
    ll_world *world = new_world(3);
    const ll_truth real = {.world = world, .history = truth};
    ll_world *shown = ll_client_rendered(l->client);
    ll_draw_info *marks = ll_client_draw_infos(l->client);
    start_lone(l, 60, 0, 0);
    ll_history_add(truth, 0, world);
    world->entity[1].x = 10;
    world->entity[2].x = -8;
    world->entity[2].y = 6;
    ll_history_add(truth, 100 * LL_MS, world);

    shown->entity[0] = (ll_entity){.x = -3, .y = 4}; /* truth: 0, 0 */
    shown->entity[1] = (ll_entity){.x = 7};          /* of 50 ms, when the truth was 5; now it is 10 */
    shown->entity[2] = (ll_entity){.x = -4, .y = 3}; /* of 50 ms, when the truth was the same; now -8, 6 */
    marks[0].time = 100 * LL_MS;
    marks[1].time = marks[2].time = 50 * LL_MS;
    ll_client_metrics_frame(l->client_metrics, l->client, &real, 100 * LL_MS);
    assert_true(l->client_metrics->last.own_lead == -5);
    assert_true(of(l, LL_METRIC_OWN_LEAD).count == 1 && of(l, LL_METRIC_OWN_LEAD).max == 5);
    assert_true(of(l, LL_METRIC_REMOTE_ERROR).count == 2 && of(l, LL_METRIC_REMOTE_ERROR).max == 5);
    assert_near(of(l, LL_METRIC_REMOTE_ERROR).mean, (3 + 5) / 2.0, 1e-9);
    assert_true(l->client_metrics->last.remote_error == 5); /* the larger: -4 is to the right of -8 */
    assert_true(of(l, LL_METRIC_VIEW_AGE).count == 2 && of(l, LL_METRIC_VIEW_AGE).mean == 50);
    assert_true(l->client_metrics->last.view_age == 50);
    assert_true(of(l, LL_METRIC_TIMELINE_ERROR).count == 2);
    assert_near(of(l, LL_METRIC_TIMELINE_ERROR).max, 2, 1e-9);
    assert_near(of(l, LL_METRIC_TIMELINE_ERROR).mean, 1, 1e-9);
    assert_int_equal(of(l, LL_METRIC_BUFFER).count, 0); /* nothing is interpolated */

    shown->entity[1].x = 2; /* now the larger, and to the left */
    marks[1].time = 20 * LL_MS;
    l->client->drawing.buffer_ms = 12.5;
    l->client->view.state = LL_VIEW_STARVED;
    l->client->view.held = 1;
    ll_client_metrics_frame(l->client_metrics, l->client, &real, 100 * LL_MS);
    assert_true(l->client_metrics->last.remote_error == -8 && l->client_metrics->last.view_age == 80);
    assert_true(of(l, LL_METRIC_BUFFER).count == 1 && of(l, LL_METRIC_BUFFER).mean == 12.5);
    assert_true(l->client_metrics->buffer.frames == 2 && l->client_metrics->buffer.held_frames == 1);

    ll_client_metrics_init(l->client_metrics, 3,
                           200 * LL_MS); /* before its time nothing counts, but views are updated */
    ll_client_metrics_frame(l->client_metrics, l->client, &real, 199 * LL_MS);
    assert_true(l->client_metrics->buffer.frames == 0 && of(l, LL_METRIC_VIEW_AGE).count == 0);
    assert_true(l->client_metrics->last.own_lead == -5 && l->client_metrics->last.remote_error == -8);
    free(truth);
    free(world);
    free_lone(l);
}

/* ---- smoothness ---- */

/* Positions drawn every 0.5 s and their differences:
 *   x   0   1   3   6   6   5   7   7
 *   v       1   2   3   0  -1   2   0      per frame
 *   a           4   4 -12  -4  12  -8      m/s2: differences of v / 0.25
 *   j               0 -32  16  32 -40      m/s3: differences of a / 0.5
 * From the fourth position on all are known. The truth moves by 1 each frame, but not in the last. All of it
 * lies on a line through the plane, of slope 3 to 4. */
static void smoothness_is_of_differences(void **state)
{
    (void)state;
    const double x[] = {0, 1, 3, 6, 6, 5, 7, 7}, truth_x[] = {0, 1, 2, 3, 4, 5, 6, 6};
    lone *l = new_lone(2, &toy, &ll_sync_free);
    ll_history *truth = new_history(2);
    ll_world *world = new_world(2);
    const ll_truth real = {.world = world, .history = truth};
    start_lone(l, 60, 0, 0);
    ll_history_add(truth, 0, world);
    for (int i = 0; i < 8; i++) {
        world->entity[1] = (ll_entity){.x = -0.6 * truth_x[i], .y = 0.8 * truth_x[i]};
        ll_client_rendered(l->client)->entity[1] = (ll_entity){.x = -0.6 * x[i], .y = 0.8 * x[i]};
        l->client->displays.elapsed = LL_SECOND / 2;
        ll_client_metrics_frame(l->client_metrics, l->client, &real, i * LL_SECOND / 2);
    }
    const ll_smoothness *s = &l->client_metrics->track[1].smooth;
    assert_int_equal(s->frames, 5);
    assert_near(s->acceleration, 16 + 144 + 16 + 144 + 64, 1e-9);
    assert_near(s->jerk, 0 + 1024 + 256 + 1024 + 1600, 1e-9);
    assert_near(s->step_max, 3, 1e-9);
    assert_near(s->truth_step_sum, 4, 1e-9);
    assert_int_equal(s->moving, 4);
    assert_int_equal(s->frozen, 1);    /* 6 to 6 while the truth moved; 7 to 7 stood as the truth did */
    assert_int_equal(s->reversals, 1); /* -1, 2 */
    assert_int_equal(l->client_metrics->track[0].smooth.samples, 0); /* of the others only */
    free(truth);
    free(world);
    free_lone(l);
}

/* Steps in the plane: quarter turns are no reversals, steps against the previous one are, on any axis. */
static void steps_back_are_reversals(void **state)
{
    (void)state;
    const double places[][2] = {{0, 0}, {0, 0}, {0, 0}, {1, 0}, {1, 1},
                                {0, 1}, {0, 3}, {1, 2}, {2, 3}, {0, 3}};
    ll_smoothness s = {0};
    for (int i = 0; i < 10; i++)
        ll_smoothness_add(&s, &(ll_entity){.x = places[i][0], .y = places[i][1]}, (double[]){i, 0}, 1);
    assert_int_equal(s.reversals, 2); /* (0, 2) to (1, -1), and (1, 1) to (-2, 0) */
}

/* ---- animation error and hitches ---- */

/* Steps of the drawn position every 0.5 s against its drawn speed. */
static void animation_errs_by_the_step_beyond_the_speed(void **state)
{
    (void)state;
    const double x[] = {0, 3, 6, 6, 8}, vx[] = {6, 6, 6, 6, 8}, off[] = {-1, 0, 0, 3, 2};
    ll_smoothness s = {0};
    for (int i = 0; i < 5; i++)
        assert_near(
            ll_smoothness_add(&s, &(ll_entity){.x = x[i], .y = 1, .vx = vx[i]}, (double[]){i, 0}, 0.5),
            off[i], 1e-9);
}

/* More than two still displays in a row while the truth moves are one hitch, of any length. */
static void long_stills_are_hitches(void **state)
{
    (void)state;
    const double x[] = {0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3},
                 truth[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 10, 10, 10, 11, 12};
    const int hitches[] = {0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    ll_smoothness s = {0};
    for (int i = 0; i < 16; i++) {
        ll_smoothness_add(&s, &(ll_entity){.x = x[i]}, (double[]){truth[i], 0}, 0.1);
        assert_int_equal(s.hitches, hitches[i]);
    }
}

/* ---- visible corrections ---- */

static void corrections_below_a_pixel_or_a_tenth_of_the_way_are_not_seen(void **state)
{
    (void)state;
    lone *l = new_lone(1, &toy, &ll_sync_free);
    ll_history *truth = new_history(1);
    ll_world *world = new_world(1);
    const ll_truth real = {.world = world, .history = truth};
    const double moved[] = {0.19, 0.21, 0.29, 0.31, 0.5}, step[] = {0, 0, 3, 3, 6};
    const int count[] = {0, 1, 1, 2, 2};
    start_lone(l, 60, 0, 0);
    ll_history_add(truth, 0, world);
    l->client_metrics->corrections.pixel_m = 0.2;
    for (int i = 0; i < 5; i++) {
        ll_client_metrics_moved(l->client_metrics, moved[i], step[i]);
        ll_client_metrics_frame(l->client_metrics, l->client, &real, i * LL_MS);
        assert_int_equal(l->client_metrics->corrections.visible_m_all.count, count[i]);
    }
    assert_near(l->client_metrics->corrections.visible_m_all.sum, 0.21 + 0.31, 1e-9);
    ll_client_metrics_frame(l->client_metrics, l->client, &real, 5 * LL_MS); /* nothing moved since */
    assert_int_equal(l->client_metrics->corrections.visible_m_all.count, 2);
    free(truth);
    free(world);
    free_lone(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(acknowledgements_take_a_round_trip),
        cmocka_unit_test(inputs_that_were_not_applied_have_no_round_trip),
        cmocka_unit_test(start_does_not_count),
        cmocka_unit_test(corrections_are_measured_at_the_same_input),
        cmocka_unit_test(views_are_held_against_the_truth),
        cmocka_unit_test(smoothness_is_of_differences),
        cmocka_unit_test(steps_back_are_reversals),
        cmocka_unit_test(animation_errs_by_the_step_beyond_the_speed),
        cmocka_unit_test(long_stills_are_hitches),
        cmocka_unit_test(corrections_below_a_pixel_or_a_tenth_of_the_way_are_not_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

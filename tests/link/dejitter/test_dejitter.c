/* De-jitter buffers against closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/hash.h"
#include "base/rng.h"
#include "link/dejitter/dejitter.h"
#include "link/harness.h"

#define CAPACITY 1024
#define LAG (80 * LL_MS)
#define AHEAD (7 * LL_SECOND) /* of the sender's clock: it must have no effect */

static ll_dejitter *buffer_open(int capacity)
{
    ll_dejitter *b = malloc(ll_dejitter_size(capacity));
    assert_non_null(b);
    memset(b, 0xa5, ll_dejitter_size(capacity)); /* init must not rely on zeros */
    ll_dejitter_init(b, capacity);
    return b;
}

static ll_dejitter_params policy(int choice, double delay_ms, double interval_ms)
{
    return (ll_dejitter_params){.policy = choice, .delay_ms = delay_ms, .interval_ms = interval_ms};
}

/* Pushes a packet sent at `sent` and `transit` later there, by a sender whose clock is ahead. */
static void push(ll_dejitter *b, const ll_dejitter_params *params, int64_t id, ll_time sent, ll_time transit)
{
    assert_true(ll_dejitter_push(b, params, id, sent + AHEAD, sent + transit));
    assert_true(ll_dejitter_valid(b));
}

static int play_all(ll_dejitter *b, ll_time now)
{
    ll_dejitter_packet p;
    int played = 0;
    while (ll_dejitter_pop(b, now, &p))
        played++;
    return played;
}

static void without_a_policy_packets_pass(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(8);
    ll_dejitter_params none = policy(LL_DEJITTER_NONE, 50, 10);
    ll_dejitter_packet p;
    assert_int_equal(ll_dejitter_next_due(b), LL_NEVER);
    assert_false(ll_dejitter_pop(b, LL_SECOND, &p));
    push(b, &none, 5, 100, LAG);
    assert_int_equal(ll_dejitter_next_due(b), 100 + LAG);
    assert_false(ll_dejitter_pop(b, 100 + LAG - 1, &p));
    assert_true(ll_dejitter_pop(b, 100 + LAG, &p));
    assert_true(p.id == 5 && p.sent == 100 + AHEAD && p.arrived == 100 + LAG && p.due == 100 + LAG);
    assert_int_equal(ll_dejitter_depth(b), 0);
    assert_true(ll_dejitter_get_stats(b)->added_sum_ms == 0 && ll_dejitter_get_stats(b)->late == 0);
    free(b);
}

/* Equal delay for each: order and rhythm are those of arrival. */
static void from_arrival_every_packet_is_held_alike(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_ARRIVAL, 35, 0);
    ll_dejitter_packet p;
    for (int64_t i = 0; i < 10000; i++) {
        ll_time arrived = i * 10 * LL_MS, sent = arrived - LAG - (ll_time)(i * 37 % 50) * LL_MS;
        while (ll_dejitter_pop(b, arrived, &p))
            assert_true(p.due == p.id * 10 * LL_MS + 35 * LL_MS);
        assert_true(ll_dejitter_push(b, &params, i, sent, arrived));
    }
    const ll_dejitter_stats *stats = ll_dejitter_get_stats(b);
    assert_true(stats->added_sum_ms == 350000 && stats->added_max_ms == 35);
    assert_true(stats->late == 0 && stats->underruns == 0);
    assert_int_equal(stats->depth_max, 4); /* those of the last 35 ms */
    free(b);
}

/* Transit times uniform over w: a packet is later than the delay d with a probability of 1 - d / w. The
 * fastest of 2000 packets in two seconds is slower than the minimum by w / 2001 on average, with the same
 * standard deviation; that shifts the delay. There are 150 times two seconds. */
#define SPREAD_MS 100.0

static const ll_dejitter_stats *play_jittered(ll_dejitter *b, const ll_dejitter_params *params, int64_t count)
{
    for (int64_t i = 0; i < count; i++) {
        ll_time arrived = i * LL_MS, transit = LAG + ll_ms(SPREAD_MS * ll_rng_unit(3, 1, (uint64_t)i));
        assert_true(ll_dejitter_push(b, params, i, arrived - transit, arrived));
        play_all(b, arrived);
    }
    return ll_dejitter_get_stats(b);
}

static void by_send_time_the_share_of_late_packets_is_known(void **state)
{
    (void)state;
    enum { COUNT = 300000 };
    static const double delays[] = {0, 10, 40, 75, 99};
    for (int i = 0; i < 5; i++) {
        double d = delays[i], w = SPREAD_MS, late = 1 - d / w;
        ll_dejitter *b = buffer_open(CAPACITY);
        ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, d, 0);
        const ll_dejitter_stats *stats = play_jittered(b, &params, COUNT);
        double shift = w / 2001;
        double share = (double)stats->late / COUNT, added = stats->added_sum_ms / COUNT;
        double error = 3 * sqrt((late * (1 - late) + 1e-6) / COUNT) + 3 * shift / w / sqrt(150);
        assert_near(share, late - (late > 0 ? shift / w : 0), error);
        double second = d * d * d / (3 * w), mean = d * d / (2 * w); /* of max(0, d - lateness) */
        assert_near(added, mean + shift * d / w,
                    3 * sqrt((second - mean * mean) / COUNT) + 3 * shift * d / w / sqrt(150) + 1e-9);
        assert_near(stats->added_max_ms, d, 1e-9);
        free(b);
    }
}

/* With enough delay nothing is late; each packet then leaves the same time after it was sent. */
static void by_send_time_the_rhythm_of_sending_comes_back(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, 60, 0);
    int64_t expected = 0;
    ll_dejitter_packet p;
    ll_time now = 0;
    for (int64_t i = 0; i < 20000; i++) {
        /* sent in pairs, the second of which overtakes the first; one of ten takes the minimum time */
        ll_time transit = LAG + (i % 2 == 0 ? 50 : i % 10 == 1 ? 0 : 20) * LL_MS;
        now = i * 16 * LL_MS + transit;
        if (i % 2 == 0)
            continue;
        push(b, &params, i, i * 16 * LL_MS, transit);
        push(b, &params, i - 1, (i - 1) * 16 * LL_MS, now - (i - 1) * 16 * LL_MS);
        while (ll_dejitter_pop(b, now, &p)) {
            assert_int_equal(p.id, expected);
            if (expected > 0)
                assert_int_equal(p.due, p.id * 16 * LL_MS + LAG + 60 * LL_MS);
            expected++;
        }
    }
    assert_int_equal(ll_dejitter_get_stats(b)->late, 0);
    assert_true(expected > 19990);
    free(b);
}

/* The fastest packet counts for two seconds: if the delay increases by more than that of the buffer, all
 * packets are late until then; a decrease counts at once. */
static void the_fastest_packet_is_forgotten(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, 20, 0);
    int64_t late_until = 0;
    for (int64_t i = 0; i < 1000; i++) {
        ll_time sent = i * 10 * LL_MS, transit = i < 300   ? LAG
                                                 : i < 800 ? LAG + 30 * LL_MS
                                                           : LAG - 30 * LL_MS;
        int64_t before = ll_dejitter_get_stats(b)->late;
        push(b, &params, i, sent, transit);
        if (ll_dejitter_get_stats(b)->late > before)
            late_until = sent + transit;
        if (i == 999) {
            const ll_dejitter_packet *packets = ll_dejitter_packets(b);
            assert_int_equal(packets[ll_dejitter_depth(b) - 1].due, sent + transit + 20 * LL_MS);
        }
        play_all(b, sent + transit);
    }
    ll_time change = 300 * 10 * LL_MS + LAG;
    assert_true(late_until >= change + 7 * LL_SECOND / 4 && late_until <= change + 2 * LL_SECOND);
    free(b);
}

/* Late after an empty buffer is an under-run; late while others wait is not. */
static void underruns_are_of_an_empty_buffer(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(8);
    ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, 30, 0);
    const ll_dejitter_stats *stats = ll_dejitter_get_stats(b);
    push(b, &params, 0, 0, LAG); /* due at 110 ms */
    assert_int_equal(play_all(b, 110 * LL_MS), 1);
    push(b, &params, 1, 10 * LL_MS, 105 * LL_MS); /* due at 120 ms and there at 115 ms */
    assert_true(stats->late == 0 && stats->underruns == 0);
    play_all(b, 120 * LL_MS);
    push(b, &params, 2, 20 * LL_MS, 115 * LL_MS); /* 130 ms, 135 ms */
    assert_true(stats->late == 1 && stats->underruns == 1);
    play_all(b, 135 * LL_MS);
    push(b, &params, 4, 40 * LL_MS, 100 * LL_MS); /* 150 ms, 140 ms */
    push(b, &params, 3, 30 * LL_MS, 115 * LL_MS); /* 140 ms, 145 ms, while 4 waits */
    assert_true(stats->late == 2 && stats->underruns == 1);
    assert_int_equal(ll_dejitter_packets(b)[0].id, 3);
    free(b);
}

/* A packet that arrives when its successor is due, though not taken yet, goes after it. */
static void a_late_packet_is_not_before_its_time(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(8);
    ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, 30, 0);
    ll_dejitter_packet p;
    push(b, &params, 0, 0, LAG);
    push(b, &params, 2, 20 * LL_MS, LAG);
    push(b, &params, 1, 10 * LL_MS, 125 * LL_MS); /* at 135 ms; 2 was due at 130 ms */
    static const int64_t ids[] = {0, 2, 1}, dues[] = {110, 130, 135};
    for (int i = 0; i < 3; i++) {
        assert_true(ll_dejitter_pop(b, LL_SECOND, &p));
        assert_true(p.id == ids[i] && p.due == dues[i] * LL_MS);
    }
    free(b);
}

/* After any change, packets in the buffer keep their order and times. */
static void changes_keep_the_order(void **state)
{
    (void)state;
    for (int choice = 0; choice < LL_DEJITTER_CHOICES; choice++) {
        ll_dejitter *b = buffer_open(CAPACITY);
        ll_dejitter_packet p;
        ll_time last = 0, last_sent = INT64_MIN;
        int64_t late = 0;
        for (int64_t i = 0; i < 20000; i++) {
            double u = ll_rng_unit(4, 1, (uint64_t)i);
            ll_time arrived = i * 10 * LL_MS, transit = LAG + ll_ms(60 * u);
            ll_dejitter_params params = policy(choice, 200 * ll_rng_unit(4, 2, (uint64_t)i / 7), 10);
            assert_true(ll_dejitter_push(b, &params, i, arrived - transit, arrived));
            assert_true(ll_dejitter_valid(b));
            bool was_late = ll_dejitter_get_stats(b)->late > late;
            late = ll_dejitter_get_stats(b)->late;
            if (was_late)
                last_sent = INT64_MIN; /* may be out of order */
            while (ll_dejitter_pop(b, arrived, &p)) {
                assert_true(p.due >= last && p.due >= p.arrived);
                if (ll_dejitter_policies[choice].by_sending && late == 0)
                    assert_true(p.sent >= last_sent);
                last = p.due;
                last_sent = p.sent;
            }
        }
        free(b);
    }
}

/* ---- adaptive ---- */

/* Mirror: two intervals plus the deviation of the times between arrivals, which is 0 on a clean link. */
static void mirror_wants_two_intervals_of_a_clean_link(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_MIRROR, 0, 20);
    for (int64_t i = 0; i < 1000; i++) {
        push(b, &params, i, i * 20 * LL_MS, LAG);
        play_all(b, i * 20 * LL_MS + LAG);
        assert_int_equal(ll_dejitter_delay(b), 40 * LL_MS);
    }
    assert_int_equal(ll_dejitter_get_stats(b)->late, 0);
    free(b);
}

/* Transit times uniform over w, packets never out of order: the times between arrivals have the variance 2
 * w^2 / 12, an average packet is w / 2 behind the fastest. The root of an estimate from about 200 packets is
 * 0.3 % low, and the fastest of 200 is w / 201 above the minimum. */
static void mirror_adds_the_deviation(void **state)
{
    (void)state;
    enum { COUNT = 200000 };
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_MIRROR, 0, 10);
    double w = 9, sum = 0, deviation = w / sqrt(6);
    for (int64_t i = 0; i < COUNT; i++) {
        ll_time transit = LAG + ll_ms(w * ll_rng_unit(6, 1, (uint64_t)i));
        push(b, &params, i, i * 10 * LL_MS, transit);
        play_all(b, i * 10 * LL_MS + transit);
        sum += i < 1000 ? 0 : ll_to_ms(ll_dejitter_delay(b));
    }
    assert_near(sum / (COUNT - 1000), 20 + deviation + w / 2 - w / 201, 0.004 * deviation + 0.2 * w / 201);
    assert_int_equal(ll_dejitter_get_stats(b)->late, 0); /* two intervals are more than w */
    free(b);
}

/* Its delay grows by at most 4 % of the elapsed time and shrinks by at most 2 %. */
static void mirror_follows_at_its_speed(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_MIRROR, 0, 10);
    ll_time before = 20 * LL_MS, fastest_up = 0, fastest_down = 0, arrived_before = LAG;
    for (int64_t i = 0; i < 3000; i++) {
        ll_time transit = LAG + (i > 1000 && i < 1500 ? (i % 2) * 60 * LL_MS : 0);
        ll_time arrived = i * 10 * LL_MS + transit;
        if (arrived < arrived_before)
            continue; /* overtaken: not sent */
        push(b, &params, i, i * 10 * LL_MS, transit);
        play_all(b, arrived);
        ll_time change = ll_dejitter_delay(b) - before, passed = arrived - arrived_before;
        assert_true(change <= passed / 25 && change >= -(passed / 50));
        fastest_up += change > 0 && change == passed / 25;
        fastest_down += change < 0 && change == -(passed / 50);
        before = ll_dejitter_delay(b);
        arrived_before = arrived;
    }
    assert_true(fastest_up > 50 && fastest_down > 50);
    free(b);
}

/* Netcode for Entities: one interval of a clean link, but never less than configured. */
static void nfe_wants_one_interval_of_a_clean_link(void **state)
{
    (void)state;
    static const double least[] = {0, 15, 70};
    for (int k = 0; k < 3; k++) {
        ll_dejitter *b = buffer_open(CAPACITY);
        ll_dejitter_params params = policy(LL_DEJITTER_NFE, least[k], 20);
        for (int64_t i = 0; i < 1000; i++) {
            push(b, &params, i, i * 20 * LL_MS, LAG);
            play_all(b, i * 20 * LL_MS + LAG);
            assert_int_equal(ll_dejitter_delay(b), ll_ms(least[k] > 20 ? least[k] : 20));
        }
        free(b);
    }
}

/* Gaps of n intervals give n intervals, at most six; the delay changes by a tenth of the elapsed time. */
static void nfe_measures_the_gaps(void **state)
{
    (void)state;
    static const int64_t gaps[][2] = {{2, 2}, {3, 3}, {6, 6}, {9, 6}};
    for (int k = 0; k < 4; k++) {
        ll_dejitter *b = buffer_open(CAPACITY);
        ll_dejitter_params params = policy(LL_DEJITTER_NFE, 0, 20);
        ll_time before = 20 * LL_MS;
        int64_t at_full_speed = 0;
        for (int64_t i = 0; i < 400; i++) {
            ll_time step = (i == 0 ? 0 : gaps[k][0]) * 20 * LL_MS;
            push(b, &params, i, i * gaps[k][0] * 20 * LL_MS, LAG);
            play_all(b, LL_NEVER - 1);
            ll_time change = ll_dejitter_delay(b) - before;
            assert_true(change <= step / 10 && change >= -(step / 10));
            at_full_speed += step > 0 && change == step / 10;
            before = ll_dejitter_delay(b);
        }
        assert_int_equal(ll_dejitter_delay(b) / 1000, gaps[k][1] * 20 * 1000);
        assert_true(at_full_speed > 3);
        free(b);
    }
}

/* Gaps of one and three intervals in turn: their average swings between 260/7 and 300/7 ms and differs by
 * 120/7 from the next, so that the rule wants 450/7 ms after a long gap, and less by more than 2 ms, a tenth
 * of the short one, after that. */
static void nfe_adds_the_deviation_of_the_gaps(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_NFE, 0, 20);
    ll_time sent = 0;
    for (int64_t i = 0; i < 400; i++) {
        sent += (i % 2 ? 60 : 20) * LL_MS;
        push(b, &params, i, sent, LAG);
        play_all(b, LL_NEVER - 1);
        if (i > 200)
            assert_near(ll_to_ms(ll_dejitter_delay(b)), 450.0 / 7 - (i % 2 ? 0 : 2), 1e-5);
    }
    free(b);
}

/* Packets that arrive further apart than they were sent: from 40 ms the average moves a quarter of the way to
 * 60. */
static void nfe_heeds_the_arrivals(void **state)
{
    (void)state;
    ll_dejitter_params params = policy(LL_DEJITTER_NFE, 0, 40);
    ll_dejitter_history h = {
        .packets = 1, .delay = 40 * LL_MS, .gap_ms = 40, .arrivals_ms = 40, .arrived = LAG, .sent = 0};
    ll_dejitter_arrival next = {.sent = 40 * LL_MS, .arrived = LAG + 60 * LL_MS};
    assert_int_equal(ll_dejitter_policies[LL_DEJITTER_NFE].delay(&h, &params, &next), 45 * LL_MS);
}

/* Every second packet is 30 ms behind the fastest: 15 ms on average, with a swing of the average of weight
 * 1/8 by 1 / (16 - 1) of the half. Gaps are even; arrivals 10 and 70 ms apart average to at most 40 + 30 / 7.
 */
static void nfe_adds_the_average_lateness(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(CAPACITY);
    ll_dejitter_params params = policy(LL_DEJITTER_NFE, 60, 40); /* more than the arrivals need */
    for (int64_t i = 0; i < 2000; i++) {
        push(b, &params, i, i * 40 * LL_MS, LAG + (i % 2) * 30 * LL_MS);
        play_all(b, i * 40 * LL_MS + LAG + (i % 2) * 30 * LL_MS);
        if (i > 100)
            assert_near(ll_to_ms(ll_dejitter_delay(b)), 75, 15.0 / 15 + 1e-6);
    }
    free(b);
}

/* ---- the block ---- */

static void a_full_buffer_refuses(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(3);
    ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, 100, 0);
    for (int64_t i = 0; i < 5; i++)
        assert_int_equal(ll_dejitter_push(b, &params, i, i, i + LAG), i < 3);
    const ll_dejitter_stats *stats = ll_dejitter_get_stats(b);
    assert_true(stats->pushed == 5 && stats->overflowed == 2 && stats->depth_max == 3 &&
                stats->depth_sum == 6);
    assert_int_equal(play_all(b, LL_SECOND), 3);
    assert_true(ll_dejitter_push(b, &params, 9, 9, LL_SECOND));
    free(b);
}

static void clearing_forgets(void **state)
{
    (void)state;
    ll_dejitter *b = buffer_open(8);
    ll_dejitter_params params = policy(LL_DEJITTER_SEND_TIME, 10, 0);
    push(b, &params, 0, 0, LAG);
    ll_dejitter_clear(b);
    assert_int_equal(ll_dejitter_depth(b), 0);
    assert_int_equal(ll_dejitter_next_due(b), LL_NEVER);
    push(b, &params, 1, 10 * LL_MS, 3 * LAG); /* the fastest now */
    assert_int_equal(ll_dejitter_next_due(b), 10 * LL_MS + 3 * LAG + 10 * LL_MS);
    assert_int_equal(ll_dejitter_get_stats(b)->pushed, 2);
    free(b);
}

static void a_buffer_can_be_moved_and_copied(void **state)
{
    (void)state;
    for (int choice = 0; choice < LL_DEJITTER_CHOICES; choice++) {
        size_t size = ll_dejitter_size(64);
        assert_int_equal(size % 8, 0);
        ll_dejitter *stays = buffer_open(64), *moves = buffer_open(64);
        ll_dejitter_params params = policy(choice, 40, 10);
        for (int64_t i = 0; i < 5000; i++) {
            ll_time arrived = i * 10 * LL_MS,
                    sent = arrived - LAG - ll_ms(70 * ll_rng_unit(4, 3, (uint64_t)i));
            ll_dejitter_push(stays, &params, i, sent, arrived);
            ll_dejitter_push(moves, &params, i, sent, arrived);
            play_all(stays, arrived);
            play_all(moves, arrived);
            ll_dejitter *place = malloc(size);
            memcpy(place, moves, size);
            memset(moves, 0xee, size);
            free(moves);
            moves = place;
        }
        assert_int_equal(ll_hash(0, stays, size), ll_hash(0, moves, size));
        free(stays);
        free(moves);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_policy_packets_pass),
        cmocka_unit_test(from_arrival_every_packet_is_held_alike),
        cmocka_unit_test(by_send_time_the_share_of_late_packets_is_known),
        cmocka_unit_test(by_send_time_the_rhythm_of_sending_comes_back),
        cmocka_unit_test(the_fastest_packet_is_forgotten),
        cmocka_unit_test(underruns_are_of_an_empty_buffer),
        cmocka_unit_test(a_late_packet_is_not_before_its_time),
        cmocka_unit_test(changes_keep_the_order),
        cmocka_unit_test(mirror_wants_two_intervals_of_a_clean_link),
        cmocka_unit_test(mirror_adds_the_deviation),
        cmocka_unit_test(mirror_follows_at_its_speed),
        cmocka_unit_test(nfe_wants_one_interval_of_a_clean_link),
        cmocka_unit_test(nfe_measures_the_gaps),
        cmocka_unit_test(nfe_adds_the_deviation_of_the_gaps),
        cmocka_unit_test(nfe_heeds_the_arrivals),
        cmocka_unit_test(nfe_adds_the_average_lateness),
        cmocka_unit_test(a_full_buffer_refuses),
        cmocka_unit_test(clearing_forgets),
        cmocka_unit_test(a_buffer_can_be_moved_and_copied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The clock that a client measures: the effect of a link, the filters, and how the clock in use follows. */
#include "netcode/toy.h"

#include "base/rng.h"

static ll_time draw(uint64_t seed, uint64_t stream, uint64_t k, ll_time least, ll_time most)
{
    return least + (ll_time)(ll_rng_u64(seed, stream, k) % (uint64_t)(most - least + 1));
}

/* The result of the filter, which these tests do not check. */
static ll_time filtered;

static ll_time as_filtered(const ll_clock_sample *samples, int count)
{
    (void)samples, (void)count;
    return filtered;
}

static const ll_clock_filter fixed_filter = {as_filtered};

/* A symmetric link: the offset is exact to the ns. An asymmetric one: any filter is off by half of the
 * difference. */
static void the_offset_is_off_by_half_the_asymmetry(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 1000; k++)
        for (int f = 0; ll_clock_filters[f]; f++) {
            ll_time up = 2 * draw(1, 0, k, 0, 600 * LL_MS), down = 2 * draw(1, 1, k, 0, 600 * LL_MS);
            ll_time ahead = draw(1, 2, k, -3600 * LL_SECOND, 3600 * LL_SECOND);
            ll_clock_sync sync = {0};
            for (int i = 0; i < 12; i++) {
                ll_time t0 = i * 250 * LL_MS;
                ll_clock_sync_add(&sync, ll_clock_filters[f], t0, t0 + up + ahead, t0 + up + down, i == 0);
            }
            assert_int_equal(sync.offset - ahead, (up - down) / 2);
            assert_int_equal(ll_clock_sync_round_trip(&sync), up + down);
        }
}

static int by_offset(const void *a, const void *b)
{
    ll_time x = ((const ll_clock_sample *)a)->offset, y = ((const ll_clock_sample *)b)->offset;
    return (x > y) - (x < y);
}

/* Of the last eight samples, or of fewer: against a sort, a sum and a search. */
static void filters_look_at_the_last_eight(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++)
        for (int f = 0; f < 3; f++) {
            ll_clock_sync sync = {0};
            ll_clock_sample all[30];
            for (uint64_t k = 0; k < 30; k++) {
                ll_time t0 = (ll_time)k * LL_SECOND, up = draw(seed, 1, k, 0, 9) * 10 * LL_MS,
                        down = draw(seed, 2, k, 0, 9) * 10 * LL_MS; /* equal ones too */
                ll_clock_sync_add(&sync, ll_clock_filters[f], t0, t0 + up, t0 + up + down, true);
                all[k] = (ll_clock_sample){(up - down) / 2, up + down};
                int n = k < 7 ? (int)k + 1 : 8;
                ll_clock_sample last[8], least = {0, LL_NEVER};
                memcpy(last, &all[k + 1 - (uint64_t)n], (size_t)n * sizeof last[0]);
                ll_time sum = 0, longest = 0;
                bool is_least = false;
                for (int i = 0; i < n; i++) {
                    sum += last[i].offset;
                    longest = last[i].round_trip > longest ? last[i].round_trip : longest;
                    least = last[i].round_trip < least.round_trip ? last[i] : least;
                }
                for (int i = 0; i < n; i++)
                    is_least |= last[i].round_trip == least.round_trip && last[i].offset == sync.offset;
                qsort(last, (size_t)n, sizeof last[0], by_offset);
                if (f == 0)
                    assert_int_equal(sync.offset, last[(n - 1) / 2].offset);
                else if (f == 1)
                    assert_true(is_least);
                else
                    assert_true(llabs(sync.offset * n - sum) <= n);
                assert_int_equal(ll_clock_sync_round_trip(&sync), longest);
            }
            sync.count = 0;
            assert_int_equal(ll_clock_sync_round_trip(&sync), 0);
        }
}

/* 0 to 50 ms in each direction: the mean of eight is off by sqrt(2 x 50^2 / 12) / 2 / sqrt(8) = 3.6 ms rms,
 * the shortest round trip by nearly twice that. With a fifth of the packets up held for 50 to 300 ms the mean
 * is far off instead. */
static void each_filter_has_its_link(void **state)
{
    (void)state;
    for (int spikes = 0; spikes < 2; spikes++) {
        double squares[3] = {0}, rms[3];
        int windows = 4000;
        for (int w = 0; w < windows; w++)
            for (int f = 0; f < 3; f++) {
                ll_clock_sync sync = {0};
                for (uint64_t k = 0; k < 8; k++) {
                    uint64_t draw_of = (uint64_t)w * 8 + k;
                    double up = spikes ? 10 : 50 * ll_rng_unit(7, 0, draw_of),
                           down = spikes ? 10 : 50 * ll_rng_unit(7, 1, draw_of);
                    if (spikes && ll_rng_unit(7, 2, draw_of) < 0.2)
                        up += 50 + 250 * ll_rng_unit(7, 3, draw_of);
                    ll_clock_sync_add(&sync, ll_clock_filters[f], 0, ll_ms(up), ll_ms(up + down), true);
                }
                squares[f] += ll_to_ms(sync.offset) * ll_to_ms(sync.offset);
            }
        for (int f = 0; f < 3; f++)
            rms[f] = sqrt(squares[f] / windows);
        if (spikes)
            assert_true(rms[1] < 2 && rms[0] < rms[2] / 2 && rms[2] > 15);
        else
            assert_true(fabs(rms[2] - 3.608) < 0.15 && rms[1] > 1.7 * rms[2] && rms[0] < rms[1]);
    }
}

/* Below 100 ms the offset follows by a twentieth of the elapsed time; from there on it is corrected at once,
 * and counted. */
static void the_offset_is_slewed_or_snaps(void **state)
{
    (void)state;
    static const ll_time errors[] = {1,           LL_MS,           5 * LL_MS,     99 * LL_MS, 100 * LL_MS - 1,
                                     100 * LL_MS, 100 * LL_MS + 1, 10 * LL_SECOND};
    for (size_t i = 0; i < 2 * sizeof errors / sizeof errors[0]; i++) {
        ll_time error = i % 2 ? -errors[i / 2] : errors[i / 2], t = LL_SECOND;
        bool snaps = errors[i / 2] >= 100 * LL_MS;
        ll_clock_sync sync = {.offset = 7 * LL_SECOND, .at = t};
        filtered = sync.offset + error;
        for (int k = 1; k <= 40; k++) {
            t += 50 * LL_MS; /* a sample moves it by 2.5 ms at most */
            ll_clock_sync_add(&sync, &fixed_filter, t - LL_MS, t, t, false);
            ll_time most = k * 2500000, moved = errors[i / 2] < most || snaps ? errors[i / 2] : most;
            assert_int_equal(sync.offset, 7 * LL_SECOND + (error < 0 ? -moved : moved));
            assert_int_equal(sync.snaps, snaps);
        }
    }
    ll_clock_sync sync = {.offset = 0,
                          .at = 0}; /* at the handshake it is used as it is, and that is no snap */
    filtered = -42;
    ll_clock_sync_add(&sync, &fixed_filter, 0, 0, 0, true);
    assert_int_equal(sync.offset, -42);
    filtered = LL_SECOND;
    ll_clock_sync_add(&sync, &fixed_filter, 0, 0, 0, true);
    assert_int_equal(sync.offset, LL_SECOND);
    assert_int_equal(sync.snaps, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_offset_is_off_by_half_the_asymmetry),
        cmocka_unit_test(filters_look_at_the_last_eight),
        cmocka_unit_test(each_filter_has_its_link),
        cmocka_unit_test(the_offset_is_slewed_or_snaps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The ring of positions, against a linear search. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/rng.h"
#include "game/core/history.h"
#include "support/near.h"

#define RECORDS 1700
#define KEPT LL_HISTORY_STEPS

static void the_past_is_found_as_by_a_linear_search(void **state)
{
    (void)state;
    static ll_time time[RECORDS];
    static double x[RECORDS], y[RECORDS];
    ll_history *history = malloc(ll_history_size(2));
    ll_world *world = calloc(1, sizeof *world + 2 * sizeof(ll_entity));
    ll_history_init(history, 2);
    world->players = world->entities = 2;
    ll_time now = 0;
    for (int n = 0; n < RECORDS; n++) {
        /* Even steps, uneven ones, and occasional stalls, as in lockstep. */
        uint64_t draw = ll_rng_u64(1, 0, (uint64_t)n);
        now += n / 300 % 2 ? LL_SECOND / 60 : n % 40 == 0 ? LL_SECOND : 1 + (ll_time)(draw % (40 * LL_MS));
        time[n] = now;
        x[n] = world->entity[1].x = ll_rng_unit(1, 1, (uint64_t)n);
        y[n] = world->entity[1].y = ll_rng_unit(1, 2, (uint64_t)n);
        ll_history_add(history, now, world);
        int oldest = n < KEPT ? 0 : n - KEPT + 1;
        for (int q = 0; q < 20; q++) {
            ll_time span = time[n] - time[oldest], t;
            if (q < 12) /* anywhere, also before the oldest and after the newest */
                t = time[oldest] - LL_SECOND / 10 +
                    (ll_time)(ll_rng_unit(1, 3, (uint64_t)(n * 32 + q)) * (double)(span + LL_SECOND / 5));
            else /* at a record, and next to it */
                t = time[oldest +
                         (int)(ll_rng_u64(1, 4, (uint64_t)(n * 32 + q)) % (uint64_t)(n - oldest + 1))] +
                    q % 3 - 1;
            int i = oldest;
            while (i < n && time[i + 1] <= t)
                i++;
            double s = i < n && t > time[i] ? (double)(t - time[i]) / (double)(time[i + 1] - time[i]) : 0, gx,
                   gy;
            int j = i < n ? i + 1 : i;
            ll_history_at(history, ll_history_find(history, t), 1, &gx, &gy);
            assert_near(gx, x[i] + s * (x[j] - x[i]), 1e-9);
            assert_near(gy, y[i] + s * (y[j] - y[i]), 1e-9);
            const ll_moment found = ll_history_find(history, t),
                            again = ll_history_find_near(history, t, i + q * 7 - 70);
            assert_true(again.before == found.before && again.after == found.after &&
                        again.share == found.share);
        }
    }
    double gx, gy;
    ll_history_at(history, ll_history_find(history, now / 2), 0, &gx, &gy);
    assert_true(gx == 0 && gy == 0);
    free(history);
    free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_past_is_found_as_by_a_linear_search)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

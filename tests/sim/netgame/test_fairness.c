/* Fairness by hand: three players whose input latency is their round trip, since nothing is predicted. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

static double measure(const cJSON *metrics, const char *path)
{
    const cJSON *value = ll_param_number_at(metrics, path);
    assert_non_null(value);
    return value->valuedouble;
}

static void fairness_follows_the_lag(void **state)
{
    (void)state;
    static const char *const sets[] = {"players=[{\"lag_ms\":0},{\"lag_ms\":100},{\"lag_ms\":200}]",
                                       "server.update_hz=60", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 20, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    double x[3], sum = 0, squares = 0;
    for (int i = 0; i < 3; i++) {
        char path[64];
        snprintf(path, sizeof path, "players.%d.input_latency_ms.mean", i);
        x[i] = measure(m, path);
        sum += x[i];
        squares += x[i] * x[i];
    }
    assert_true(x[0] < 60 && x[1] > 200 && x[2] > 400);
    assert_near(measure(m, "server.fairness.input_latency_ms.spread"), (x[2] - x[0]), 1e-9);
    assert_near(measure(m, "server.fairness.input_latency_ms.jain"), sum * sum / (3 * squares), 1e-12);
    double slope = (x[2] - x[0]) / 400; /* least squares of three even points */
    assert_near(measure(m, "server.fairness.input_latency_ms.per_ms_of_round_trip"), slope, 1e-9);
    assert_true(slope > 0.95 && slope < 1.05);
    cJSON_Delete(m);
    scene_close(&s);
}

/* Equal bots; a player far away hits less where nothing is rewound, and a player who never shoots is not
 * counted. */
static void fairness_counts_hits(void **state)
{
    (void)state;
    static const char *const sets[] = {"players.0.lag_ms=5", "players.1.lag_ms=400", NULL};
    scene s = scene_open("rifle_no_rewind", sets);
    scene_run(&s, 60, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    double near = measure(m, "players.0.shots.hit_ratio"), far = measure(m, "players.1.shots.hit_ratio");
    assert_true(near > far && far > 0 && near <= 1);
    assert_near(near,
                measure(m, "players.0.shots.hitscan.compensated_hits") /
                    measure(m, "players.0.shots.hitscan.shots"),
                1e-12);
    assert_near(measure(m, "server.fairness.hit_ratio.spread"), fabs(near - far), 1e-12);
    cJSON_Delete(m);
    scene_close(&s);

    s = scene_open("behind_cover", NULL);
    scene_run(&s, 1, NULL); /* no player has shot yet */
    m = ll_netgame_metrics(s.game);
    assert_null(ll_param_number_at(m, "players.0.shots.hit_ratio"));
    assert_null(ll_param_number_at(m, "server.fairness.hit_ratio.spread"));
    cJSON_Delete(m);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(fairness_follows_the_lag),
                                       cmocka_unit_test(fairness_counts_hits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The adviser compared with brute force. It runs every setting once; where seeds matter, two fifths of all
 * runs and a thousand more to verify. Its cost must be within 2 % of the cheapest setting that holds, and its
 * advice must hold on seeds that neither has used. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/advise/advise.h"
#include "experiment/format/table.h"
#include "support/many.h"
#include "support/near.h"
#include "support/stride.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static ll_experiment *experiment(const char *text)
{
    cJSON *json = cJSON_Parse(text);
    ll_experiment *e;
    assert_non_null(json);
    must(ll_experiment_parse(json, "scenarios", NULL, &e));
    cJSON_Delete(json);
    return e;
}

#define STEPS "{\"path\":\"methods.0.dt_s\",\"from\":0.0002,\"to\":0.2,\"count\":24,\"scale\":\"log\"}"
#define METHODS                                                                                              \
    "{\"path\":\"methods.0.method\",\"values\":[\"explicit_euler\",\"semi_implicit_euler\",\"velocity_"      \
    "verlet\",\"rk4\"]}"
#define MOTION(problem, seconds)                                                                             \
    "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"" problem "\",\"duration_s\":" seconds                 \
    ",\"methods\":[{\"method\":\"rk4\"}]},\"axes\":[" METHODS "," STEPS                                      \
    "],\"metrics\":[\"methods.0.e_max\",\"methods.0.evaluations\"]}"

/* A race whose player A has jitter and loss: repeats differ. */
#define RACE(error, cost)                                                                                    \
    "{\"scenario\":\"race\",\"set\":{\"duration_s\":4,\"players.0.link.up.jitter_ms\":30,"                   \
    "\"players.0.link.down.loss_pct\":5},\"repeats\":12,\"axes\":[{\"path\":\"server.update_hz\","           \
    "\"values\":"                                                                                            \
    "[2,3,5,7,10,15,20,30,45,60]},{\"path\":\"players.0.lag_ms\",\"values\":[20,60,100,150]},{\"path\":"     \
    "\"players.0.prediction\",\"values\":[false,true]},{\"path\":\"players.0.interpolation\",\"values\":"    \
    "[false,true]}],\"metrics\":[\"" error "\",\"" cost "\"]}"

/* De-jitter delay against late snapshots. */
#define DEJITTER                                                                                             \
    "{\"scenario\":\"dejitter_500\",\"set\":{\"duration_s\":10},\"repeats\":12,\"axes\":[{\"path\":"         \
    "\"players.0.dejitter\",\"values\":"                                                                     \
    "[\"send_time\",\"mirror\",\"nfe\"]},{\"path\":\"players.0.dejitter_ms\",\"from\":20,\"to\":490,"        \
    "\"count\":24}],"                                                                                        \
    "\"metrics\":[\"players.0.dejitter.late_ratio\",\"players.0.dejitter.added_mean_ms\"]}"

/* Hitscan with server-side rewind up to a limit: what is the lowest update rate? */
#define REWIND                                                                                               \
    "{\"scenario\":\"behind_cover\",\"set\":{\"duration_s\":20},\"repeats\":12,\"axes\":[{\"path\":"         \
    "\"server."                                                                                              \
    "update_hz\",\"values\":"                                                                                \
    "[10,12,15,20,25,30,40,50,60]},{\"path\":\"server.max_rewind_ms\",\"values\":[100,150,200,250,300]},"    \
    "{\"path\":\"players.1.interpolation_ratio\",\"values\":[1,2]}],"                                        \
    "\"metrics\":[\"players.1.shots.hitscan.false_misses\",\"players.1.bandwidth.down_bytes_per_s\"]}"

/* Input delay against resimulated ticks; lockstep resimulates none, but waits. */
#define DELAYS "[0,1,2,3,4,5,6,7,8,9,10,12]"
#define ROLLBACK                                                                                             \
    "{\"scenario\":\"rollback_loss\",\"set\":{\"duration_s\":14},\"repeats\":12,\"axes\":[{\"path\":"        \
    "\"server.sync\",\"values\":"                                                                            \
    "[\"deterministic\",\"rollback\"]},{\"path\":\"server.max_rollback_ticks\",\"values\":[4,6,8]},{"        \
    "\"zip\":["                                                                                              \
    "{\"path\":\"players.0.input_delay_ticks\",\"values\":" DELAYS "},"                                      \
    "{\"path\":\"players.1.input_delay_ticks\",\"values\":" DELAYS "}]}],"                                   \
    "\"metrics\":[\"players.0.rollback.ticks_per_s\",\"players.0.ack_rtt_ms.mean\"]}"

/* Solver passes against the drift of a pyramid that should stand still. */
#define RIGID                                                                                                \
    "{\"scenario\":\"rigid/"                                                                                 \
    "pyramid\",\"set\":{\"duration_s\":1},\"axes\":[{\"path\":\"solver.method\",\"values\":"                 \
    "[\"pgs\",\"pgs_ngs\",\"soft_step\",\"tgs_sticky\",\"xpbd\",\"avbd\"]},{\"path\":\"hz\",\"values\":[30," \
    "60,120]},{\"zip\":["                                                                                    \
    "{\"path\":\"solver.substeps\",\"values\":[1,2,4,8,16,32]},"                                             \
    "{\"path\":\"solver.iterations\",\"values\":[1,2,4,8,16,32]}]}],"                                        \
    "\"metrics\":[\"drift_worst_m\",\"passes_per_s\"]}"

/* Cells and pressure solver against the error of vortices. */
#define FLUID                                                                                                \
    "{\"scenario\":\"fluid/"                                                                                 \
    "taylor_green\",\"set\":{\"duration_s\":0.5},\"axes\":[{\"path\":\"params.n\",\"values\":"               \
    "[16,24,32,48]},{\"path\":\"solver.pressure\",\"values\":[\"gauss_seidel\",\"sor\",\"pcg\","             \
    "\"multigrid\",\"direct\"]},"                                                                            \
    "{\"path\":\"solver.tolerance\",\"values\":[0.3,0.1,0.01,1e-4]}],\"metrics\":[\"error_l2\",\"cell_"      \
    "visits\"]}"

/* Methods that fail at long steps, or always: failed runs are neither cheap nor accurate. */
#define ALL_METHODS                                                                                          \
    "{\"path\":\"methods.0.method\",\"values\":[\"explicit_euler\",\"semi_implicit_euler\",\"velocity_"      \
    "verlet\",\"rk4\",\"yoshida4\",\"yoshida6\",\"implicit_euler\",\"trapezoid\",\"ab4\"]}"
#define FAILING(problem, params, seconds)                                                                    \
    "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"" problem "\",\"params\":{" params                     \
    "},\"duration_s\":" seconds ",\"methods\":[{\"method\":\"rk4\"}]},\"axes\":[" ALL_METHODS                \
    ",{\"path\":\"methods.0.dt_s\",\"values\":[0.4,0.25,0.15,0.08,0.04,0.02,0.01,0.005]}],\"metrics\":["     \
    "\"methods.0.e_max\",\"methods.0.evaluations\"]}"

/* A signed error: too much decay counts as much as too little. */
#define SIGNED                                                                                               \
    "{\"scenario\":\"fluid/taylor_green\",\"set\":{\"duration_s\":0.6},\"axes\":[{\"path\":"                 \
    "\"solver.advection\",\"values\":[\"semi_lagrangian\",\"maccormack\",\"bfecc\",\"central\"]},{\"path\":" \
    "\"params.n\",\"values\":[12,16,20,24,32,40,48]},{\"path\":\"solver.cfl\",\"values\":[0.3,0.6]}],"       \
    "\"metrics\":[\"decay_error\",\"cell_visits\"]}"

/* Costs are counts (bytes, evaluations, passes, visits) and times of the simulation: with measured processor
 * time brute force would find another optimum each time. */
static const struct {
    const char *name, *text;
    double max_error;
    double regret; /* 0: 2 % */
    bool long_one; /* takes as long as all others: of `test_experiment advise many` */
} cases[] = {
    {"kepler 1e-3", MOTION("kepler", "5"), 1e-3, 0, false},
    {"kepler 1e-8", MOTION("kepler", "5"), 1e-8, 0, false},
    {"pendulum 1e-2", MOTION("pendulum", "5"), 1e-2, 0, false},
    {"oscillator 1e-5", MOTION("oscillator", "5"), 1e-5, 0, false},
    {"race, what A sees of itself", RACE("players.0.own_lead_m.mean", "players.0.bandwidth.down_bytes_per_s"),
     0.5, 0, false},
    {"race, what A sees of B", RACE("players.0.remote_error_m.mean", "players.0.bandwidth.down_bytes_per_s"),
     3, 0, false},
    {"de-jitter buffer", DEJITTER, 0.1, 0, false},
    {"rewind", REWIND, 1, 0, true},
    {"rollback and lockstep", ROLLBACK, 1, 0, true},
    {"pyramid of bodies", RIGID, 0.02, 0, false},
    {"vortices on a grid", FLUID, 0.005, 0, false},
    {"an orbit that most miss, 0.1", FAILING("kepler", "\"e\":0.7", "8"), 0.1, 0, false},
    {"an orbit that most miss, 1e-3", FAILING("kepler", "\"e\":0.7", "8"), 1e-3, 0, false},
    {"an orbit that most miss, 3e-5", FAILING("kepler", "\"e\":0.7", "8"), 3e-5, 0, false},
    {"a fast spring, 0.1", FAILING("oscillator", "\"omega\":9", "6"), 0.1, 0, false},
    {"a fast spring, 1e-4", FAILING("oscillator", "\"omega\":9", "6"), 1e-4, 0, false},
    {"a limit cycle, 0.5", FAILING("van_der_pol", "\"mu\":4", "9"), 0.5, 0, false},
    {"decay with a sign, 0.05", SIGNED, 0.05, 0, false},
    {"decay with a sign, 0.01", SIGNED, 0.01, 0, false},
};

enum { SEEDS = 24 };

static bool long_ones;

/* Mean error over seeds from `first` on, and half width of its 95 % interval. */
static double mean_error(const ll_experiment *e, int64_t point, int64_t first, int64_t count, double *half,
                         double *cost)
{
    ll_experiment more = *e;
    ll_sums error = {0}, costs = {0};
    ll_kept_block kept = {0};
    more.head.repeats = first + count;
    bool good = true;
    for (int64_t r = first; r < first + count && good; r++) {
        ll_row row;
        must(ll_experiment_run(&more, point * more.head.repeats + r, NULL, &kept, &row));
        good = ll_row_good(&row) && !isnan(row.metrics[e->error_metric]);
        ll_sums_add(&error, fabs(row.metrics[e->error_metric]));
        ll_sums_add(&costs, fabs(row.metrics[e->cost_metric]));
    }
    ll_kept_block_free(&kept);
    if (!good)
        return INFINITY;
    *half = count > 1 ? ll_interval_95(count, error.squares) : 0;
    *cost = costs.mean;
    return error.mean;
}

/* Of every point the error with its interval, and the cost, over many seeds. */
typedef struct measured {
    double error, half, cost;
} measured;

static measured *measure_all(const ll_experiment *e)
{
    measured *all = calloc((size_t)e->points, sizeof *all);
    for (int64_t p = 0; p < e->points; p++)
        all[p].error = mean_error(e, p, 0, e->head.repeats > 1 ? SEEDS : 1, &all[p].half, &all[p].cost);
    return all;
}

/* Lowest cost of all points whose error holds. */
static double brute_force(const ll_experiment *e, const measured *all, double max_error)
{
    double least = INFINITY;
    for (int64_t p = 0; p < e->points; p++) {
        if (all[p].error + all[p].half <= max_error)
            least = smaller(least, all[p].cost);
    }
    return least;
}

/* On seeds that neither the search nor its verification has used. */
static void holds_on_other_seeds(const ll_experiment *e, const cJSON *advice, double max_error)
{
    double half, cost;
    int64_t point = cJSON_GetObjectItem(advice, "point")->valueint, count = e->head.repeats > 1 ? 60 : 2;
    double error = mean_error(e, point, e->head.repeats + 256, count, &half, &cost);
    if (!(error <= max_error))
        fail_msg("%lld: %g on other seeds", (long long)point, error);
}

static void advice_equals_brute_force(void **state)
{
    (void)state;
    const char *measured_text = ""; /* of `all`: cases that differ by the limit alone share it */
    measured *all = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i += LL_TEST_STRIDE) {
        if (cases[i].long_one && !long_ones && LL_TEST_STRIDE == 1)
            continue;
        ll_experiment *e = experiment(cases[i].text);
        cJSON *answer;
        if (strcmp(measured_text, cases[i].text) != 0) {
            free(all);
            all = measure_all(e);
            measured_text = cases[i].text;
        }
        must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = cases[i].max_error}, &answer));
        double least = brute_force(e, all, cases[i].max_error),
               runs = cJSON_GetObjectItem(answer, "runs")->valuedouble;
        const cJSON *advice = cJSON_GetObjectItem(answer, "advice");
        const cJSON *cost = cJSON_GetObjectItem(advice, "cost");
        assert_true(isfinite(least)); /* the case has a solution */
        print_message("%s: cost %g, least %g, %g of %lld runs\n", cases[i].name,
                      cost ? cost->valuedouble : NAN, least, runs, (long long)e->runs);
        double most = (double)(e->points + 40), fifth = (double)e->runs / 5,
               regret = cases[i].regret > 0 ? cases[i].regret : 0.02;
        if (!cost || !(cost->valuedouble <= (1 + regret) * least) ||
            !(runs <= (e->head.repeats > 1 ? larger(most, 2 * fifth + 1024) : most)))
            fail_msg("%s", cases[i].name);
        assert_true(cJSON_GetObjectItem(advice, "error")->valuedouble <= cases[i].max_error);
        assert_int_equal(cJSON_GetObjectItem(advice, "runs")->valueint, e->head.repeats);
        assert_true(cJSON_GetObjectItem(cJSON_GetObjectItem(advice, "verified"), "error")->valuedouble <=
                    cases[i].max_error);
        holds_on_other_seeds(e, advice, cases[i].max_error);
        cJSON_Delete(answer);
        ll_experiment_free(e);
    }
    free(all);
}

static const char *optimum(const cJSON *answer)
{
    return cJSON_GetObjectItem(answer, "optimum")->valuestring;
}

/* With runs to spare for every point the optimum is proven; with few runs the answer is the best found, and
 * all runs are used. */
static void it_says_whether_the_optimum_is_proven(void **state)
{
    (void)state;
    ll_experiment *e = experiment(FAILING("kepler", "\"e\":0.55", "5"));
    measured *all = measure_all(e);
    double least = brute_force(e, all, 1e-2);
    free(all);
    for (int few = 0; few < 2; few++) {
        cJSON *answer;
        must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = 1e-2, .most_runs = few ? 12 : 200},
                       &answer));
        assert_string_equal(optimum(answer), few ? "best found" : "proven");
        const cJSON *advice = cJSON_GetObjectItem(answer, "advice");
        if (few)
            assert_int_equal(cJSON_GetObjectItem(answer, "runs")->valueint, 12);
        else
            assert_true(cJSON_GetObjectItem(advice, "cost")->valuedouble == least);
        cJSON_Delete(answer);
    }
    ll_experiment_free(e);
}

/* Of settings with equal cost the one with the smallest error. Solver passes do not depend on the density,
 * errors do. */
static void ties_go_to_the_least_error(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"free_fall\",\"duration_s\":3,\"methods\":[{"
        "\"method\":"
        "\"explicit_euler\",\"dt_s\":0.1}]},\"axes\":[{\"path\":\"params.g\",\"values\":[9,7,5,3,4,6,8]}],"
        "\"metrics\":[\"methods.0.e_final\",\"methods.0.evaluations\"]}");
    cJSON *answer;
    must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = 1, .most_runs = 30}, &answer));
    const cJSON *advice = cJSON_GetObjectItem(answer, "advice");
    assert_int_equal(cJSON_GetObjectItem(advice, "point")->valueint, 3); /* g = 3: 0.45 m */
    assert_string_equal(optimum(answer), "proven");
    cJSON_Delete(answer);
    ll_experiment_free(e);
}

#define TOGETHER(path, values)                                                                               \
    "{\"zip\":[{\"path\":\"players.0." path "\",\"values\":" values "},{\"path\":\"players.1." path          \
    "\",\"values\":" values "}]}"

/* Bursts of loss against input delay: the cost of a run varies more by seed than by setting. */
#define BURSTS                                                                                               \
    "{\"scenario\":\"race\",\"set\":{\"duration_s\":7,\"seed\":1001,\"server.sync\":\"deterministic\","      \
    "\"players.0.link.up.loss_model\":\"gemodel\",\"players.0.link.up.ge_p_pct\":2.5,"                       \
    "\"players.0.link.up.ge_r_pct\":30,\"players.0.link.down.jitter_ms\":15},\"repeats\":8,\"axes\":"        \
    "[" TOGETHER("input_delay_ticks", "[0,1,2,3,4,6,8,10,12,14,16]") "," TOGETHER(                           \
        "lag_ms",                                                                                            \
        "[20,50,80]") ",{\"path\":\"players.0.redundancy\",\"values\":[0,3]}],"                              \
                      "\"metrics\":[\"players.0.stalls.stalled_s\",\"players.0.ack_rtt_ms.mean\"]}"

/* Settings share their seeds: bad first seeds must not make a setting look more expensive than one with more
 * runs. */
static void costs_are_compared_over_the_same_seeds(void **state)
{
    (void)state;
    ll_experiment *e = experiment(BURSTS);
    measured *all = measure_all(e);
    for (double limit = 0.6; limit < 3; limit += 1.1) {
        cJSON *answer;
        double half, cost;
        must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = limit}, &answer));
        const cJSON *advice = cJSON_GetObjectItem(answer, "advice");
        assert_false(cJSON_IsNull(advice));
        mean_error(e, cJSON_GetObjectItem(advice, "point")->valueint, 0, SEEDS, &half, &cost);
        assert_true(cost <= 1.02 * brute_force(e, all, limit));
        cJSON_Delete(answer);
    }
    free(all);
    ll_experiment_free(e);
}

/* Frames of random length: a setting that misses the limit on its seeds may hold on others. */
#define FRAMES                                                                                               \
    "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"damped\",\"params\":{\"omega\":3.5},\"frames\":"       \
    "\"random\","                                                                                            \
    "\"duration_s\":4,\"methods\":[{\"method\":\"rk2\",\"steps\":\"frame\"}]},\"repeats\":6,\"axes\":[{"     \
    "\"path\":"                                                                                              \
    "\"methods.0.method\",\"values\":[\"explicit_euler\",\"semi_implicit_euler\",\"velocity_verlet\","       \
    "\"rk4\"]},"                                                                                             \
    "{\"path\":\"frame_s\",\"from\":0.02,\"to\":0.3,\"count\":9,\"scale\":\"log\"},{\"path\":\"frame_"       \
    "jitter\","                                                                                              \
    "\"values\":[0.3,0.8]}],\"metrics\":[\"methods.0.e_max\",\"methods.0.evaluations\"]}"

static void proven_optima_are_optimal(void **state)
{
    (void)state;
    ll_experiment *e = experiment(FRAMES);
    measured *all = measure_all(e);
    int proven = 0;
    for (double limit = 0.05; limit < 3; limit *= 1.5) {
        cJSON *answer;
        double half, cost = INFINITY;
        must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = limit, .most_runs = 2 * e->runs},
                       &answer));
        const cJSON *advice = cJSON_GetObjectItem(answer, "advice");
        if (!cJSON_IsNull(advice))
            mean_error(e, cJSON_GetObjectItem(advice, "point")->valueint, 0, SEEDS, &half, &cost);
        if (strcmp(optimum(answer), "proven") == 0) {
            proven++;
            assert_true(cost <= 1.02 * brute_force(e, all, limit));
        }
        cJSON_Delete(answer);
    }
    assert_true(proven >= 2);
    free(all);
    ll_experiment_free(e);
}

/* Few shots miss because of rewinding: none in six runs does not prove a rate below one in three. */
static void few_runs_without_an_event_prove_no_rarity(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"behind_cover\",\"set\":{\"duration_s\":6},\"repeats\":4,\"axes\":[{\"path\":"
        "\"server.update_hz\",\"values\":[40,60]},{\"path\":\"server.max_rewind_ms\",\"values\":[250,300]}],"
        "\"metrics\":[\"players.1.shots.hitscan.false_misses\",\"players.1.bandwidth.down_bytes_per_s\"]}");
    for (int many = 0; many < 2; many++) {
        cJSON *answer;
        must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = 0.3, .most_runs = many ? 400 : 22},
                       &answer));
        const cJSON *advice = cJSON_GetObjectItem(answer, "advice");
        assert_int_equal(cJSON_IsNull(advice), !many);
        if (many) {
            const cJSON *verified = cJSON_GetObjectItem(advice, "verified");
            assert_true(cJSON_GetObjectItem(verified, "runs")->valueint >= 13);
            assert_true(cJSON_GetObjectItem(verified, "error_ci95")->valuedouble > 0);
        }
        cJSON_Delete(answer);
    }
    ll_experiment_free(e);
}

static void it_says_when_none_holds_and_how_near_it_came(void **state)
{
    (void)state;
    ll_experiment *e = experiment(MOTION("kepler", "5"));
    cJSON *answer;
    must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = 1e-14}, &answer));
    assert_true(cJSON_IsFalse(cJSON_GetObjectItem(answer, "holds")));
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(answer, "advice")));
    double nearest = cJSON_GetObjectItem(cJSON_GetObjectItem(answer, "nearest"), "error")->valuedouble;
    assert_true(nearest > 1e-14 && nearest < 1e-9); /* rk4 at small steps */
    cJSON_Delete(answer);
    ll_experiment_free(e);
}

static void it_answers_the_same_again(void **state)
{
    (void)state;
    ll_experiment *e = experiment(cases[4].text);
    char *texts[2];
    for (int i = 0; i < 2; i++) {
        cJSON *answer;
        must(ll_advise(&(ll_advise_request){.experiment = e, .max_error = 0.5}, &answer));
        texts[i] = cJSON_Print(answer);
        cJSON_Delete(answer);
    }
    assert_string_equal(texts[0], texts[1]);
    free(texts[0]);
    free(texts[1]);
    ll_experiment_free(e);
}

static void bad_requests_are_reported(void **state)
{
    (void)state;
    ll_experiment *e = experiment("{\"scenario\":\"race\",\"metrics\":[\"players.0.corrections\"]}");
    cJSON *answer;
    ll_status status = ll_advise(&(ll_advise_request){.experiment = e, .max_error = 1}, &answer);
    assert_true(status.code == LL_BAD_INPUT && strcmp(status.field, "cost") == 0);
    status = ll_advise(&(ll_advise_request){.experiment = e, .max_error = -1}, &answer);
    assert_true(status.code == LL_BAD_INPUT && strstr(status.text, "got -1"));
    ll_experiment_free(e);
}

int main(int count, char **arguments)
{
    long_ones = ll_test_many(count, arguments);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(advice_equals_brute_force),
        cmocka_unit_test(it_says_whether_the_optimum_is_proven),
        cmocka_unit_test(ties_go_to_the_least_error),
        cmocka_unit_test(costs_are_compared_over_the_same_seeds),
        cmocka_unit_test(proven_optima_are_optimal),
        cmocka_unit_test(few_runs_without_an_event_prove_no_rarity),
        cmocka_unit_test(it_says_when_none_holds_and_how_near_it_came),
        cmocka_unit_test(it_answers_the_same_again),
        cmocka_unit_test(bad_requests_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Families: their table, choices and checks on rows that are known, and seeds of measurement and check. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/advise/tradeoff.h"
#include "experiment/spec/metric_path.h"
#include "library/library.h"
#include "session/session.h"
#include "support/near.h"
#include "threads/clock.h"

static int64_t ticks;

static int64_t counting_clock(void)
{
    return ++ticks * 1000000;
}

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* ---- the table ---- */

static bool has_series(const ll_tradeoff_problem *problem)
{
    for (const ll_refinement_series *s = ll_refinement_series_table; s->scenario; s++)
        if (strcmp(s->scenario, problem->scenario) == 0 && strcmp(s->error, problem->error) == 0)
            return true;
    return false;
}

static void every_family_has_problems_and_two_costs(void **state)
{
    (void)state;
    int count = 0;
    for (const ll_tradeoff_family *f = ll_tradeoff_families; f->name; f++, count++) {
        assert_ptr_equal(ll_tradeoff_family_find(f->name), f);
        assert_true(ll_tradeoff_problem_count(f) > 0 && ll_tradeoff_cost_count(f) >= 2);
        assert_string_equal(f->costs[0].path, "cpu_s");
        char method[40];
        int first = 0;
        for (const char *list = f->first; ll_list_next(&list, method, sizeof method); first++) {
            const ll_tradeoff_request alone = {.methods = method};
            if (ll_tradeoff_steps(f, &alone) == 0)
                fail_msg("%s has no %s", f->name, method);
        }
        assert_in_range(first, 3, 6);
        for (int p = 0; p < ll_tradeoff_problem_count(f); p++)
            if (strcmp(f->name, "integrators") != 0 && !has_series(&f->problems[p]))
                fail_msg("%s: %s has no series", f->name, f->problems[p].scenario);
    }
    assert_int_equal(count, 8);
    assert_null(ll_tradeoff_family_find("magic"));
}

/* ---- choices ---- */

static const ll_tradeoff_family small = {.name = "small",
                                         .title = "Small",
                                         .text = "",
                                         .problems = {{"race", "error", "error"}},
                                         .costs = {{"cpu_s", "s"}, {"work", "work"}}};

static ll_measured around(double value, double half)
{
    return (ll_measured){value, value - half, value + half};
}

static ll_tradeoff_values values_of(double error, double cost, int64_t seed)
{
    return (ll_tradeoff_values){.error = around(error, error / 10),
                                .costs = {around(cost / 1000, cost / 1e5), around(cost, cost / 100)},
                                .seed = seed,
                                .seeds = 10};
}

static void fill(ll_tradeoff_row *row, const char *method, double error, double cost)
{
    *row = (ll_tradeoff_row){
        .random = true, .values = values_of(error, cost, 1), .again = values_of(error, cost, 11)};
    strcpy(row->method, method);
    strcpy(row->value, "1");
}

/* Bounds 11 and 0.011 on the front: levels 2, 0.35 and 0.062. */
static ll_tradeoff known(ll_tradeoff_row rows[5])
{
    fill(&rows[0], "coarse", 10, 1);
    fill(&rows[1], "middle", 0.3, 10);
    fill(&rows[2], "twin", 0.3, 10.1); /* as cheap */
    fill(&rows[3], "fine", 0.01, 100);
    fill(&rows[4], "bad", 0.2, 200);
    return (ll_tradeoff){.family = &small, .rows = rows, .count = 5};
}

static void choices_hold_where_the_check_agrees(void **state)
{
    (void)state;
    ll_tradeoff_row rows[5];
    ll_tradeoff t = known(rows);
    must(ll_tradeoff_choose(&t));
    assert_int_equal(t.choice_count, 6); /* of two costs */
    const bool front[] = {true, true, false, true, false};
    for (int i = 0; i < 5; i++)
        assert_true(rows[i].front[0] == front[i] && rows[i].front[1] == front[i]);
    const int chosen[] = {1, 1, 3};
    for (int i = 0; i < 6; i++) {
        const ll_tradeoff_choice *c = &t.choices[i];
        assert_int_equal(c->row, chosen[i % 3]);
        assert_int_equal(c->cheapest_again, c->row);
        assert_string_equal(ll_tradeoff_verdict(c), "holds");
        assert_string_equal(c->tied, i % 3 == 2 ? "" : "twin");
        assert_true(rows[c->row].values.error.high <= c->level);
    }
    assert_true(t.choices[0].level == 2);
    assert_near(t.choices[1].level, 0.35, 1e-12);
    free(t.choices);
}

static void choices_fail_with_the_figures(void **state)
{
    (void)state;
    ll_tradeoff_row rows[5];
    ll_tradeoff t = known(rows);
    rows[3].again.error.high = 0.07; /* not certainly within 0.062 any more */
    rows[4].again.costs[1] = around(5, 0.01);
    must(ll_tradeoff_choose(&t));
    assert_string_equal(ll_tradeoff_verdict(&t.choices[2]), "does not hold");
    assert_non_null(strstr(t.choices[2].why, "0.01, at most 0.07"));
    assert_string_equal(ll_tradeoff_verdict(&t.choices[0]), "holds"); /* time is as it was */
    assert_string_equal(ll_tradeoff_verdict(&t.choices[3]), "does not hold");
    assert_int_equal(t.choices[3].cheapest_again, 4);
    assert_non_null(strstr(t.choices[3].why, "bad 1 is cheaper: 5 against 10"));
    for (int i = 0; i < 5; i++)
        rows[i].again.seeds = 0;
    must(ll_tradeoff_choose(&t));
    assert_string_equal(ll_tradeoff_verdict(&t.choices[0]), "not checked");
    for (int i = 0; i < 5; i++)
        rows[i].values.error = (ll_measured){1, NAN, NAN};
    must(ll_tradeoff_choose(&t));
    assert_int_equal(t.choice_count, 0); /* nothing is known of the errors */
    free(t.choices);
}

/* ---- seeds ---- */

/* Mean of the error over runs of the engine alone. */
static double mean_error(const char *set_hitscan, int64_t first, int count)
{
    double sum = 0;
    for (int64_t seed = first; seed < first + count; seed++) {
        cJSON *json = NULL;
        ll_session *session = NULL;
        must(ll_scenario_load("scenarios", "behind_cover", &json));
        cJSON *server = cJSON_GetObjectItem(json, "server");
        cJSON_GetObjectItem(json, "duration_s")->valuedouble = 6;
        cJSON_ReplaceItemInObject(server, "hitscan", cJSON_CreateString(set_hitscan));
        cJSON_GetObjectItem(server, "max_rewind_ms")->valuedouble = 50;
        must(ll_session_create(json, seed, NULL, NULL, &session));
        must(ll_session_run_to(session, ll_session_get_info(session).end_tick));
        cJSON *report = ll_session_metrics(session);
        sum +=
            ll_metric_value(cJSON_GetObjectItem(report, "metrics"), "players.1.shots.hitscan.false_misses");
        cJSON_Delete(report);
        cJSON_Delete(json);
        ll_session_destroy(session);
    }
    return sum / count;
}

static void the_check_has_other_seeds_than_the_measurement(void **state)
{
    (void)state;
    enum { SEEDS = 12, CHECK = 10 };
    ll_tradeoff t;
    const ll_tradeoff_request request = {.scenarios = "scenarios",
                                         .duration = "6",
                                         .methods = "rewind,none",
                                         .seeds = SEEDS,
                                         .check_seeds = CHECK,
                                         .now_ns = counting_clock};
    must(ll_tradeoff_measure(ll_tradeoff_family_find("lag_compensation"), &request, &t));
    assert_int_equal(t.count, 8);
    for (int i = 0; i < t.count; i++) {
        const ll_tradeoff_values *v = &t.rows[i].values, *again = &t.rows[i].again;
        assert_true(v->seed == 1 && v->seeds == SEEDS && v->runs == SEEDS);
        assert_true(again->seed == v->seed + v->seeds && again->seeds == CHECK);
        assert_true(v->error.low <= v->error.value && v->error.value <= v->error.high);
        for (int c = 0; c < 4; c++)
            assert_true(v->costs[c].value >= 0 && again->costs[c].value >= 0);
    }
    const ll_tradeoff_row *row = &t.rows[4];
    assert_string_equal(row->method, "rewind");
    assert_string_equal(row->sets, "duration_s=6 server.hitscan=rewind server.max_rewind_ms=50");
    assert_near(row->values.error.value, mean_error("rewind", 1, SEEDS), 1e-9);
    assert_near(row->again.error.value, mean_error("rewind", 1 + SEEDS, CHECK), 1e-9);
    assert_true(row->values.error.value != row->again.error.value);
    ll_tradeoff_free(&t);
}

static void a_family_without_the_method_is_refused(void **state)
{
    (void)state;
    ll_tradeoff t;
    const ll_tradeoff_request request = {
        .scenarios = "scenarios", .methods = "magic", .seeds = 10, .now_ns = counting_clock};
    ll_status status = ll_tradeoff_measure(ll_tradeoff_family_find("oceans"), &request, &t);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_non_null(strstr(status.text, "magic"));
    ll_tradeoff_free(&t);
}

/* ---- steps and interrupts ---- */

static int64_t questions, asked_most;

static bool go_on(void *context)
{
    (void)context;
    return ++questions < asked_most;
}

/* All settings, as far as it gets. */
static ll_status work(ll_tradeoff_run *run, const ll_interrupt *interrupt)
{
    ll_status status;
    while (ll_tradeoff_next(run, interrupt, &status))
        ;
    return status;
}

/* Runs it whole, then ends it at questions in between. */
static void count_and_interrupt(const char *family, const char *methods, const char *duration)
{
    ll_tradeoff_run *run;
    const ll_interrupt interrupt = {go_on, counting_clock, NULL};
    ll_tradeoff_request request = {.scenarios = "scenarios",
                                   .duration = duration,
                                   .methods = methods,
                                   .seeds = 10,
                                   .check_seeds = 10,
                                   .now_ns = counting_clock};
    const ll_tradeoff_family *of = ll_tradeoff_family_find(family);
    questions = 0;
    asked_most = INT64_MAX;
    must(ll_tradeoff_open(of, &request, &run));
    must(work(run, &interrupt));
    int64_t steps = ll_tradeoff_steps(of, &request), all = questions;
    assert_true(steps > 0 && ll_tradeoff_done(run) == steps && all > 10);
    ll_tradeoff_close(run);
    for (int part = 1; part < 8; part++) {
        questions = 0;
        asked_most = all * part / 8;
        must(ll_tradeoff_open(of, &request, &run));
        assert_int_equal(work(run, &interrupt).code, LL_INTERRUPTED);
        assert_true(questions >= asked_most && questions < all);
        ll_status status;
        assert_false(ll_tradeoff_next(run, NULL, &status)); /* for other threads too */
        assert_false(ll_failed(&status));
        ll_tradeoff_close(run);
    }
    request.check_seeds = 0;
    assert_int_equal(2 * ll_tradeoff_steps(of, &request), steps);
    request.methods = "magic";
    assert_int_equal(ll_tradeoff_steps(of, &request), 0);
}

static void steps_are_counted_and_an_interrupt_ends_it(void **state)
{
    (void)state;
    count_and_interrupt("integrators", "rk4,radau5", "0.2");
    count_and_interrupt("contact_solvers", "xpbd", "0.1");
}

/* ---- the rows so far ---- */

static int rows_of(const ll_tradeoff *t, const char *method, const char *value)
{
    int n = 0;
    for (int i = 0; i < t->count; i++)
        n += strcmp(t->rows[i].method, method) == 0 && (!value || strcmp(t->rows[i].value, value) == 0);
    return n;
}

static void coarse_settings_of_all_methods_come_first_and_the_check_last(void **state)
{
    (void)state;
    ll_tradeoff_run *run;
    ll_tradeoff t;
    ll_status status;
    const ll_tradeoff_family *of = ll_tradeoff_family_find("contact_solvers");
    const ll_tradeoff_request request = {.scenarios = "scenarios",
                                         .duration = "0.1",
                                         .methods = "xpbd,soft_step",
                                         .seeds = 10,
                                         .check_seeds = 10,
                                         .now_ns = counting_clock};
    must(ll_tradeoff_open(of, &request, &run));
    must(ll_tradeoff_so_far(run, &t));
    assert_true(t.count == 0 && t.choice_count == 0);
    ll_tradeoff_free(&t);
    for (int i = 0; i < 4; i++) /* two methods of two problems */
        assert_true(ll_tradeoff_next(run, NULL, &status));
    must(ll_tradeoff_so_far(run, &t));
    assert_int_equal(t.count, 4);
    assert_int_equal(rows_of(&t, "xpbd", "1"), 2);
    assert_int_equal(rows_of(&t, "soft_step", "1"), 2);
    assert_true(t.rows[0].problem == 0 && t.rows[3].problem == 1); /* in the order of the family */
    assert_true(t.rows[0].values.runs == 3 && t.rows[0].again.seeds == 0);
    ll_tradeoff_free(&t);
    while (ll_tradeoff_done(run) < ll_tradeoff_steps(of, &request) - 1)
        assert_true(ll_tradeoff_next(run, NULL, &status));
    must(ll_tradeoff_so_far(run, &t));
    assert_int_equal(t.count, 22); /* six and five settings */
    assert_true(t.choice_count > 0);
    for (int i = 0; i < t.choice_count; i++) /* some are measured again, not all */
        assert_string_equal(ll_tradeoff_verdict(&t.choices[i]), "not checked");
    ll_tradeoff_free(&t);
    must(work(run, NULL));
    must(ll_tradeoff_so_far(run, &t));
    for (int i = 0; i < t.choice_count; i++)
        assert_true(t.choices[i].checked);
    ll_tradeoff_free(&t);
    ll_tradeoff_close(run);
}

static void *work_too(void *run)
{
    must(work(run, NULL));
    return NULL;
}

static void two_threads_measure_what_one_does(void **state)
{
    (void)state;
    ll_tradeoff alone, both;
    ll_tradeoff_run *run;
    pthread_t threads[2];
    const ll_tradeoff_family *of = ll_tradeoff_family_find("integrators");
    const ll_tradeoff_request request = {.scenarios = "scenarios",
                                         .duration = "0.5",
                                         .methods = "rk4,dopri5,velocity_verlet",
                                         .seeds = 10,
                                         .now_ns = ll_thread_cpu_ns};
    must(ll_tradeoff_measure(of, &request, &alone));
    must(ll_tradeoff_open(of, &request, &run));
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, work_too, run), 0);
    for (int i = 0; i < 2; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(ll_tradeoff_done(run), ll_tradeoff_steps(of, &request));
    must(ll_tradeoff_so_far(run, &both));
    assert_true(alone.count > 50 && both.count == alone.count);
    for (int i = 0; i < alone.count; i++) {
        const ll_tradeoff_row *a = &alone.rows[i], *b = &both.rows[i];
        assert_string_equal(a->sets, b->sets);
        assert_memory_equal(&a->values.error, &b->values.error, sizeof a->values.error);
        assert_true(a->values.costs[1].value == b->values.costs[1].value && b->values.runs >= 1);
    }
    ll_tradeoff_free(&alone);
    ll_tradeoff_free(&both);
    ll_tradeoff_close(run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_family_has_problems_and_two_costs),
        cmocka_unit_test(choices_hold_where_the_check_agrees),
        cmocka_unit_test(choices_fail_with_the_figures),
        cmocka_unit_test(the_check_has_other_seeds_than_the_measurement),
        cmocka_unit_test(a_family_without_the_method_is_refused),
        cmocka_unit_test(steps_are_counted_and_an_interrupt_ends_it),
        cmocka_unit_test(coarse_settings_of_all_methods_come_first_and_the_check_last),
        cmocka_unit_test(two_threads_measure_what_one_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

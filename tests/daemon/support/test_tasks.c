/* Turns rotate, budgets and disconnecting clients stop tasks, and draining stops all. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "daemon/support/tasks.h"

static int64_t now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000 + t.tv_nsec / 1000000;
}

static void burn(int64_t ns)
{
    struct timespec t, from;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
    do
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    while ((int64_t)(t.tv_sec - from.tv_sec) * 1000000000 + t.tv_nsec - from.tv_nsec < ns);
}

typedef struct job {
    atomic_llong pieces; /* of half a millisecond */
    long long most;      /* 0: until it is stopped */
    atomic_int ending;   /* reason of its end */
    atomic_bool over;
    ll_status told;
    const struct job *others; /* whose pieces it counts while it runs: who waits for its end may be late */
    int other_count;
    long long meanwhile;
} job;

static long long pieces_of_others(const job *j)
{
    long long sum = 0;
    for (int i = 0; i < j->other_count; i++)
        sum += atomic_load(&j->others[i].pieces);
    return sum;
}

static void run(void *context, ll_task *task)
{
    job *j = context;
    long long before = pieces_of_others(j);
    while (ll_task_yield(task) && (j->most == 0 || atomic_load(&j->pieces) < j->most)) {
        burn(500000);
        atomic_fetch_add(&j->pieces, 1);
    }
    j->meanwhile = pieces_of_others(j) - before;
    atomic_store(&j->ending, (int)ll_task_end_reason(task));
    j->told = ll_task_error(task, "it was here");
    atomic_store(&j->over, true);
}

static ll_tasks *tasks; /* of the test that runs */

static ll_status add(const char *client, const char *session, double budget_s, job *j, ll_task **task)
{
    ll_task_spec order = {.budget_s = budget_s, .run = run, .context = j};
    snprintf(order.client, sizeof order.client, "%s", client);
    snprintf(order.session, sizeof order.session, "%s", session);
    return ll_tasks_add(tasks, &order, task);
}

static void wait_for(atomic_bool *what)
{
    int64_t until = now_ms() + 60000;
    while (!atomic_load(what)) {
        assert_true(now_ms() < until);
        usleep(1000);
    }
}

/* A task is counted after its `run` has returned, so a little later than `over`. */
static void wait_for_ended(uint64_t count)
{
    int64_t until = now_ms() + 60000;
    while (ll_tasks_get_stats(tasks).ended < count && now_ms() < until)
        usleep(1000);
    assert_int_equal(ll_tasks_get_stats(tasks).ended, count);
}

static void wait_for_done(uint64_t count)
{
    int64_t until = now_ms() + 60000;
    while (ll_tasks_get_stats(tasks).done < count && now_ms() < until)
        usleep(1000);
    assert_int_equal(ll_tasks_get_stats(tasks).done, count);
}

static void begin(int turns)
{
    ll_status status = ll_tasks_start(turns, &tasks);
    assert_false(ll_failed(&status));
}

/* After a failed test, too: its tasks go on until then, so their jobs are static. */
static int end(void **state)
{
    (void)state;
    if (tasks != NULL)
        ll_tasks_free(tasks);
    tasks = NULL;
    return 0;
}

static void test_a_budget_is_kept(void **state)
{
    (void)state;
    begin(1);
    static job j = {0};
    add("a", "s", 0.05, &j, NULL);
    wait_for(&j.over);
    assert_int_equal(atomic_load(&j.ending), LL_TASK_OVER_BUDGET);
    assert_in_range(atomic_load(&j.pieces), 60, 110); /* of half a millisecond */
    assert_int_equal(j.told.code, LL_INTERRUPTED);
    assert_non_null(strstr(j.told.text, "0.05 s"));
    assert_non_null(strstr(j.told.text, "it was here"));
}

/* Eleven tasks of one client and one of another: each client gets half of the time. */
static void test_turns_go_round_clients(void **state)
{
    (void)state;
    begin(1);
    static job many[11], one = {.most = 300, .others = many, .other_count = 11};
    for (int i = 0; i < 11; i++)
        add("many", i % 2 ? "x" : "y", 0, &many[i], NULL);
    usleep(50000);
    add("one", "z", 0, &one, NULL);
    wait_for(&one.over);
    assert_in_range(one.meanwhile, 200, 450);
}

static void test_turns_go_round_sessions(void **state)
{
    (void)state;
    begin(1);
    static job many[7], one = {.most = 300, .others = many, .other_count = 7};
    for (int i = 0; i < 7; i++)
        add("c", "busy", 0, &many[i], NULL);
    add("c", "other", 0, &one, NULL);
    wait_for(&one.over);
    assert_in_range(one.meanwhile, 200, 450);
}

/* A client that adds tasks again and again does not come before one that waits. */
static void test_coming_again_is_no_advantage(void **state)
{
    (void)state;
    begin(1);
    static job patient = {0}, again[40];
    add("patient", "s", 0, &patient, NULL);
    for (int i = 0; i < 40; i++) {
        again[i].most = 10;
        add("again", "s", 0, &again[i], NULL);
        wait_for(&again[i].over);
    }
    assert_true(atomic_load(&patient.pieces) >= 300);
}

/* Clients come and go, the first of several first or last: what is kept of each ends with its last task. */
static void test_clients_that_have_gone_are_forgotten(void **state)
{
    (void)state;
    enum { ROUNDS = 6, CLIENTS = 4 };
    static job all[ROUNDS][CLIENTS];
    begin(2);
    uint64_t done = 0;
    for (int round = 0; round < ROUNDS; round++) {
        job *j = all[round];
        for (int i = 0; i < CLIENTS; i++) {
            char name[32];
            snprintf(name, sizeof name, "%d of %d", i, round % 2);
            j[i].most = 1 + (round + i) % CLIENTS * 4;
            assert_int_equal(add(name, name, 0, &j[i], NULL).code, LL_OK);
        }
        for (int i = 0; i < CLIENTS; i++)
            wait_for(&j[i].over);
        wait_for_done(done += CLIENTS);
    }
}

static void test_a_task_is_stopped(void **state)
{
    (void)state;
    begin(2);
    static job j[3] = {0};
    ll_task *task[3];
    for (int i = 0; i < 3; i++)
        add("a", "s", 0, &j[i], &task[i]);
    for (int i = 0; i < 3; i++)
        ll_task_stop(task[i], LL_TASK_CLIENT_GONE);
    for (int i = 0; i < 3; i++) {
        wait_for(&j[i].over);
        assert_int_equal(atomic_load(&j[i].ending), LL_TASK_CLIENT_GONE);
    }
    wait_for_ended(3);
}

static void test_one_client_has_a_limit(void **state)
{
    (void)state;
    enum { MOST_OF_CLIENT = 128 };
    begin(1);
    static job j[MOST_OF_CLIENT + 2];
    for (int i = 0; i < MOST_OF_CLIENT; i++) {
        ll_status status = add("greedy", "s", 0, &j[i], NULL);
        assert_false(ll_failed(&status));
    }
    assert_int_equal(add("greedy", "t", 0, &j[MOST_OF_CLIENT], NULL).code, LL_LIMIT);
    assert_int_equal(add("other", "t", 0, &j[MOST_OF_CLIENT + 1], NULL).code, LL_OK);
    end(NULL);
    for (int i = 0; i < MOST_OF_CLIENT;
         i++) /* each `run` is called once, also of tasks that never had a turn */
        assert_true(atomic_load(&j[i].over));
}

/* Other clients have as many as there may be, all started that may be. */
static void test_many_tasks_do_not_keep_out_others(void **state)
{
    (void)state;
    enum { CLIENTS = 4, EACH = 128, MOST_STARTED = 128 };
    begin(2);
    static job j[CLIENTS * EACH + 2];
    int started = 0;
    for (int i = 0; i < CLIENTS * EACH; i++) {
        char client[16], session[16];
        snprintf(client, sizeof client, "greedy %d", i % CLIENTS);
        snprintf(session, sizeof session, "s%d", i);
        assert_int_equal(add(client, session, 0, &j[i], NULL).code, LL_OK);
    }
    for (int64_t until = now_ms() + 60000; started < MOST_STARTED && now_ms() < until; usleep(10000)) {
        started = 0;
        for (int i = 0; i < CLIENTS * EACH; i++)
            started += atomic_load(&j[i].pieces) > 0;
    }
    assert_int_equal(started, MOST_STARTED);
    job *modest = &j[CLIENTS * EACH], *more = modest + 1;
    modest->most = 1;
    assert_int_equal(add("modest", "", 0, modest, NULL).code, LL_OK);
    wait_for(&modest->over);
    assert_int_equal(add("greedy 0", "", 0, more, NULL).code, LL_LIMIT);
}

static void hog(void *context, ll_task *task)
{
    (void)task;
    burn(800000000); /* and does not yield */
    atomic_store(&((job *)context)->over, true);
}

/* As many tasks that do not yield as there are turns: others continue meanwhile. */
static void test_a_long_piece_does_not_keep_a_turn(void **state)
{
    (void)state;
    begin(2);
    static job hogs[2] = {0}, short_one = {.most = 20};
    for (int i = 0; i < 2; i++) {
        ll_task_spec order = {.client = "hog", .run = hog, .context = &hogs[i]};
        ll_tasks_add(tasks, &order, NULL);
    }
    usleep(20000);
    add("other", "s", 0, &short_one, NULL);
    wait_for(&short_one.over);
    assert_false(atomic_load(&hogs[0].over) && atomic_load(&hogs[1].over));
    assert_int_equal(ll_tasks_get_stats(tasks).waiting, 0);
}

/* A queue that goes on is not stalled, however long one of it waits. */
static void test_a_queue_that_goes_on_is_not_stalled(void **state)
{
    (void)state;
    begin(1);
    static job j[30];
    for (int i = 0; i < 30; i++) {
        char session[16]; /* of one, only a few tasks are started */
        snprintf(session, sizeof session, "s%d", i);
        add("a", session, 0, &j[i], NULL); /* slices of 10 ms: each waits for 29 others */
    }
    int good = 0, late = 0; /* on a busy machine the queue itself may wait for a processor */
    for (int64_t until = now_ms() + 60000; good + late < 50 && now_ms() < until; usleep(5000)) {
        ll_tasks_stats stats = ll_tasks_get_stats(tasks);
        if (stats.longest_s > 0.1 && stats.longest_s > 2 * stats.stalled_s)
            good++;
        else if (stats.longest_s > 0.1)
            late++;
    }
    assert_int_equal(good + late, 50);
    assert_true(good > late);
}

static void test_draining_ends_all(void **state)
{
    (void)state;
    begin(2);
    static job j[60];
    for (int i = 0; i < 60; i++)
        add(i % 2 ? "a" : "b", "s", 0, &j[i], NULL);
    usleep(30000);
    ll_tasks_drain(tasks);
    assert_int_equal(add("c", "s", 0, &j[0], NULL).code, LL_UNAVAILABLE);
    for (int i = 0; i < 60; i++) {
        wait_for(&j[i].over);
        assert_int_equal(atomic_load(&j[i].ending), LL_TASK_STOPPED);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_a_budget_is_kept, end),
        cmocka_unit_test_teardown(test_turns_go_round_clients, end),
        cmocka_unit_test_teardown(test_turns_go_round_sessions, end),
        cmocka_unit_test_teardown(test_coming_again_is_no_advantage, end),
        cmocka_unit_test_teardown(test_clients_that_have_gone_are_forgotten, end),
        cmocka_unit_test_teardown(test_a_task_is_stopped, end),
        cmocka_unit_test_teardown(test_one_client_has_a_limit, end),
        cmocka_unit_test_teardown(test_many_tasks_do_not_keep_out_others, end),
        cmocka_unit_test_teardown(test_a_long_piece_does_not_keep_a_turn, end),
        cmocka_unit_test_teardown(test_a_queue_that_goes_on_is_not_stalled, end),
        cmocka_unit_test_teardown(test_draining_ends_all, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

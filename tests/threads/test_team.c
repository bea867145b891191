/* A team does every part of every job once, and its threads end with it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <string.h>
#include <time.h>

#include "threads/team.h"

static void ok(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

typedef struct marks {
    int32_t count;
    uint8_t at[1000]; /* how often each element was done */
    int done[LL_TEAM_PARTS_MAX], parts;
} marks;

static void mark(void *context, int part, int parts)
{
    marks *m = context;
    ll_share of = ll_share_of(m->count, part, parts);
    for (int32_t i = of.begin; i < of.end; i++)
        m->at[i]++;
    m->done[part]++;
    if (part == 0)
        m->parts = parts;
}

static void each_element_once(void **state)
{
    (void)state;
    static const int teams[] = {1, 2, 3, 7, LL_TEAM_PARTS_MAX};
    for (size_t t = 0; t < sizeof teams / sizeof *teams; t++) {
        ll_team *team;
        ok(ll_team_make(teams[t], &team));
        for (int32_t count = 0; count <= 1000; count += 37) {
            marks m = {.count = count};
            ll_team_run(team, count, 0, mark, &m);
            assert_int_equal(m.parts, teams[t]);
            for (int32_t i = 0; i < 1000; i++)
                assert_int_equal(m.at[i], i < count);
            for (int i = 0; i < LL_TEAM_PARTS_MAX; i++)
                assert_int_equal(m.done[i], i < teams[t]);
        }
        ll_team_free(team);
    }
}

static void few_elements_and_no_team_use_one_thread(void **state)
{
    (void)state;
    ll_team *team;
    marks small = {.count = 99}, alone = {.count = 99};
    ok(ll_team_make(4, &team));
    ll_team_run(team, 99, 100, mark, &small);
    ll_team_run(NULL, 99, 0, mark, &alone);
    assert_int_equal(small.parts, 1);
    assert_int_equal(alone.parts, 1);
    assert_int_equal(ll_team_parts(NULL), 1);
    ll_team_free(team);
}

static void add(void *context, int part, int parts)
{
    (void)parts;
    ((int64_t *)context)[8 * part]++; /* a cache line each */
}

/* What a part has written is seen by the caller, and by any part of the next job. */
static void a_chain_of_jobs(void **state)
{
    (void)state;
    ll_team *team;
    int64_t sums[8 * 3] = {0};
    ok(ll_team_make(3, &team));
    for (int i = 1; i <= 20000; i++) {
        team->run(team, add, sums);
        for (int part = 0; part < 3; part++)
            assert_int_equal(sums[8 * part], i);
    }
    ll_team_free(team);
}

static void a_team_that_sleeps_wakes(void **state)
{
    (void)state;
    ll_team *team;
    int64_t sums[8 * 2] = {0};
    const struct timespec rest = {.tv_nsec = 20000000};
    ok(ll_team_make(2, &team));
    for (int i = 1; i <= 5; i++) {
        nanosleep(&rest, NULL);
        team->run(team, add, sums);
        assert_int_equal(sums[8], i);
    }
    nanosleep(&rest, NULL);
    ll_team_free(team); /* from sleep */
}

static int threads_now(void)
{
    int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    assert_non_null(tasks);
    for (struct dirent *entry; (entry = readdir(tasks)) != NULL;)
        count += entry->d_name[0] != '.';
    closedir(tasks);
    return count;
}

/* pthread_join returns when the kernel clears the thread's id, which is before the thread leaves /proc. */
static bool threads_become(int count)
{
    const struct timespec rest = {.tv_nsec = 1000000};
    for (int tries = 0; tries < 10000 && threads_now() != count; tries++)
        nanosleep(&rest, NULL);
    return threads_now() == count;
}

#ifdef __SANITIZE_THREAD__
enum { OTHERS = 2 }; /* the sanitizer has a thread of its own from the first one on */
#else
enum { OTHERS = 1 };
#endif

static void threads_end_with_their_team(void **state)
{
    (void)state;
    ll_team *team;
    ok(ll_team_make(2, &team));
    ll_team_free(team);
    assert_true(threads_become(OTHERS));
    ok(ll_team_make(5, &team));
    assert_int_equal(threads_now(), OTHERS + 4);
    ll_team_free(team);
    assert_true(threads_become(OTHERS));
    ll_team_free(NULL);
}

static void counts_out_of_range_are_refused(void **state)
{
    (void)state;
    static const int wrong[] = {-1, 0, LL_TEAM_PARTS_MAX + 1};
    for (int i = 0; i < 3; i++) {
        ll_team *team = (ll_team *)(uintptr_t)1;
        ll_status status = ll_team_make(wrong[i], &team);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_null(team);
        assert_non_null(strstr(status.text, "1 to 16"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_end_with_their_team),
        cmocka_unit_test(each_element_once),
        cmocka_unit_test(few_elements_and_no_team_use_one_thread),
        cmocka_unit_test(a_chain_of_jobs),
        cmocka_unit_test(a_team_that_sleeps_wakes),
        cmocka_unit_test(counts_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

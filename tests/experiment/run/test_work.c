/* Threads that work on a store. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <time.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/run/work.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* One run of twenty million steps. */
static ll_experiment *long_run(void)
{
    static const char text[] =
        "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":200,"
        "\"methods\":[{\"method\":\"rk4\",\"dt_s\":1e-5}]},\"metrics\":[\"methods.0.e_final\"]}";
    ll_experiment *e;
    cJSON *json = cJSON_Parse(text);
    must(ll_experiment_parse(json, "scenarios", NULL, &e));
    cJSON_Delete(json);
    return e;
}

/* It is in a store in memory. */
static ll_result_store *store_of(char id[LL_EXPERIMENT_ID_MAX + 1])
{
    ll_result_store *store;
    ll_experiment *e = long_run();
    must(ll_result_store_open(":memory:", &store));
    must(ll_experiment_register(store, e, 0, 1, id));
    ll_experiment_free(e);
    return store;
}

/* Until the workers have claimed the only chunk: another claim of it is given back. */
static void wait_for_claim(ll_workers *workers, ll_result_store *store, const char *id)
{
    ll_chunk chunk;
    for (;;) {
        must(ll_result_store_claim(store, id, &chunk));
        if (chunk.chunk < 0)
            return;
        ll_result_store_return(store, &chunk);
        ll_workers_notify(workers);
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
}

/* A stopped worker interrupts its run; its chunk is free at once. */
static void stopped_workers_return_their_chunk(void **state)
{
    (void)state;
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_chunk chunk;
    ll_workers *workers;
    ll_result_store *store = store_of(id);
    ll_workers_config config = {.store = store, .id = id, .threads = 1};
    must(ll_workers_start(&config, &workers));
    wait_for_claim(workers, store, id);
    must(ll_workers_stop(workers));
    must(ll_result_store_claim(store, id, &chunk));
    assert_int_equal(chunk.chunk, 0);
    ll_result_store_close(store);
}

static void chunks_keep_threads_busy(void **state)
{
    (void)state;
    ll_experiment *e = long_run();
    assert_int_equal(ll_experiment_chunk(e, 12800), 100);
    assert_int_equal(ll_experiment_chunk(e, 100), 1);
    assert_int_equal(ll_experiment_chunk(e, 1), 1);
    assert_int_equal(ll_experiment_chunk(e, 10000000), 5000);
    ll_experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stopped_workers_return_their_chunk),
        cmocka_unit_test(chunks_keep_threads_busy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

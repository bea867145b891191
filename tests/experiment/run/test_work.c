/* Workers on a shared store. */
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

/* One run of twenty million steps, in a store in memory. */
static ll_result_store *store_of(char id[LL_EXPERIMENT_ID_MAX + 1])
{
    static const char text[] =
        "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":200,"
        "\"methods\":[{\"method\":\"rk4\",\"dt_s\":1e-5}]},\"metrics\":[\"methods.0.e_final\"]}";
    ll_experiment *e;
    ll_result_store *store;
    cJSON *json = cJSON_Parse(text);
    must(ll_experiment_parse(json, "scenarios", &e));
    must(ll_result_store_open("sqlite::memory:", &store));
    must(ll_experiment_register(store, e, 0, 1, 0, id));
    ll_experiment_free(e);
    cJSON_Delete(json);
    return store;
}

static ll_workers *start(ll_result_store *store, const char *id)
{
    ll_workers *workers;
    ll_workers_config config = {.store = store, .id = id, .threads = 1, .lease_s = 1.5, .drain = true};
    must(ll_workers_start(&config, &workers));
    return workers;
}

static ll_experiment_record wait_for_claim(ll_result_store *store, const char *id)
{
    ll_experiment_record record;
    do {
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        must(store->kind->record(store, id, &record));
    } while (record.leased == 0 && record.done == 0);
    return record;
}

/* The run takes several leases; no other worker gets its chunk meanwhile. */
static void a_run_longer_than_its_lease_is_not_lost(void **state)
{
    (void)state;
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_result_store *store = store_of(id);
    ll_workers *workers = start(store, id);
    ll_experiment_record record = wait_for_claim(store, id);
    while (record.done == 0) {
        ll_lease lease;
        must(store->kind->claim(store, id, "other", 60, &lease));
        assert_true(lease.chunk < 0);
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
        must(store->kind->record(store, id, &record));
    }
    must(ll_workers_join(workers));
    ll_result_store_close(store);
}

/* A stopped worker interrupts its run; its chunk is free at once, without counting the attempt. */
static void stopped_workers_return_their_chunk(void **state)
{
    (void)state;
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_lease lease;
    ll_result_store *store = store_of(id);
    ll_workers *workers = start(store, id);
    wait_for_claim(store, id);
    must(ll_workers_stop(workers));
    must(store->kind->claim(store, id, "other", 60, &lease));
    assert_true(lease.chunk == 0 && lease.attempt == 1);
    ll_result_store_close(store);
}

/* Two seconds each, but neither so small that the queue becomes slow, nor so large that threads are idle. */
static void chunks_take_seconds(void **state)
{
    (void)state;
    assert_int_equal(ll_chunk_size(12800, 0), 100);
    assert_int_equal(ll_chunk_size(12800, 0.001), 100);
    assert_int_equal(ll_chunk_size(12800, 0.1), 20);
    assert_int_equal(ll_chunk_size(12800, 10), 7);
    assert_int_equal(ll_chunk_size(100, 10), 1);
    assert_int_equal(ll_chunk_size(1, 0), 1);
    assert_int_equal(ll_chunk_size(10000000, 1e-6), 5000);
    assert_int_equal(ll_chunk_size(10000000, 1), 5000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_longer_than_its_lease_is_not_lost),
        cmocka_unit_test(stopped_workers_return_their_chunk),
        cmocka_unit_test(chunks_take_seconds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

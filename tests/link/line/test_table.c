/* Valid and invalid parameters of a link. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "link/harness.h"
#include "link/stages/stage.h"

static ll_status parse(const char *text, ll_link_params *params)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    *params = link_params();
    ll_status status = ll_param_parse(&ll_link_table, json, params);
    cJSON_Delete(json);
    return status;
}

static void the_table_is_sound(void **state)
{
    (void)state;
    assert_string_equal(ll_param_table_valid(&ll_link_table).text, "");
}

/* By default nothing is drawn, so that nothing costs. */
static void defaults_are_plain(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    assert_false(ll_stages_any(&params));
    assert_int_equal(ll_stages_used(&params), 0);
    assert_true(ll_link_delay_max_ms(&params, 12) == 12);
}

/* Each row that switches a stage on; the two ways to ask agree. */
static void stages_are_used_by_their_rows(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        uint32_t stage, more;
    } cases[] = {{"{\"loss_pct\":1}", 1U << LL_STAGE_LOSS, 0},
                 {"{\"loss_model\":\"gemodel\"}", 1U << LL_STAGE_LOSS, 0},
                 {"{\"loss_model\":\"state\"}", 1U << LL_STAGE_LOSS, 0},
                 {"{\"blackout_length_ms\":1}", 1U << LL_STAGE_LOSS, 0},
                 {"{\"duplicate_pct\":1}", 1U << LL_STAGE_DUPLICATE, 0},
                 {"{\"jitter_ms\":1}", 1U << LL_STAGE_DELAY, 0},
                 {"{\"spike_length_ms\":1}", 1U << LL_STAGE_DELAY, 0},
                 {"{\"rate_kbps\":1}", 1U << LL_STAGE_RATE, 1U << LL_STAGE_LIMIT},
                 {"{\"delay_ms\":1,\"reorder_pct\":1}", 1U << LL_STAGE_REORDER, 0},
                 {"{\"corrupt_pct\":1}", 1U << LL_STAGE_CORRUPT, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_link_params params;
        assert_string_equal(parse(cases[i].text, &params).text, "");
        assert_true(ll_stages_any(&params));
        assert_int_equal(ll_stages_used(&params), cases[i].stage | cases[i].more);
    }
}

static void contradictory_parameters_are_rejected(void **state)
{
    (void)state;
    static const struct {
        const char *text, *field, *sentence;
    } cases[] = {
        {"{\"reorder_pct\":5}", "reorder_pct",
         "reorder_pct: must be 0 where delay_ms, jitter_ms and rate_kbps are 0, since a reordered packet "
         "goes without that delay; got 5"},
        {"{\"reorder_pct\":5,\"delay_ms\":20,\"order\":\"fifo\"}", "reorder_pct",
         "reorder_pct: must be 0 where order is fifo; got 5"},
        {"{\"reorder_gap\":5}", "reorder_gap", "reorder_gap: must be 1 where reorder_pct is 0; got 5"},
        {"{\"loss_model\":\"state\",\"p13_pct\":60,\"p14_pct\":50}", "p14_pct",
         "p14_pct: must be at most 100 % together with p13_pct, 60 %; got 50"},
        {"{\"loss_model\":\"state\",\"p32_pct\":1}", "p32_pct",
         "p32_pct: must be at most 100 % together with p31_pct, 100 %; got 1"},
        {"{\"spike_every_ms\":1000,\"spike_length_ms\":1001}", "spike_length_ms",
         "spike_length_ms: must be at most spike_every_ms, 1000 ms; got 1001"},
        {"{\"blackout_every_ms\":10,\"blackout_length_ms\":20}", "blackout_length_ms",
         "blackout_length_ms: must be at most blackout_every_ms, 10 ms; got 20"},
        {"{\"delay_corr_pct\":100}", "delay_corr_pct", "delay_corr_pct: must be 0 to 99 %; got 100"},
        {"{\"mtu_bytes\":63}", "mtu_bytes", "mtu_bytes: must be 0 or 64 to 65507 B; got 63"},
        {"{\"mtu_bytes\":65508}", "mtu_bytes",
         "mtu_bytes: must be a whole number from 0 to 65507 B; got 65508"},
        {"{\"reorder_gap\":0}", "reorder_gap", "reorder_gap: must be a whole number from 1 to 1000; got 0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_link_params params;
        ll_status status = parse(cases[i].text, &params);
        assert_string_equal(status.text, cases[i].sentence);
        assert_string_equal(status.field, cases[i].field);
        assert_int_equal(status.code, LL_BAD_INPUT);
    }
}

/* Rows of a model that is not chosen, and rows that only qualify others, have no effect and are not
 * rejected. */
static void unused_parameters_may_be_set(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "{\"p13_pct\":60,\"p14_pct\":50,\"ge_p_pct\":30}",
        "{\"loss_model\":\"gemodel\",\"loss_pct\":5,\"p32_pct\":5}",
        "{\"loss_corr_pct\":50,\"duplicate_corr_pct\":50,\"reorder_corr_pct\":50,\"corrupt_corr_pct\":50}",
        "{\"spike_add_ms\":500,\"spike_every_ms\":100,\"limit_ms\":1000,\"limit_packets\":3}",
        "{\"spike_length_ms\":2000,\"blackout_length_ms\":3000}",
        "{\"rate_kbps\":100,\"reorder_pct\":5}",
        "{\"mtu_bytes\":0}",
        "{\"mtu_bytes\":64}",
        "{\"mtu_bytes\":65507}"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        ll_link_params params;
        assert_string_equal(parse(texts[i], &params).text, "");
    }
}

static void the_longest_delay_is_the_sum_of_all(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double want;
    } cases[] = {
        {"{\"delay_ms\":30,\"jitter_ms\":10}", 140},
        {"{\"jitter_ms\":10,\"distribution\":\"normal\"}", 100 + 40.0214314},
        {"{\"jitter_ms\":10,\"distribution\":\"pareto\"}", 100 + 121.2435565},
        {"{\"jitter_ms\":10,\"distribution\":\"paretonormal\"}", 100 + 105.3675665},
        {"{\"spike_add_ms\":50,\"limit_ms\":300}", 100},
        {"{\"spike_add_ms\":50,\"spike_length_ms\":1}", 150},
        {"{\"rate_kbps\":64,\"limit_ms\":300}", 400},
        {"{\"delay_ms\":5,\"jitter_ms\":4,\"spike_add_ms\":50,\"spike_length_ms\":1,\"rate_kbps\":64}", 659},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_link_params params;
        assert_string_equal(parse(cases[i].text, &params).text, "");
        assert_near(ll_link_delay_max_ms(&params, 100), cases[i].want, 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_is_sound),
        cmocka_unit_test(defaults_are_plain),
        cmocka_unit_test(stages_are_used_by_their_rows),
        cmocka_unit_test(contradictory_parameters_are_rejected),
        cmocka_unit_test(unused_parameters_may_be_set),
        cmocka_unit_test(the_longest_delay_is_the_sum_of_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

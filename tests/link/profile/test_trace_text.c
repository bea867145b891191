/* Files of measured links: what is read, and the sentence for each thing that is not understood. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "link/profile/trace_text.h"

static ll_profile_params params;

static void mahimahi_is_read(void **state)
{
    (void)state;
    assert_string_equal(ll_trace_read("f", "0\n3\n3\r\n10", &params).text, "");
    static const double want[] = {0, 3, 3, 10};
    assert_int_equal(params.capacity_count, 4);
    assert_memory_equal(params.capacity_ms, want, sizeof want);
    assert_int_equal(params.time_count, 0);
    assert_string_equal(ll_param_check(&ll_profile_table, &params).text, "");
}

static void csv_is_read(void **state)
{
    (void)state;
    assert_string_equal(
        ll_trace_read("f", "t_ms,delay_ms,lost\n0,12.5,0\n100,0,1\n250.5,1000,0\n", &params).text, "");
    assert_int_equal(params.time_count, 3);
    assert_int_equal(params.capacity_count, 0);
    assert_true(params.trace_delay_ms[0] == 12.5 && params.trace_t_ms[2] == 250.5);
    assert_true(params.trace_lost[0] == 0 && params.trace_lost[1] == 1 && params.trace_lost[2] == 0);
    assert_string_equal(ll_param_check(&ll_profile_table, &params).text, "");
}

#define CSV "t_ms,delay_ms,lost\n"

static void other_texts_are_refused_by_line_and_field(void **state)
{
    (void)state;
    static const struct {
        const char *text, *sentence;
    } cases[] = {
        {"", "f: the file is empty"},
        {"0\n", "f: the last time must be at least 1 ms"},
        {"5\n4\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got 4"},
        {"5\n\n6\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got nothing"},
        {"5\n6.5\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got 6.5"},
        {"5\n 6\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got  6"},
        {"5\n-6\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got -6"},
        {"5\n1e3\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got 1e3"},
        {"5\n3600001\n", "f, line 2, time: must be a whole number of ms from 5 to 3600000; got 3600001"},
        {"5\n99999999999999999999999999999999999999\n",
         "f, line 2, time: must be a whole number of ms from 5 to 3600000; got 999999999999999999999999"},
        {"time\n5\n", "f, line 1, header: must be t_ms,delay_ms,lost, or a whole number of ms in a trace of "
                      "Mahimahi; got time"},
        {"t_ms;delay_ms;lost\n",
         "f, line 1, header: must be t_ms,delay_ms,lost, or a whole number of ms in a trace of Mahimahi; got "
         "t_ms;delay_ms;lost"},
        {CSV, "f: no row follows the header"},
        {CSV "5,1,0\n", "f, line 2, t_ms: must be 0, where a trace begins; got 5"},
        {CSV "0,1,0\n0,1,0\n", "f, line 3, t_ms: must be a number of ms above 0, at most 3600000; got 0"},
        {CSV "0,1,0\n10,1,0\n9,1,0\n",
         "f, line 4, t_ms: must be a number of ms above 10, at most 3600000; got 9"},
        {CSV "0,1001,0\n", "f, line 2, delay_ms: must be a number of ms from 0 to 1000; got 1001"},
        {CSV "0,nan,0\n", "f, line 2, delay_ms: must be a number of ms from 0 to 1000; got nan"},
        {CSV "0,,0\n", "f, line 2, delay_ms: must be a number of ms from 0 to 1000; got nothing"},
        {CSV "0,-1,0\n", "f, line 2, delay_ms: must be a number of ms from 0 to 1000; got -1"},
        {CSV "0,1.,0\n", "f, line 2, delay_ms: must be a number of ms from 0 to 1000; got 1."},
        {CSV "0,1,2\n", "f, line 2, lost: must be 0 or 1; got 2"},
        {CSV "0,1,true\n", "f, line 2, lost: must be 0 or 1; got true"},
        {CSV "0,1,0,9\n", "f, line 2, lost: must be 0 or 1; got 0,9"},
        {CSV "0,1\n", "f, line 2, lost: must be there, after a comma; got 0,1"},
        {CSV "0\n", "f, line 2, delay_ms: must be there, after a comma; got 0"},
        {CSV "0,\x01\xff,0\n", "f, line 2, delay_ms: must be a number of ms from 0 to 1000; got ??"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_status status = ll_trace_read("f", cases[i].text, &params);
        assert_string_equal(status.text, cases[i].sentence);
        assert_int_equal(status.code, LL_BAD_INPUT);
    }
}

/* As long as there is room, and one more. */
static void traces_have_a_bounded_length(void **state)
{
    (void)state;
    char *text = malloc(20 * (LL_CAPACITY_MAX + 2)), *at = text;
    assert_non_null(text);
    for (int i = 1; i <= LL_CAPACITY_MAX; i++)
        at += sprintf(at, "%d\n", i);
    assert_string_equal(ll_trace_read("f", text, &params).text, "");
    assert_int_equal(params.capacity_count, LL_CAPACITY_MAX);
    sprintf(at, "9000\n");
    assert_string_equal(ll_trace_read("f", text, &params).text,
                        "f, line 8193: a trace has at most 8192 lines of samples");
    at = text + sprintf(text, CSV);
    for (int i = 0; i < LL_TRACE_MAX; i++)
        at += sprintf(at, "%d,1,0\n", i);
    assert_string_equal(ll_trace_read("f", text, &params).text, "");
    sprintf(at, "9000,1,0\n");
    assert_string_equal(ll_trace_read("f", text, &params).text,
                        "f, line 2050: a trace has at most 2048 lines of samples");
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mahimahi_is_read),
        cmocka_unit_test(csv_is_read),
        cmocka_unit_test(other_texts_are_refused_by_line_and_field),
        cmocka_unit_test(traces_have_a_bounded_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

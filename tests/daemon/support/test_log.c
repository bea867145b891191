/* A line of the log is JSON with every text. */
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "daemon/support/log.h"

/* What a line of the log has, read back; to be deleted. */
static cJSON *logged(const char *detail)
{
    char text[8192] = "";
    int ends[2], terminal = dup(STDERR_FILENO);
    assert_int_equal(pipe(ends), 0);
    dup2(ends[1], STDERR_FILENO);
    ll_log_write("warn", "a test", "%s", detail);
    dup2(terminal, STDERR_FILENO);
    close(ends[1]);
    ssize_t length = read(ends[0], text, sizeof text - 1);
    close(ends[0]);
    close(terminal);
    assert_true(length > 0 && text[length - 1] == '\n');
    cJSON *line = cJSON_Parse(text);
    assert_non_null(line);
    return line;
}

static void every_byte_comes_back(void **state)
{
    (void)state;
    static const char *const details[] = {"",       "race",      "\"\\\"",   "a\x01\x1f\x7f z",
                                          "\n\n\n", "tab\there", "\xc3\xa4", "\x02"};
    for (size_t i = 0; i < sizeof details / sizeof *details; i++) {
        cJSON *line = logged(details[i]);
        assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(line, "detail")), details[i]);
        assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(line, "level")), "warn");
        assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(line, "msg")), "a test");
        cJSON_Delete(line);
    }
}

/* A long detail is cut, to a line that is still JSON. */
static void long_details_are_cut(void **state)
{
    (void)state;
    for (int sign = 1; sign < 128; sign += 31) {
        char detail[5000];
        memset(detail, sign, sizeof detail);
        detail[sizeof detail - 1] = '\0';
        cJSON *line = logged(detail);
        const char *read = cJSON_GetStringValue(cJSON_GetObjectItem(line, "detail"));
        assert_in_range(strlen(read), 300, 1023);
        assert_int_equal(strspn(read, (char[]){(char)sign, '\0'}), strlen(read));
        cJSON_Delete(line);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_byte_comes_back),
        cmocka_unit_test(long_details_are_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

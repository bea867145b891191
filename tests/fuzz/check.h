/* Checks of the fuzzers: wrong results abort as well. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <limits.h>
#include <malloc.h>

#include "base/status.h"

#define FUZZ_CHECK(expression) ((expression) ? (void)0 : fuzz_check_failed(#expression, __FILE__, __LINE__))

_Noreturn static inline void fuzz_check_failed(const char *expression, const char *file, int line)
{
    fprintf(stderr, "%s:%d: %s\n", file, line, expression);
    abort();
}

/* Blocks of sessions and configurations are large: returning their pages to the system for each input would
 * cost more than the test itself. */
__attribute__((constructor)) static void fuzz_keep_memory(void)
{
    mallopt(M_MMAP_THRESHOLD, 1 << 28);
    mallopt(M_TRIM_THRESHOLD, INT_MAX);
    mallopt(M_TOP_PAD, 1 << 24);
}

/* Length of the well-formed UTF-8 sequence (RFC 3629, table of section 4) at `s`, which ends with a NUL; 0:
 * none. */
static inline int fuzz_utf8(const unsigned char *s)
{
    static const struct {
        unsigned char low, high, second_low, second_high;
        int length;
    } forms[] = {{0x01, 0x7f, 0, 0, 1},       {0xc2, 0xdf, 0x80, 0xbf, 2}, {0xe0, 0xe0, 0xa0, 0xbf, 3},
                 {0xe1, 0xec, 0x80, 0xbf, 3}, {0xed, 0xed, 0x80, 0x9f, 3}, {0xee, 0xef, 0x80, 0xbf, 3},
                 {0xf0, 0xf0, 0x90, 0xbf, 4}, {0xf1, 0xf3, 0x80, 0xbf, 4}, {0xf4, 0xf4, 0x80, 0x8f, 4}};
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        if (s[0] < forms[i].low || s[0] > forms[i].high)
            continue;
        if (forms[i].length > 1 && (s[1] < forms[i].second_low || s[1] > forms[i].second_high))
            return 0;
        for (int k = 2; k < forms[i].length; k++)
            if (s[k] < 0x80 || s[k] > 0xbf)
                return 0;
        return forms[i].length;
    }
    return 0;
}

static inline bool fuzz_is_text(const char *text)
{
    const unsigned char *s = (const unsigned char *)text;
    for (int step; *s; s += step) {
        step = fuzz_utf8(s);
        if (step == 0)
            return false;
    }
    return true;
}

/* An error has a message that may be sent to a browser. */
static inline bool fuzz_failed(const ll_status *status)
{
    if (!ll_failed(status))
        return false;
    FUZZ_CHECK(status->text[0] != '\0');
    FUZZ_CHECK(fuzz_is_text(status->text) && fuzz_is_text(status->field));
    return true;
}

static inline char *fuzz_print(cJSON *json) /* takes it */
{
    FUZZ_CHECK(json != NULL);
    char *text = cJSON_PrintUnformatted(json);
    FUZZ_CHECK(text != NULL);
    cJSON_Delete(json);
    return text;
}

/* Shared by the tests of sessions. */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "session/scenario.h"
#include "session/session.h"

/* Lines of a log, each with its newline. */
typedef struct lines {
    char text[1 << 16];
    size_t size;
} lines;

static inline void keep_line(void *context, const char *line, size_t length)
{
    lines *l = context;
    assert_true(l->size + length + 1 < sizeof l->text);
    memcpy(l->text + l->size, line, length);
    l->size += length;
    l->text[l->size++] = '\n';
    l->text[l->size] = '\0';
}

static inline void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

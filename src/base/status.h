/* Errors that a person can act on.
 *
 * Functions that can fail for external reasons return an ll_status by value: a code for machines and a
 * sentence that names the field, the allowed range and the value: `field: must be MIN to MAX UNIT; got VALUE.
 * Hint.` Broken internal invariants are asserted (base/assert.h), never reported.
 *
 * A function that owns nothing yet passes an error on by LL_TRY. One that has something to release makes its
 * steps by LL_THEN, each skipped once one has failed, then releases it and returns the first error:
 *
 *     LL_TRY(read_options(body, &options));
 *     ll_status status = ll_json_read(path, &json);
 *     LL_THEN(status, ll_experiment_parse(json, NULL, NULL, &experiment));
 *     LL_THEN(status, run(experiment, &options));
 *     cJSON_Delete(json);
 *     return status; */
#pragma once

#include <stdbool.h>

typedef enum ll_code {
    LL_OK = 0,
    LL_BAD_INPUT, /* invalid text or value; `field` says where */
    LL_NOT_FOUND, /* no such scenario, session, player or path */
    LL_FORBIDDEN, /* not permitted by the key */
    LL_CONFLICT,  /* valid, but not in the present state */
    LL_LIMIT,     /* a configured limit was reached */
    LL_IO,        /* a file, a socket or the database failed */
    LL_NO_MEMORY,
    LL_DIVERGED,    /* a simulation produced a value that is not finite */
    LL_UNAVAILABLE, /* a required server does not answer now */
    LL_INTERRUPTED, /* stopped from outside (base/interrupt.h); the sentence says how far it came */
} ll_code;

typedef struct ll_status {
    ll_code code;
    char field[64]; /* dotted path of the offending field (`players.1.lag_ms`), or empty */
    char text[256]; /* one sentence */
} ll_status;

/* Most are ok: only the first bytes of the texts are written. */
static inline ll_status ll_ok(void)
{
    ll_status s;
    s.code = LL_OK;
    s.field[0] = s.text[0] = '\0';
    return s;
}

ll_status ll_error(ll_code code, const char *format, ...) __attribute__((format(printf, 2, 3)));
ll_status ll_field_error(ll_code code, const char *field, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static inline bool ll_failed(const ll_status *s)
{
    return s->code != LL_OK;
}

/* Returns the status of a call from the present function if it has failed. */
#define LL_TRY(...)                                                                                          \
    do {                                                                                                     \
        ll_status tried_ = __VA_ARGS__;                                                                      \
        if (ll_failed(&tried_))                                                                              \
            return tried_;                                                                                   \
    } while (0)

/* The next step: unless `status` has failed, it becomes that of the call. */
#define LL_THEN(status, ...)                                                                                 \
    do {                                                                                                     \
        if (!ll_failed(&(status)))                                                                           \
            (status) = __VA_ARGS__;                                                                          \
    } while (0)

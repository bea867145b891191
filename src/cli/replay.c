/* The verb `replay`. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/verbs.h"
#include "session/session.h"

static bool read_hash(const char *line, size_t length, int64_t *tick, char hash[17])
{
    cJSON *o = cJSON_ParseWithLength(line, length);
    const cJSON *op = cJSON_GetObjectItemCaseSensitive(o, "op"),
                *t = cJSON_GetObjectItemCaseSensitive(o, "tick");
    const cJSON *h = cJSON_GetObjectItemCaseSensitive(o, "hash");
    bool ok = cJSON_IsString(op) && strcmp(op->valuestring, "hash") == 0 && cJSON_IsNumber(t) &&
              cJSON_IsString(h) && strlen(h->valuestring) == 16;
    if (ok) {
        *tick = (int64_t)t->valuedouble;
        memcpy(hash, h->valuestring, 17);
    }
    cJSON_Delete(o);
    return ok;
}

/* Compares with every hash line of the log; returns their count, or -1 after printing the first
 * difference. */
static int64_t compare_hashes(ll_session *s, const char *text, size_t length)
{
    int64_t compared = 0;
    for (const char *p = text, *end = text + length; p < end;) {
        const char *newline = memchr(p, '\n', (size_t)(end - p));
        size_t size = newline ? (size_t)(newline - p) : (size_t)(end - p);
        char wanted[17], got[17];
        int64_t tick;
        if (read_hash(p, size, &tick, wanted)) {
            ll_status status = ll_session_run_to(s, tick);
            if (ll_failed(&status)) {
                fprintf(stderr, "laglab: tick %" PRId64 ": %s\n", tick, status.text);
                return -1;
            }
            snprintf(got, sizeof got, "%016" PRIx64, ll_session_hash(s));
            if (strcmp(got, wanted) != 0) {
                fprintf(stderr, "laglab: tick %" PRId64 " differs: log %s, replay %s\n", tick, wanted, got);
                return -1;
            }
            compared++;
        }
        p += size + 1;
    }
    return compared;
}

/* Runs the tick after the log's last one, in which the original session failed. */
static bool fails_alike(ll_session *s, int64_t tick)
{
    char wanted[17], got[17];
    ll_status status = ll_session_run_to(s, tick);
    snprintf(wanted, sizeof wanted, "%016" PRIx64, ll_session_failed_hash(s));
    LL_THEN(status, ll_session_run_to(s, tick + 1));
    snprintf(got, sizeof got, "%016" PRIx64, ll_session_hash(s));
    if (!ll_failed(&status))
        fprintf(stderr, "laglab: the session of the log failed after tick %" PRId64 "; the replay does not\n",
                tick);
    else if (strcmp(wanted, got) != 0)
        fprintf(stderr, "laglab: failure after tick %" PRId64 ": hash of the log %s, of the replay %s\n",
                tick, wanted, got);
    else
        fprintf(stderr, "laglab: failure after tick %" PRId64 ", as in the log: %s\n", tick, status.text);
    return ll_failed(&status) && strcmp(wanted, got) == 0;
}

/* Replays the log of a failed session: exit 1, also when the replay fails in the same way. */
static int replay(ll_session *session, const char *text, size_t length)
{
    int64_t head = ll_session_get_info(session).head_tick, failed_at = ll_session_failed_at(session);
    int64_t compared = compare_hashes(session, text, length);
    if (compared < 0)
        return 1;
    if (failed_at >= 0)
        compared += fails_alike(session, failed_at);
    else if (ll_session_run_to(session, head).code != LL_OK)
        failed_at = ll_session_failed_at(session);
    printf("{\"ticks\":%" PRId64 ",\"compared\":%" PRId64 ",\"hash\":\"%016" PRIx64 "\"}\n", head, compared,
           ll_session_hash(session));
    return failed_at >= 0;
}

int ll_verb_replay(int argc, char **argv)
{
    const ll_option none[] = {{0}};
    const char *name;
    char *text = NULL;
    size_t length = 0;
    ll_session *session = NULL;
    FILE *f = NULL;
    int result = 2;
    ll_status status = ll_arguments_one(
        "replay LOG: run a log again; exit 1 at the first tick whose hash differs", argc, argv, none, &name);
    if (!ll_failed(&status) && !name)
        status = ll_error(LL_BAD_INPUT,
                          "LOG: required; a file written by `laglab run --log`, or - for standard input");
    if (!ll_failed(&status)) {
        f = strcmp(name, "-") == 0 ? stdin : fopen(name, "rb");
        status =
            f ? ll_input_whole(f, name, &text, &length) : ll_error(LL_NOT_FOUND, "cannot read %.200s", name);
    }
    LL_THEN(status, ll_session_restore(text, length, NULL, NULL, &session));
    if (ll_failed(&status))
        result = ll_argument_fail(&status);
    else
        result = replay(session, text, length);
    ll_session_destroy(session);
    free(text);
    if (f && f != stdin)
        fclose(f);
    return result;
}

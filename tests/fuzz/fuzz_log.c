/* Any lines of a log: refused, or a session that can run, and whose own log gives the same state. */
#include "check.h"

#include "session/session.h"

#define LONG 400 /* ticks: more would take too long to replay */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct lines {
    char *text;
    size_t size;
} lines;

static void keep_line(void *context, const char *line, size_t length)
{
    lines *l = context;
    l->text = realloc(l->text, l->size + length + 1);
    FUZZ_CHECK(l->text != NULL && memchr(line, '\n', length) == NULL);
    memcpy(l->text + l->size, line, length);
    l->size += length;
    l->text[l->size++] = '\n';
}

static void same_from_own_log(ll_session *session)
{
    lines own = {0};
    ll_session *again;
    ll_session_log(session, keep_line, &own);
    ll_status status = ll_session_restore(own.text, own.size, NULL, NULL, &again);
    FUZZ_CHECK(!fuzz_failed(&status));
    FUZZ_CHECK(ll_session_get_info(again).head_tick == ll_session_get_info(session).head_tick);
    FUZZ_CHECK(ll_session_hash(again) == ll_session_hash(session));
    ll_session_destroy(again);
    free(own.text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ll_session *session;
    ll_status status = ll_session_restore((const char *)data, size, NULL, NULL, &session);
    FUZZ_CHECK(fuzz_failed(&status) == (session == NULL));
    if (session == NULL)
        return 0;
    ll_session_info info = ll_session_get_info(session);
    bool failed = info.status == LL_SESSION_FAILED;
    FUZZ_CHECK(info.tick >= 0 && info.head_tick <= info.end_tick);
    FUZZ_CHECK(failed ? info.tick <= info.head_tick : info.tick == info.head_tick);
    if (info.head_tick <= LONG) {
        int64_t to = info.tick + 60 < info.end_tick ? info.tick + 60 : info.end_tick;
        status = ll_session_run_to(session, to);
        FUZZ_CHECK(!fuzz_failed(&status) || status.code == LL_DIVERGED);
        if (!ll_failed(&status))
            same_from_own_log(session);
    }
    ll_session_destroy(session);
    return 0;
}

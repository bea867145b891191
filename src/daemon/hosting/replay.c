/* Whether the log of a claimed session leads to the state that it had: a hash that the last owner stored is
 * compared with a replay of the lines that the log had then. */
#include <inttypes.h>
#include <string.h>
#include <time.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/log.h"

enum {
    LIGHT_BYTES = 6 << 20
}; /* with its checkpoints; the hash of a larger one would take a millisecond or more of each save */
#define HASH_NS LL_SECOND /* between two hashes of a session */
#define LONGEST_NS                                                                                           \
    (500 * LL_MS) /* processor time of a comparison; a session that needs more is not compared */

void ll_session_entry_add_hash(ll_session_entry *session_entry, ll_stored *row)
{
    ll_entry_stored *stored = &session_entry->stored;
    ll_session_info info = ll_session_get_info(session_entry->session);
    ll_time now = session_entry->wall;
    bool fit = !info.parked && !info.seeking && info.status != LL_SESSION_FAILED &&
               info.at_tick == info.tick && ll_session_awake_bytes(session_entry->session) <= LIGHT_BYTES;
    if (fit && !session_entry->work.background_tick &&
        (stored->hash_lines == 0 || now - stored->hashed_wall >= HASH_NS)) {
        stored->hash_tick = info.tick;
        stored->hash_lines = stored->lines;
        stored->hash = ll_session_hash(session_entry->session);
        stored->hashed_wall = now;
    }
    row->hash_tick = stored->hash_tick;
    row->hash_lines = stored->hash_lines;
    row->hash = stored->hash;
}

/* Length of the first `lines` lines; 0: there are fewer. */
static size_t length_of(const char *log, size_t length, int64_t lines)
{
    const char *at = log, *end = log + length;
    for (int64_t i = 0; i < lines; i++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        if (!newline)
            return 0;
        at = newline + 1;
    }
    return (size_t)(at - log);
}

static int64_t cpu_now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * LL_SECOND + t.tv_nsec;
}

static bool before(void *context)
{
    const int64_t *until = context;
    return cpu_now_ns() < *until;
}

static ll_status differs(ll_session_entry *session_entry, uint64_t hash)
{
    const ll_entry_stored *stored = &session_entry->stored;
    if (!session_entry->differs)
        atomic_fetch_add(&session_entry->host->counts.mismatches, 1);
    session_entry->differs = true;
    ll_log_write("error", "replay differs", "Stored session %" PRId64 " at tick %" PRId64 ".",
                 stored->place.number, stored->hash_tick);
    return ll_error(LL_CONFLICT,
                    "The log of this session leads to another state than it had: at tick %" PRId64
                    " hash %016" PRIx64 " instead of %016" PRIx64 ". Its log can still be read.",
                    stored->hash_tick, hash, stored->hash);
}

ll_status ll_session_entry_check_replay(ll_session_entry *session_entry, const char *log, size_t length)
{
    const ll_entry_stored *stored = &session_entry->stored;
    size_t part = stored->hash_lines > 0 ? length_of(log, length, stored->hash_lines) : 0;
    ll_session *copy = NULL;
    uint64_t hash = 0;
    if (part == 0)
        return ll_ok();
    ll_status status = ll_session_restore(log, part, NULL, NULL, &copy);
    if (ll_failed(&status))
        return ll_ok(); /* the whole log says why */
    int64_t until = cpu_now_ns() + LONGEST_NS;
    ll_interrupt interrupt = {before, cpu_now_ns, &until};
    status = ll_session_run_within(copy, stored->hash_tick, &interrupt);
    bool there = !ll_failed(&status) && ll_session_get_info(copy).tick == stored->hash_tick;
    if (there)
        hash = ll_session_hash(copy);
    ll_session_destroy(copy);
    return !there || hash == stored->hash ? ll_ok() : differs(session_entry, hash);
}

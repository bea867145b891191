/* A session and the store: its row, its log, and what saves a replay of it.
 *
 * A daemon that takes over hundreds of sessions must not replay hours of each. In a shared store a state is
 * therefore kept now and then: whenever a replay up to the present would take long. A session is then
 * restored from the newest one, and replays only what came later. On the way the replay is compared with a
 * hash that the last owner stored. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/gzip.h"
#include "daemon/support/log.h"

enum {
    LIGHT_BYTES = 6 << 20,  /* with its checkpoints; the hash of a larger one would take a millisecond or more
                               of each save */
    STATE_BYTES = 16 << 20, /* a larger one is not kept */
    CHECK_EACH = 32         /* of 32 sessions that began from a state, one is replayed from its log too */
};
#define HASH_NS LL_SECOND /* between two hashes of a session */
#define LONGEST_NS                                                                                           \
    (500 * LL_MS)              /* processor time of a comparison; a session that needs more is not compared */
#define REPLAY_NS (50 * LL_MS) /* processor time of a replay that is worth a state, at least */
#define REPLAY_NS_PER_BYTE 30  /* and more for a large session: ten times what storing its state takes */
#define STATE_EACH_NS (10 * LL_MS) /* between two states of all sessions of this daemon */

/* ---- hashes ---- */

static void add_hash(ll_session_entry *session_entry, ll_stored *row)
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

/* ---- keeping a state ---- */

/* What a task compresses and stores. */
typedef struct kept_state {
    ll_session_entry *session_entry;
    ll_store_place place;
    void *bytes;
    size_t size;
} kept_state;

static void run_keep(void *context, ll_task *task)
{
    kept_state *kept = context;
    ll_host *host = kept->session_entry->host;
    ll_stored_state state = {0};
    ll_status status = ll_gzip_bytes(kept->bytes, kept->size, task, &state.bytes, &state.size);
    if (!ll_failed(&status)) {
        ll_store_put_state(host->store, kept->place, &state);
        atomic_fetch_add(&host->counts.states_stored, 1);
    }
    free(state.bytes);
    free(kept->bytes);
    ll_host_release_memory(host, (int64_t)kept->size);
    atomic_store(&kept->session_entry->shared.keeping, false);
    ll_session_entry_release(kept->session_entry);
    free(kept);
}

static bool is_worth_a_state(const ll_session_entry *session_entry)
{
    const ll_entry_stored *stored = &session_entry->stored;
    int64_t ticks = ll_session_get_info(session_entry->session).tick - stored->state_tick;
    double bytes = (double)ll_session_bytes(session_entry->session);
    double replay_ns = (double)ticks * session_entry->work.tick_ns, least = REPLAY_NS_PER_BYTE * bytes;
    return bytes <= STATE_BYTES && replay_ns > REPLAY_NS && replay_ns > least;
}

/* Not those of all sessions at once. */
static bool take_turn(ll_host_sharing *sharing)
{
    ll_time now = ll_host_now(), next = atomic_load(&sharing->next_state);
    return now >= next && atomic_compare_exchange_strong(&sharing->next_state, &next, now + STATE_EACH_NS);
}

/* A task of the daemon for a session, with a reference to it. */
static ll_status start_task(ll_session_entry *session_entry, void (*run)(void *context, ll_task *task),
                            void *context)
{
    ll_task_spec spec = {.client = "the daemon", .own = true, .run = run, .context = context};
    memcpy(spec.session, session_entry->identity.id, sizeof session_entry->identity.id);
    ll_session_entry_retain(session_entry);
    ll_status status = ll_tasks_add(session_entry->host->tasks, &spec, NULL);
    if (ll_failed(&status))
        ll_session_entry_release(session_entry);
    return status;
}

/* Copies the state for a task, which stores it; its memory is reserved until then. */
static ll_status start_keeping(ll_session_entry *session_entry)
{
    ll_host *host = session_entry->host;
    kept_state *kept = calloc(1, sizeof *kept);
    if (!kept)
        return ll_error(LL_NO_MEMORY, "out of memory: state of a session");
    *kept = (kept_state){.session_entry = session_entry, .place = session_entry->stored.place};
    ll_status status = ll_session_save_state(session_entry->session, &kept->bytes, &kept->size);
    LL_THEN(status, ll_host_reserve_memory(host, (int64_t)kept->size));
    if (!ll_failed(&status)) {
        atomic_store(&session_entry->shared.keeping, true);
        status = start_task(session_entry, run_keep, kept);
        if (!ll_failed(&status))
            return status;
        atomic_store(&session_entry->shared.keeping, false);
        ll_host_release_memory(host, (int64_t)kept->size);
    }
    free(kept->bytes);
    free(kept);
    return status;
}

static bool may_keep(ll_session_entry *session_entry)
{
    const ll_host *host = session_entry->host;
    return ll_store_is_shared(host->store) && !session_entry->moved && !atomic_load(&host->sharing.ends) &&
           !atomic_load(&session_entry->shared.keeping) && !session_entry->work.background_tick &&
           !ll_store_failing(host->store, NULL);
}

static void keep_state(ll_session_entry *session_entry)
{
    if (!may_keep(session_entry) || !is_worth_a_state(session_entry) ||
        !take_turn(&session_entry->host->sharing))
        return;
    ll_status status = start_keeping(session_entry);
    if (!ll_failed(&status))
        session_entry->stored.state_tick = ll_session_get_info(session_entry->session).tick;
}

/* ---- the row ---- */

static int64_t unix_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

void ll_session_entry_save(ll_session_entry *session_entry)
{
    if (!session_entry->session || session_entry->deleted)
        return;
    ll_session_info info = ll_session_get_info(session_entry->session);
    ll_entry_stored *stored = &session_entry->stored;
    const ll_entry_identity *identity = &session_entry->identity;
    ll_stored row = {.place = stored->place,
                     .created_ms = identity->created_ms,
                     .seen_ms = unix_ms(),
                     .key_count = identity->key_count,
                     .playing = info.status == LL_SESSION_PLAYING,
                     .speed = info.speed,
                     .tick = info.tick + (info.status == LL_SESSION_FAILED), /* ll_session_position */
                     .head_tick = info.head_tick,
                     .lines = stored->lines};
    const ll_class_key *key = atomic_load(&session_entry->shared.class_key);
    if (key)
        memcpy(row.class_key, key->name, sizeof row.class_key);
    memcpy(row.id, identity->id, sizeof row.id);
    memcpy(row.code, identity->code, sizeof row.code);
    memcpy(row.keys, identity->keys, (size_t)identity->key_count * sizeof *row.keys);
    if (ll_store_is_shared(session_entry->host->store))
        add_hash(session_entry, &row);
    stored->playing = row.playing;
    stored->speed = row.speed;
    stored->tick = row.tick;
    stored->head_tick = row.head_tick;
    stored->saved_wall = session_entry->wall;
    stored->rewound = false;
    if (stored->collecting) {
        ll_store_batch_put(&stored->collected, &row);
        stored->ticket = ll_store_submit(session_entry->host->store, &stored->collected);
        stored->collecting = false;
    } else {
        stored->ticket = ll_store_put(session_entry->host->store, &row);
        keep_state(session_entry);
    }
}

/* ---- a stored state ---- */

/* Reads it as it was saved; *state is empty if there is none, or it cannot be read. */
static void read_state(ll_session_entry *session_entry, ll_stored_state *state)
{
    ll_store *store = session_entry->host->store;
    ll_stored_state packed = {0};
    *state = (ll_stored_state){0};
    if (!ll_store_is_shared(store))
        return;
    ll_status status = ll_store_read_state(store, session_entry->stored.place.number, &packed);
    if (!ll_failed(&status) && packed.bytes)
        status = ll_gunzip_bytes(packed.bytes, packed.size, 2 * STATE_BYTES, &state->bytes, &state->size);
    if (ll_failed(&status))
        ll_log_write("warn", "state not read", "Stored session %" PRId64 ": %s",
                     session_entry->stored.place.number, status.text);
    free(packed.bytes);
}

static void drop(ll_stored_state *state)
{
    free(state->bytes);
    *state = (ll_stored_state){0};
}

void ll_session_entry_fetch_state(ll_session_entry *session_entry)
{
    ll_stored_state state;
    int64_t stored_tick = session_entry->stored.state_tick;
    if (stored_tick == 0 || stored_tick > ll_session_get_info(session_entry->session).tick)
        return;
    read_state(session_entry, &state);
    if (state.bytes) {
        ll_status status = ll_session_use_state(session_entry->session, state.bytes, state.size);
        atomic_fetch_add(&session_entry->host->counts.states_used,
                         !ll_failed(&status)); /* or it replays all */
    }
    drop(&state);
}

/* ---- comparing ---- */

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

/* The session as it was when its hash was stored, parked; NULL: that is not known, or the state is later. */
static ll_session *restore_hashed(const ll_session_entry *session_entry, const ll_session_source *all)
{
    const ll_entry_stored *stored = &session_entry->stored;
    ll_session_source part = *all;
    ll_session *copy = NULL;
    part.length = stored->hash_lines > 0 ? length_of(all->log, all->length, stored->hash_lines) : 0;
    if (part.length == 0)
        return NULL;
    ll_status status = ll_session_restore_from(&part, NULL, NULL, &copy);
    if (ll_failed(&status))
        return NULL;
    int64_t from = ll_session_saved_tick(copy);
    if (all->state && (from <= 0 || from > stored->hash_tick)) {
        ll_session_destroy(copy);
        return NULL;
    }
    if (all->state)
        ll_session_set_position(copy, 0, &(ll_session_position){.tick = from, .head = from});
    return copy;
}

/* Runs to the tick of the stored hash; false: that takes too long, or the log fails before. */
static bool run_to_hash(ll_session *copy, const ll_entry_stored *stored, const ll_interrupt *interrupt,
                        uint64_t *hash)
{
    ll_status status = ll_session_run_within(copy, stored->hash_tick, interrupt);
    if (ll_failed(&status) || ll_session_get_info(copy).tick != stored->hash_tick)
        return false;
    *hash = ll_session_hash(copy);
    return true;
}

/* Compares the replay with the stored hash. One that is equal leaves its state in *latest. When the replay
 * from the stored state differs, *wrong is set, and the log alone decides. */
static ll_status compare(ll_session_entry *session_entry, const ll_session_source *source,
                         ll_stored_state *latest, bool *wrong)
{
    const ll_entry_stored *stored = &session_entry->stored;
    ll_session *copy = restore_hashed(session_entry, source);
    if (!copy)
        return ll_ok();
    int64_t until = cpu_now_ns() + LONGEST_NS;
    ll_interrupt interrupt = {before, cpu_now_ns, &until};
    uint64_t hash = 0;
    bool there = run_to_hash(copy, stored, &interrupt, &hash), same = there && hash == stored->hash;
    if (same)
        ll_session_save_state(copy, (void **)&latest->bytes, &latest->size); /* or the one before */
    ll_session_destroy(copy);
    if (!there || same)
        return ll_ok();
    if (!source->state)
        return differs(session_entry, hash);
    *wrong = true;
    ll_log_write("error", "stored state differs", "Stored session %" PRId64 ": it is replayed from its log.",
                 stored->place.number);
    return compare(session_entry, &(ll_session_source){source->log, source->length, NULL, 0}, latest, wrong);
}

/* ---- checking at leisure ---- */

/* A session that began from a state, and its log: do they agree? */
typedef struct leisure_check {
    ll_session_entry *session_entry;
    ll_entry_stored stored; /* the hash that it had */
    char *log;
    size_t length; /* when the hash was stored */
} leisure_check;

static void run_check(void *context, ll_task *task)
{
    leisure_check *check = context;
    ll_session *copy = NULL;
    uint64_t hash = 0;
    ll_status status = ll_session_restore(check->log, check->length, NULL, NULL, &copy);
    ll_interrupt interrupt = ll_task_interrupt(task);
    if (!ll_failed(&status) && run_to_hash(copy, &check->stored, &interrupt, &hash) &&
        hash != check->stored.hash) {
        atomic_fetch_add(&check->session_entry->host->counts.mismatches, 1);
        ll_log_write("error", "log differs",
                     "Stored session %" PRId64 " at tick %" PRId64 ": hash %016" PRIx64
                     " by its log, %016" PRIx64 " by its state.",
                     check->stored.place.number, check->stored.hash_tick, hash, check->stored.hash);
    }
    ll_session_destroy(copy);
    free(check->log);
    ll_session_entry_release(check->session_entry);
    free(check);
}

/* One of CHECK_EACH sessions that began from a state; takes the log if it starts. */
static bool start_check(ll_session_entry *session_entry, char *log, size_t length)
{
    const ll_entry_stored *stored = &session_entry->stored;
    size_t part = stored->hash_lines > 0 ? length_of(log, length, stored->hash_lines) : 0;
    if (part == 0 || atomic_fetch_add(&session_entry->host->sharing.unchecked, 1) % CHECK_EACH != 0)
        return false;
    leisure_check *check = calloc(1, sizeof *check);
    if (!check)
        return false;
    *check = (leisure_check){session_entry, *stored, log, part};
    ll_status status = start_task(session_entry, run_check, check);
    if (ll_failed(&status))
        free(check);
    return !ll_failed(&status);
}

/* ---- loading ---- */

/* Restores the clock as last stored, or at the last command when that is later. A playing session continues
 * from the daemon's start, or from its claim. */
static void resume(ll_session_entry *session_entry)
{
    const ll_entry_stored *row = &session_entry->stored;
    const ll_host *host = session_entry->host;
    ll_time from = ll_store_is_shared(host->store) ? session_entry->wall : host->started;
    bool older = row->head_tick < ll_session_get_info(session_entry->session).head_tick;
    ll_session_set_position(session_entry->session, from,
                            &(ll_session_position){.tick = older ? -1 : row->tick,
                                                   .head = row->head_tick,
                                                   .speed = row->speed,
                                                   .playing = row->playing});
    session_entry->wall = from;
}

ll_status ll_session_entry_stored_log(ll_session_entry *session_entry, char **text, size_t *length)
{
    if (!session_entry->host->store)
        return ll_error(LL_NOT_FOUND, "Sessions are not stored.");
    return ll_store_read_log(session_entry->host->store, session_entry->stored.place.number, text, length);
}

static ll_status restore(ll_session_entry *session_entry, const ll_session_source *source)
{
    session_entry->restoring = true;
    ll_status status =
        ll_session_restore_from(source, ll_session_entry_on_line, session_entry, &session_entry->session);
    session_entry->restoring = false;
    if (!ll_failed(&status))
        return status;
    session_entry->session = NULL;
    ll_log_write("error", "session not restored", "Stored session %" PRId64 ": %s",
                 session_entry->stored.place.number, status.text);
    return ll_error(LL_IO, "Stored log of this session cannot be replayed: %.180s", status.text);
}

/* After `source` was restored. */
static ll_status verify(ll_session_entry *session_entry, ll_session_source *source)
{
    ll_session *session = session_entry->session;
    ll_stored_state latest = {0};
    bool used = ll_session_saved_tick(session) > 0, wrong = false;
    if (!used)
        source->state = NULL; /* of another run */
    session_entry->stored.state_tick = used ? ll_session_saved_tick(session) : 0;
    ll_status status = compare(session_entry, source, &latest, &wrong);
    if (wrong)
        session_entry->stored.state_tick = 0;
    if (!ll_failed(&status) && (latest.bytes || wrong))
        ll_session_use_state(session, latest.bytes, latest.size);
    atomic_fetch_add(&session_entry->host->counts.states_used, used && !wrong);
    drop(&latest);
    return status;
}

ll_status ll_session_entry_load(ll_session_entry *session_entry)
{
    char *log = NULL;
    size_t length = 0;
    ll_stored_state state;
    LL_ASSERT(!session_entry->session && !session_entry->restoring); /* one thread loads it */
    LL_TRY(ll_session_entry_stored_log(session_entry, &log, &length));
    read_state(session_entry, &state);
    ll_session_source source = {log, length, state.bytes, state.size};
    ll_status status = restore(session_entry, &source);
    LL_THEN(status, verify(session_entry, &source));
    if (!ll_failed(&status)) {
        resume(session_entry);
        ll_session_entry_update_stats(session_entry);
        if (session_entry->stored.state_tick > 0 && start_check(session_entry, log, length))
            log = NULL;
    } else if (session_entry->session) {
        ll_session_destroy(session_entry->session);
        session_entry->session = NULL;
    }
    drop(&state);
    free(log);
    return status;
}

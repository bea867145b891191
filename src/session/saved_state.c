/* States that are kept outside of a session: a session with a long log wakes from one, and replays only what
 * came later.
 *
 * A block is relocatable, so that its bytes are its state in any process of the same engine. With it go the
 * configuration, the position in the log and the events of the last seconds. A state belongs to all logs that
 * begin with the same scenario and commands: hashes of these say whether a log does. */
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "session/internal.h"

#define FORMAT 0x31657461746c6cu /* lltate1 */

/* The events follow, then the block, then what the configuration differs in from that at tick 0. */
typedef struct saved_head {
    uint64_t format, hash; /* of all that follows this member */
    uint64_t base_hash, log_hash;
    int64_t tick;
    uint64_t next;
    int32_t step, skipped;
    uint64_t block_size, config_size;
    uint32_t event_count, event_size;
} saved_head;

enum { HASHED_FROM = 2 * sizeof(uint64_t) };

static uint64_t hash_of(const void *bytes, size_t size)
{
    return ll_hash(FORMAT, (const char *)bytes + HASHED_FROM, size - HASHED_FROM);
}

typedef struct range_hash {
    const char *object;
    uint64_t hash;
} range_hash;

static void hash_range(void *context, size_t from, size_t bytes)
{
    range_hash *r = context;
    r->hash = ll_hash(r->hash, r->object + from, bytes);
}

static uint64_t hash_base(const ll_session *s)
{
    range_hash r = {s->base, FORMAT};
    ll_param_each_range(s->scenario.kind->table, s->base, hash_range, &r);
    return r.hash;
}

/* Of the first `count` commands. */
static uint64_t hash_log(const ll_log *log, size_t count)
{
    uint64_t hash = FORMAT;
    for (size_t i = 0; i < count; i++) {
        const ll_log_entry *e = &log->entries[i];
        hash = ll_hash_u64(ll_hash_u64(hash, (uint64_t)e->tick), (uint64_t)e->op);
        hash = ll_hash_u64(hash, (uint64_t)e->player);
        hash = ll_hash(hash, &e->action, sizeof e->action);
        if (e->values)
            hash = ll_hash(hash, e->values, strlen(e->values));
    }
    return hash;
}

/* ---- saving ---- */

static uint32_t first_event(const ll_session *s)
{
    ll_time from = ll_tick_time(ll_session_first_recorded(s, s->tick), s->freq);
    uint32_t end = s->events.count, oldest = s->events.base, first = end;
    if (end - oldest > LL_EVENT_RING)
        oldest = end - LL_EVENT_RING;
    while (first > oldest && s->events.ring[(first - 1) % LL_EVENT_RING].begin >= from)
        first--;
    return first;
}

static bool may_be_saved(const ll_session *s)
{
    return s->block && !s->stale && s->observes_all && !s->unwatched &&
           s->transition.kind == LL_TRANSITION_NONE && s->status != LL_SESSION_FAILED && s->tick > 0;
}

static size_t size_of(const saved_head *head)
{
    return sizeof *head + head->event_count * sizeof(ll_event) + head->block_size + head->config_size;
}

/* A copy of the configuration at tick 0; NULL without memory. */
static void *copy_base(const ll_session *s)
{
    void *copy = calloc(1, s->config_size);
    if (copy)
        ll_param_copy(s->scenario.kind->table, copy, s->base);
    return copy;
}

ll_status ll_session_save_state(const ll_session *s, void **bytes, size_t *size)
{
    *bytes = NULL;
    *size = 0;
    if (!may_be_saved(s))
        return ll_error(LL_CONFLICT, "the session is not at a state that can be saved");
    void *counted = copy_base(s), *known = copy_base(s);
    char *to = NULL;
    ll_status status = ll_ok();
    const uint32_t first = first_event(s);
    saved_head head = {.format = FORMAT,
                       .base_hash = hash_base(s),
                       .log_hash = hash_log(&s->log, s->position.next),
                       .tick = s->tick,
                       .next = s->position.next,
                       .step = s->position.step,
                       .skipped = s->position.skipped,
                       .block_size = s->block_size,
                       .event_count = s->events.count - first,
                       .event_size = sizeof(ll_event)};
    if (counted && known) {
        head.config_size = ll_session_write_differences(s, counted, s->config, NULL);
        to = malloc(size_of(&head));
    }
    if (!to) {
        status = ll_error(LL_NO_MEMORY, "out of memory: state of a session (%zu bytes)", size_of(&head));
        goto cleanup;
    }
    char *at = to + sizeof head;
    for (uint32_t i = first; i < s->events.count; i++, at += sizeof(ll_event))
        memcpy(at, &s->events.ring[i % LL_EVENT_RING], sizeof(ll_event));
    memcpy(at, s->block, s->block_size);
    ll_session_write_differences(s, known, s->config, (unsigned char *)at + s->block_size);
    memcpy(to, &head, sizeof head);
    head.hash = hash_of(to, size_of(&head));
    memcpy(to, &head, sizeof head);
    *bytes = to;
    *size = size_of(&head);
cleanup:
    free(counted);
    free(known);
    return status;
}

/* ---- beginning from it ---- */

static bool is_whole(const ll_session *s, const saved_head *head, const void *bytes, size_t size)
{
    return head->format == FORMAT && head->event_size == sizeof(ll_event) &&
           head->event_count <= LL_EVENT_RING && head->block_size == s->block_size &&
           head->config_size < size && size == size_of(head) && head->hash == hash_of(bytes, size);
}

static bool is_of_log(const ll_session *s, const saved_head *head)
{
    const ll_log *log = &s->log;
    return head->tick > 0 && head->tick <= s->end && head->next <= log->count && head->step >= 0 &&
           head->step <= ll_session_head(s)->timeline_count &&
           (head->next == log->count || log->entries[head->next].tick >= head->tick) &&
           head->base_hash == hash_base(s) && head->log_hash == hash_log(log, head->next);
}

static ll_status take(ll_session *s, const saved_head *head, const char *at)
{
    ll_saved_state *saved = &s->saved;
    size_t events = head->event_count * sizeof(ll_event);
    ll_checkpoint *checkpoint = &saved->checkpoint;
    checkpoint->block = malloc(s->block_size);
    checkpoint->config = copy_base(s);
    saved->events = malloc(events + 1);
    if (!checkpoint->block || !checkpoint->config || !saved->events)
        return ll_error(LL_NO_MEMORY, "out of memory: state of a session (%zu bytes)", s->block_size);
    memcpy(saved->events, at, events);
    memcpy(checkpoint->block, at + events, s->block_size);
    ll_session_read_differences(s, (const unsigned char *)at + events + s->block_size, checkpoint->config);
    saved->event_count = head->event_count;
    checkpoint->tick = head->tick;
    checkpoint->position =
        (ll_log_position){.next = (size_t)head->next, .step = head->step, .skipped = head->skipped};
    return ll_ok();
}

ll_status ll_session_use_state(ll_session *s, const void *bytes, size_t size)
{
    saved_head head;
    if (s->block)
        return ll_error(LL_CONFLICT, "the session is not asleep");
    LL_TRY(ll_session_unpack(s));
    ll_session_drop_saved_state(s);
    if (size >= sizeof head)
        memcpy(&head, bytes, sizeof head);
    if (size < sizeof head || !is_whole(s, &head, bytes, size))
        return ll_error(LL_CONFLICT, "the state is damaged, or of another engine");
    if (!is_of_log(s, &head))
        return ll_error(LL_CONFLICT, "the state is not one that this log leads to");
    ll_status status = take(s, &head, (const char *)bytes + sizeof head);
    if (ll_failed(&status))
        ll_session_drop_saved_state(s);
    return status;
}

bool ll_session_is_asleep(const ll_session *s)
{
    return !s->block;
}

int64_t ll_session_saved_tick(const ll_session *s)
{
    return s->saved.checkpoint.tick;
}

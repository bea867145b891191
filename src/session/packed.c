/* Configurations of a session: all three lie in one block while they are used. While it is parked only the
 * bytes remain in which the first differs from the defaults, and each from the one before it.
 *
 * The block has pages of its own: a parked session leaves no hole between small blocks that stay. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

enum {
    CONFIGS = 3,  /* of the scenario, at tick 0, at present */
    SHORT_GAP = 8 /* equal bytes between two differences that cost more as a gap */
};

struct ll_packed {
    size_t size;
    size_t used; /* of the present configuration */
    int64_t seed;
    char title[LL_TITLE_MAX + 8];
    unsigned char bytes[];
};

/* ---- the block ---- */

static char *config_at(const ll_session *s, int i)
{
    return (char *)s->memory + (size_t)i * s->config_size;
}

bool ll_session_allocate(ll_session *s)
{
    const size_t configs = CONFIGS * s->config_size;
    s->memory = ll_state_memory_new_pages(configs);
    if (!s->memory)
        return false;
    memset(s->memory, 0, configs);
    s->scenario.config = config_at(s, 0);
    s->base = config_at(s, 1);
    s->config = config_at(s, 2);
    return true;
}

/* ---- differences: where, how many, their bytes; one of no bytes ends a configuration ---- */

typedef struct difference {
    uint32_t from, bytes;
} difference;

typedef struct writing {
    unsigned char *at; /* NULL: only counts */
    size_t size;
    char *known;        /* as it will be read so far */
    const char *object; /* that is written */
} writing;

static void write_difference(writing *w, size_t from, size_t bytes)
{
    difference d = {(uint32_t)from, (uint32_t)bytes};
    if (w->at) {
        memcpy(w->at + w->size, &d, sizeof d);
        memcpy(w->at + w->size + sizeof d, w->object + from, bytes);
    }
    memcpy(w->known + from, w->object + from, bytes);
    w->size += sizeof d + bytes;
}

static void write_range(void *context, size_t from, size_t bytes)
{
    writing *w = context;
    for (size_t i = from, end = from + bytes; i < end; i++) {
        if (w->known[i] == w->object[i])
            continue;
        size_t last = i;
        for (size_t j = i + 1; j < end && j - last <= SHORT_GAP; j++)
            if (w->known[j] != w->object[j])
                last = j;
        write_difference(w, i, last + 1 - i);
        i = last;
    }
}

/* The bytes in which `object` differs from `known`, which is then equal to it; `to` NULL: only their number.
 */
static size_t write_differences(const ll_session *s, void *known, const void *object, unsigned char *to)
{
    writing w = {.at = to, .known = known, .object = object};
    ll_param_each_range(s->scenario.kind->table, object, write_range, &w);
    write_difference(&w, 0, 0);
    return w.size;
}

/* Gives the end of what was read. */
static const unsigned char *read_differences(const ll_session *s, const unsigned char *at, void *object)
{
    difference d;
    for (memcpy(&d, at, sizeof d); d.bytes > 0; memcpy(&d, at, sizeof d)) {
        LL_ASSERT((size_t)d.from + d.bytes <= s->config_size);
        memcpy((char *)object + d.from, at + sizeof d, d.bytes);
        at += sizeof d + d.bytes;
    }
    return at + sizeof d;
}

/* Writes to `to`, or counts if it is NULL; false without memory. */
static bool write_all(const ll_session *s, unsigned char *to, size_t *size)
{
    const ll_param_table *table = s->scenario.kind->table;
    void *known = calloc(1, s->config_size);
    *size = 0;
    if (known)
        ll_param_defaults_in_zeros(table, known);
    for (int i = 0; i < CONFIGS && known; i++) {
        *size += write_differences(s, known, config_at(s, i), to ? to + *size : NULL);
        void *next = calloc(1, s->config_size);
        if (next)
            ll_param_copy(table, next, known);
        free(known);
        known = next;
    }
    bool done = known != NULL;
    free(known);
    return done;
}

static void read_all(const ll_session *s, const ll_packed *packed)
{
    const ll_param_table *table = s->scenario.kind->table;
    const unsigned char *at = packed->bytes;
    for (int i = 0; i < CONFIGS; i++) {
        if (i == 0)
            ll_param_defaults_in_zeros(table, config_at(s, 0));
        else
            ll_param_copy(table, config_at(s, i), config_at(s, i - 1));
        at = read_differences(s, at, config_at(s, i));
    }
    LL_ASSERT(at == packed->bytes + packed->size);
}

/* ---- packing ---- */

void ll_session_pack(ll_session *s)
{
    size_t size;
    if (s->packed || !write_all(s, NULL, &size))
        return; /* without memory it keeps its block */
    const ll_scenario_head *head = ll_session_head(s);
    ll_packed *packed = malloc(sizeof *packed + size);
    if (!packed)
        return;
    if (!write_all(s, packed->bytes, &packed->size)) {
        free(packed);
        return;
    }
    packed->used = ll_session_config_used(s);
    packed->seed = head->seed;
    memcpy(packed->title, head->title, sizeof packed->title);
    s->packed = packed;
    ll_state_memory_free(s->memory);
    s->memory = s->scenario.config = s->base = s->config = NULL;
}

ll_status ll_session_unpack(ll_session *s)
{
    if (!s->packed)
        return ll_ok();
    if (!ll_session_allocate(s))
        return ll_error(LL_NO_MEMORY, "out of memory: configuration of a session");
    read_all(s, s->packed);
    free(s->packed);
    s->packed = NULL;
    return ll_ok();
}

/* ---- what stays readable ---- */

int64_t ll_session_seed(const ll_session *s)
{
    return s->packed ? s->packed->seed : ll_session_head(s)->seed;
}

const char *ll_session_title(const ll_session *s)
{
    return s->packed ? s->packed->title : ll_session_head(s)->title;
}

size_t ll_session_config_used(const ll_session *s)
{
    return s->packed ? s->packed->used : ll_param_used(s->scenario.kind->table, s->config);
}

size_t ll_session_packed_bytes(const ll_session *s)
{
    size_t size = 0;
    if (s->packed)
        return sizeof *s->packed + s->packed->size;
    return write_all(s, NULL, &size) ? sizeof(ll_packed) + size : CONFIGS * ll_session_config_used(s);
}

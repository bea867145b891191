#include "netcode/snapshot/snapshot.h"

#include <string.h>

/* ---- exact values: 64-bit words ---- */

static void put_words(ll_bit_writer *w, const void *from, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t word;
        memcpy(&word, (const char *)from + i * sizeof word, sizeof word);
        ll_bits_put(w, word != 0, 1);
        if (word == 0)
            continue;
        ll_bits_put(w, word, 32);
        ll_bits_put(w, word >> 32, 32);
    }
}

static void get_words(ll_bit_reader *r, void *to, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t word = 0;
        if (ll_bits_get(r, 1)) {
            word = ll_bits_get(r, 32);
            word |= ll_bits_get(r, 32) << 32;
        }
        memcpy((char *)to + i * sizeof word, &word, sizeof word);
    }
}

#define REALS 6 /* of an entity, before its flags */
_Static_assert(offsetof(ll_entity, flags) == REALS * sizeof(uint64_t), "an entity is reals and flags");

void ll_put_exact(ll_bit_writer *w, const ll_entity *e)
{
    put_words(w, e, REALS);
    ll_bits_put_number(w, e->flags);
}

void ll_get_exact(ll_bit_reader *r, ll_entity *e)
{
    get_words(r, e, REALS);
    e->flags = ll_bits_get_number(r);
}

void ll_put_tail(ll_bit_writer *w, const ll_world *world)
{
    put_words(w, ll_world_tail_const(world), (size_t)world->tail / sizeof(uint64_t));
}

void ll_get_tail(ll_bit_reader *r, ll_world *world)
{
    get_words(r, ll_world_tail(world), (size_t)world->tail / sizeof(uint64_t));
}

/* ---- on the grid ---- */

void ll_put_cell(ll_bit_writer *w, const ll_cell *c, const ll_cell *from)
{
    bool rests = ll_cell_rests(c);
    ll_bits_put_signed(w, (int64_t)c->x - from->x);
    ll_bits_put_signed(w, (int64_t)c->y - from->y);
    ll_bits_put_signed(w, (int64_t)c->angle - from->angle);
    ll_bits_put(w, rests, 1);
    if (!rests) {
        ll_bits_put_signed(w, (int64_t)c->vx - from->vx);
        ll_bits_put_signed(w, (int64_t)c->vy - from->vy);
        ll_bits_put_signed(w, (int64_t)c->angular_velocity - from->angular_velocity);
    }
    ll_bits_put(w, c->flags != from->flags, 1);
    if (c->flags != from->flags)
        ll_bits_put_number(w, c->flags);
}

/* Clears `fits` if there is no such step. */
static int32_t get_steps(ll_bit_reader *r, int32_t from, bool *fits)
{
    int64_t difference = ll_bits_get_signed(r);
    if (difference < -2 * (int64_t)INT32_MAX || difference > 2 * (int64_t)INT32_MAX) {
        *fits = false;
        return 0;
    }
    int64_t n = from + difference;
    *fits = *fits && n >= -INT32_MAX && n <= INT32_MAX;
    return (int32_t)n;
}

bool ll_get_cell(ll_bit_reader *r, const ll_cell *from, ll_cell *c)
{
    bool fits = true;
    *c = (ll_cell){.flags = from->flags};
    c->x = get_steps(r, from->x, &fits);
    c->y = get_steps(r, from->y, &fits);
    c->angle = get_steps(r, from->angle, &fits);
    if (!ll_bits_get(r, 1)) {
        c->vx = get_steps(r, from->vx, &fits);
        c->vy = get_steps(r, from->vy, &fits);
        c->angular_velocity = get_steps(r, from->angular_velocity, &fits);
    }
    if (ll_bits_get(r, 1))
        c->flags = ll_bits_get_number(r);
    return fits;
}

ll_status ll_off_grid(int entity)
{
    return ll_error(LL_BAD_INPUT, "a member of entity %d must be less than 2^31 steps from 0", entity);
}

/* ---- cost ---- */

void ll_snapshot_cost_add(ll_snapshot_cost *sum, const ll_snapshot_cost *cost)
{
    sum->entity_bits += cost->entity_bits;
    sum->tail_bits += cost->tail_bits;
    sum->entities += cost->entities;
    sum->unchanged += cost->unchanged;
    sum->resting += cost->resting;
    sum->whole += cost->whole;
}

/* ---- the end ---- */

static ll_status ended(ll_bit_reader *r)
{
    if (r->at > r->size)
        return ll_error(LL_BAD_INPUT, "a snapshot ends too early: it has %lld bits", (long long)r->size);
    if (!ll_bits_ended_well(r))
        return ll_error(LL_BAD_INPUT, "a snapshot must end where its last member does; it has %lld bits",
                        (long long)r->size);
    return ll_ok();
}

static bool finite(const ll_entity *e)
{
    double sum = e->x + e->y + e->vx + e->vy + e->angle + e->angular_velocity;
    return sum - sum == 0;
}

static ll_status not_finite(int entity)
{
    return ll_error(LL_BAD_INPUT, "every member of an entity must be finite; entity %d has one that is not",
                    entity);
}

ll_status ll_decoded_slowly(ll_bit_reader *r, const ll_world *world)
{
    LL_TRY(ended(r));
    for (int i = 0; i < world->entities; i++)
        if (!finite(&world->entity[i]))
            return not_finite(i);
    return ll_ok();
}

ll_status ll_decoded_some(ll_bit_reader *r, const ll_world *world, const ll_changed *changed)
{
    LL_TRY(ended(r));
    for (int k = 0; k < changed->count; k++)
        if (!finite(&world->entity[changed->entity[k]]))
            return not_finite(changed->entity[k]);
    return ll_ok();
}

/* ---- full: the world as it lies in memory. The simplest encoding: 448 bits per entity ---- */

static void encode_full(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    int64_t bits = 8 * (int64_t)ll_world_size(out->world);
    if (bits <= w->capacity)
        memcpy(w->bytes, out->world, ll_world_size(out->world));
    w->count += bits;
    cost->entity_bits += out->world->entities * 8 * (int64_t)sizeof(ll_entity);
    cost->tail_bits += 8 * (int64_t)out->world->tail;
    cost->entities += out->world->entities;
}

static ll_status decode_full(ll_bit_reader *r, const ll_incoming *in)
{
    size_t size = ll_world_size(in->world);
    if (r->size != 8 * (int64_t)size)
        return ll_error(LL_BAD_INPUT, "a full snapshot of this world must have %zu bytes; got %lld", size,
                        (long long)r->size / 8);
    if (memcmp(in->world, r->bytes, sizeof *in->world) != 0)
        return ll_error(
            LL_BAD_INPUT,
            "a full snapshot must be of a world of %d players, %d entities and a tail of %d bytes",
            in->world->players, in->world->entities, in->world->tail);
    memcpy(in->world, r->bytes, size);
    r->at = r->size;
    return ll_decoded(r, in->world);
}

const ll_codec ll_codec_full = {.name = "full", .encode = encode_full, .decode = decode_full};

/* ---- the table ---- */

#define ROW(name) &ll_codec_##name,
#define NAME(name) #name,

const ll_codec *const ll_codecs[] = {LL_CODECS(ROW) NULL};
const char *const ll_codec_names[] = {LL_CODECS(NAME) NULL};

int ll_codec_index(const ll_codec *codec)
{
    int i = 0;
    while (ll_codecs[i] != codec)
        i++;
    return i;
}

const ll_codec *ll_codec_at(int index)
{
    for (int i = 0; ll_codecs[i] != NULL; i++)
        if (i == index)
            return ll_codecs[i];
    return NULL;
}

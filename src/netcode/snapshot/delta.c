/* Delta: the differences from a baseline, a snapshot that the client has acknowledged (Fiedler, "Snapshot
 * Compression"; Quake III). Of the entities on the grid only changed ones are sent, each after the number of
 * entities skipped before it; after the last comes the number skipped to the end. The receiver's own entity
 * comes first, bitwise; an unchanged tail is one bit. */
#include "netcode/snapshot/common.h"

#include <string.h>

static bool changed(const ll_outgoing *out, int i)
{
    const ll_cell *c = &out->cells[i];
    return i != out->self && (!ll_cell_fits(c) || memcmp(c, &out->baseline[i], sizeof *c) != 0);
}

/* The cell that an entity is compared with: zero where the baseline's does not fit the grid. */
static ll_cell origin(const ll_cell *baseline)
{
    return ll_cell_fits(baseline) ? *baseline : (ll_cell){0};
}

static void put_entity(ll_bit_writer *w, const ll_outgoing *out, int i)
{
    const ll_cell *c = &out->cells[i];
    ll_bits_put(w, !ll_cell_fits(c), 1);
    if (ll_cell_fits(c)) {
        ll_cell from = origin(&out->baseline[i]);
        ll_put_cell(w, c, &from);
    } else {
        ll_put_exact(w, &out->world->entity[i]);
    }
}

/* Counts what is not sent of the entities from..to - 1, or rests. */
static void count(const ll_outgoing *out, int from, int to, ll_snapshot_cost *cost)
{
    for (int i = from; i < to; i++) {
        const ll_cell *c = &out->cells[i];
        cost->resting += i != out->self && ll_cell_fits(c) && ll_cell_rests(c);
        cost->unchanged += i != out->self && !changed(out, i);
    }
}

static int first_changed(const ll_outgoing *out)
{
    int i = out->receivers;
    while (i < out->world->entities && !changed(out, i))
        i++;
    return i;
}

/* The gap before `first` depends on the receiver. */
static void put_others(ll_bit_writer *w, const ll_outgoing *out, int first, ll_snapshot_cost *cost)
{
    int entities = out->world->entities, next = first;
    int64_t start = w->count;
    count(out, out->receivers, entities, cost);
    for (int i = first; i < entities; i++) {
        if (!changed(out, i))
            continue;
        if (i > first)
            ll_bits_put_number(w, (uint64_t)(i - next));
        put_entity(w, out, i);
        next = i + 1;
    }
    if (first < entities)
        ll_bits_put_number(w, (uint64_t)(entities - next));
    cost->entity_bits += w->count - start;
    start = w->count;
    ll_bits_put(w, out->same_tail, 1);
    if (!out->same_tail)
        ll_put_tail(w, out->world);
    cost->tail_bits += w->count - start;
}

static const ll_common_codec others = {.first = first_changed, .put = put_others};

static void encode(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    const ll_common_part *part = ll_common_part_of(out, &others);
    int first = part ? part->first : first_changed(out), next = 0;
    int64_t start = w->count;
    ll_put_exact(w, &out->world->entity[out->self]);
    count(out, 0, out->receivers, cost);
    for (int i = 0; i < out->receivers; i++) {
        if (!changed(out, i))
            continue;
        ll_bits_put_number(w, (uint64_t)(i - next));
        put_entity(w, out, i);
        next = i + 1;
    }
    ll_bits_put_number(w, (uint64_t)(first - next));
    cost->entities += out->world->entities;
    cost->entity_bits += w->count - start;
    ll_put_common(w, out, &others, part, first, cost);
}

static bool get_entity(ll_bit_reader *r, const ll_incoming *in, int i)
{
    if (ll_bits_get(r, 1)) {
        ll_get_exact(r, &in->world->entity[i]);
        return true;
    }
    ll_cell before = ll_cell_of(&in->baseline->entity[i], in->grid), from = origin(&before), cell;
    bool fits = ll_get_cell(r, &from, &cell);
    in->world->entity[i] = ll_cell_entity(&cell, in->grid);
    return fits;
}

static ll_status get_changed(ll_bit_reader *r, const ll_incoming *in)
{
    int count = in->world->entities;
    for (int next = 0;; next++) {
        uint64_t gap = ll_bits_get_number(r);
        if (gap > (uint64_t)(count - next))
            return ll_error(LL_BAD_INPUT, "at most %d entities can be skipped after %d of %d; got %llu",
                            count - next, next, count, (unsigned long long)gap);
        next += (int)gap;
        if (next == count)
            return ll_ok();
        if (next == in->self)
            return ll_error(LL_BAD_INPUT, "the receiver's own entity, %d, is sent twice", next);
        if (!get_entity(r, in, next))
            return ll_off_grid(next);
    }
}

/* The baseline lies on the grid, because it was received on it. */
static ll_status decode(ll_bit_reader *r, const ll_incoming *in)
{
    memcpy(in->world->entity, in->baseline->entity, (size_t)in->world->entities * sizeof(ll_entity));
    ll_get_exact(r, &in->world->entity[in->self]);
    LL_TRY(get_changed(r, in));
    if (ll_bits_get(r, 1))
        memcpy(ll_world_tail(in->world), ll_world_tail_const(in->baseline), (size_t)in->world->tail);
    else
        ll_get_tail(r, in->world);
    return ll_decoded(r, in->world);
}

const ll_codec ll_codec_delta = {
    .name = "delta",
    .gridded = true,
    .compares = true,
    .encode = encode,
    .decode = decode,
};

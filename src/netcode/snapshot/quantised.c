/* Quantised: the grid's four steps, then each entity in steps from zero, small numbers with few bits, and one
 * bit in place of the velocities of an entity at rest (Fiedler, "Snapshot Compression"). The receiver's own
 * entity, and one that does not fit the grid, are sent bitwise. */
#include <string.h>

#include "netcode/snapshot/common.h"

void ll_put_grid(ll_bit_writer *w, const ll_quantization *grid)
{
    const float steps[] = {grid->m, grid->mps, grid->rad, grid->radps};
    for (int i = 0; i < 4; i++) {
        uint32_t bits;
        memcpy(&bits, &steps[i], sizeof bits);
        ll_bits_put(w, bits, 32);
    }
}

ll_status ll_get_grid(ll_bit_reader *r, ll_quantization *grid)
{
    float steps[4];
    for (int i = 0; i < 4; i++) {
        uint32_t bits = (uint32_t)ll_bits_get(r, 32);
        memcpy(&steps[i], &bits, sizeof bits);
        if (!(steps[i] >= 1e-6f && steps[i] <= 1e6f)) /* false for NaN too */
            return ll_error(LL_BAD_INPUT, "a step of a grid must be 1e-06 to 1e+06; got %g",
                            (double)steps[i]);
    }
    *grid = (ll_quantization){steps[0], steps[1], steps[2], steps[3]};
    return ll_ok();
}

/* The entities from..to - 1. */
static void put_entities(ll_bit_writer *w, const ll_outgoing *out, int from, int to, ll_snapshot_cost *cost)
{
    const ll_cell zero = {0};
    int64_t start = w->count;
    for (int i = from; i < to; i++) {
        const ll_cell *c = &out->cells[i];
        bool exact = i == out->self || !ll_cell_fits(c);
        if (i != out->self)
            ll_bits_put(w, exact, 1);
        if (exact)
            ll_put_exact(w, &out->world->entity[i]);
        else
            ll_put_cell(w, c, &zero);
        cost->resting += !exact && ll_cell_rests(c);
    }
    cost->entity_bits += w->count - start;
}

static int first_of_others(const ll_outgoing *out)
{
    return out->receivers;
}

static void put_others(ll_bit_writer *w, const ll_outgoing *out, int first, ll_snapshot_cost *cost)
{
    put_entities(w, out, first, out->world->entities, cost);
    int64_t start = w->count;
    ll_put_tail(w, out->world);
    cost->tail_bits += w->count - start;
}

static const ll_common_codec others = {.first = first_of_others, .put = put_others};

static void encode(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    const ll_common_part *part = ll_common_part_of(out, &others);
    ll_put_grid(w, out->grid);
    put_entities(w, out, 0, out->receivers, cost);
    cost->entities += out->world->entities;
    ll_put_common(w, out, &others, part, out->receivers, cost);
}

static ll_status decode(ll_bit_reader *r, const ll_incoming *in)
{
    const ll_cell zero = {0};
    LL_TRY(ll_get_grid(r, in->grid));
    for (int i = 0; i < in->world->entities; i++) {
        ll_entity *e = &in->world->entity[i];
        ll_cell cell;
        if (i == in->self || ll_bits_get(r, 1)) {
            ll_get_exact(r, e);
            continue;
        }
        if (!ll_get_cell(r, &zero, &cell))
            return ll_off_grid(i);
        *e = ll_cell_entity(&cell, in->grid);
    }
    ll_get_tail(r, in->world);
    return ll_decoded(r, in->world);
}

const ll_codec ll_codec_quantised = {
    .name = "quantised",
    .gridded = true,
    .encode = encode,
    .decode = decode,
};

/* A small precomputed tile of sea, repeated in space and in a loop, like sprites in games. It costs a copy,
 * and its pattern repeats in time and space. */
#include <string.h>

#include "fluid/ocean/state.h"

/* Part of the block: the frames (height, dx, dz of each), and the ocean that made them. */

static ll_ocean_setup tile_of(const ll_ocean_setup *s)
{
    ll_ocean_setup tile = *s;
    tile.method = LL_OCEAN_SPECTRUM;
    tile.n = s->tile;
    tile.length = s->length * (double)s->tile / (double)s->n;
    return tile;
}

static size_t pictures_size(const ll_ocean_setup *s)
{
    return (3 * (size_t)(s->frames * s->tile * s->tile) * sizeof(double) + 63) & ~(size_t)63;
}

static size_t size(const ll_ocean_setup *s)
{
    ll_ocean_setup tile = tile_of(s);
    return pictures_size(s) + ll_ocean_size_by(&ll_ocean_spectrum, &tile);
}

static double *picture(const ll_ocean *o, int64_t frame)
{
    return (double *)ll_ocean_part(o, o->at_method) + 3 * frame * o->setup.tile * o->setup.tile;
}

static void init(ll_ocean *o)
{
    ll_ocean_setup tile = tile_of(&o->setup);
    void *block = (char *)ll_ocean_part(o, o->at_method) + pictures_size(&o->setup);
    ll_ocean *source = ll_ocean_init_by(&ll_ocean_spectrum, block, &tile);
    ll_ocean_surface s = ll_ocean_surface_of(source);
    size_t bytes = (size_t)(tile.n * tile.n) * sizeof(double);
    ll_time loop = ll_ms(1e3 * o->setup.loop_s);
    for (int64_t frame = 0; frame < o->setup.frames; frame++) {
        ll_ocean_spectrum.evaluate(source, loop / o->setup.frames * frame);
        double *to = picture(o, frame);
        memcpy(to, s.height, bytes);
        memcpy(to + tile.n * tile.n, s.dx, bytes);
        memcpy(to + 2 * tile.n * tile.n, s.dz, bytes);
    }
}

static void evaluate(ll_ocean *o, ll_time t)
{
    int64_t n = o->setup.n, tile = o->setup.tile;
    ll_time loop = ll_ms(1e3 * o->setup.loop_s), length = loop / o->setup.frames;
    int64_t frame = t % loop / length;
    const double *from = picture(o, frame < o->setup.frames ? frame : o->setup.frames - 1);
    const int64_t to[3] = {o->at_height, o->at_dx, o->at_dz};
    for (int field = 0; field < 3; field++)
        for (int64_t j = 0; j < n; j++)
            for (int64_t i = 0; i < n; i += tile)
                memcpy((double *)ll_ocean_part(o, to[field]) + j * n + i,
                       from + (field * tile + j % tile) * tile, (size_t)tile * sizeof(double));
}

/* A tile of the spectrum's sea, precomputed, repeated in space and frame by frame in a loop: costs a
 * copy, like sprites. */
const ll_ocean_method ll_ocean_tiled = {
    .size = size,
    .init = init,
    .evaluate = evaluate,
};

/* The block of an ocean that a method makes. */
#include <string.h>

#include "fluid/ocean/state.h"

static int64_t place(int64_t *end, size_t size)
{
    int64_t at = *end;
    *end = (at + (int64_t)size + 63) & ~INT64_C(63);
    return at;
}

static ll_ocean layout_of(const ll_ocean_method *method, const ll_ocean_setup *s)
{
    ll_ocean o = {.setup = *s};
    size_t points = (size_t)(s->n * s->n) * sizeof(double);
    int64_t end = 0;
    place(&end, sizeof o);
    o.at_height = place(&end, points);
    o.at_dx = place(&end, points);
    o.at_dz = place(&end, points);
    o.at_method = place(&end, method->size(s));
    o.at_end = end;
    return o;
}

size_t ll_ocean_size_by(const ll_ocean_method *method, const ll_ocean_setup *setup)
{
    return (size_t)layout_of(method, setup).at_end;
}

ll_ocean *ll_ocean_init_by(const ll_ocean_method *method, void *block, const ll_ocean_setup *setup)
{
    ll_ocean *o = block;
    ll_ocean head = layout_of(method, setup);
    memset(block, 0, (size_t)head.at_end);
    *o = head;
    method->init(o);
    method->evaluate(o, 0);
    return o;
}

ll_ocean_surface ll_ocean_surface_of(const ll_ocean *o)
{
    return (ll_ocean_surface){.n = o->setup.n,
                              .length = o->setup.length,
                              .height = ll_ocean_part(o, o->at_height),
                              .dx = ll_ocean_part(o, o->at_dx),
                              .dz = ll_ocean_part(o, o->at_dz)};
}

const ll_ocean_setup *ll_ocean_setup_of(const ll_ocean *o)
{
    return &o->setup;
}

/* What the methods of an ocean share: its block, and waves of the linear theory. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/ocean/state.h"

/* ---- the block that a method makes ---- */

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

/* ---- waves, and how much of the sea's energy they have ---- */

#define TURN 6.283185307179586

double ll_ocean_frequency(double k, double gravity, double depth)
{
    double decay = depth > 0 ? ll_exp(-2 * k * depth) : 0;
    return sqrt(gravity * k * (1 - decay) / (1 + decay)); /* the fraction is tanh(k depth) */
}

ll_wave ll_wave_of(const ll_ocean_setup *s, int64_t mx, int64_t mz)
{
    double step = TURN / s->length;
    ll_wave w = {.kx = step * (double)mx, .kz = step * (double)mz};
    w.k = sqrt(w.kx * w.kx + w.kz * w.kz);
    w.frequency = ll_ocean_frequency(w.k, s->gravity, s->depth);
    if (s->loop_s > 0) {
        w.cycles = (int64_t)(w.frequency * s->loop_s / TURN + 0.5);
        w.cycles = w.cycles > 0 ? w.cycles : 1;
        w.frequency = TURN * (double)w.cycles / s->loop_s;
    }
    return w;
}

double ll_wave_angle(const ll_ocean_setup *s, const ll_wave *w, ll_time t)
{
    if (!(s->loop_s > 0))
        return w->frequency * ll_to_s(t);
    ll_time loop = ll_ms(1e3 * s->loop_s);
    double turns = (double)w->cycles * ((double)(t % loop) / (double)loop);
    return TURN * (turns - (double)(int64_t)turns);
}

double ll_ocean_energy(const ll_ocean_setup *s, double frequency)
{
    if (!(s->wind_speed > 0))
        return 0;
    double r = s->gravity / (s->wind_speed * frequency), r2 = r * r, f2 = frequency * frequency;
    return 8.1e-3 * s->gravity * s->gravity / (f2 * f2 * frequency) * ll_exp(-0.74 * r2 * r2);
}

/* Waves of the linear theory, and how much of the sea's energy they have. */
#include <math.h>

#include "base/detmath.h"
#include "fluid/ocean/state.h"

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

#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/ocean_internal.h"
#include "fluid/ocean_table.h"

#define TURN 6.283185307179586

static const ll_ocean_method *const methods[] = {&ll_ocean_gerstner, &ll_ocean_spectrum, &ll_ocean_tiled};

/* In the order of `methods`; a test compares them. */
const char *const ll_ocean_method_names[] = {"gerstner", "spectrum", "tiled", NULL};

const char *ll_ocean_method_help(ll_ocean_method_kind kind)
{
    return methods[kind]->help;
}

static const ll_param rows[] = {
    LL_OCEAN_ROW(method, "method", .type = LL_PARAM_CHOICE, .choices = ll_ocean_method_names,
                 .standard = LL_OCEAN_SPECTRUM, .help = "Method for the surface."),
    LL_OCEAN_REAL(choppiness, "choppiness", 0, 1.5, 1, NULL, "Scale of the horizontal displacement."),
    LL_OCEAN_ROWS(256, 0),
};

static ll_status check_rows(const void *object, const char *path)
{
    (void)path;
    return ll_ocean_check(object);
}

const ll_param_table ll_ocean_table = {.name = "ocean",
                                       .help = "The surface of an ocean.",
                                       .rows = rows,
                                       .count = sizeof rows / sizeof rows[0],
                                       .size = sizeof(ll_ocean_setup),
                                       .check = check_rows};

ll_status ll_ocean_check(const ll_ocean_setup *s)
{
    if (s->n % 2 != 0 || !ll_fft_allowed(s->n))
        return ll_field_error(LL_BAD_INPUT, "n", "n: must be even, without prime factors above 5; got %lld.",
                              (long long)s->n);
    if (s->method != LL_OCEAN_TILED)
        return ll_ok();
    if (s->tile % 2 != 0 || !ll_fft_allowed(s->tile) || s->n % s->tile != 0)
        return ll_field_error(
            LL_BAD_INPUT, "tile",
            "tile: must be even, without prime factors above 5, and divide n; got %lld for n %lld.",
            (long long)s->tile, (long long)s->n);
    if (!(s->loop_s > 0))
        return ll_field_error(LL_BAD_INPUT, "loop_s", "loop_s: must be above 0 s for tiled; got %g.",
                              s->loop_s);
    if (s->tile * s->tile * s->frames > 1 << 22)
        return ll_field_error(LL_LIMIT, "frames",
                              "frames: %lld frames of the tile need %lld MiB; at most 96 are allowed.",
                              (long long)s->frames, (long long)(s->tile * s->tile * s->frames * 24 >> 20));
    return ll_ok();
}

/* ---- waves ---- */

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

/* Energy below `frequency`: the integral of the spectrum. */
static double slower(const ll_ocean_setup *s, double frequency)
{
    double r = s->gravity / (s->wind_speed * frequency), r2 = r * r;
    return ll_exp(-0.74 * r2 * r2);
}

ll_ocean_fit ll_ocean_fit_of(const ll_ocean_setup *s)
{
    double cell = s->length / (double)s->n;
    ll_ocean_fit fit = {.length = s->method == LL_OCEAN_TILED ? cell * (double)s->tile : s->length};
    if (!(s->wind_speed > 0))
        return fit;
    double peak = 0.877 * s->gravity / s->wind_speed;
    fit.peak = TURN * s->gravity / (peak * peak);
    fit.longer = slower(s, ll_ocean_frequency(TURN / fit.length, s->gravity, s->depth));
    fit.shorter = 1 - slower(s, ll_ocean_frequency(TURN / (2 * cell), s->gravity, s->depth));
    fit.height = 4 * sqrt(8.1e-3 / (4 * 0.74)) * s->wind_speed * s->wind_speed / s->gravity;
    return fit;
}

/* ---- the block ---- */

static int64_t place(int64_t *end, size_t size)
{
    int64_t at = *end;
    *end = (at + (int64_t)size + 63) & ~INT64_C(63);
    return at;
}

static ll_ocean layout_of(const ll_ocean_setup *s)
{
    ll_ocean o = {.setup = *s};
    size_t points = (size_t)(s->n * s->n) * sizeof(double);
    int64_t end = 0;
    place(&end, sizeof o);
    o.at_height = place(&end, points);
    o.at_dx = place(&end, points);
    o.at_dz = place(&end, points);
    o.at_method = place(&end, methods[s->method]->size(s));
    o.at_end = end;
    return o;
}

size_t ll_ocean_size(const ll_ocean_setup *setup)
{
    return (size_t)layout_of(setup).at_end;
}

ll_ocean *ll_ocean_init(void *block, const ll_ocean_setup *setup)
{
    ll_ocean *o = block;
    ll_ocean head = layout_of(setup);
    memset(block, 0, (size_t)head.at_end);
    *o = head;
    methods[setup->method]->init(o);
    ll_ocean_evaluate(o, 0);
    return o;
}

void ll_ocean_evaluate(ll_ocean *o, ll_time t)
{
    methods[o->setup.method]->evaluate(o, t);
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

/* ---- between points ---- */

typedef struct spot {
    int64_t at[4];
    double weight[4];
} spot;

static int64_t wrapped(int64_t i, int64_t n)
{
    return (i % n + n) % n;
}

static spot spot_of(const ll_ocean *o, double x, double z)
{
    int64_t n = o->setup.n;
    double per = (double)n / o->setup.length, fx = floor(x * per), fz = floor(z * per);
    double u = x * per - fx, v = z * per - fz;
    int64_t i = wrapped((int64_t)fx, n), j = wrapped((int64_t)fz, n), right = (i + 1) % n, up = (j + 1) % n;
    return (spot){{j * n + i, j * n + right, up * n + i, up * n + right},
                  {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v}};
}

static double blend(const double *values, const spot *s)
{
    double sum = 0;
    for (int i = 0; i < 4; i++)
        sum += s->weight[i] * values[s->at[i]];
    return sum;
}

/* The rest position of the point displaced to (x, z), by fixed-point iteration, which converges while no wave
 * breaks. */
double ll_ocean_height_at(const ll_ocean *o, double x, double z)
{
    ll_ocean_surface s = ll_ocean_surface_of(o);
    spot at = spot_of(o, x, z);
    for (int i = 0; i < 8; i++)
        at = spot_of(o, x - blend(s.dx, &at), z - blend(s.dz, &at));
    return blend(s.height, &at);
}

#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "fluid/ocean/parameters.h"
#include "fluid/ocean/state.h"

#define TURN 6.283185307179586

#define METHODS(X) X(GERSTNER, gerstner) X(SPECTRUM, spectrum) X(TILED, tiled)
#define ROW(kind, name) [LL_OCEAN_##kind] = &ll_ocean_##name,
#define NAME(kind, name) [LL_OCEAN_##kind] = #name,

static const ll_ocean_method *const methods[] = {METHODS(ROW)};
const char *const ll_ocean_method_names[LL_OCEAN_METHODS + 1] = {METHODS(NAME)};

static const ll_param rows[] = {
    LL_OCEAN_ROW(method, "method", .type = LL_PARAM_CHOICE, .choices = ll_ocean_method_names,
                 .default_value = LL_OCEAN_SPECTRUM, .help = "Method for the surface."),
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
                                       LL_PARAM_ROWS(rows, ll_ocean_setup),
                                       .check = check_rows};

ll_status ll_ocean_check(const ll_ocean_setup *s)
{
    if (s->n % 2 != 0 || !ll_fft_allowed(s->n))
        return ll_field_error(LL_BAD_INPUT, "n", "n: must be even, without prime factors above 5; got %lld.",
                              (long long)s->n);
    const double loop_min_s = 1e-6; /* a frame of it, at most 256, is some ns, and time is counted in these */
    if (s->loop_s > 0 && s->loop_s < loop_min_s)
        return ll_field_error(LL_BAD_INPUT, "loop_s", "loop_s: must be 0 or at least %g s; got %g.",
                              loop_min_s, s->loop_s);
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
    LL_ASSERT(fit.length > 0 && cell > 0);
    fit.longer = slower(s, ll_ocean_frequency(TURN / fit.length, s->gravity, s->depth));
    fit.shorter = 1 - slower(s, ll_ocean_frequency(TURN / (2 * cell), s->gravity, s->depth));
    fit.height = 4 * sqrt(8.1e-3 / (4 * 0.74)) * s->wind_speed * s->wind_speed / s->gravity;
    return fit;
}

/* ---- the block ---- */

size_t ll_ocean_size(const ll_ocean_setup *setup)
{
    return ll_ocean_size_by(methods[setup->method], setup);
}

ll_ocean *ll_ocean_init(void *block, const ll_ocean_setup *setup)
{
    return ll_ocean_init_by(methods[setup->method], block, setup);
}

void ll_ocean_evaluate(ll_ocean *o, ll_time t)
{
    methods[o->setup.method]->evaluate(o, t);
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

/* A box on the surface: sixteen vertical columns, each lifted by the water that it displaces. */

enum { COLUMNS = 4 };

void ll_buoy_step(ll_buoy *b, const ll_ocean *o, double dt)
{
    double g = ll_ocean_setup_of(o)->gravity, lift = 0, right = 0, far = 0;
    for (int j = 0; j < COLUMNS; j++)
        for (int i = 0; i < COLUMNS; i++) {
            double x = ((i + 0.5) / COLUMNS - 0.5) * b->width, z = ((j + 0.5) / COLUMNS - 0.5) * b->length;
            double bottom = b->y + b->pitch * x + b->roll * z - b->height / 2;
            double wet = ll_ocean_height_at(o, b->x + x, b->z + z) - bottom;
            wet = wet > 0 ? (wet < b->height ? wet : b->height) : 0;
            double speed = b->speed + b->pitch_rate * x + b->roll_rate * z;
            /* Force on a column over the mass of the whole box: its weight is 1 g in total. */
            double force = (wet / b->height) / b->density * (g - b->drag * speed) / (COLUMNS * COLUMNS);
            lift += force;
            right += force * x;
            far += force * z;
        }
    double square = b->height * b->height;
    b->speed += dt * (lift - g);
    b->pitch_rate += dt * 12 * right / (b->width * b->width + square);
    b->roll_rate += dt * 12 * far / (b->length * b->length + square);
    b->y += dt * b->speed;
    b->pitch += dt * b->pitch_rate;
    b->roll += dt * b->roll_rate;
}

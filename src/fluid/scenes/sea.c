/* A sea state as a row of fluid.h, with a box that floats on it. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fluid/ocean/parameters.h"
#include "fluid/scenes/scenes.h"

typedef struct solver {
    double choppiness;
    int32_t method; /* ll_ocean_method_kind */
    int32_t reserved;
} solver;

/* Start of the block, before the ocean. */
typedef struct sea {
    ll_ocean_setup setup;
    ll_time now;
    ll_buoy buoy;
} sea;

#define OCEAN_AT ((sizeof(sea) + 63) & ~(size_t)63)

static ll_ocean *ocean_of(const void *block)
{
    return (ll_ocean *)((char *)(uintptr_t)block + OCEAN_AT);
}

/* ---- tables ---- */

static const ll_param param_rows[] = {LL_OCEAN_ROWS(128, 30)};
const ll_param_table ll_fluid_sea_params = {.name = "sea_state",
                                            .help = "A square of fully developed sea.",
                                            LL_PARAM_ROWS(param_rows, ll_ocean_setup)};

static const ll_param solver_rows[] = {
    {LL_PARAM_ROW("method", CHOICE, solver, method), .choices = ll_ocean_method_names,
     .default_value = LL_OCEAN_SPECTRUM, .live = true, .help = "Method for the surface."},
    {LL_PARAM_ROW("choppiness", REAL, solver, choppiness), .max = 1.5, .default_value = 1, .live = true,
     .help = "Scale of the horizontal displacement."},
};
const ll_param_table ll_fluid_sea_solver = {
    .name = "sea_solver", .help = "Parameters of a sea's surface.", LL_PARAM_ROWS(solver_rows, solver)};

/* ---- the scene ---- */

static ll_ocean_setup setup_by(const void *params, int32_t method, double choppiness)
{
    ll_ocean_setup s = *(const ll_ocean_setup *)params;
    s.method = method;
    s.choppiness = choppiness;
    return s;
}

static size_t size(const void *params, const void *given)
{
    size_t most = 0;
    (void)given;
    for (int32_t method = 0; method < LL_OCEAN_METHODS; method++) {
        ll_ocean_setup s = setup_by(params, method, 1);
        size_t bytes = ll_ocean_size(&s);
        most = bytes > most ? bytes : most;
    }
    return OCEAN_AT + most;
}

/* Checks every method, since it may be changed. */
static ll_status check(const void *params, const void *given)
{
    for (int32_t method = 0; method < LL_OCEAN_METHODS; method++) {
        ll_ocean_setup s = setup_by(params, method, 1);
        ll_status status = ll_ocean_check(&s);
        if (ll_failed(&status)) {
            char field[sizeof status.field];
            snprintf(field, sizeof field, "params.%.50s", status.field);
            return ll_field_error(LL_BAD_INPUT, field, "params.%s", status.text);
        }
    }
    return ll_fluid_check_bytes("params.n", "the ocean", (int64_t)size(params, given));
}

static void set_solver(void *block, const void *given)
{
    sea *s = block;
    const solver *now = given;
    s->setup = setup_by(&s->setup, now->method, now->choppiness);
    ll_ocean_init(ocean_of(block), &s->setup);
    ll_ocean_evaluate(ocean_of(block), s->now);
}

static void init(void *block, const void *params, const void *given)
{
    sea *s = block;
    memset(block, 0, size(params, given));
    s->setup = *(const ll_ocean_setup *)params;
    double middle = s->setup.length / 2;
    s->buoy = (ll_buoy){
        .x = middle, .z = middle, .width = 4, .length = 8, .height = 2, .density = 0.5, .drag = 1.5};
    set_solver(block, given);
}

static ll_status step(void *block, double dt, const ll_fluid_run *run)
{
    (void)run; /* a tick is one transform */
    sea *s = block;
    s->now += ll_ms(1e3 * dt);
    ll_ocean_evaluate(ocean_of(block), s->now);
    ll_buoy_step(&s->buoy, ocean_of(block), dt);
    return ll_ok();
}

/* ---- queries ---- */

#define SEA_TRACED(X)                                                                                        \
    X(number, significant_height_m, "m", significant,                                                        \
      "significant wave height: four standard deviations of the surface", LL_FLUID_FAILED)                   \
    X(signed_number, height_min_m, "m", low, "height of the lowest point of the surface", LL_FLUID_FAILED)   \
    X(signed_number, height_max_m, "m", high, "height of the highest point of the surface", LL_FLUID_FAILED) \
    X(signed_number, height_mean_m, "m", sum / points, "mean height of the surface", LL_FLUID_FAILED)        \
    X(signed_number, body_y_m, "m", s->buoy.y, "height of the floating box", LL_FLUID_FAILED)                \
    X(signed_number, body_pitch_rad, "rad", s->buoy.pitch, "pitch angle of the floating box",                \
      LL_FLUID_FAILED)                                                                                       \
    X(signed_number, body_roll_rad, "rad", s->buoy.roll, "roll angle of the floating box", LL_FLUID_FAILED)  \
    X(signed_number, water_at_body_m, "m", ll_ocean_height_at(ocean_of(block), s->buoy.x, s->buoy.z),        \
      "height of the water at the floating box", LL_FLUID_FAILED)

#define SEA(X)                                                                                               \
    SEA_TRACED(X)                                                                                            \
    X(number, wind_sea_height_m, "m", fit.height,                                                            \
      "significant wave height of the sea that the wind raises on an unlimited surface", LL_FLUID_FAILED)    \
    X(number, wind_sea_share_in_box, NULL, fit.height > 0 ? fmax(0, 1 - fit.longer - fit.shorter) : NAN,     \
      "share of the energy of the wind's sea that the box and its cells can represent",                      \
      LL_FLUID_FAILED " Or the wind raises no sea.")                                                         \
    X(signed_number, height_error, NULL, fit.height > 0 ? significant / fit.height - 1 : NAN,                \
      "error of the significant wave height against that of the wind's sea, relative",                       \
      LL_FLUID_FAILED " Or the wind raises no sea.")                                                         \
    X(signed_number, excess_kurtosis, NULL, kurtosis - 3,                                                    \
      "excess kurtosis of the surface's heights: 0 for many independent waves, -1.5 for a single one",       \
      LL_FLUID_FAILED " Or the surface is flat.")

const ll_metric_table ll_fluid_sea_metrics = {.path = "",
                                              .also = LL_FLUID_AGAIN,
                                              .when = "Only of the method ocean.",
                                              .help = "Measures of the surface of an ocean, now.",
                                              LL_METRICS_FROM(SEA)};

const ll_metric_table ll_fluid_sea_traced = {.path = "",
                                             .when = "Only of the method ocean.",
                                             .help = "Measures that are also columns of the trace.",
                                             LL_METRICS_FROM(SEA_TRACED)};

static int numbers(const void *block, ll_fluid_number *out)
{
    const sea *s = block;
    ll_ocean_surface f = ll_ocean_surface_of(ocean_of(block));
    ll_ocean_fit fit = ll_ocean_fit_of(&s->setup);
    double sum = 0, squares = 0, low = INFINITY, high = -INFINITY, points = (double)(f.n * f.n);
    for (int64_t i = 0; i < f.n * f.n; i++) {
        sum += f.height[i];
        squares += f.height[i] * f.height[i];
        low = fmin(low, f.height[i]);
        high = fmax(high, f.height[i]);
    }
    double fourth = 0, mean = sum / points, variance = squares / points - mean * mean;
    for (int64_t i = 0; i < f.n * f.n; i++)
        fourth += (f.height[i] - mean) * (f.height[i] - mean) * (f.height[i] - mean) * (f.height[i] - mean);
    double kurtosis = variance > 0 ? fourth / points / (variance * variance) : NAN;
    double significant = 4 * sqrt(fmax(squares / points - sum / points * (sum / points), 0));
    return LL_FLUID_TELL(out, SEA);
}

/* Fraction of the energy above which the wave height differs notably from the wind's. */
static const double share_told = 0.05;

static int notices(const void *block, ll_fluid_notice *out)
{
    const ll_ocean_setup *s = &((const sea *)block)->setup;
    ll_ocean_fit fit = ll_ocean_fit_of(s);
    const char *where = s->method == LL_OCEAN_TILED ? "tile" : "box";
    int count = 0;
    if (fit.longer > share_told)
        snprintf(out[count++].text, sizeof out->text,
                 "%.0f %% of the sea's energy is in waves longer than the %s of %.4g m (at a wind of %g m/s "
                 "the peak has %.0f m), which do not fit: the significant height is not the wind's %.3g m.",
                 100 * fit.longer, where, fit.length, s->wind_speed, fit.peak, fit.height);
    if (fit.shorter > share_told)
        snprintf(out[count++].text, sizeof out->text,
                 "%.0f %% of the sea's energy is in waves shorter than two cells of %.3g m: they are "
                 "omitted, and the significant height is below the wind's %.3g m.",
                 100 * fit.shorter, s->length / (double)s->n, fit.height);
    return count;
}

static void extent(const void *block, double *x0, double *y0, double *x1, double *y1)
{
    *x0 = *y0 = 0;
    *x1 = *y1 = ((const sea *)block)->setup.length;
}

static const char *const height_columns[] = {"value", NULL};
static const char *const body_columns[] = {"x_m", "z_m", "y_m", "pitch_rad", "roll_rad", NULL};

static const ll_fluid_layer layers[] = {
    {.name = "height",
     .help = "Height of the water, seen from above with x to the right and z upwards: m.",
     .shape = LL_FLUID_FIELD,
     .columns = height_columns},
    {.name = "body",
     .help = "The floating box: position, height and slopes.",
     .shape = LL_FLUID_POINTS,
     .columns = body_columns},
};

static void layer_size(const void *block, int layer, int32_t *width, int32_t *height)
{
    int32_t n = (int32_t)((const sea *)block)->setup.n;
    *width = layer == 0 ? n : 1;
    *height = layer == 0 ? n : 1;
}

static void layer_values(const void *block, int layer, float *out)
{
    const sea *s = block;
    if (layer == 0) {
        ll_ocean_surface f = ll_ocean_surface_of(ocean_of(block));
        for (int64_t i = 0; i < f.n * f.n; i++)
            *out++ = (float)f.height[i];
        return;
    }
    const double body[] = {s->buoy.x, s->buoy.z, s->buoy.y, s->buoy.pitch, s->buoy.roll};
    for (int i = 0; i < 5; i++)
        *out++ = (float)body[i];
}

static const ll_fluid_method ocean = {
    .name = "ocean",
    .help = "Surface of an ocean as a function of time; only floating bodies are integrated.",
    .layers = layers,
    .layer_count = sizeof layers / sizeof layers[0],
    .step = step,
    .set_solver = set_solver,
    .numbers = numbers,
    .metrics = &ll_fluid_sea_metrics,
    .traced = &ll_fluid_sea_traced,
    .extent = extent,
    .layer_size = layer_size,
    .layer_values = layer_values,
};

const ll_fluid_scene ll_fluid_sea = {
    .name = "sea",
    .title = "Sea state",
    .help = "A fully developed sea from above, with a floating box: a few waves, as many as points, or a "
            "tile that repeats.",
    .source = "Pierson and Moskowitz 1964",
    .method = &ocean,
    .params = &ll_fluid_sea_params,
    .solver = &ll_fluid_sea_solver,
    .duration_s = 30,
    .check = check,
    .size = size,
    .init = init,
    .notices = notices,
};

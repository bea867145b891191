/* Particles as a method of fluid.h, and their scenes as rows of its table. */
#include <string.h>

#include "base/detmath.h"
#include "fluid/particle.h"
#include "fluid/scenes.h"

/* What may be chosen in every scene; the rest is as ll_particle_scenes has it. */
typedef struct solver {
    int64_t iterations, substeps;
    double cfl, tolerance, relaxation, smoothing;
    int32_t method;
    bool lagged_density;
    uint8_t reserved[3];
} solver;

typedef struct params {
    double size;
} params;

#define ROW(struct_, field, ...)                                                                             \
    {                                                                                                        \
        .name = #field, .offset = offsetof(struct_, field), __VA_ARGS__                                      \
    }
#define LIVE(field, ...) ROW(solver, field, .live = true, __VA_ARGS__)

/* ---- the scene that a block was made from ---- */

static void apply(const solver *s, ll_particle_params *p)
{
    p->method = s->method;
    p->iterations = s->iterations;
    p->substeps = s->substeps;
    p->cfl = s->cfl;
    p->tolerance = s->tolerance;
    p->relaxation = s->relaxation;
    p->smoothing = s->smoothing;
    p->lagged_density = s->lagged_density;
}

static ll_status check_scene(const char *name, const void *given, const void *chosen)
{
    ll_particle_setup setup;
    ll_particle_params p;
    (void)chosen;
    ll_particle_scene_setup(ll_particle_scene_named(name), ((const params *)given)->size, &setup, &p);
    ll_status status = ll_particles_check(&setup);
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, "params.size", "params.size: %.200s", status.text);
    return ll_fluid_check_bytes("params.size", "so many particles", (int64_t)ll_particles_size(&setup));
}

static size_t size_of_scene(const char *name, const void *given)
{
    ll_particle_setup setup;
    ll_particle_params p;
    ll_particle_scene_setup(ll_particle_scene_named(name), ((const params *)given)->size, &setup, &p);
    return ll_particles_size(&setup);
}

static void init_scene(const char *name, void *block, const void *given, const void *chosen)
{
    ll_particle_setup setup;
    ll_particle_params p;
    ll_particle_scene_setup(ll_particle_scene_named(name), ((const params *)given)->size, &setup, &p);
    apply(chosen, &p);
    memset(block, 0, ll_particles_size(&setup));
    ll_particles_init(block, &setup, &p);
}

/* ---- the method ---- */

static ll_status step(void *block, double dt)
{
    return ll_particles_step(block, dt);
}

static void set_solver(void *block, const void *chosen)
{
    ll_particle_params p = *ll_particles_get_params(block);
    apply(chosen, &p);
    ll_particles_set_params(block, &p);
}

static int numbers(const void *block, ll_fluid_number *out)
{
    ll_particle_metrics m = ll_particles_measure(block, 0);
    ll_particle_stats stats = ll_particles_stats(block);
    const ll_fluid_number all[] = {
        {"front_m", m.front},
        {"height_m", m.height},
        {"density_error_mean", m.density_mean},
        {"density_error_max", m.density_max},
        {"mass", m.mass},
        {"momentum_x", m.momentum_x},
        {"momentum_y", m.momentum_y},
        {"kinetic_energy", m.kinetic_energy},
        {"potential_energy", m.potential_energy},
        {"speed_max", m.speed_max},
        {"particles", (double)stats.fluid},
        {"wall_particles", (double)stats.wall},
        {"pairs", (double)stats.pairs},
        {"substeps", (double)stats.substeps},
        {"iterations", (double)stats.iterations},
        {"steps", (double)stats.tick},
        {"bytes", (double)ll_particles_size(ll_particles_get_setup(block))},
    };
    int count = sizeof all / sizeof all[0];
    for (int i = 0; i < count; i++)
        out[i] = all[i];
    return count;
}

static void extent(const void *block, double *x0, double *y0, double *x1, double *y1)
{
    const ll_particle_setup *setup = ll_particles_get_setup(block);
    *x0 = *y0 = 0;
    *x1 = setup->width;
    *y1 = setup->height;
}

enum { PARTICLES, BODY };

static const char *const particle_columns[] = {"x_m", "y_m", "speed_mps", "density", NULL};
static const char *const body_columns[] = {"x_m", "y_m", "angle_rad", "width_m", "height_m", NULL};

static const ll_fluid_layer layers[] = {
    [PARTICLES] = {.name = "particles",
                   .help = "Particles of the fluid; density over that at rest.",
                   .shape = LL_FLUID_POINTS,
                   .columns = particle_columns},
    [BODY] = {.name = "body",
              .help = "The box that the fluid carries.",
              .shape = LL_FLUID_POINTS,
              .columns = body_columns},
};

static void layer_size(const void *block, int layer, int32_t *width, int32_t *height)
{
    *width = layer == PARTICLES ? ll_particles_view(block).count : ll_particles_body(block).mass > 0;
    *height = 1;
}

static void layer_values(const void *block, int layer, float *out)
{
    if (layer == BODY) {
        ll_particle_body b = ll_particles_body(block);
        const ll_particle_float *made = &ll_particles_get_setup(block)->body;
        const double all[] = {b.x, b.y, b.angle, made->width, made->height};
        for (int i = 0; b.mass > 0 && i < 5; i++)
            out[i] = (float)all[i];
        return;
    }
    ll_particle_view view = ll_particles_view(block);
    double rest = ll_particles_get_params(block)->density;
    for (int32_t i = 0; i < view.count; i++) {
        *out++ = (float)view.x[i];
        *out++ = (float)view.y[i];
        *out++ = (float)ll_sqrt(view.u[i] * view.u[i] + view.v[i] * view.v[i]);
        *out++ = (float)(view.density[i] / rest);
    }
}

static const ll_fluid_method particles = {
    .name = "particles",
    .help = "Particles that push each other apart (smoothed particle hydrodynamics).",
    .layers = layers,
    .layer_count = sizeof layers / sizeof layers[0],
    .step = step,
    .set_solver = set_solver,
    .numbers = numbers,
    .traced = 10,
    .extent = extent,
    .layer_size = layer_size,
    .layer_values = layer_values,
};

/* ---- scenes ---- */

#define SCENE(name_, title_, help_, source_, duration_, size_, method_, cfl_, iterations_)                   \
    static const ll_param name_##_params[] = {                                                               \
        ROW(params, size, .type = LL_PARAM_REAL, .min = 4, .max = 1000, .standard = size_,                   \
            .help = "Particles along the scene's own length."),                                              \
    };                                                                                                       \
    static const ll_param name_##_solver[] = {                                                               \
        LIVE(method, .type = LL_PARAM_CHOICE, .choices = ll_particle_method_names, .standard = method_,      \
             .help = "How the fluid is kept from being compressed."),                                        \
        LIVE(iterations, .type = LL_PARAM_INT, .min = 1, .max = 1000, .standard = iterations_,               \
             .help = "Passes of pbf; the most of dfsph."),                                                   \
        LIVE(substeps, .type = LL_PARAM_INT, .min = 1, .max = 100000, .standard = 1000,                      \
             .help = "The most substeps in a step; a fluid that needs more is stopped."),                    \
        LIVE(cfl, .type = LL_PARAM_REAL, .min = 0.05, .max = 3, .standard = cfl_,                            \
             .help = "How many spacings the fastest particle may go in a substep, of dfsph and pbf."),       \
        LIVE(tolerance, .type = LL_PARAM_REAL, .min = 1e-9, .max = 0.1, .standard = 1e-4,                    \
             .help = "Mean relative error of density at which dfsph stops."),                                \
        LIVE(relaxation, .type = LL_PARAM_REAL, .min = 0.05, .max = 1.5, .standard = 0.5,                    \
             .help = "Share of each correction that dfsph and pbf make at a time."),                         \
        LIVE(smoothing, .type = LL_PARAM_REAL, .max = 0.5, .standard = 0,                                    \
             .help = "Share of the neighbours' mean velocity that a particle of pbf takes on."),             \
        LIVE(lagged_density, .type = LL_PARAM_BOOL,                                                          \
             .help = "Density of wcsph follows the velocity before the forces; it explodes."),               \
    };                                                                                                       \
    const ll_param_table ll_fluid_##name_##_params = {                                                       \
        .name = #name_, .help = title_, .rows = name_##_params, .count = 1, .size = sizeof(params)};         \
    const ll_param_table ll_fluid_##name_##_solver = {.name = #name_ "_solver",                              \
                                                      .help = "How a fluid of particles is stepped.",        \
                                                      .rows = name_##_solver,                                \
                                                      .count = sizeof name_##_solver / sizeof(ll_param),     \
                                                      .size = sizeof(solver)};                               \
    static ll_status name_##_check(const void *given, const void *chosen)                                    \
    {                                                                                                        \
        return check_scene(#name_, given, chosen);                                                           \
    }                                                                                                        \
    static size_t name_##_size(const void *given, const void *chosen)                                        \
    {                                                                                                        \
        (void)chosen;                                                                                        \
        return size_of_scene(#name_, given);                                                                 \
    }                                                                                                        \
    static void name_##_init(void *block, const void *given, const void *chosen)                             \
    {                                                                                                        \
        init_scene(#name_, block, given, chosen);                                                            \
    }                                                                                                        \
    const ll_fluid_scene ll_fluid_##name_ = {.name = #name_,                                                 \
                                             .title = title_,                                                \
                                             .help = help_,                                                  \
                                             .source = source_,                                              \
                                             .method = &particles,                                           \
                                             .params = &ll_fluid_##name_##_params,                           \
                                             .solver = &ll_fluid_##name_##_solver,                           \
                                             .duration_s = duration_,                                        \
                                             .check = name_##_check,                                         \
                                             .size = name_##_size,                                           \
                                             .init = name_##_init}

SCENE(dam_break, "Dam break",
      "A column of width 1 and height 2 falls into a dry tank; lengths in its width a, times in sqrt(a / g).",
      "Martin and Moyce 1952; Ritter 1892", 2.4, 20, LL_PARTICLE_WCSPH, 0.4, 100);
SCENE(hydrostatic, "Hydrostatic column", "A column of height 1 comes to rest under gravity 1.",
      "p = density g depth", 10, 40, LL_PARTICLE_WCSPH, 0.4, 100);
SCENE(pool, "A pool",
      "A shallow pool of 20 m in which a higher half falls over a lower one, as games have it.",
      "Macklin and Mueller 2013", 10, 100, LL_PARTICLE_PBF, 1, 4);
SCENE(raft, "A raft", "A box that floats on the fluid, which moves it and is moved by it.", "Archimedes", 5,
      20, LL_PARTICLE_DFSPH, 0.4, 100);

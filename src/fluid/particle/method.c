/* Particles as a method of fluid.h. */
#include "base/detmath.h"
#include "fluid/particle/particle.h"

/* ---- layers ---- */

static const char *const particle_columns[] = {"x_m", "y_m", "speed_mps", "pressure_pa", "density", NULL};
static const char *const body_columns[] = {"x_m", "y_m", NULL};

static const ll_fluid_layer layers[] = {
    {.name = "particles",
     .help = "Positions in m, speed in m/s, pressure in Pa, density over the rest density.",
     .shape = LL_FLUID_POINTS,
     .columns = particle_columns},
    {.name = "body",
     .help = "Corners of the floating box.",
     .shape = LL_FLUID_POINTS,
     .columns = body_columns},
};

static void layer_size(const void *block, int layer, int32_t *width, int32_t *height)
{
    *width = layer == 0 ? ll_particles_view(block).count : ll_particles_body(block).mass > 0 ? 4 : 0;
    *height = 1;
}

static void corners(const ll_particles *p, float *out)
{
    ll_particle_body b = ll_particles_body(p);
    const ll_particle_float *box = &ll_particles_get_setup(p)->body;
    double c = ll_cos(b.angle), s = ll_sin(b.angle);
    for (int i = 0; b.mass > 0 && i < 4; i++) {
        double x = (i == 0 || i == 3 ? -0.5 : 0.5) * box->width, y = (i < 2 ? -0.5 : 0.5) * box->height;
        *out++ = (float)(b.x + c * x - s * y);
        *out++ = (float)(b.y + s * x + c * y);
    }
}

static void layer_values(const void *block, int layer, float *out)
{
    if (layer == 1) {
        corners(block, out);
        return;
    }
    ll_particle_view v = ll_particles_view(block);
    double rest = ll_particles_get_params(block)->density;
    for (int32_t a = 0; a < v.count; a++) {
        *out++ = (float)v.x[a];
        *out++ = (float)v.y[a];
        *out++ = (float)ll_sqrt(v.u[a] * v.u[a] + v.v[a] * v.v[a]);
        *out++ = (float)v.pressure[a];
        *out++ = (float)(v.density[a] / rest);
    }
}

/* ---- the rest of the method ---- */

static ll_status step(void *block, double dt, const ll_fluid_run *run)
{
    return ll_particles_step_by(block, dt, run);
}

static uint64_t hash(const void *block)
{
    return ll_particles_hash(block);
}

static void set_solver(void *block, const void *solver)
{
    ll_particles_set_params(block, solver);
}

static void drag_force(void *block, const ll_drag_force *what)
{
    ll_particles_drag(block, what);
}

#define PARTICLES_TRACED(X)                                                                                  \
    X(signed_number, front_m, "m", m.front,                                                                  \
      "horizontal position of the front: right edge of the rightmost particle", LL_FLUID_FAILED)             \
    X(signed_number, height_m, "m", m.height,                                                                \
      "height of the fluid at the left wall: upper edge of the highest particle there", LL_FLUID_FAILED)     \
    X(number, density_error_mean, NULL, m.density_mean,                                                      \
      "mean density error: compression beyond the rest density, relative; expansion does not count",         \
      LL_FLUID_FAILED)                                                                                       \
    X(number, density_error_max, NULL, m.density_max,                                                        \
      "largest density error of a particle: compression beyond the rest density, relative", LL_FLUID_FAILED) \
    X(number, kinetic_energy, "J/m", m.kinetic_energy, "kinetic energy of all particles per metre of depth", \
      LL_FLUID_FAILED)                                                                                       \
    X(signed_number, potential_energy, "J/m", m.potential_energy,                                            \
      "potential energy of all particles by gravity, per metre of depth", LL_FLUID_FAILED)                   \
    X(signed_number, momentum_x, "kg/s", m.momentum_x,                                                       \
      "horizontal momentum of all particles per metre of depth", LL_FLUID_FAILED)                            \
    X(signed_number, momentum_y, "kg/s", m.momentum_y,                                                       \
      "vertical momentum of all particles per metre of depth", LL_FLUID_FAILED)

#define PARTICLES(X)                                                                                         \
    PARTICLES_TRACED(X)                                                                                      \
    X(number, mass, "kg/m", m.mass,                                                                          \
      "mass of the particles within the tank per metre of depth; of all particles if the tank is open",      \
      LL_FLUID_FAILED)                                                                                       \
    X(number, speed_max_mps, "m/s", m.speed_max, "speed of the fastest particle", LL_FLUID_FAILED)           \
    X(number, neighbours, NULL, m.neighbours, "mean number of neighbours of a particle", LL_FLUID_FAILED)    \
    X(count, particles, NULL, s.fluid, "particles of the fluid", LL_FLUID_FAILED)                            \
    X(count, substeps, NULL, s.substeps, "substeps so far", LL_FLUID_FAILED)                                 \
    X(count, iterations, NULL, s.iterations, "passes of the pressure solver over all particles so far",      \
      LL_FLUID_FAILED)                                                                                       \
    X(count, cell_visits, NULL, (double)s.iterations *s.fluid,                                               \
      "particles times passes of the pressure solver so far: a cost that is the same on every machine",      \
      LL_FLUID_FAILED)                                                                                       \
    X(signed_number, body_x_m, "m", b.x, "horizontal position of the floating body", LL_FLUID_FAILED)        \
    X(signed_number, body_y_m, "m", b.y, "height of the floating body", LL_FLUID_FAILED)                     \
    X(signed_number, body_angle_rad, "rad", b.angle, "angle of the floating body", LL_FLUID_FAILED)

const ll_metric_table ll_particle_metrics_table = {.path = "",
                                                   .also = LL_FLUID_AGAIN,
                                                   .when = "Only of the method particles.",
                                                   .help = "Measures of a fluid of particles, now.",
                                                   LL_METRICS_FROM(PARTICLES)};

const ll_metric_table ll_particle_traced = {.path = "",
                                            .when = "Only of the method particles.",
                                            .help = "Measures that are also columns of the trace.",
                                            LL_METRICS_FROM(PARTICLES_TRACED)};

static int numbers(const void *block, ll_fluid_number *out)
{
    ll_particle_metrics m = ll_particles_measure(block, 0);
    ll_particle_stats s = ll_particles_stats(block);
    ll_particle_body b = ll_particles_body(block);
    return LL_FLUID_TELL(out, PARTICLES);
}

static void extent(const void *block, double *x0, double *y0, double *x1, double *y1)
{
    const ll_particle_setup *s = ll_particles_get_setup(block);
    *x0 = *y0 = 0;
    *x1 = s->width;
    *y1 = s->height;
}

const ll_fluid_method ll_fluid_particles = {
    .name = "particles",
    .help = "Particles with mass that interact with their neighbours: smoothed particle hydrodynamics.",
    .layers = layers,
    .layer_count = sizeof layers / sizeof layers[0],
    .step = step,
    .set_solver = set_solver,
    .hash = hash,
    .drag_force = drag_force,
    .numbers = numbers,
    .metrics = &ll_particle_metrics_table,
    .traced = &ll_particle_traced,
    .extent = extent,
    .layer_size = layer_size,
    .layer_values = layer_values,
};

#include "fluid/particle.h"

#define ROW(field, ...)                                                                                      \
    {                                                                                                        \
        .name = #field, .offset = offsetof(ll_particle_params, field), .live = true, __VA_ARGS__             \
    }
#define REAL(field, low, high, value, of, text)                                                              \
    ROW(field, .type = LL_PARAM_REAL, .min = low, .max = high, .standard = value, .unit = of, .help = text)
#define WHOLE(field, low, high, value, text)                                                                 \
    ROW(field, .type = LL_PARAM_INT, .min = low, .max = high, .standard = value, .help = text)
#define SWITCH(field, value, text) ROW(field, .type = LL_PARAM_BOOL, .standard = value, .help = text)

static const ll_param rows[] = {
    ROW(method, .type = LL_PARAM_CHOICE, .choices = ll_particle_method_names, .standard = LL_PARTICLE_DFSPH,
        .help = "How the fluid is kept from being compressed."),
    REAL(gravity_x, -1000, 1000, 0, "m/s^2", "Gravity, or any force on all of the fluid, to the right."),
    REAL(gravity_y, -1000, 1000, -10, "m/s^2", "Gravity upwards."),
    REAL(density, 1e-3, 1e6, 1000, "kg/m^2", "Density at rest."),
    REAL(
        sound_speed, 1e-3, 1e6, 40, "m/s",
        "Of wcsph, ten times the largest speed to come for 1 % of compression; scales artificial viscosity."),
    REAL(artificial_viscosity, 0, 1, 0.02, NULL, "Monaghan's alpha: damps approach and parting."),
    REAL(viscosity, 0, 1000, 0, "m^2/s", "Kinematic viscosity."),
    REAL(diffusion, 0, 1, 0.1, NULL, "Diffusion of density, of wcsph (delta)."),
    REAL(cfl, 0.05, 3, 0.4, NULL,
         "How many spacings the fastest particle may go in a substep, of dfsph and pbf."),
    REAL(tolerance, 1e-9, 0.1, 1e-4, NULL, "Mean relative error of density at which dfsph stops."),
    REAL(relaxation, 0.05, 1.5, 0.5, NULL, "Share of each correction that dfsph and pbf make at a time."),
    REAL(smoothing, 0, 0.5, 0, NULL,
         "Share of the neighbours' mean velocity that a particle of pbf takes on in a substep (XSPH)."),
    WHOLE(iterations, 1, 1000, 100, "Passes of pbf; the most of dfsph."),
    WHOLE(substeps, 1, 100000, 1000, "The most substeps in a step; a fluid that needs more is stopped."),
    SWITCH(no_slip, 0, "Fluid sticks to walls."),
    SWITCH(lagged_density, 0,
           "Density of wcsph follows the velocity before the forces, as explicit Euler does; it explodes."),
};

const ll_param_table ll_particle_table = {.name = "particles",
                                          .help = "How a fluid of particles is stepped.",
                                          .rows = rows,
                                          .count = sizeof rows / sizeof rows[0],
                                          .size = sizeof(ll_particle_params)};

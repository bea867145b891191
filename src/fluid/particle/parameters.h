/* Rows of particles' settings, with a scene's defaults. */
#pragma once

#include "fluid/particle/particle.h"

#define LL_PARTICLE_ROW(member, ...)                                                                         \
    {                                                                                                        \
        .name = #member, .offset = offsetof(ll_particle_params, member), .live = true, __VA_ARGS__           \
    }
#define LL_PARTICLE_REAL(member, low, high, value, of, text)                                                 \
    LL_PARTICLE_ROW(member, .type = LL_PARAM_REAL, .min = low, .max = high, .default_value = value,          \
                    .unit = of, .help = text)
#define LL_PARTICLE_WHOLE(member, low, high, value, text)                                                    \
    LL_PARTICLE_ROW(member, .type = LL_PARAM_INT, .min = low, .max = high, .default_value = value,           \
                    .help = text)
#define LL_PARTICLE_SWITCH(member, value, text)                                                              \
    LL_PARTICLE_ROW(member, .type = LL_PARAM_BOOL, .default_value = value, .help = text)

#define LL_PARTICLE_ROWS(method_, gravity_x_, gravity_y_, density_, sound_speed_, artificial_, viscosity_,   \
                         no_slip_, cfl_, iterations_, smoothing_)                                            \
    LL_PARTICLE_ROW(method, .type = LL_PARAM_CHOICE, .choices = ll_particle_method_names,                    \
                    .default_value = method_, .help = "Pressure method."),                                   \
        LL_PARTICLE_REAL(gravity_x, -1000, 1000, gravity_x_, "m/s^2",                                        \
                         "Gravity, or any force on all of the fluid, to the right."),                        \
        LL_PARTICLE_REAL(gravity_y, -1000, 1000, gravity_y_, "m/s^2", "Gravity upwards."),                   \
        LL_PARTICLE_REAL(density, 1e-3, 1e6, density_, "kg/m^3", "Rest density."),                           \
        LL_PARTICLE_REAL(sound_speed, 1e-3, 1e6, sound_speed_, "m/s",                                        \
                         "Speed of sound of wcsph: ten times the largest expected speed gives 1 % of "       \
                         "compression. Scales "                                                              \
                         "artificial viscosity."),                                                           \
        LL_PARTICLE_REAL(artificial_viscosity, 0, 1, artificial_, NULL,                                      \
                         "Monaghan's alpha: damps approach and separation."),                                \
        LL_PARTICLE_REAL(viscosity, 0, 1000, viscosity_, "m^2/s", "Kinematic viscosity."),                   \
        LL_PARTICLE_REAL(diffusion, 0, 1, 0.1, NULL, "Density diffusion of wcsph (delta)."),                 \
        LL_PARTICLE_REAL(                                                                                    \
            cfl, 0.05, 3, cfl_, NULL,                                                                        \
            "CFL number of dfsph and pbf: spacings that the fastest particle may move per substep."),        \
        LL_PARTICLE_REAL(tolerance, 1e-9, 0.1, 1e-5, NULL,                                                   \
                         "Mean relative density error at which dfsph stops."),                               \
        LL_PARTICLE_REAL(relaxation, 0.05, 1.5, 0.5, NULL,                                                   \
                         "Relaxation: fraction of each correction that dfsph and pbf apply. dfsph adds "     \
                         "Nesterov's momentum: 0.85 up to a relaxation of 0.54, none from 0.8 on."),         \
        LL_PARTICLE_REAL(                                                                                    \
            smoothing, 0, 0.5, smoothing_, NULL,                                                             \
            "XSPH of pbf: fraction of the neighbours' mean velocity that a particle takes on per "           \
            "substep."),                                                                                     \
        LL_PARTICLE_WHOLE(iterations, 1, 1000, iterations_, "Iterations of pbf; limit of dfsph."),           \
        LL_PARTICLE_WHOLE(substeps, 1, 100000, 1000,                                                         \
                          "Largest number of substeps per step; a fluid that needs more is stopped."),       \
        LL_PARTICLE_SWITCH(no_slip, no_slip_, "No-slip walls."),                                             \
        LL_PARTICLE_SWITCH(lagged_density, 0,                                                                \
                           "Density of wcsph uses the velocity before the forces, as in explicit Euler: "    \
                           "unstable.")

/* A table of settings. */
#define LL_PARTICLE_TABLE(name_, rows_)                                                                      \
    {                                                                                                        \
        .name = name_, .help = "Parameters of a fluid of particles.",                                        \
        LL_PARAM_ROWS(rows_, ll_particle_params)                                                             \
    }

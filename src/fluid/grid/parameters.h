/* Rows of a grid's settings, with a scene's defaults. */
#pragma once

#include "fluid/grid/grid.h"

#define LL_GRID_REAL(member, least, most, normal, text)                                                      \
    {                                                                                                        \
        .name = #member, .type = LL_PARAM_REAL, .offset = offsetof(ll_grid_solver, member), .min = least,    \
        .max = most, .default_value = normal, .live = true, .help = text                                     \
    }

#define LL_GRID_INT(member, least, most, normal, text)                                                       \
    {                                                                                                        \
        .name = #member, .type = LL_PARAM_INT, .offset = offsetof(ll_grid_solver, member), .min = least,     \
        .max = most, .default_value = normal, .live = true, .help = text                                     \
    }

#define LL_GRID_CHOICE(member, names, normal, text)                                                          \
    {                                                                                                        \
        .name = #member, .type = LL_PARAM_CHOICE, .offset = offsetof(ll_grid_solver, member),                \
        .choices = names, .default_value = normal, .live = true, .help = text                                \
    }

#define LL_GRID_ROWS(advection_, splitting_, pressure_, tolerance_, cfl_)                                    \
    LL_GRID_CHOICE(advection, ll_advection_names, advection_, "Advection scheme of velocities and dye."),    \
        LL_GRID_INT(backtrace, 1, 3, 2, "Order of the trace back in time, for all schemes but central."),    \
        {LL_PARAM_ROW("limiter", BOOL, ll_grid_solver, limiter), .default_value = 1, .live = true,           \
         .help = "Clamp maccormack and bfecc to the values that they interpolate."},                         \
        {LL_PARAM_ROW("conserve_mass", BOOL, ll_grid_solver, conserve_mass), .default_value = 1,             \
         .live = true,                                                                                       \
         .help = "Conserve the dye's mass: spread the gain or loss of advection over values that have "      \
                 "room within their bounds."},                                                               \
        LL_GRID_CHOICE(splitting, ll_splitting_names, splitting_,                                            \
                       "One projection at the end of a step, or with a reflection in the middle: order 2."), \
        LL_GRID_CHOICE(pressure, ll_pressure_names, pressure_, "Pressure solver."),                          \
        LL_GRID_REAL(tolerance, 0, 1, tolerance_,                                                            \
                     "Largest remaining fraction of the divergence at which the pressure solver stops. 0: "  \
                     "it makes all its sweeps."),                                                            \
        LL_GRID_INT(sweeps, 1, 100000, 1000, "Largest number of sweeps or cycles of the pressure solver."),  \
        LL_GRID_REAL(relaxation, 0, 1.999, 0,                                                                \
                     "Over-relaxation of jacobi and sor; 0: their own, 1 and 2 / (1 + sin(pi / N))."),       \
        LL_GRID_REAL(cfl, 0.01, 100, cfl_, "CFL number: cells that anything may move per substep."),         \
        LL_GRID_INT(substeps, 0, 1000, 0, "Substeps per step; 0: as many as cfl needs."),                    \
        LL_GRID_REAL(viscosity_scale, 0, 1000, 1, "Factor of the scene's viscosity."),                       \
        LL_GRID_REAL(vorticity_confinement, 0, 10, 0,                                                        \
                     "Vorticity confinement: strength of the force that restores vortices.")

extern const char *const ll_splitting_names[LL_SPLITTINGS + 1];

/* Smallest and largest number of cells per side, as a row of a scene's struct. */
#define LL_GRID_CELLS(type_, normal)                                                                         \
    {                                                                                                        \
        LL_PARAM_ROW("n", INT, type_, n), .min = 8, .max = 8192, .default_value = normal,                    \
                                          .help = "Cells per side; even."                                    \
    }

/* A scene's table of settings. */
#define LL_GRID_TABLE(name_, rows_)                                                                          \
    {                                                                                                        \
        .name = name_, .help = "Parameters of a fluid on a grid.", LL_PARAM_ROWS(rows_, ll_grid_solver)      \
    }

/* Parameters of every scene begin with `int64_t n`, for a square box. */
size_t ll_grid_scene_size(const void *params, const void *solver);

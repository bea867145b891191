/* The rows of a grid's settings, with the defaults that a scene wants. */
#pragma once

#include "fluid/grid/grid.h"

#define LL_GRID_REAL(member, least, most, normal, text)                                                      \
    {                                                                                                        \
        .name = #member, .type = LL_PARAM_REAL, .offset = offsetof(ll_grid_solver, member), .min = least,    \
        .max = most, .standard = normal, .live = true, .help = text                                          \
    }

#define LL_GRID_INT(member, least, most, normal, text)                                                       \
    {                                                                                                        \
        .name = #member, .type = LL_PARAM_INT, .offset = offsetof(ll_grid_solver, member), .min = least,     \
        .max = most, .standard = normal, .live = true, .help = text                                          \
    }

#define LL_GRID_CHOICE(member, names, normal, text)                                                          \
    {                                                                                                        \
        .name = #member, .type = LL_PARAM_CHOICE, .offset = offsetof(ll_grid_solver, member),                \
        .choices = names, .standard = normal, .live = true, .help = text                                     \
    }

#define LL_GRID_ROWS(advection_, splitting_, pressure_, tolerance_, cfl_)                                    \
    LL_GRID_CHOICE(advection, ll_advection_names, advection_, "How velocities and dye are carried."),        \
        LL_GRID_INT(backtrace, 1, 3, 2, "Order of the way back in time, of all but central."),               \
        {.name = "clamp",                                                                                    \
         .type = LL_PARAM_BOOL,                                                                              \
         .offset = offsetof(ll_grid_solver, clamp),                                                          \
         .standard = 1,                                                                                      \
         .live = true,                                                                                       \
         .help = "Keep maccormack and bfecc between the values that theirs come from."},                     \
        {.name = "keep_mass",                                                                                \
         .type = LL_PARAM_BOOL,                                                                              \
         .offset = offsetof(ll_grid_solver, keep_mass),                                                      \
         .standard = 1,                                                                                      \
         .live = true,                                                                                       \
         .help = "Spread what carrying the dye gains or loses over where the values that it comes from "     \
                 "leave room."},                                                                             \
        LL_GRID_CHOICE(splitting, ll_splitting_names, splitting_,                                            \
                       "One projection at the end of a step, or with a reflection in the middle: order 2."), \
        LL_GRID_CHOICE(pressure, ll_pressure_names, pressure_, "Solver of the pressure equation."),          \
        LL_GRID_REAL(                                                                                        \
            tolerance, 0, 1, tolerance_,                                                                     \
            "Where the pressure solver stops: the share of the divergence that may be left. 0: all "         \
            "its sweeps are made."),                                                                         \
        LL_GRID_INT(sweeps, 1, 100000, 1000, "Sweeps or cycles of the pressure solver, at most."),           \
        LL_GRID_REAL(relaxation, 0, 1.999, 0,                                                                \
                     "Of jacobi and sor; 0: their own, 1 and 2 / (1 + sin(pi / N))."),                       \
        LL_GRID_REAL(cfl, 0.01, 100, cfl_, "Cells that anything may move in a substep."),                    \
        LL_GRID_INT(substeps, 0, 1000, 0, "Of a step; 0: as many as cfl asks for."),                         \
        LL_GRID_REAL(viscosity_scale, 0, 1000, 1, "Times the scene's viscosity."),                           \
        LL_GRID_REAL(confinement, 0, 10, 0, "Force that feeds vortices: share of what turns a cell.")

extern const char *const ll_splitting_names[LL_SPLITTINGS + 1];

/* The least and the most cells along a side, as a row of a scene's struct. */
#define LL_GRID_CELLS(type_, normal)                                                                         \
    {                                                                                                        \
        .name = "n", .type = LL_PARAM_INT, .offset = offsetof(type_, n), .min = 8, .max = 8192,              \
        .standard = normal, .help = "Cells along a side; even."                                              \
    }

/* A scene's table of settings. */
#define LL_GRID_TABLE(name_, rows_)                                                                          \
    {                                                                                                        \
        .name = name_, .help = "How a fluid on a grid is stepped.", .rows = rows_,                           \
        .count = sizeof rows_ / sizeof rows_[0], .size = sizeof(ll_grid_solver)                              \
    }

/* Every scene's parameters begin with `int64_t n`, of a square box. */
size_t ll_grid_scene_size(const void *params, const void *solver);

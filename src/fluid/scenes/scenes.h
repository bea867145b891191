/* Every scene of every method. A new scene is a name here, and three definitions by that name: ll_fluid_NAME,
 * a row; ll_fluid_NAME_params, the table of its own parameters; ll_fluid_NAME_solver, the table of its
 * method's settings with the scene's defaults. Append new names at the end. */
#pragma once

#include "fluid/core/fluid.h"

#define LL_FLUID_SCENES(X)                                                                                   \
    X(cavity)                                                                                                \
    X(taylor_green)                                                                                          \
    X(cylinder) X(rotation) X(dam_break) X(hydrostatic) X(poiseuille) X(drop) X(raft) X(pool) X(sea)

#define LL_FLUID_DECLARE(name)                                                                               \
    extern const ll_fluid_scene ll_fluid_##name;                                                             \
    extern const ll_param_table ll_fluid_##name##_params, ll_fluid_##name##_solver;
LL_FLUID_SCENES(LL_FLUID_DECLARE)
#undef LL_FLUID_DECLARE

/* What the scenes measure in addition to their methods, and the ocean, which is a method of one scene. */
extern const ll_metric_table ll_fluid_cavity_metrics, ll_fluid_cavity_profiles, ll_fluid_cavity_references,
    ll_fluid_taylor_green_metrics, ll_fluid_rotation_metrics, ll_fluid_dam_break_metrics,
    ll_fluid_hydrostatic_metrics, ll_fluid_poiseuille_metrics, ll_fluid_sea_metrics, ll_fluid_sea_traced;

/* All tables of fluids, as the beginning of a list. */
#define LL_FLUID_METRIC_TABLES                                                                               \
    &ll_grid_metrics, &ll_particle_metrics_table, &ll_fluid_sea_metrics, &ll_fluid_cavity_metrics,           \
        &ll_fluid_cavity_profiles, &ll_fluid_cavity_references, &ll_fluid_taylor_green_metrics,              \
        &ll_fluid_rotation_metrics, &ll_fluid_dam_break_metrics, &ll_fluid_hydrostatic_metrics,              \
        &ll_fluid_poiseuille_metrics

/* Columns of traces of fluids: of the method, then of the scene. */
#define LL_FLUID_TRACE_TABLES                                                                                \
    &ll_grid_traced, &ll_particle_traced, &ll_fluid_sea_traced, &ll_fluid_cavity_metrics,                    \
        &ll_fluid_taylor_green_metrics, &ll_fluid_rotation_metrics, &ll_fluid_dam_break_metrics,             \
        &ll_fluid_hydrostatic_metrics, &ll_fluid_poiseuille_metrics

/* In the order of ll_fluid_scenes, NULL-terminated. */
extern const char *const ll_fluid_scene_names[];
extern const ll_param_table *const ll_fluid_params_tables[];
extern const ll_param_table *const ll_fluid_solver_tables[];

/* Fluids of particles in the plane (smoothed particle hydrodynamics): m, s, kg. Mass, force, momentum and
 * energy are per metre of depth: kg/m, N/m, kg/s, J/m; density is kg/m^3, pressure Pa.
 *
 * A fluid is one block of known size: indices, no pointers. A copy of the block is a snapshot. A step calls
 * neither malloc nor a clock, and computes the same bits on every compiler and optimisation level. Particles
 * are sorted by cell, so their order changes; `id` does not.
 *
 * Kernel: Wendland C2, support radius 2 h. Walls and the moving body are particles too (three layers, or
 * filled): they have the fluid's spacing and take part in sums over neighbours, but only their owner moves
 * them. */
#pragma once

#include <stddef.h>

#include "fluid/core/fluid.h"

typedef struct ll_particles ll_particles;

/* ---- initial contents: fix the block's size ---- */

enum { LL_WALL_LEFT = 1, LL_WALL_RIGHT = 2, LL_WALL_BOTTOM = 4, LL_WALL_TOP = 8 };

#define LL_PARTICLE_FILLS 4
#define LL_PARTICLES_MAX 1100000 /* fluid and walls together: a million in a tank */

typedef struct ll_particle_fill { /* a rectangle of fluid, or its inscribed ellipse */
    double x, y, width, height;   /* m; x, y: its lower left corner */
    double u, v;                  /* m/s */
    double strain;                /* 1/s: adds (-strain, strain) times the position relative to its centre */
    int32_t round;
    int32_t settled; /* 1: compressed by its own weight, for wcsph */
} ll_particle_fill;

typedef struct ll_particle_float { /* a floating rectangle; density 0: none */
    double x, y, width, height;    /* m; x, y: its centre */
    double density;                /* kg/m^3 */
} ll_particle_float;

typedef struct ll_particle_setup {
    double width, height; /* m: the tank is [0, width] x [0, height] */
    double spacing;       /* m between particles at rest */
    double smoothing;     /* h in spacings */
    int32_t walls;        /* bits of LL_WALL_ */
    int32_t periodic;     /* 1: periodic in x */
    int32_t fill_count, reserved;
    ll_particle_fill fill[LL_PARTICLE_FILLS];
    ll_particle_float body;
} ll_particle_setup;

/* ---- parameters: all can change between steps ---- */

typedef enum ll_particle_method_kind {
    LL_PARTICLE_WCSPH,
    LL_PARTICLE_PBF,
    LL_PARTICLE_DFSPH,
    LL_PARTICLE_METHODS
} ll_particle_method_kind;

extern const char *const ll_particle_method_names[LL_PARTICLE_METHODS + 1]; /* NULL-terminated */

/* Names, ranges and defaults: ll_particle_table. */
typedef struct ll_particle_params {
    double gravity_x, gravity_y;
    double density;              /* kg/m^3 at rest */
    double sound_speed;          /* m/s */
    double artificial_viscosity; /* Monaghan's alpha */
    double viscosity;            /* kinematic, m^2/s */
    double diffusion;            /* delta of wcsph */
    double cfl;                  /* dfsph and pbf: largest motion in spacings per substep */
    double tolerance;            /* dfsph: relative density error at which the solver stops */
    double relaxation;           /* of dfsph's and pbf's Jacobi iteration */
    double smoothing;            /* pbf: XSPH, fraction of the neighbours' mean velocity per substep */
    int64_t iterations;          /* of pbf; limit of dfsph */
    int64_t substeps;            /* limit per step */
    int32_t method;              /* ll_particle_method_kind */
    bool no_slip;                /* no-slip walls */
    bool lagged_density;         /* wcsph: density uses the velocity before the forces; unstable */
    uint8_t reserved[2];
} ll_particle_params;

extern const ll_param_table ll_particle_table;

/* ---- making and stepping ---- */

/* Checks ranges; LL_LIMIT names the memory that too large a fluid needs. */
ll_status ll_particles_check(const ll_particle_setup *setup);
size_t ll_particles_size(const ll_particle_setup *setup); /* bytes of the block; setup must be checked */
/* Size of the part at the block's beginning that a snapshot must hold; the rest is rewritten in each step. */
size_t ll_particles_state_size(const ll_particles *p);

/* `block` has ll_particles_size bytes, aligned to 16. The fluid is at its beginning. */
ll_particles *ll_particles_init(void *block, const ll_particle_setup *setup,
                                const ll_particle_params *params);
void ll_particles_set_params(ll_particles *p, const ll_particle_params *params);
const ll_particle_params *ll_particles_get_params(const ll_particles *p);
const ll_particle_setup *ll_particles_get_setup(const ll_particles *p);

/* One step of `dt` seconds, 1e-6 to 1, in as many substeps as the CFL condition needs. LL_DIVERGED names the
 * tick, the particle and the reason: a value that is not finite, a CFL condition that was broken or needs too
 * many substeps, or more neighbours than there is room for. The fluid cannot be used any more. */
ll_status ll_particles_step(ll_particles *p, double dt);
ll_status ll_particles_step_by(ll_particles *p, double dt,
                               const ll_fluid_run *run); /* as ll_fluid_method's */

/* Fluid within the circle is dragged at the given velocity, until changed. */
void ll_particles_drag(ll_particles *p, const ll_drag_force *drag_force);

typedef struct ll_particle_place {
    double x, y, u, v; /* m, m/s */
} ll_particle_place;

/* Places the whole fluid: element k is the particle of id k, counted by init from 0 through the fills, row by
 * row from below. Warm-start data of solvers does not change. */
void ll_particles_put(ll_particles *p, const ll_particle_place *places);

uint64_t ll_particles_hash(const ll_particles *p); /* equal for equal histories */

/* Checks every invariant of the block, for LL_VALIDATE and tests. */
bool ll_particles_valid(const ll_particles *p);

/* ---- queries ---- */

typedef struct ll_particle_view { /* arrays of `count`; valid until the next step */
    int32_t count, reserved;
    const int32_t *id;
    const double *x, *y, *u, *v; /* m, m/s */
    const double *density;       /* kg/m^3: of wcsph its own, of the others the sum over neighbours */
    const double *pressure;      /* Pa */
} ll_particle_view;

ll_particle_view ll_particles_view(const ll_particles *p);

typedef struct ll_particle_body {  /* the moving body */
    double x, y, angle;            /* m, rad */
    double u, v, angular_velocity; /* m/s, rad/s */
    double mass, inertia;          /* kg/m, kg m; 0: no body */
} ll_particle_body;

ll_particle_body ll_particles_body(const ll_particles *p);

typedef struct ll_particle_metrics {
    double front;                            /* m: right edge of the rightmost particle */
    double height;                           /* m: upper edge of the highest particle at the left wall */
    double mass;                             /* kg/m within the tank, or of all if the tank is open */
    double momentum_x, momentum_y;           /* kg/s */
    double kinetic_energy, potential_energy; /* J/m; potential: of gravity, to the origin */
    double density_mean, density_max;        /* relative compression beyond the rest density */
    double pressure_rms;                     /* relative error from a hydrostatic column of `depth` */
    double speed_max;                        /* m/s */
    double neighbours;                       /* mean, of fluid and walls */
} ll_particle_metrics;

/* `depth`: of the hydrostatic column to compare with, m. */
ll_particle_metrics ll_particles_measure(const ll_particles *p, double depth);

typedef struct ll_particle_stats {
    int64_t tick;
    int64_t substeps;   /* total */
    int64_t iterations; /* of the pressure solvers, total */
    int32_t fluid, wall, body;
    int32_t pairs; /* of the last substep */
    double time;   /* s */
} ll_particle_stats;

ll_particle_stats ll_particles_stats(const ll_particles *p);

/* ---- scenes ---- */

typedef struct ll_particle_scene {
    const char *name, *title;
    const char *help;             /* contents and reference */
    double size;                  /* default number of particles along the scene's own length */
    double depth;                 /* m, for pressure_rms; 0: no column */
    double dt, duration;          /* s, of a step and of the run */
    const ll_param_table *solver; /* ll_particle_params with the scene's defaults */
    void (*configure)(double size, ll_particle_setup *setup);
} ll_particle_scene;

extern const ll_particle_scene *const ll_particle_scenes[];         /* NULL-terminated */
const ll_particle_scene *ll_particle_scene_named(const char *name); /* NULL if there is no such scene */
/* Sets all of both; `size` 0: the scene's default. */
void ll_particle_scene_setup(const ll_particle_scene *scene, double size, ll_particle_setup *setup,
                             ll_particle_params *params);

extern const ll_metric_table ll_particle_metrics_table, ll_particle_traced;
extern const ll_fluid_method ll_fluid_particles; /* of the scenes in fluid/scenes/particles.c */

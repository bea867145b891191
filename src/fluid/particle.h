/* Fluids of particles in the plane (smoothed particle hydrodynamics): m, s, kg per metre of depth.
 *
 * A fluid is one block whose size is known before it is made: indices, no pointers. A copy of the block is a
 * snapshot. A step calls neither malloc nor a clock, and computes the same bits on every compiler and
 * optimisation level. Particles lie sorted by cell, so their order changes; `id` stays.
 *
 * Kernel: Wendland C2, support 2 h. Walls and the moving body are particles too (three layers, or filled):
 * they have the fluid's spacing, take part in sums over neighbours, and are moved by nothing but their
 * owner. */
#pragma once

#include <stddef.h>

#include "fluid/fluid.h"

typedef struct ll_particles ll_particles;

/* ---- what is there at first: fixes the block's size ---- */

enum { LL_WALL_LEFT = 1, LL_WALL_RIGHT = 2, LL_WALL_BOTTOM = 4, LL_WALL_TOP = 8 };

#define LL_PARTICLE_FILLS 4
#define LL_PARTICLES_MAX 1000000 /* of fluid and walls together */

typedef struct ll_particle_fill { /* a rectangle of fluid, or the ellipse within it */
    double x, y, width, height;   /* m; x, y: its lower left corner */
    double u, v;                  /* m/s */
    double strain;                /* 1/s: adds (-strain, strain) times the place to its centre */
    int32_t round;
    int32_t settled; /* 1: as dense as its own weight makes it, of wcsph */
} ll_particle_fill;

typedef struct ll_particle_float { /* a rectangular body that fluid moves; none with density 0 */
    double x, y, width, height;    /* m; x, y: its centre */
    double density;                /* kg/m^2 */
} ll_particle_float;

typedef struct ll_particle_setup {
    double width, height; /* m: the tank is [0, width] x [0, height] */
    double spacing;       /* m between particles at rest */
    double smoothing;     /* h in spacings */
    int32_t walls;        /* bits of LL_WALL_ */
    int32_t periodic;     /* 1: what leaves at the right enters at the left */
    int32_t fill_count, reserved;
    ll_particle_fill fill[LL_PARTICLE_FILLS];
    ll_particle_float body;
} ll_particle_setup;

/* ---- parameters: all may change between steps ---- */

typedef enum ll_particle_method_kind {
    LL_PARTICLE_WCSPH,
    LL_PARTICLE_PBF,
    LL_PARTICLE_DFSPH,
    LL_PARTICLE_METHODS
} ll_particle_method_kind;

extern const char *const ll_particle_method_names[LL_PARTICLE_METHODS + 1]; /* NULL-terminated */
const char *ll_particle_method_help(ll_particle_method_kind kind);          /* method, cost and source */

/* Names, ranges and defaults: ll_particle_table. */
typedef struct ll_particle_params {
    double gravity_x, gravity_y;
    double density;              /* kg/m^2 at rest */
    double sound_speed;          /* m/s */
    double artificial_viscosity; /* Monaghan's alpha */
    double viscosity;            /* kinematic, m^2/s */
    double diffusion;            /* delta of wcsph */
    double cfl;                  /* dfsph and pbf: spacings that the fastest particle may go in a substep */
    double tolerance;            /* dfsph: relative density error at which the solver stops */
    double relaxation;           /* of dfsph's and pbf's Jacobi iteration */
    double smoothing;            /* pbf: share of the neighbours' mean velocity taken on in a substep */
    int64_t iterations;          /* of pbf; the most of dfsph */
    int64_t substeps;            /* the most in a step */
    int32_t method;              /* ll_particle_method_kind */
    bool no_slip;                /* fluid sticks to walls */
    bool lagged_density;         /* wcsph: density follows the velocity before the forces; unstable */
    uint8_t reserved[2];
} ll_particle_params;

extern const ll_param_table ll_particle_table;

/* ---- making and stepping ---- */

/* Ranges; LL_LIMIT tells the memory that too large a fluid would take. */
ll_status ll_particles_check(const ll_particle_setup *setup);
size_t ll_particles_size(const ll_particle_setup *setup); /* bytes of the block; setup is checked */
/* The part at the block's beginning that a snapshot must hold; what follows is rewritten in each step. */
size_t ll_particles_state_size(const ll_particles *p);

/* `block` has ll_particles_size bytes, aligned to 16; the fluid begins there. */
ll_particles *ll_particles_init(void *block, const ll_particle_setup *setup,
                                const ll_particle_params *params);
void ll_particles_set_params(ll_particles *p, const ll_particle_params *params);
const ll_particle_params *ll_particles_get_params(const ll_particles *p);
const ll_particle_setup *ll_particles_get_setup(const ll_particles *p);

/* One step of `dt` seconds, 1e-6 to 1, in as many substeps as the CFL condition asks for. LL_DIVERGED names
 * the tick, the particle and the reason: a value that is not finite, a CFL condition that the most substeps
 * cannot keep or that was broken, or more neighbours than there is room for. The fluid is then spent. */
ll_status ll_particles_step(ll_particles *p, double dt);
ll_status ll_particles_step_paced(ll_particles *p, double dt, ll_pace *pace); /* as ll_fluid_method's */

/* Fluid within the circle moves as told, until told otherwise. */
void ll_particles_stir(ll_particles *p, const ll_fluid_stir *stir);

typedef struct ll_particle_place {
    double x, y, u, v; /* m, m/s */
} ll_particle_place;

/* Puts all of the fluid: place k is that of the particle of id k, which init counts from 0 through the fills,
 * row by row from below. What a solver remembers of the step before is not changed. */
void ll_particles_put(ll_particles *p, const ll_particle_place *places);

uint64_t ll_particles_hash(const ll_particles *p); /* the same for the same history */

/* Every invariant of the block, for LL_VALIDATE and tests. */
bool ll_particles_valid(const ll_particles *p);

/* ---- looking ---- */

typedef struct ll_particle_view { /* arrays of `count`; valid until the next step */
    int32_t count, reserved;
    const int32_t *id;
    const double *x, *y, *u, *v; /* m, m/s */
    const double *density;       /* kg/m^2: of wcsph its own, of the others the sum over neighbours */
    const double *pressure;      /* N/m */
} ll_particle_view;

ll_particle_view ll_particles_view(const ll_particles *p);

typedef struct ll_particle_body { /* the moving body */
    double x, y, angle;           /* m, rad */
    double u, v, spin;            /* m/s, rad/s */
    double mass, inertia;         /* 0: there is none */
} ll_particle_body;

ll_particle_body ll_particles_body(const ll_particles *p);

typedef struct ll_particle_metrics {
    double front;                            /* m: the right edge of the rightmost particle */
    double height;                           /* m: the upper edge of the highest particle at the left wall */
    double mass;                             /* kg/m within the tank, or of all where no wall holds it */
    double momentum_x, momentum_y;           /* kg/s */
    double kinetic_energy, potential_energy; /* J/m; potential: of gravity, to the origin */
    double density_mean, density_max;        /* relative compression beyond the density at rest */
    double pressure_rms;                     /* relative error to a hydrostatic column of `depth` */
    double speed_max;                        /* m/s */
    double neighbours;                       /* mean, of fluid and walls */
} ll_particle_metrics;

/* `depth` of the column that pressure is held against, m. */
ll_particle_metrics ll_particles_measure(const ll_particles *p, double depth);

typedef struct ll_particle_stats {
    int64_t tick;
    int64_t substeps;   /* in all */
    int64_t iterations; /* of the pressure solvers, in all */
    int32_t fluid, wall, body;
    int32_t pairs; /* of the last substep */
    double time;   /* s */
} ll_particle_stats;

ll_particle_stats ll_particles_stats(const ll_particles *p);

/* ---- scenes ---- */

typedef struct ll_particle_scene {
    const char *name, *title;
    const char *help;             /* what is in it and what it is held against */
    double size;                  /* standard number of particles along the scene's own length */
    double depth;                 /* m, for pressure_rms; 0: no column */
    double dt, duration;          /* s, of a step and of the whole */
    const ll_param_table *solver; /* ll_particle_params with the scene's defaults */
    void (*configure)(double size, ll_particle_setup *setup);
} ll_particle_scene;

extern const ll_particle_scene *const ll_particle_scenes[];         /* NULL-terminated */
const ll_particle_scene *ll_particle_scene_named(const char *name); /* NULL with no such scene */
/* Sets all of both; `size` 0 is the scene's standard. */
void ll_particle_scene_setup(const ll_particle_scene *scene, double size, ll_particle_setup *setup,
                             ll_particle_params *params);

extern const ll_fluid_method ll_fluid_particles; /* of the scenes in scene_particles.c */

/* The block of a fluid of particles, for the files of this module. */
#pragma once

#include "fluid/particle/particle.h"

/* Arrays of one double per particle: fluid first, then walls and body. */
typedef enum ll_particle_field {
    LL_PARTICLE_X,
    LL_PARTICLE_Y,
    LL_PARTICLE_U,
    LL_PARTICLE_V,
    LL_PARTICLE_DENSITY,
    LL_PARTICLE_PRESSURE,        /* Pa */
    LL_PARTICLE_PRESSURE_FACTOR, /* p / density^2 of the solvers, and their initial guess */
    LL_PARTICLE_DIVERGENCE,      /* the same of dfsph's divergence solver */
    LL_PARTICLE_STATES,
    LL_PARTICLE_REACHED = LL_PARTICLE_STATES, /* k of dfsph's last iteration */
    LL_PARTICLE_X0 = LL_PARTICLE_STATES,      /* before the substep */
    LL_PARTICLE_Y0,
    LL_PARTICLE_SORTED,
    LL_PARTICLE_AX = LL_PARTICLE_SORTED, /* acceleration; of walls: the fluid's force on them over their
                                            mass, if there is a body */
    LL_PARTICLE_AY,
    LL_PARTICLE_FACTOR, /* temporary of a solver */
    LL_PARTICLE_RATE,   /* of density, or a similar sum; RATE to SUM: sums of four per particle */
    LL_PARTICLE_GX,     /* GX and GY: sums of two per particle */
    LL_PARTICLE_GY,
    LL_PARTICLE_SUM,
    LL_PARTICLE_FIELDS
} ll_particle_field;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* The smoothing kernel. */
typedef struct ll_particle_kernel {
    double h, support;
    double scale, slope_scale; /* of the kernel and of its gradient */
    double gradient_scale;     /* of the gradient relative to the kernel's own derivative */
    double viscous_scale;      /* makes the viscous sum of a lattice exact */
} ll_particle_kernel;

/* The grid of cells that finds neighbours. */
typedef struct ll_particle_cells {
    double origin_x, origin_y;
    double per_m_x, per_m_y; /* cells per metre */
} ll_particle_cells;

/* Of the body in the tank. */
typedef struct ll_particle_body_motion {
    double u0, v0; /* velocity before the substep */
    double ax, ay; /* last acceleration */
} ll_particle_body_motion;

/* Where the arrays lie, from the start of the block. */
typedef struct ll_particle_layout {
    int64_t field, id, state_end, local, cell, order, fluid_start, wall_start;
    int64_t row, beside, pair, ex, ey, slope, kernel, end;
} ll_particle_layout;

struct ll_particles {
    ll_particle_setup setup;
    ll_particle_params params;
    ll_particle_body body;
    ll_drag_force drag_force;
    double time;
    double mass; /* of one particle */
    ll_particle_kernel kernel;
    ll_particle_cells cells;
    double wrap; /* width of a periodic tank, or infinity */
    ll_particle_body_motion motion;
    int64_t tick, substeps, iterations;
    int32_t fluid, wall, body_count;
    int32_t columns, rows;
    int32_t pairs;
    /* Where things lie, and what a substep leaves: not hashed. */
    int32_t stride;   /* doubles per field */
    int32_t capacity; /* of pairs */
    int32_t beside;   /* fluid particles with pairs with walls */
    int32_t reserved;
    ll_particle_layout at;
};

#pragma GCC diagnostic pop

#define LL_PART(name, type)                                                                                  \
    static inline type *ll_part_##name(const ll_particles *p)                                                \
    {                                                                                                        \
        return (type *)((char *)(uintptr_t)p + p->at.name);                                                  \
    }
LL_PART(id, int32_t)   /* fluid: from 0; tank: -1; body: -2 - k */
LL_PART(local, double) /* x, y of the body's particle k in the body frame */
LL_PART(cell, int32_t) /* for sorting: cell, index and one field */
LL_PART(order, double)
LL_PART(fluid_start, int32_t) /* first particle of a cell; one more at the end */
LL_PART(wall_start, int32_t)
/* Pairs of fluid particle a: from row[2 a] with fluid of a higher index, from row[2 a + 1] with walls, to
 * row[2 a + 2]. */
LL_PART(row, int32_t)
LL_PART(beside, int32_t) /* fluid particles with pairs with walls, in their order */
LL_PART(pair, int32_t)   /* the other particle */
LL_PART(ex, double)      /* x of a minus x of the other */
LL_PART(ey, double)
LL_PART(slope, double) /* the kernel's gradient is slope * (ex, ey); negative */
LL_PART(kernel, double)

static inline double *ll_particle_values(const ll_particles *p, ll_particle_field field)
{
    return (double *)((char *)(uintptr_t)p + p->at.field) + (size_t)field * (size_t)p->stride;
}

static inline int32_t ll_particle_total(const ll_particles *p)
{
    return p->fluid + p->wall;
}

/* Particles whose pairs are processed together: intermediate results stay in the first-level cache. */
#define LL_PARTICLE_BLOCK 32

static inline int32_t ll_particle_block_end(int32_t from, int32_t end)
{
    return end - from > LL_PARTICLE_BLOCK ? from + LL_PARTICLE_BLOCK : end;
}

/* ---- threads ---- */

/* What a part of a job computes: the sums of the particles begin..end - 1, which are whole cells. A pair adds
 * to both of its particles, in the order of the first one, so that the part visits two more kinds of pairs:
 * those of halo..begin - 1, particles of another part, as far as they reach into this one; and it leaves out
 * what the pairs of tail..end - 1 add to particles of the next part. */
typedef struct ll_particle_share {
    int32_t halo, begin, tail, end;
    int32_t first_cell, last_cell;
} ll_particle_share;

ll_particle_share ll_particle_share_of(const ll_particles *p, int part, int parts);

/* Fewest particles that are worth a team: the shortest pass takes about 20 ns for each. */
#define LL_PARTICLE_TEAM 512

/* Visits one particle: `own` if its sums are this part's, `inside` if all its pairs are. */
typedef void ll_particle_visit(void *context, int32_t a, const ll_particle_share *s, bool own, bool inside);

static inline bool ll_particle_takes(const ll_particle_share *s, int32_t b, bool inside)
{
    return inside || (b >= s->begin && b < s->end);
}

/* A visit, for ll_particle_each: inlined three times, as what `own` and `inside` are there. */
#define LL_PARTICLE_VISIT(name)                                                                              \
    static inline __attribute__((always_inline)) void name(                                                  \
        void *context, int32_t a, const ll_particle_share *s, bool own, bool inside)

static inline __attribute__((always_inline)) void ll_particle_each(const ll_particle_share *s,
                                                                   ll_particle_visit *visit, void *context)
{
    for (int32_t a = s->halo; a < s->begin; a++)
        visit(context, a, s, false, false);
    for (int32_t a = s->begin; a < s->tail; a++)
        visit(context, a, s, true, true);
    for (int32_t a = s->tail; a < s->end; a++)
        visit(context, a, s, true, false);
}

/* Distance to the nearest image of another particle in a periodic tank. */
static inline double ll_particle_shortest(double e, double half, double wrap)
{
    e -= e > half ? wrap : 0;
    e += e < -half ? wrap : 0;
    return e;
}

/* Failure in a substep; all zero: none. */
typedef struct ll_particle_fault {
    const char *reason;
    int32_t particle; /* index */
    int32_t reserved;
    double value, limit;
} ll_particle_fault;

typedef struct ll_particle_method {
    double travel; /* spacings that a particle may move per substep before its neighbours are invalid */
    double (*dt_limit)(const ll_particles *p, double speed); /* s; `speed`: the largest */
    ll_particle_fault (*substep)(ll_particles *p, double dt, const ll_fluid_run *run);
} ll_particle_method;

extern const ll_particle_method ll_particle_wcsph, ll_particle_pbf, ll_particle_dfsph;

/* neighbours.c */
void ll_particle_cells_size(const ll_particle_setup *setup, double support, ll_particles *p);
void ll_particle_sort_fluid(ll_particles *p);
void ll_particle_sort_walls(ll_particles *p);
/* Finds all pairs closer than `reach`, and computes their vectors and kernels. Where `reach` is the side of a
 * cell, a pair that is nearer by a rounding error only may be missed: its kernel is 0. */
ll_particle_fault ll_particle_pairs(ll_particles *p, double reach, ll_team *team);

/* Writes those of the particles begin..end - 1 that are nearer to `a` than the root of reach2, in their
 * order, and returns their number. Writes up to LL_PARTICLE_NEAR_LANES more numbers than there are particles,
 * and reads as far. */
#define LL_PARTICLE_NEAR_LANES 4
typedef int32_t ll_particle_near(const double *x, const double *y, int32_t a, int32_t begin, int32_t end,
                                 double reach2, int32_t *pair);
ll_particle_near ll_particle_near_base, ll_particle_near_avx2;

/* Of one pair, by the formulas of geometry.inc. */
typedef struct ll_particle_pair_geometry {
    double ex, ey, slope, kernel;
} ll_particle_pair_geometry;

ll_particle_pair_geometry ll_particle_geometry_of(const ll_particles *p, int32_t a, int32_t b);

/* geometry.c: vectors and kernels of the pairs of the particles from..to - 1, by what the CPU has */
void ll_particle_geometry(ll_particles *p, int32_t from, int32_t to);
void ll_particle_geometry_base(ll_particles *p, int32_t from, int32_t to);
void ll_particle_geometry_avx2(ll_particles *p, int32_t from, int32_t to);

/* sums.c: passes over pairs that methods share. `team` may be NULL, and changes no bit. */
/* DENSITY of the fluid, and FACTOR: how much a particle's own k reduces it, over k dt^2. `moved`: also
 * recomputes the pairs' geometry, a block of particles at a time, so that it is read from the cache. */
void ll_particle_sum_density(ll_particles *p, bool moved, ll_team *team);
/* Walls get the mean k of the fluid around, plus gravity's contribution over `volume` = 1 / density (0 for
 * changes of k). */
void ll_particle_mirror(ll_particles *p, double *pressure_factor, double volume);
/* PRESSURE of the fluid: the field that k of fluid and walls makes. */
void ll_particle_field_pressure(ll_particles *p, const double *pressure_factor, ll_team *team);
/* Adds viscous acceleration. With no-slip walls it leaves their mirrored velocity in GX and GY. */
void ll_particle_add_viscosity(ll_particles *p, ll_team *team);
/* Sum of m (v_a - v_b) grad W into RATE of the fluid. */
void ll_particle_sum_rate(ll_particles *p, ll_team *team);
/* Computes AX, AY from k = p / density^2 of fluid and walls; of walls only if there is a body. */
void ll_particle_push(ll_particles *p, const double *pressure_factor, ll_team *team);
/* Sets AX, AY to 0. */
void ll_particle_rest(ll_particles *p);

/* coupling.c */
void ll_particle_body_place(ll_particles *p);
/* Adds the momentum that the fluid exerted during dt by AX, AY of the body's particles. */
void ll_particle_body_push(ll_particles *p, double dt);
void ll_particle_body_move(ll_particles *p, double dt);

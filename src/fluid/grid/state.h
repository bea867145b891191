/* The block of a grid, for the files that step it. */
#pragma once

#include "fluid/grid/grid.h"

typedef enum ll_grid_field_kind {
    LL_FIELD_U,
    LL_FIELD_V,
    LL_FIELD_DYE,
    LL_FIELD_PRESSURE, /* times dt / h: m/s */
    LL_FIELD_A,        /* A to F: temporary within a step */
    LL_FIELD_B,
    LL_FIELD_C,
    LL_FIELD_D,
    LL_FIELD_E,
    LL_FIELD_F,
    LL_FIELD_SOURCE,
    LL_FIELD_OPEN_X,
    LL_FIELD_OPEN_Y,
    LL_FIELD_INVERSE,
    LL_FIELDS
} ll_grid_field_kind;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

struct ll_grid {
    ll_grid_config config;
    ll_grid_solver solver;
    ll_drag_force drag_force;
    int64_t size;
    int64_t steps, solves, sweeps; /* since the start */
    int64_t last_sweeps, last_substeps;
    double last_residual; /* relative */
    double last_cfl;
    double time, mass_start;
    int32_t stride, rows;
    int32_t empty; /* no obstacle */
    int32_t reserved;
};

#pragma GCC diagnostic pop

static inline double *ll_grid_field(const ll_grid *g, ll_grid_field_kind kind)
{
    return (double *)((char *)g + sizeof(ll_grid)) + (int64_t)kind * g->stride * g->rows;
}

static inline int64_t ll_grid_k(const ll_grid *g, int32_t i, int32_t j)
{
    return (int64_t)(j + 1) * g->stride + i + 1;
}

static inline bool ll_grid_periodic_x(const ll_grid *g)
{
    return g->config.sides[LL_LEFT] == LL_SIDE_PERIODIC;
}

static inline bool ll_grid_periodic_y(const ll_grid *g)
{
    return g->config.sides[LL_BELOW] == LL_SIDE_PERIODIC;
}

int32_t *ll_grid_first_donors(const ll_grid *); /* of each value, while it is advected */

/* ---- boundary.c ---- */

/* Position of a field's values in a cell. */
typedef enum ll_grid_place { LL_PLACE_U, LL_PLACE_V, LL_PLACE_CELL } ll_grid_place;

/* Computed values: faces on walls are excluded. Ends are exclusive. */
typedef struct ll_grid_span {
    int32_t i0, i1, j0, j1;
} ll_grid_span;

ll_grid_span ll_grid_span_of(const ll_grid *, ll_grid_place);
void ll_grid_bounds(const ll_grid *, ll_grid_place, double *field); /* fills the ring */
void ll_grid_close(const ll_grid *, double *u, double *v);          /* no flow through faces of obstacles */

/* ---- advection.c ---- */

typedef struct ll_grid_advect {
    const ll_grid *g; /* its u and v advect */
    ll_grid_place place;
    const double *in;
    double *out;
    double *spare[2];
    int32_t *donors;
    double dt;
    ll_team *team; /* may be NULL */
} ll_grid_advect;

/* NULL: the scheme does whole steps, without splitting (central.c). */
typedef void ll_advect(const ll_grid_advect *);
extern ll_advect *const ll_advections[LL_ADVECTIONS];

/* out = in at the point where the flow was `dt` ago, interpolated between four values. `donors`: the first of
 * the four for each value, or NULL. */
void ll_grid_trace(const ll_grid_advect *, const double *in, double *out, double dt, int32_t *donors);
void ll_grid_clamp(const ll_grid_advect *); /* clamps out to the range of its donors */
/* out = base + (in - back) / 2; `out` may be one of the others. */
void ll_grid_add_half(const ll_grid_advect *, double *out, const double *base, const double *back);

/* ---- mass.c ---- */

/* Changes out, within the range of its donors, so that its sum is that of `in` less what leaves the box. */
void ll_grid_keep_mass(const ll_grid_advect *);

/* ---- forces, projection ---- */

void ll_grid_diffuse(ll_grid *, double dt, ll_team *);
void ll_grid_add_forces(const ll_grid *, double *du, double *dv, double dt);
void ll_grid_drive(ll_grid *); /* sources and pointer drag */
void ll_grid_project(ll_grid *, const ll_fluid_run *);
void ll_grid_poisson(const ll_grid *, ll_poisson *); /* all but `b` and settings */
void ll_grid_outflow(ll_grid *, double dt);

/* One Runge-Kutta step. */
void ll_grid_step_central(ll_grid *, double dt, const ll_fluid_run *);
#define LL_CENTRAL_CFL 1.5       /* of 1.73, the method's limit on the imaginary axis */
#define LL_CENTRAL_DYE_CFL 0.5   /* limit up to which limited fluxes make no new extremes */
#define LL_CENTRAL_DIFFUSION 0.3 /* nu dt / h^2, of 0.314 */

/* Fluid on a staggered grid (MAC): velocities on faces, pressure and dye in cells; incompressible, density 1.
 *
 * One relocatable block. A step is divided so that nothing moves further than `cfl` cells at a time. Each
 * substep applies advection, forces and viscosity, and projects the result onto fields without divergence;
 * with central fluxes a Runge-Kutta method of order 3 does all of this. Sides of the box are walls, inflow,
 * outflow or periodic; cells may be obstacles. */
#pragma once

#include "fluid/core/fluid.h"
#include "fluid/pressure/poisson.h"

typedef enum ll_grid_side_kind {
    LL_SIDE_WALL, /* no slip */
    LL_SIDE_SLIP,
    LL_SIDE_IN,      /* fixed initial inflow */
    LL_SIDE_OUT,     /* outflow; at the right only */
    LL_SIDE_PERIODIC /* with the opposite side */
} ll_grid_side_kind;

enum { LL_LEFT, LL_RIGHT, LL_BELOW, LL_ABOVE };

typedef enum ll_advection_kind {
    LL_ADVECTION_SEMI_LAGRANGIAN,
    LL_ADVECTION_MACCORMACK,
    LL_ADVECTION_BFECC,
    LL_ADVECTION_CENTRAL,
    LL_ADVECTIONS
} ll_advection_kind;

typedef enum ll_splitting { LL_SPLITTING_PROJECTION, LL_SPLITTING_REFLECTION, LL_SPLITTINGS } ll_splitting;

/* Settings: all may change between steps. Names, ranges and defaults: parameters.h. */
typedef struct ll_grid_solver {
    int32_t advection; /* ll_advection_kind */
    int32_t splitting; /* ll_splitting */
    int32_t pressure;  /* ll_pressure_kind */
    int32_t reserved;
    int64_t backtrace;            /* order 1 to 3 */
    int64_t sweeps;               /* limit of the pressure solver */
    int64_t substeps;             /* per step; 0: by `cfl` */
    double tolerance;             /* of the pressure solver, relative */
    double relaxation;            /* 0: the solver's own */
    double cfl;                   /* cells */
    double viscosity_scale;       /* factor of the scene's viscosity */
    double vorticity_confinement; /* vorticity confinement */
    bool limiter;                 /* maccormack and bfecc stay within the values that they interpolate */
    bool conserve_mass;           /* of the dye */
    uint8_t padding[6];
} ll_grid_solver;

extern const char *const ll_advection_names[LL_ADVECTIONS + 1];

/* Fixed by a scene. */
typedef struct ll_grid_config {
    int32_t nx, ny;
    double x, y, h;                           /* lower left corner, cell size: m */
    int32_t sides[4];                         /* ll_grid_side_kind */
    double wall_speed;                        /* m/s to the right, of the upper wall */
    double viscosity;                         /* m^2/s */
    double buoyancy;                          /* m/s^2 upwards for dye 1 */
    double source_x, source_y, source_radius; /* the dye is held at 1 there; radius 0: no source */
    int32_t dyed;                             /* 1: with dye */
    int32_t frozen;                           /* 1: velocities do not change */
    double params[4];                         /* copy of the scene's own */
} ll_grid_config;

typedef struct ll_grid ll_grid;

size_t ll_grid_size(int32_t nx, int32_t ny);
/* Whether a scene of this size, with or without obstacles, can be made with these settings. */
ll_status ll_grid_check(const ll_grid_config *, const ll_grid_solver *, bool empty);

/* At rest and without dye. Then the scene fills fluid, velocities and dye, and calls ll_grid_start. */
void ll_grid_init(void *block, const ll_grid_config *, const ll_grid_solver *);
void ll_grid_start(ll_grid *);
ll_status ll_grid_step(ll_grid *, double dt, const ll_fluid_run *run); /* as ll_fluid_method's */
void ll_grid_set_solver(ll_grid *, const ll_grid_solver *);

const ll_grid_config *ll_grid_get_config(const ll_grid *);
double ll_grid_time(const ll_grid *);

/* Fields have a ring of one cell: index ll_grid_at. u of cell (i, j) is on its left face, v on its lower
 * one. */
static inline int64_t ll_grid_at(int32_t nx, int32_t i, int32_t j)
{
    return (int64_t)(j + 1) * ((nx + 4) & ~1) + i + 1;
}

double *ll_grid_u(const ll_grid *);
double *ll_grid_v(const ll_grid *);
double *ll_grid_dye(const ll_grid *);
uint8_t *ll_grid_fluid(const ll_grid *); /* 1, or 0 in obstacles */

double ll_grid_divergence(const ll_grid *); /* 1/s: the largest */
double ll_grid_energy(const ll_grid *, double mean_x,
                      double mean_y); /* m^4/s^2: kinetic energy of the deviation from the mean */
double ll_grid_mass(const ll_grid *); /* m^2 of dye */
int ll_grid_numbers(const void *block, ll_fluid_number *out);
extern const ll_metric_table ll_grid_metrics, ll_grid_traced;

extern const ll_fluid_method ll_fluid_grid;

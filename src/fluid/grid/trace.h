/* Tracing the flow back in time, by what the CPU has. */
#pragma once

#include "fluid/grid/state.h"

/* Positions in cells, and velocities in cells per `scale`. */
typedef struct ll_grid_tracer {
    const double *u, *v;
    int64_t stride;
    double nx, ny;
    bool periodic_x, periodic_y;
    ll_grid_place place;
    int64_t order;
    double scale;      /* dt / h */
    const double *in;  /* what is carried */
    double *out;       /* another field */
    int32_t *donors;   /* or NULL */
    ll_grid_span span; /* of the computed values; at least four cells wide */
} ll_grid_tracer;

/* A set of loops over row `j`. */
typedef struct ll_grid_tracing {
    void (*trace)(const ll_grid_tracer *, int32_t j);
    void (*clamp)(const ll_grid_advect *, int32_t j); /* out, to the range of its donors */
    /* How far each value may rise (`up`) and fall within the range of its donors; 0 in obstacles. */
    void (*room)(const ll_grid_advect *, int32_t j, double *up, double *down);
} ll_grid_tracing;

extern const ll_grid_tracing ll_grid_tracing_base, ll_grid_tracing_avx2;

const ll_grid_tracing *ll_grid_tracing_here(void); /* for this CPU */

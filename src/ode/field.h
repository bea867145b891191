/* A system's functions, written once for one state and for two at once.
 *
 * LL_ODE_RHS and its like define `name` for one state and `name_pair` for two from one body, in which `real`
 * is the type of a number, double or ll_pair, and ll_real_sqrt, ll_real_sin and ll_real_cos are functions of
 * it. They also define name_midpoint and name_leapfrog, the loops of extrapolation (ode/extrapolation.h) with
 * the body within: where a state has few components, calls and the way through memory cost as much as the
 * body. `dim` is that of the system, a constant. */
#pragma once

#include "base/detmath.h"
#include "ode/extrapolation.h"

static inline ll_pair ll_pair_sqrt(ll_pair x)
{
    return (ll_pair){ll_sqrt(x[0]), ll_sqrt(x[1])};
}

static inline ll_pair ll_pair_sin(ll_pair x)
{
    return (ll_pair){ll_sin(x[0]), ll_sin(x[1])};
}

static inline ll_pair ll_pair_cos(ll_pair x)
{
    return (ll_pair){ll_cos(x[0]), ll_cos(x[1])};
}

#define ll_real_sqrt(x) _Generic((x), double : ll_sqrt, default : ll_pair_sqrt)(x)
#define ll_real_sin(x) _Generic((x), double : ll_sin, default : ll_pair_sin)(x)
#define ll_real_cos(x) _Generic((x), double : ll_cos, default : ll_pair_cos)(x)

/* ll_ode_rhs: p, t, y give dy. */
#define LL_ODE_RHS(name, dim, ...)                                                                           \
    static void name(const void *p, double t, const double *y, double *dy)                                   \
    {                                                                                                        \
        typedef double real;                                                                                 \
        (void)p, (void)t, (void)sizeof(real);                                                                \
        __VA_ARGS__                                                                                          \
    }                                                                                                        \
    LL_INLINE void name##_pair(const void *p, const ll_pair *at, const ll_pair *y, ll_pair *dy)              \
    {                                                                                                        \
        typedef ll_pair real;                                                                                \
        real t = *at;                                                                                        \
        (void)p, (void)t;                                                                                    \
        __VA_ARGS__                                                                                          \
    }                                                                                                        \
    static inline __attribute__((unused)) void name##_midpoint(                                              \
        const void *p, const ll_ode_plan *plan, double t, double h, const double *y, const double *f0,       \
        ll_pair *sum, ll_pair *error)                                                                        \
    {                                                                                                        \
        ll_ode_midpoint_rows((dim), name##_pair, p, plan, t, h, y, f0, sum, error);                          \
    }

/* ll_ode_acceleration: p, t, q, v give a. Leapfrog is for an a that is free of v. */
#define LL_ODE_ACCELERATION(name, dim, ...)                                                                  \
    static void name(const void *p, double t, const double *q, const double *v, double *a)                   \
    {                                                                                                        \
        typedef double real;                                                                                 \
        (void)p, (void)t, (void)q, (void)v, (void)sizeof(real);                                              \
        __VA_ARGS__                                                                                          \
    }                                                                                                        \
    LL_INLINE void name##_pair(const void *p, const ll_pair *at, const ll_pair *q, const ll_pair *v,         \
                               ll_pair *a)                                                                   \
    {                                                                                                        \
        typedef ll_pair real;                                                                                \
        real t = *at;                                                                                        \
        (void)p, (void)t, (void)q, (void)v;                                                                  \
        __VA_ARGS__                                                                                          \
    }                                                                                                        \
    LL_INLINE void name##_rhs_pair(const void *p, const ll_pair *t, const ll_pair *y, ll_pair *dy)           \
    {                                                                                                        \
        for (int i = 0; i < (dim) / 2; i++)                                                                  \
            dy[i] = y[(dim) / 2 + i];                                                                        \
        name##_pair(p, t, y, y + (dim) / 2, dy + (dim) / 2);                                                 \
    }                                                                                                        \
    static inline __attribute__((unused)) void name##_midpoint(                                              \
        const void *p, const ll_ode_plan *plan, double t, double h, const double *y, const double *f0,       \
        ll_pair *sum, ll_pair *error)                                                                        \
    {                                                                                                        \
        ll_ode_midpoint_rows((dim), name##_rhs_pair, p, plan, t, h, y, f0, sum, error);                      \
    }                                                                                                        \
    static inline __attribute__((unused)) void name##_leapfrog(                                              \
        const void *p, const ll_ode_plan *plan, double t, double h, const double *y, const double *f0,       \
        ll_pair *sum, ll_pair *error)                                                                        \
    {                                                                                                        \
        (void)f0;                                                                                            \
        ll_ode_leapfrog_rows((dim) / 2, name##_pair, NULL, p, plan, t, h, y, sum, error);                    \
    }

/* ll_ode_magnetic: p, t, q give e and b. */
#define LL_ODE_MAGNETIC(name, dim, ...)                                                                      \
    static void name(const void *p, double t, const double *q, double *e, double *b)                         \
    {                                                                                                        \
        typedef double real;                                                                                 \
        (void)p, (void)t, (void)q, (void)sizeof(real);                                                       \
        __VA_ARGS__                                                                                          \
    }                                                                                                        \
    LL_INLINE void name##_pair(const void *p, const ll_pair *at, const ll_pair *q, ll_pair *e, ll_pair *b)   \
    {                                                                                                        \
        typedef ll_pair real;                                                                                \
        real t = *at;                                                                                        \
        (void)p, (void)t, (void)q;                                                                           \
        __VA_ARGS__                                                                                          \
    }                                                                                                        \
    static inline __attribute__((unused)) void name##_leapfrog(                                              \
        const void *p, const ll_ode_plan *plan, double t, double h, const double *y, const double *f0,       \
        ll_pair *sum, ll_pair *error)                                                                        \
    {                                                                                                        \
        (void)f0;                                                                                            \
        ll_ode_leapfrog_rows((dim) / 2, NULL, name##_pair, p, plan, t, h, y, sum, error);                    \
    }

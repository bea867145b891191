/* Functions of a system, written once for one state and for two at once.
 *
 * LL_ODE_RHS and the other macros define `name` for one state and `name_pair` for two from one body, in which
 * `real` is the number type, double or ll_pair, and ll_real_sqrt, ll_real_sin and so on are its functions.
 * They also compile the loops of methods with this body, collected by LL_ODE_KERNELS, and name_leapfrog: for
 * small states, calls and memory traffic cost as much as the body. `dim` is the system's, a constant. */
#pragma once

#include "ode/core/kernels.h"

#define ll_real_abs(x) _Generic((x), double : __builtin_fabs, default : ll_pair_fabs)(x)
#define ll_real_sqrt(x) _Generic((x), double : ll_sqrt, default : ll_pair_sqrt)(x)
#define ll_real_sin(x) _Generic((x), double : ll_sin, default : ll_pair_sin)(x)
#define ll_real_cos(x) _Generic((x), double : ll_cos, default : ll_pair_cos)(x)
#define ll_real_sincos(x, s, c) _Generic((x), double : ll_sincos, default : ll_pair_sincos)(x, s, c)

/* Loops of the methods that take any f, from `rhs` of one state and `rhs_pair` of two. */
#define LL_ODE_LOOPS(name, dim, rhs, rhs_pair)                                                               \
    static inline __attribute__((unused)) double name##_midpoint(const void *p, const ll_ode_plan *plan,     \
                                                                 const ll_ode_trial *trial)                  \
    {                                                                                                        \
        return ll_ode_midpoint_rows((dim), rhs_pair, p, plan, trial);                                        \
    }                                                                                                        \
    static inline __attribute__((unused)) double name##_dop853(const void *p, const ll_ode_trial *trial)     \
    {                                                                                                        \
        LL_ODE_OWN_STAGES(ll_ode_dop853_stages, LL_DOP853_STAGES, dim, rhs, p, trial);                       \
    }                                                                                                        \
    static inline                                                                                            \
        __attribute__((unused)) double name##_seven_stages(const void *p, const ll_ode_trial *trial)         \
    {                                                                                                        \
        LL_ODE_OWN_STAGES(ll_ode_seven_stages, LL_SEVEN, dim, rhs, p, trial);                                \
    }

#define LL_ODE_KERNELS(name)                                                                                 \
    .midpoint = name##_midpoint, .dop853 = name##_dop853, .seven_stages = name##_seven_stages

/* ll_ode_rhs: computes dy from p, t, y. */
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
    LL_ODE_LOOPS(name, dim, name, name##_pair)

/* ll_ode_acceleration: computes a from p, t, q, v. Leapfrog needs an a independent of v. */
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
    LL_INLINE void name##_rhs(const void *p, double t, const double *y, double *dy)                          \
    {                                                                                                        \
        for (int i = 0; i < (dim) / 2; i++)                                                                  \
            dy[i] = y[(dim) / 2 + i];                                                                        \
        name(p, t, y, y + (dim) / 2, dy + (dim) / 2);                                                        \
    }                                                                                                        \
    LL_INLINE void name##_rhs_pair(const void *p, const ll_pair *t, const ll_pair *y, ll_pair *dy)           \
    {                                                                                                        \
        for (int i = 0; i < (dim) / 2; i++)                                                                  \
            dy[i] = y[(dim) / 2 + i];                                                                        \
        name##_pair(p, t, y, y + (dim) / 2, dy + (dim) / 2);                                                 \
    }                                                                                                        \
    LL_ODE_LOOPS(name, dim, name##_rhs, name##_rhs_pair)                                                     \
    static inline __attribute__((unused)) double name##_leapfrog(const void *p, const ll_ode_plan *plan,     \
                                                                 const ll_ode_trial *trial)                  \
    {                                                                                                        \
        return ll_ode_leapfrog_rows((dim) / 2, name##_pair, NULL, p, plan, trial);                           \
    }

/* ll_ode_magnetic: computes e and b from p, t, q. */
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
    static inline __attribute__((unused)) double name##_leapfrog(const void *p, const ll_ode_plan *plan,     \
                                                                 const ll_ode_trial *trial)                  \
    {                                                                                                        \
        return ll_ode_leapfrog_rows((dim) / 2, NULL, name##_pair, p, plan, trial);                           \
    }

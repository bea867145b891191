#include "rigid/body/rigid.h"

static const char *const continuous_names[] = {"off", "speculative", "swept", NULL};
static const char *const simd_names[] = {"auto", "scalar", "sse2", "avx2", NULL};

#define ROW(field, ...)                                                                                      \
    {                                                                                                        \
        .name = #field, .offset = offsetof(ll_rigid_params, field), .live = true, __VA_ARGS__                \
    }
#define REAL(field, low, high, value, of, text)                                                              \
    ROW(field, .type = LL_PARAM_REAL, .min = low, .max = high, .default_value = value, .unit = of,           \
        .help = text)
#define WHOLE(field, low, high, value, text)                                                                 \
    ROW(field, .type = LL_PARAM_INT, .min = low, .max = high, .default_value = value, .help = text)
#define CHOICE(field, names, value, text)                                                                    \
    ROW(field, .type = LL_PARAM_CHOICE, .choices = names, .default_value = value, .help = text)
#define SWITCH(field, value, text) ROW(field, .type = LL_PARAM_BOOL, .default_value = value, .help = text)

static const ll_param rows[] = {
    REAL(gravity_x, -1000, 1000, 0, "m/s^2", "Gravity to the right."),
    REAL(gravity_y, -1000, 1000, -10, "m/s^2", "Gravity upwards."),
    {LL_PARAM_ROW("method", CHOICE, ll_rigid_params, solver), .choices = ll_rigid_solver_names,
     .default_value = LL_SOLVER_SOFT_STEP, .live = true, .help = "Contact solver."},
    CHOICE(continuous, continuous_names, LL_CONTINUOUS_OFF,
           "Tunnelling prevention: none, speculative contacts, or continuous collision detection (swept)."),
    CHOICE(bounding_volume, ll_volume_names, LL_VOLUME_EXACT,
           "Shape that collides instead of the exact one."),
    CHOICE(simd, simd_names, LL_SIMD_AUTO,
           "Width of the contact solver's loops; the results are the same bits."),
    WHOLE(substeps, 1, 64, 16, "Substeps per step, of the solvers soft_step, tgs_sticky and xpbd."),
    WHOLE(iterations, 1, 200, 10, "Velocity passes, of the solvers impulse, pgs, pgs_ngs and avbd."),
    WHOLE(position_iterations, 0, 200, 4, "Position passes, of the solver pgs_ngs."),
    REAL(contact_hertz, 1, 1000, 120, "Hz",
         "Contact stiffness of soft_step; limited to an eighth of the substep rate."),
    REAL(contact_damping_ratio, 0, 100, 10, NULL, "Contact damping ratio of soft_step."),
    REAL(contact_push_speed, 0, 1000, 3, "m/s", "Largest speed at which an overlap is pushed apart."),
    REAL(joint_hertz, 1, 1000, 120, "Hz", "Joint stiffness; limited to a quarter of the substep rate."),
    REAL(joint_damping_ratio, 0, 100, 2, NULL, "Joint damping ratio."),
    REAL(baumgarte, 0, 1, 0.2, NULL, "Fraction of an overlap that pgs and pgs_ngs correct per pass."),
    REAL(restitution_threshold, 0, 1000, 1, "m/s", "Slower impacts do not bounce."),
    REAL(recycle_distance, 0, 1, 0.05, "m",
         "Relative motion of two bodies beyond which their manifold is recomputed."),
    REAL(sleep_threshold, 0, 10, 0.05, "m/s", "Bodies slower than this for half a second may sleep."),
    SWITCH(warm_start, 1, "Warm starting: begin with the impulses of the last step."),
    SWITCH(recycle, 1,
           "Contact recycling: keep manifolds of bodies that hardly moved relative to each other."),
    SWITCH(sleep, 1, "Let resting islands sleep."),
};

enum { GRAVITY_ROWS = 2, ROWS = sizeof rows / sizeof rows[0] };

const ll_param_table ll_rigid_table = {.name = "rigid_world",
                                       .help = "Parameters of a world of rigid bodies.",
                                       .rows = rows,
                                       .count = ROWS,
                                       .size = sizeof(ll_rigid_params)};

const ll_param_table ll_rigid_solver_table = {.name = "rigid_solver",
                                              .help = "Contact detection and solver.",
                                              .rows = rows + GRAVITY_ROWS,
                                              .count = ROWS - GRAVITY_ROWS,
                                              .size = sizeof(ll_rigid_params)};

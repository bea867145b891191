#include "rigid/body/rigid.h"

static const char *const continuous_names[] = {"off", "speculative", "swept", NULL};
static const char *const simd_names[] = {"auto", "scalar", "sse2", "avx2", NULL};

#define ROW(field, ...)                                                                                      \
    {                                                                                                        \
        .name = #field, .offset = offsetof(ll_rigid_params, field), .live = true, __VA_ARGS__                \
    }
#define REAL(field, low, high, value, of, text)                                                              \
    ROW(field, .type = LL_PARAM_REAL, .min = low, .max = high, .standard = value, .unit = of, .help = text)
#define WHOLE(field, low, high, value, text)                                                                 \
    ROW(field, .type = LL_PARAM_INT, .min = low, .max = high, .standard = value, .help = text)
#define CHOICE(field, names, value, text)                                                                    \
    ROW(field, .type = LL_PARAM_CHOICE, .choices = names, .standard = value, .help = text)
#define SWITCH(field, value, text) ROW(field, .type = LL_PARAM_BOOL, .standard = value, .help = text)

static const ll_param rows[] = {
    REAL(gravity_x, -1000, 1000, 0, "m/s^2", "Gravity to the right."),
    REAL(gravity_y, -1000, 1000, -10, "m/s^2", "Gravity upwards."),
    {.name = "method",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_rigid_params, solver),
     .choices = ll_rigid_solver_names,
     .standard = LL_SOLVER_SOFT_STEP,
     .live = true,
     .help = "How contacts are resolved."},
    CHOICE(continuous, continuous_names, LL_CONTINUOUS_OFF,
           "What is done against passing through: nothing, contacts ahead of time, or sweeping fast bodies."),
    CHOICE(volume, ll_volume_names, LL_VOLUME_EXACT, "What collides in the place of every shape."),
    CHOICE(simd, simd_names, LL_SIMD_AUTO,
           "Width of the contact solver's loops; the results are the same bits."),
    WHOLE(substeps, 1, 64, 16, "Parts of a step, of the solvers soft_step, tgs_sticky and xpbd."),
    WHOLE(iterations, 1, 200, 10,
          "Passes over the velocities, of the solvers impulse, pgs, pgs_ngs and avbd."),
    WHOLE(position_iterations, 0, 200, 4, "Passes over the positions, of the solver pgs_ngs."),
    REAL(contact_hertz, 1, 1000, 120, "Hz",
         "Stiffness of contacts of soft_step; at most an eighth of the substep rate is used."),
    REAL(contact_damping, 0, 100, 10, NULL, "Damping ratio of contacts of soft_step."),
    REAL(push_speed, 0, 1000, 3, "m/s", "Fastest way out of an overlap."),
    REAL(joint_hertz, 1, 1000, 120, "Hz",
         "Stiffness of joints; at most a quarter of the substep rate is used."),
    REAL(joint_damping, 0, 100, 2, NULL, "Damping ratio of joints."),
    REAL(baumgarte, 0, 1, 0.2, NULL, "Share of an overlap that pgs and pgs_ngs correct at a time."),
    REAL(restitution_speed, 0, 1000, 1, "m/s", "Slower impacts do not bounce."),
    REAL(recycle_distance, 0, 1, 0.05, "m",
         "How far two bodies move to each other before their manifold is made anew."),
    REAL(sleep_speed, 0, 10, 0.05, "m/s", "What is slower for half a second may sleep."),
    SWITCH(warm_start, 1, "Begin with the impulses of the step before."),
    SWITCH(recycle, 1, "Keep manifolds of bodies that hardly moved to each other."),
    SWITCH(sleep, 1, "Let islands of bodies that rest fall asleep."),
};

enum { GRAVITY_ROWS = 2, ROWS = sizeof rows / sizeof rows[0] };

const ll_param_table ll_rigid_table = {.name = "rigid_world",
                                       .help = "How a world of rigid bodies is stepped.",
                                       .rows = rows,
                                       .count = ROWS,
                                       .size = sizeof(ll_rigid_params)};

const ll_param_table ll_rigid_solver_table = {.name = "rigid_solver",
                                              .help = "How contacts are found and resolved.",
                                              .rows = rows + GRAVITY_ROWS,
                                              .count = ROWS - GRAVITY_ROWS,
                                              .size = sizeof(ll_rigid_params)};

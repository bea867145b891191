#include "netcode/reckoning/reckoning.h"

const ll_reckoning_model *const ll_reckoning_models[] = {
    NULL, &ll_reckoning_static, &ll_reckoning_velocity, &ll_reckoning_spin, &ll_reckoning_acceleration, NULL};
const ll_convergence *const ll_convergences[] = {&ll_convergence_snap, &ll_convergence_linear,
                                                 &ll_convergence_cubic, &ll_convergence_projective, NULL};

/* In the order of the tables; a test compares them. */
const char *const ll_reckoning_names[] = {"none",          "static",       "velocity",
                                          "velocity_spin", "acceleration", NULL};
const char *const ll_convergence_names[] = {"snap", "linear", "cubic", "projective", NULL};

#include "fluid/grid/state.h"

const ll_advection *const ll_advections[LL_ADVECTIONS] = {
    &ll_advection_semi_lagrangian, &ll_advection_maccormack, &ll_advection_bfecc, &ll_advection_central};

/* In the order of ll_advections; a test compares them. */
const char *const ll_advection_names[LL_ADVECTIONS + 1] = {"semi_lagrangian", "maccormack", "bfecc",
                                                           "central", NULL};

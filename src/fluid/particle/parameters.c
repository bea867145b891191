#include "fluid/particle/parameters.h"

static const ll_param rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_DFSPH, 0, -10, 1000, 40, 0.02, 0, 0, 0.4, 100, 0),
};

const ll_param_table ll_particle_table = LL_PARTICLE_TABLE("particles", rows);

#include "session/kinds.h"

const ll_sim_kind *const ll_sim_kinds[] = {&ll_sim_netgame, &ll_sim_motion, &ll_sim_rigid, &ll_sim_fluid,
                                           NULL};

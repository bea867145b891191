#include "sim/kinds.h"

#include "sim/netgame.h"

const ll_sim_kind *const ll_sim_kinds[] = {&ll_sim_netgame, NULL};

/* In the order of ll_sim_kinds; a test holds them against each other. */
const char *const ll_sim_kind_names[] = {"netgame", NULL};

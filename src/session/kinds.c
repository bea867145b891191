#include "session/kinds.h"

#define ROW(NAME) &ll_sim_##NAME,
const ll_sim_kind *const ll_sim_kinds[] = {LL_SIM_KINDS(ROW) NULL};

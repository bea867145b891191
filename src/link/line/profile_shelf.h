/* What the links of a block have in common: the samples of profiles and what each direction remembers of
 * them, and a queue in each direction that all share. Relocatable. */
#pragma once

#include "link/line/link.h"

typedef struct ll_profile_shelf ll_profile_shelf;

typedef struct ll_shelf_setup {
    const ll_profile_params *profiles;
    int count;
    int ways; /* directions: of player i, 2 i is up and 2 i + 1 is down */
    const ll_bottleneck_params *bottleneck;
    uint64_t seed;
} ll_shelf_setup;

/* 0 where there is neither a profile nor a shared queue. A multiple of 8. */
size_t ll_profile_shelf_size(const ll_shelf_setup *setup);
void ll_profile_shelf_init(ll_profile_shelf *shelf, const ll_shelf_setup *setup);
void ll_profile_shelf_restart_stats(ll_profile_shelf *shelf);

/* ll_link_plan_of of direction `way`, with the profile that `params` name and the shared queue. NULL:
 * neither. */
ll_link_plan ll_profile_shelf_plan(ll_profile_shelf *shelf, int way, const ll_link_params *params,
                                   double lag_ms);
const ll_profile_state *ll_profile_shelf_state(const ll_profile_shelf *shelf, int way);

#include "game/core/compensate.h"

#include "game/weapons/policies.h"

const char *const ll_trace_names[] = {"parabola", "straight", "drag_neglected", NULL};

/* The first row of each is the policy without a history. */
const ll_hitscan_policy *const ll_hitscan_policies[] = {
    &ll_hitscan_none,   &ll_hitscan_rewind,      &ll_hitscan_client_authoritative,
    &ll_hitscan_hybrid, &ll_hitscan_victim_veto, NULL};
const ll_projectile_family *const ll_projectile_families[] = {
    &ll_projectile_none,    &ll_projectile_fast_forward,         &ll_projectile_rewind,
    &ll_projectile_partial, &ll_projectile_client_authoritative, NULL};

/* In the order of the tables; a test compares them. */
const char *const ll_hitscan_names[] = {"none",   "rewind",      "client_authoritative",
                                        "hybrid", "victim_veto", NULL};
const char *const ll_projectile_names[] = {"none",    "fast_forward",         "rewind",
                                           "partial", "client_authoritative", NULL};

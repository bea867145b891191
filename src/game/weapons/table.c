#include "game/core/compensate.h"

#include "game/weapons/policies.h"

const char *const ll_trace_names[] = {"parabola", "straight", NULL};

/* The first row of each is the policy without a history. */
const ll_rifle_policy *const ll_rifle_policies[] = {&ll_rifle_none, &ll_rifle_rewind, &ll_rifle_trust, NULL};
const ll_shell_family *const ll_shell_families[] = {
    &ll_shell_none, &ll_shell_fast_forward, &ll_shell_rewind, &ll_shell_partial, &ll_shell_trust, NULL};

/* In the order of the tables; a test compares them. */
const char *const ll_rifle_names[] = {"none", "rewind", "client_authoritative", NULL};
const char *const ll_shell_names[] = {"none",    "fast_forward",         "rewind",
                                      "partial", "client_authoritative", NULL};

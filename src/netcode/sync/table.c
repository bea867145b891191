#include "netcode/protocol/sync.h"

#include <stddef.h>

const ll_sync_mode *const ll_syncs[] = {
    &ll_sync_free,     &ll_sync_lockstep,           &ll_sync_gambetta, &ll_sync_deterministic,
    &ll_sync_rollback, &ll_sync_lockstep_pipelined, &ll_sync_bucket,   NULL};

/* In the order of ll_syncs; a test compares both. */
const char *const ll_sync_mode_names[] = {"free",     "lockstep",           "gambetta", "deterministic",
                                          "rollback", "lockstep_pipelined", "bucket",   NULL};

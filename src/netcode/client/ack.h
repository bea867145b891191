/* How a client learns from snapshots which inputs were applied. */
#pragma once

#include "base/vtime.h"

struct ll_client;
struct ll_client_setup;
struct ll_snapshot_entry;

typedef struct ll_ack {
    uint32_t wants; /* ll_part */

    /* Closes the inputs that `state`, the newest snapshot, decides, and moves `inputs.acked`: all inputs up
     * to it are closed. */
    void (*take)(struct ll_client *client, const struct ll_client_setup *setup,
                 const struct ll_snapshot_entry *state, ll_time now);
} ll_ack;

extern const ll_ack *const ll_acks[]; /* NULL-terminated; the index is the choice `ack` */
extern const char *const ll_ack_names[];

#include "netcode/client/ack.h"

#include <stddef.h>

const ll_ack *const ll_acks[] = {&ll_ack_high_water, &ll_ack_per_input, NULL};

/* In the order of ll_acks; a test compares both. */
const char *const ll_ack_names[] = {"high_water", "per_input", NULL};

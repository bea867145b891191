#include "netcode/hosting/hosting.h"

const ll_election *const ll_elections[] = {&ll_election_lowest_index, &ll_election_newest_state,
                                           &ll_election_best_connection, NULL};

/* In the order of the table; a test compares them. */
const char *const ll_election_names[] = {"lowest_index", "newest_state", "best_connection", NULL};

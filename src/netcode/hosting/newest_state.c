/* Who has the newest state, so that least is lost (DirectPlay 8 asks the new host's peers for what it lacks).
 * Of equal ones the best connection. */
#include "netcode/hosting/hosting.h"

static int compare(const ll_candidacy *a, const ll_candidacy *b)
{
    if (a->tick != b->tick)
        return a->tick > b->tick ? -1 : 1;
    return a->round_trip < b->round_trip ? -1 : a->round_trip > b->round_trip;
}

const ll_election ll_election_newest_state = {
    .name = "newest_state",
    .help = "Who has the newest state, and of equal ones the shortest round trip to the host that left. "
            "Players first report these to each other.",
    .asks = true,
    .compare = compare};

/* Who has the best connection (Halo, Call of Duty), by the round trip to the host that left: its part in
 * every candidate's is the same. */
#include "netcode/hosting/hosting.h"

static int compare(const ll_candidacy *a, const ll_candidacy *b)
{
    if (a->round_trip != b->round_trip)
        return a->round_trip < b->round_trip ? -1 : 1;
    return a->tick > b->tick ? -1 : a->tick < b->tick;
}

const ll_election ll_election_best_connection = {
    .name = "best_connection",
    .help = "Who had the shortest round trip to the host that left, and of equal ones the newest state. "
            "Players first report these to each other.",
    .asks = true,
    .compare = compare};

/* The first in the list of players, without a question (DirectPlay 4, Photon, Unity's
 * NetworkMigrationManager). */
#include "netcode/hosting/hosting.h"

const ll_election ll_election_lowest_index = {
    .name = "lowest_index", .help = "The first of the other players, in the order of the list."};

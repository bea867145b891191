/* Parameters of a game whose server runs on a player's machine. */
#include "netcode/hosting/hosting.h"

#include <stddef.h>

static const char *const leavings[] = {"silent", "announced", NULL};
static const char *const meanwhiles[] = {"pause", "run_on", NULL};

static const ll_param rows[] = {
    {.name = "by_player",
     .type = LL_PARAM_BOOL,
     .offset = offsetof(ll_hosting_params, by_player),
     .help =
         "The server, or the relay of the peer-to-peer syncs, runs on a player's machine: a listen server. "
         "That player has no lag; a message of another one takes both players' links."},
    {.name = "host",
     .type = LL_PARAM_INT,
     .offset = offsetof(ll_hosting_params, host),
     .max = LL_PEERS_MAX - 1,
     .help = "With by_player, the index of the player who hosts at first."},
    {.name = "leaves_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_hosting_params, leaves_s),
     .max = 36000,
     .unit = "s",
     .help = "When the host leaves for good. 0: it does not."},
    {.name = "every_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_hosting_params, every_s),
     .max = 36000,
     .unit = "s",
     .help = "How long each later host hosts before it leaves too. 0: it does not leave."},
    {.name = "leaving",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_hosting_params, leaving),
     .choices = leavings,
     .help =
         "How a host leaves. silent: it crashes, and the others notice after timeout_s. announced: it sends "
         "its last world to all others, who look for the next host at once."},
    {.name = "election",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_hosting_params, election),
     .choices = ll_election_names,
     .help =
         "Whom a player wants as the next host. lowest_index: the first of the others. newest_state: who has "
         "the newest state. best_connection: who had the shortest round trip to the host that left. For the "
         "last two, players first report these to each other."},
    {.name = "patience_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_hosting_params, patience_s),
     .min = 0.5,
     .max = 10,
     .default_value = 2,
     .unit = "s",
     .help = "How long a player asks the same one to host before it asks the next."},
    {.name = "meanwhile",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(ll_hosting_params, meanwhile),
     .choices = meanwhiles,
     .help =
         "With free, what the next host does with the time since its newest state. pause: the world stands "
         "still in it. run_on: it makes those steps at once, and each player holds its last known controls."},
};

const ll_param_table ll_hosting_table = {.name = "hosting",
                                         .help = "A server on the machine of a player, who may leave.",
                                         .rows = rows,
                                         .count = sizeof rows / sizeof rows[0],
                                         .size = sizeof(ll_hosting_params)};

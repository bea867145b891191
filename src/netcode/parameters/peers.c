/* Parameters of the peer-to-peer syncs that few scenarios choose. */
#include <stddef.h>

#include "netcode/protocol/config.h"

static const char *const topologies[] = {"relay", "mesh", NULL};
static const char *const time_syncs[] = {"wait", "stretch", NULL};

static const ll_param rows[] = {
    {LL_PARAM_ROW("topology", CHOICE, ll_peers_params, topology), .choices = topologies,
     .help = "With deterministic and rollback, how inputs travel. relay: to the server, which sends them to "
             "the others at its next update. mesh: from each player directly to each other, as a copy for "
             "each, over the sender's link up and the receiver's link down without a stop. The server then "
             "keeps the session only, and no one validates inputs."},
    {LL_PARAM_ROW("time_sync", CHOICE, ll_peers_params, time_sync), .choices = time_syncs,
     .help =
         "With deterministic and rollback, what a client does that is ahead of another. wait: from a lead "
         "of a tick on it leaves out whole frames. stretch: from half a tick on it makes its frames "
         "longer, by at most a tenth, until the lead is gone."},
    {LL_PARAM_ROW("adaptive_delay", BOOL, ll_peers_params, adaptive_delay),
     .help =
         "With deterministic and rollback, the input delay of each client follows the delay of its inputs "
         "to the others: the 95th percentile in ticks, rounded up, less delay_budget_ticks, 0 to 8. It "
         "rises at once, and falls to one tick more than that. input_delay_ticks is where it begins."},
    {LL_PARAM_ROW("delay_budget_ticks", INT, ll_peers_params, budget_ticks), .max = LL_ROLLBACK_MAX,
     .default_value = 3, .unit = "ticks",
     .help = "With adaptive_delay, how many ticks a rollback may resimulate in 95 of 100 cases. With "
             "deterministic it is 0."},
};

const ll_param_table ll_peers_table = {.name = "peers",
                                       .help = "The peer-to-peer syncs, deterministic and rollback.",
                                       LL_PARAM_ROWS(rows, ll_peers_params)};

uint8_t ll_peers_choices(const ll_peers_params *params)
{
    return (uint8_t)((params->topology == LL_TOPOLOGY_MESH ? LL_PEERS_MESH : 0) |
                     (params->time_sync == LL_TIME_SYNC_STRETCH ? LL_PEERS_STRETCH : 0) |
                     (params->adaptive_delay ? LL_PEERS_ADAPT : 0));
}
